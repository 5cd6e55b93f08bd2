# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""`knit --panels`: sewing patterns as options and in recipes, what is written and said, and what is refused."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.cli import main as cli
from stitchmesh.errors import YarnError
from stitchmesh.io import read_stitches
from stitchmesh.jobs.job import Job
from stitchmesh.jobs.run_job import run_job
from stitchmesh.recipe.recipe_file import read_recipe
from stitchmesh.shaping.panels.read_panels import read_panels
from stitchmesh.shaping.panels.shape_panels import knit_panels
from tests.cli.calls import refused, refused_without_files
from tests.shaping.panels.sewing_patterns import GORES, skirt

WIDTH = 4.0
SHORT = ["--panels", "--stitch-width", str(WIDTH), "--quality", "draft", "--device", "cpu", "--max-iterations", "5"]
"""Options with which a skirt of wide stitches is knitted in a moment; its yarns do not come to rest."""


@pytest.fixture(scope="module")
def skirt_obj(tmp_path_factory) -> Path:
    """Write the skirt; each gore is a group."""
    lines = skirt().lines
    of_gore = np.cumsum([line.startswith("f ") for line in lines]) - 1
    size = (of_gore[-1] + 1) // GORES
    grouped = []
    for line, face in zip(lines, of_gore.tolist(), strict=True):
        if line.startswith("f ") and face % size == 0:
            grouped.append(f"g gore{face // size}")
        grouped.append(line)
    path = tmp_path_factory.mktemp("patterns") / "skirt.obj"
    path.write_text("\n".join(grouped) + "\n")
    return path


@pytest.fixture(scope="module")
def knitted(tmp_path_factory, skirt_obj) -> Path:
    folder = tmp_path_factory.mktemp("knitted") / "out"
    words = ["--panel-direction", "gore1=0,-1", "--sew", "gore0,3"]
    assert cli.main(["knit", str(skirt_obj), *SHORT, *words, "--no-picture", "-o", str(folder)]) == 0
    return folder


def test_the_options_reach_the_panels(knitted, skirt_obj):
    report, fabric = json.loads((knitted / "report.json").read_text()), read_stitches(knitted / "stitches.h5")
    expected = knit_panels(
        read_panels(skirt_obj), stitch_width=WIDTH, directions={1: (0.0, -1.0)}, sewn=[(0, 3)], progress=False
    )
    assert (fabric.twin == expected.fabric.twin).all() and (fabric.row == expected.fabric.row).all()
    shape = report["shape"]
    assert not {"label", "tessellate", "repair"} & set(report)
    kinds = {tuple(seam["panels"]): seam["kind"] for seam in shape["seams"]}
    # Rows of a gore that is knitted the other way cannot go on; of the other two seams, one is to be sewn.
    assert kinds == {(0, 1): "sewn", (0, 3): "sewn", (1, 2): "sewn", (2, 3): "joined"}
    assert (shape["panels"], shape["grafted_edges"]) == (GORES, 0)
    assert (shape["joined_edges"], shape["sewn_edges"]) == (expected.report.joined_edges, expected.report.sewn_edges)
    assert shape["stitches"] == fabric.face_count and shape["rows"] == len(np.unique(fabric.row))
    assert shape["rms_stretch"] > 0.0  # of the relaxed stitches


def test_a_job_of_the_recipe_that_knit_writes_makes_the_same_yarns_and_keeps_its_stages(knitted, tmp_path):
    panels = read_recipe(knitted / "garment.toml").panels
    assert panels.knit and panels.sewn == (("gore0", 3),)
    assert [(one.panel, one.direction) for one in panels.directions] == [("gore1", (0.0, -1.0))]
    job = Job(recipe=str(knitted / "garment.toml"), render=())
    first = run_job(job, tmp_path)
    assert first.report["shape"]["panels"] == GORES
    assert (tmp_path / "yarns.h5").read_bytes() == (knitted / "yarns.h5").read_bytes()
    again = run_job(job, tmp_path)
    assert [stage["name"] for stage in again.report["job"]["stages"] if not stage["kept"]] == []
    assert again.report["shape"] == first.report["shape"]


def test_the_summary_says_what_became_of_the_seams_and_pictures_are_drawn(skirt_obj, tmp_path, capsys, monkeypatch):
    from stitchmesh.render import shaping_picture

    drawn: list[str] = []
    monkeypatch.setattr(sys.modules["stitchmesh.render"], "render_yarns", lambda yarns, path: drawn.append(path.name))
    monkeypatch.setattr(shaping_picture, "render_shaping", lambda fabric, path, figures: drawn.append(path.name))
    assert cli.main(["knit", str(skirt_obj), *SHORT, "-o", str(tmp_path / "out")]) == 0
    shape = json.loads((tmp_path / "out" / "report.json").read_text())["shape"]
    line = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("Panels: "))
    assert line == (
        f"Panels: 4, with 0 grafted and {shape['joined_edges']} joined edges; 0 are left to be sewn. Rows are off "
        f"their directions by {shape['mean_angle']:.2g} degrees (mean)."
    )
    assert drawn == ["preview.png", "shaping.png"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--panel-direction", "gor=1,0"], "directions: panel gor does not exist; expected 0 to 3; or a name: gore0,"),
        (["--panel-direction", "4=1,0"], "directions: panel 4 does not exist; expected 0 to 3"),
        (["--sew", "gore0,gore2"], "sewn: panels gore0 and gore2 have no seam; leave them out"),
        (["--unit", "m"], "choose a larger stitch, and check the unit"),
        (["--unit", "mm"], "is narrower than 2 stitches of 4 cm; choose a smaller stitch"),
        (["--auto"], "panels: rows are also found on the whole mesh (--auto); leave one of the two out"),
        (["--flip", "3"], "flip: names edges or faces of a labeled mesh, but rows are found without one (--panels)"),
        (["--yarn-radius", "9"], "too thick"),
    ],
)  # fmt: skip
def test_a_bad_option_gives_a_message_of_one_line_and_nothing_is_written(skirt_obj, tmp_path, capsys, words, message):
    width = ["--stitch-width", "0.1"] if "m" in words else []
    words = ["knit", skirt_obj, *SHORT, *width, *words, "-o", tmp_path / "out"]
    assert message in refused_without_files(capsys, tmp_path, *words)


def test_yarns_without_room_are_refused_with_the_panel_and_the_remedy(skirt_obj, tmp_path, capsys, monkeypatch):
    fabric = knit_panels(read_panels(skirt_obj), stitch_width=WIDTH, progress=False).fabric

    def crowded(*_arguments, **_options):
        last = fabric.face_count - 1
        raise YarnError(f"face {last}: yarns start 0.1 radii apart", face=last)

    monkeypatch.setattr("stitchmesh.pipeline.stages.generate_yarns", crowded)
    message = refused_without_files(capsys, tmp_path, "knit", skirt_obj, *SHORT, "-o", tmp_path / "out")
    assert "panel 3: near (" in message and "cm: face" in message
    assert "yarns start 0.1 radii apart; choose another direction of this panel (--panel-direction)" in message


def test_a_mesh_without_texture_coordinates_is_refused(tmp_path, capsys):
    path = tmp_path / "plain.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n")
    message = refused(capsys, "knit", path, *SHORT, "-o", tmp_path / "out")
    assert "plain.obj: has no texture coordinates (vt) and no groups" in message
    path.rename(path.with_suffix(".ply"))
    assert ".obj" in refused(capsys, "knit", path.with_suffix(".ply"), *SHORT, "-o", tmp_path / "out")


@pytest.mark.parametrize("words", [["--panel-direction", "0=1,0"], ["--sew", "0,1"]])
def test_an_option_of_panels_needs_panels(skirt_obj, tmp_path, capsys, words):
    message = refused(capsys, "knit", skirt_obj, *words, "-o", tmp_path / "out")
    assert "is for the panels of a sewing pattern; give knit (--panels) too" in message
