# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""`knit --auto`: rows on triangles without labels, what is written and said, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.app.project.source import read_source, source_of
from stitchmesh.cli import main as cli
from stitchmesh.errors import YarnError
from stitchmesh.io import read_mesh, read_stitches, write_mesh
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.recipe.recipe_file import read_recipe
from tests.cli.calls import refused, refused_without_files
from tests.gallery import moebius, odd_corner, torus, tube
from tests.labeling.test_partial_labeling import triangulated

SHORT = ["--auto", "--stitch-width", "1", "--quality", "draft", "--device", "cpu", "--max-iterations", "5"]
"""Options with which a small tube is knitted in a moment; its yarns do not come to rest."""


def cone() -> Mesh:
    """A narrowing tube of triangles, so that rows differ in their stitches; its axis is y, from 0 to 4.5 cm."""
    return triangulated(tube(8, 3, radius=2.0, height=1.5, top_radius=1.2))


def written(path: Path, vertices: np.ndarray, faces: list[list[int]]) -> Path:
    """Write polygons that need not be a mesh as an OBJ file."""
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + ["f " + " ".join(str(v + 1) for v in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(scope="module")
def cone_obj(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("meshes") / "cone.obj"
    write_mesh(path, cone())
    return path


@pytest.fixture(scope="module")
def knitted(tmp_path_factory, cone_obj) -> Path:
    folder = tmp_path_factory.mktemp("knitted") / "out"
    knit(cone_obj, "--multiple", "2", "-o", folder)
    return folder


def knit(*words: object) -> None:
    """Knit without a picture."""
    assert cli.main(["knit", *map(str, words), *SHORT, "--no-picture"]) == 0


def test_triangles_are_knitted(knitted):
    report, fabric = json.loads((knitted / "report.json").read_text()), read_stitches(knitted / "stitches.h5")
    assert report["repair"] == [] and not {"label", "tessellate"} & set(report)
    shape = report["shape"]
    assert (shape["stitches"], shape["rows"]) == (fabric.face_count, len(np.unique(fabric.row)))
    assert shape["irregular"] == np.count_nonzero(fabric.n_top != fabric.n_bottom) > 0
    assert (fabric.stretch is not None) and shape["rms_stretch"] > 0.0
    assert all(np.sum(fabric.n_top[fabric.row == row]) % 2 == 0 for row in np.unique(fabric.row))


def test_the_summary_says_how_the_stitches_fit_and_rounds_become_a_spiral(cone_obj, tmp_path, capsys, caplog):
    knit(cone_obj, "--spiral", "-o", tmp_path / "out")
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    shape = report["shape"]
    assert report["spiral"]["spirals"] == 1 and report["yarngen"]["yarns"] < shape["rows"]
    assert "crosses itself" not in caplog.text
    surface, shaping, where = capsys.readouterr().out.splitlines()[3:]
    assert surface == (
        f"Surface: stitches are off by {shape['rms_distance']:.2g} stitch widths (rms), at most "
        f"{shape['largest_distance']:.2g}; their stretch differs by {100 * shape['rms_stretch']:.2g} % (rms)."
    )
    assert shaping == (
        f"Shaping: {shape['irregular_per_thousand']:.3g} irregular stitches in a thousand, 0 grafted edges, "
        "0 short rows."
    )
    assert where.startswith("No picture was drawn")


def test_what_the_repair_changes_is_printed_and_reported(tmp_path, capsys):
    """The file has a face twice, and each triangle has vertices of its own."""
    mesh = cone()
    faces = mesh.face_vertex.reshape(-1, 3)
    soup = np.arange(faces.size).reshape(-1, 3).tolist()
    path = written(tmp_path / "soup.obj", mesh.vertices[faces.ravel()], [*soup, soup[4]])
    knit(path, "-o", tmp_path / "out")
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("Repair: ")]
    entries = json.loads((tmp_path / "out" / "report.json").read_text())["repair"]
    assert [entry["name"] for entry in entries] == ["duplicate faces", "welded vertices"]
    assert lines == [f"Repair: {entry['text']}." for entry in entries]
    assert lines[0] == "Repair: 1 face with the same vertices as another face was removed: face 48."


def test_yarns_without_room_are_told_what_was_not_done_yet(cone_obj, tmp_path, capsys, monkeypatch):
    """Found stitches are relaxed and given room by the command itself."""

    def crowded(*_, **__):
        raise YarnError("face 0 and 9: yarns start 0.1 radii apart", face=0, remedy="make room (sm.make_room)")

    monkeypatch.setattr("stitchmesh.pipeline.stages.generate_yarns", crowded)
    message = refused(capsys, "knit", cone_obj, *SHORT, "-o", tmp_path / "out")
    assert "two parts of the mesh touch there or fold sharply; move them apart" in message
    assert "make room" not in message and "relax the stitch mesh" not in message


def test_marks_decide_where_knitting_begins(cone_obj, tmp_path):
    marks = [{"kind": "border", "points": [[0, 4.5, 1.2]], "role": "begin"}]
    (tmp_path / "marks.json").write_text(json.dumps(marks))
    knit(cone_obj, "--marks", tmp_path / "marks.json", "--up=0,-1,0", "-o", tmp_path / "out")
    fabric = read_stitches(tmp_path / "out" / "stitches.h5")
    height = [fabric.corner_position[fabric.side_face == face][:, 1].mean() for face in np.flatnonzero(fabric.row == 0)]
    assert max(height) < -3.0  # the first row is at the upper border of the file, below after the mesh was turned
    recipe = read_recipe(tmp_path / "out" / "garment.toml")
    assert recipe.up == (0.0, -1.0, 0.0) and [mark.role for mark in recipe.rows.marks] == ["begin"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--start-border", "0,1"], "start border: names edges or faces of a labeled mesh, but rows are found"),
        (["--count", "0,1=5"], "count: names edges"),
        (["--multiple", "0"], "multiple: got 0; expected 1 or more stitches"),
        (["--up", "0,0,0"], "up: got (0.0, 0.0, 0.0); expected three finite numbers that are not all zero"),
        (["--stitch-width", "9"], "has room for"),
        (["--stitch-width", "1e-4"], "are made; choose a larger stitch"),
        (["--yarn-radius", "3"], "too thick"),
        (["--marks", "none.json"], "none.json: there is no such file"),
    ],
)
def test_a_bad_option_gives_a_message_of_one_line(cone_obj, tmp_path, capsys, words, message):
    out = tmp_path / "out"
    assert message in refused_without_files(capsys, tmp_path, "knit", cone_obj, *SHORT, *words, "-o", out)


@pytest.mark.parametrize("option", ["--multiple=2", "--no-short-rows"])
def test_an_option_of_found_rows_needs_auto(cone_obj, tmp_path, capsys, option):
    name = option.partition("=")[0].removeprefix("--").removeprefix("no-").replace("-", "_")
    message = refused_without_files(capsys, tmp_path, "knit", cone_obj, option, "-o", tmp_path / "out")
    assert f"{name}: is for rows that are found; give auto (--auto) too" in message


BORDER = {"kind": "border", "points": [[0, 0, 2]], "role": "begin"}
UPPER = {"kind": "border", "points": [[0, 4.5, 1.2]], "role": "end"}


@pytest.mark.parametrize(
    ("marks", "message"),
    [
        ("{", "is no JSON"),
        (BORDER, "expected a list"),
        ([{**BORDER, "tme": 0}], "did you mean 'time'? the keys are kind, points, role, time, radius"),
        ([{**BORDER, "points": [[0, 2]]}], "marks[0]: got points of shape (1, 2)"),
        ([{"kind": "point", "points": [[0, 90, 0]]}], "cm off the surface; draw it on the surface, and check the unit"),
        ([{**BORDER, "time": 4}, {**UPPER, "time": 1}], "knitting would end at 1 cm and begin at 4 cm"),
    ],
)
def test_bad_marks_are_refused_in_one_line_and_nothing_is_written(cone_obj, tmp_path, capsys, marks, message):
    path, out = tmp_path / "marks.json", tmp_path / "out"
    path.write_text(marks if isinstance(marks, str) else json.dumps(marks))
    words = ["knit", cone_obj, *SHORT, "--marks", path, "-o", out]
    assert message in refused_without_files(capsys, tmp_path, *words)


@pytest.mark.parametrize(
    ("name", "points", "faces", "message"),
    [
        ("strip.obj", *moebius(), "one side"),
        ("flat.obj", np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]]), [[0, 1, 2]], "none of the 1 faces has an area"),
    ],
)
def test_a_mesh_that_cannot_be_repaired_is_refused_in_one_line(tmp_path, capsys, name, points, faces, message):
    written(tmp_path / name, points, faces)
    printed = refused_without_files(capsys, tmp_path, "knit", tmp_path / name, *SHORT, "-o", tmp_path / "out")
    assert message in printed and name in printed


@pytest.mark.parametrize(
    ("command", "mesh", "reason"),
    [
        ("knit", cone, "these are triangles"),
        ("label", odd_corner, "would be both wale and course"),
        ("knit", lambda: torus(6, 8), "no border"),
    ],
)
def test_a_mesh_that_cannot_be_labeled_names_the_remedy(tmp_path, capsys, monkeypatch, command, mesh, reason):
    from stitchmesh.render import labeling_picture

    monkeypatch.setattr(labeling_picture, "render_labeling", lambda *_: None)
    write_mesh(tmp_path / "mesh.obj", mesh())
    message = refused(capsys, command, tmp_path / "mesh.obj", "-o", tmp_path / "out.h5")
    assert message.startswith("LabelError: knit it with --auto, which finds rows") and reason in message


def test_a_recipe_whose_mesh_cannot_be_labeled_names_the_remedy(tmp_path, cone_obj, capsys, monkeypatch):
    from stitchmesh.render import labeling_picture

    monkeypatch.setattr(labeling_picture, "render_labeling", lambda *_: None)
    recipe = tmp_path / "garment.toml"
    recipe.write_text(f'mesh = "{cone_obj}"\n')
    message = refused(capsys, "knit", recipe, "-o", tmp_path / "out")
    assert message.startswith(f"LabelError: write auto = true under [rows] into {recipe}, which finds rows")
    assert "rows.auto: is part of a recipe" in refused(capsys, "knit", recipe, "--auto", "-o", tmp_path / "out")


def test_a_mesh_that_crosses_itself_is_told_and_still_tried(tmp_path, caplog):
    one = cone()
    other = one.vertices @ np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) + [-2.0, 2.0, 0.0]
    faces = one.face_vertex.reshape(-1, 3)
    crossing = written(tmp_path / "crossing.obj", np.concatenate([one.vertices, other]),
                       np.concatenate([faces, faces + len(one.vertices)]).tolist())  # fmt: skip
    coarse = [word if word != "1" else "2" for word in SHORT]  # of fewer stitches
    cli.main(["knit", str(crossing), *coarse, "--no-picture", "-o", str(tmp_path / "out")])
    assert "the mesh crosses itself" in caplog.text


def test_panels_are_found_divided_and_relaxed_on_the_mesh_through_files(cone_obj, tmp_path, capsys):
    rows, stitches, even = (str(tmp_path / name) for name in ("rows.h5", "stitches.h5", "even.h5"))
    words = ["--stitch-width", "0.5", "--panel-size", "3", "--picture", str(tmp_path / "rows.png")]
    assert cli.main(["label", str(cone_obj), "--auto", *words, "-o", rows]) == 0
    said = capsys.readouterr().out
    assert "--auto: the mesh has rows already" in refused(capsys, "label", rows, "--auto", "-o", stitches)
    panels = read_stitches(rows)
    assert (panels.stitch == Stitch.PANEL).all() and (tmp_path / "rows.png").stat().st_size > 1000
    assert f"{panels.row.max() + 1} rows of {panels.face_count} faces" in said
    start = read_source(source_of("rows.h5", Path(rows).read_bytes()))
    assert start.fabric is None and start.labeling is not None and start.labeling.labeled.all()
    assert cli.main(["tessellate", rows, "--stitch-width", "0.5", "-o", stitches]) == 0
    assert cli.main(["relax-mesh", stitches, "--surface", str(cone_obj), "-o", even]) == 0
    from stitchmesh.shaping.report import distance_to_surface
    from stitchmesh.shaping.triangle_surface import triangle_surface

    surface = triangle_surface(read_mesh(cone_obj), 1.0)
    away = [distance_to_surface(read_stitches(path).vertices, surface).max() for path in (stitches, even)]
    # The surface of relaxation is smooth, and the cone has eight edges, from which it is off by less than a stitch.
    assert away[1] < 0.5 and away[1] < away[0] + 0.05


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--auto", "--set-edge", "0,1=wale"], "set edge: is for the rows of a modelled mesh; find rows with --auto"),
        (["--auto", "--no-short-rows"], "no short rows: is for stitches, and a panel holds many"),
        (["--auto", "--panel-size", "1"], "panel size: got 1; expected 2 or more stitches"),
        (["--panel-size", "4"], "panel_size: is for rows that are found; give auto (--auto) too"),
        (["--stitch-width", "4"], "stitch_width: is for rows that are found"),
    ],
)
def test_a_bad_option_of_label_gives_a_message_of_one_line(cone_obj, tmp_path, capsys, words, message):
    words = ["label", cone_obj, *words, "-o", tmp_path / "rows.h5"]
    assert message in refused_without_files(capsys, tmp_path, *words)
