# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command `label`: its steps, its files, its pictures, and what it refuses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.errors import DisplayError
from stitchmesh.io import read_mesh, read_stitches, write_mesh
from stitchmesh.labeling import label
from stitchmesh.labeling.labeling_file import read_labeling
from stitchmesh.mesh.orientation import turn_inside_out
from stitchmesh.mesh.upright import Z, upright_turn
from stitchmesh.render import labeling_picture
from tests.cli.calls import refused, refused_without_files, run
from tests.gallery import ROOT, odd_corner, torus, tube
from tests.io.test_garments import scene
from tests.labeling.test_partial_labeling import bits
from tests.output_files import visible

HAT = ROOT / "assets" / "meshes" / "hat.obj"


@pytest.fixture
def tube_obj(tmp_path) -> Path:
    write_mesh(tmp_path / "tube.obj", tube(8, 5))
    return tmp_path / "tube.obj"


def test_steps_through_files_end_in_the_rows_of_one_call(tmp_path, capsys):
    part, more, rows = (tmp_path / f"{name}.h5" for name in ("part", "more", "rows"))
    run("label", HAT, "--rows", 2, "-o", part)
    assert "2 rows; 24 of 108 faces labeled" in capsys.readouterr().out
    run("label", part, "--rows", 3, "-o", more)
    assert read_labeling(more).row_count == 5
    run("label", more, "-o", rows)
    assert bits(read_stitches(rows)) == bits(label(read_mesh(HAT)))
    assert capsys.readouterr().out.endswith("9 rows of 108 faces\n")


def test_each_step_has_an_option(tmp_path, tube_obj):
    def step(before: Path, *words: object) -> Path:
        after = tmp_path / f"step-{len(list(tmp_path.iterdir()))}.h5"
        run("label", before, *words, "-o", after)
        return after

    part = step(tube_obj, "--start-border", "41,40", "--rows", 0)
    assert np.flatnonzero(read_labeling(part).labeled).tolist() == list(range(32, 40))
    part = step(part, "--row-at", "32,33", "--rows", 0)
    assert read_labeling(part).row_count == 2
    part = step(part, "--set-edge", "32,33=wale", "--rows", 0)
    assert len(read_labeling(part).faults) == 2
    part = step(part, "--set-edge", "32,33=clear", "--rows", 1)
    part = step(part, "--flip", "33", "--rows", 0)
    assert read_labeling(part).row_is_reversed.any()
    part = step(tube_obj, "--seed", "16,17", "--rows", 1)  # the former name of --start-edge
    assert np.flatnonzero(read_labeling(part).labeled)[0] == 8


def test_faults_of_a_partly_labeled_mesh_are_printed_and_the_file_is_written(tmp_path, capsys):
    write_mesh(tmp_path / "odd.obj", odd_corner())
    run("label", tmp_path / "odd.obj", "--rows", 5, "-o", tmp_path / "part.h5")
    assert "cannot be labeled; face" in capsys.readouterr().out
    assert (tmp_path / "part.h5").exists()


def test_a_mesh_that_cannot_be_labeled_gets_a_picture_of_its_faults_and_nothing_else(tmp_path, capsys):
    write_mesh(tmp_path / "odd.obj", odd_corner())
    folder = tmp_path / "new"
    message = refused(capsys, "label", tmp_path / "odd.obj", "-o", folder / "rows.h5")
    assert message.startswith("LabelError: knit it with --auto") and "would be both wale and course" in message
    assert message.endswith(f"; {folder / 'labeling-faults.png'} shows the faces\n")
    assert visible(folder) == {"labeling-faults.png"}


def test_a_machine_without_a_display_still_gives_the_reason(tmp_path, capsys, monkeypatch):
    def no_display(*_: object, **__: object) -> None:
        raise DisplayError("no display")

    monkeypatch.setattr(labeling_picture, "render_labeling", no_display)
    write_mesh(tmp_path / "odd.obj", odd_corner())
    message = refused(capsys, "label", tmp_path / "odd.obj", "-o", tmp_path / "rows.h5")
    assert "would be both wale and course" in message and "labeling-faults" not in message
    assert [path.name for path in tmp_path.iterdir()] == ["odd.obj"]


def test_a_mesh_inside_out_is_reported_and_turned(tmp_path, caplog):
    write_mesh(tmp_path / "inside.obj", turn_inside_out(read_mesh(HAT)))
    run("label", tmp_path / "inside.obj", "-o", tmp_path / "inside.h5")
    (warning,) = caplog.messages
    assert "\n" not in warning and "is inside out" in warning and "--turn-inside-out" in warning
    caplog.clear()
    run("label", tmp_path / "inside.obj", "--turn-inside-out", "-o", tmp_path / "turned.h5")
    assert not caplog.messages
    assert bits(read_stitches(tmp_path / "turned.h5")) == bits(label(read_mesh(HAT)))


BAD_STEPS = {
    "no edge": (["--start-edge", "0,20"], "edge 0-20: no edge joins these vertices"),
    "no border": (["--start-border", "8,9"], "edge 8-9: does not lie on a border; edges of its borders are"),
    "not an edge": (["--set-edge", "0,20=wale"], "edge 0-20: no edge joins these vertices"),
    "no row there": (["--row-at", "0,1", "--rows", "0"], "edge 0-1: is not a labeled course edge"),
    "no row yet": (["--rows", "1", "--flip", "39"], "flip: face 39 has no row yet"),
    "no face": (["--flip", "4000"], "flip: face 4000 does not exist; the mesh has faces 0 to 39"),
    "less than none": (["--rows", "-2"], "rows: got -2; expected at least 1"),
    "wrong picture": (["--picture", "rows.jpg"], "rows.jpg: unknown format"),
    "hands": (["--set-edge", "0,1=course", "--set-edge", "1,9=course", "--set-edge", "9,8=course"], "needs 2"),
}


@pytest.mark.parametrize("name", BAD_STEPS)
def test_bad_steps_are_refused_in_one_line_and_nothing_is_written(tmp_path, tube_obj, capsys, name):
    words, message = BAD_STEPS[name]
    words = ["label", tube_obj, *words, "-o", tmp_path / "out.h5"]
    assert message in refused_without_files(capsys, tmp_path, *words)


def test_a_step_with_nothing_left_to_label_leaves_the_file_as_it_was(tmp_path, tube_obj, capsys):
    part = tmp_path / "part.h5"
    run("label", tube_obj, "--rows", 9, "-o", part)
    kept = part.read_bytes()
    assert "nothing is left to label: all 40 faces have rows" in refused(capsys, "label", part, "--rows", 1, "-o", part)
    assert part.read_bytes() == kept


def test_a_partly_labeled_mesh_is_an_h5_file_and_is_not_turned(tmp_path, tube_obj, capsys):
    assert "out.smobj: unknown format" in refused(
        capsys, "label", tube_obj, "--rows", 1, "-o", tmp_path / "out.smobj"
    )
    run("label", tube_obj, "--rows", 1, "-o", tmp_path / "part.h5")
    words = ["label", tmp_path / "part.h5", "--turn-inside-out", "-o", tmp_path / "rows.h5"]
    assert "the mesh has rows already" in refused(capsys, *words)
    message = refused(capsys, "label", tmp_path / "part.h5", "--up", "z", "-o", tmp_path / "rows.h5")
    assert "--up: the mesh has rows already" in message


def test_a_row_of_a_labeled_mesh_is_flipped(tmp_path, tube_obj, capsys):
    rows, flipped = tmp_path / "rows.h5", tmp_path / "flipped.h5"
    run("label", tube_obj, "-o", rows)
    run("label", rows, "--flip", 20, "-o", flipped)
    assert bits(read_stitches(flipped)) == bits(label(read_mesh(tube_obj), flip=[20]))
    run("tessellate", rows, "--stitch-width", 1, "-o", tmp_path / "stitches.h5")
    assert "holds no polygon mesh, and y points up in it" in refused(capsys, "info", rows, "--up", "z")
    assert "is a stitch already" in refused(capsys, "label", tmp_path / "stitches.h5", "-o", rows)
    assert "none.h5: " in refused(capsys, "label", tmp_path / "none.h5", "-o", rows)


def test_a_closed_mesh_names_the_remedy(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(labeling_picture, "render_labeling", lambda *_: None)
    write_mesh(tmp_path / "torus.obj", torus(6, 8))
    message = refused(capsys, "label", tmp_path / "torus.obj", "-o", tmp_path / "rows.h5")
    assert "has no border to start from; name an edge of its first row" in message
    run("label", tmp_path / "torus.obj", "--start-edge", "0,1", "-o", tmp_path / "rows.h5")


def test_a_mesh_in_another_unit_is_said_by_the_commands_that_knit_it_and_that_describe_it(tmp_path, capsys, caplog):
    """A tube that is 40 cm wide and high, in metres."""
    write_mesh(tmp_path / "skirt.obj", tube(8, 4, radius=20.0, height=10.0), unit="m")
    expected = "is 0.4 x 0.4 x 0.4 cm, too small for a garment; in m 40.0 x 40.0 x 40.0 cm: --unit m"
    run("label", tmp_path / "skirt.obj", "-o", tmp_path / "rows.h5")
    assert expected in caplog.text
    run("info", tmp_path / "skirt.obj")
    assert expected in capsys.readouterr().out
    caplog.clear()
    run("label", tmp_path / "skirt.obj", "--unit", "m", "-o", tmp_path / "rows.h5")
    assert not caplog.records


def test_a_lying_mesh_goes_through_the_stages_with_its_surface(tmp_path):
    """A tube of 36 x 20 x 36 cm whose axis is z in the file; the surface that is named is the same file."""
    upright = tube(8, 4, radius=18.0, height=5.0)
    lying = tmp_path / "skirt.obj"
    write_mesh(lying, replace(upright, vertices=upright.vertices @ upright_turn(Z)))
    rows, stitches, even = (tmp_path / f"{name}.h5" for name in ("rows", "stitches", "even"))
    run("label", lying, "-o", rows)
    run("tessellate", rows, "--stitch-width", "4", "-o", stitches)
    run("relax-mesh", stitches, "--surface", lying, "-o", even)
    height = np.ptp(read_stitches(even).vertices, axis=0)[1]
    assert height == pytest.approx(20.0, abs=0.5)  # stitches may pass the border by a part of a stitch
    run("convert", lying, tmp_path / "standing.obj", "--up", "z")
    np.testing.assert_array_equal(read_mesh(tmp_path / "standing.obj").vertices, upright.vertices)


def test_the_objects_of_a_file_are_listed(tmp_path, capsys):
    run("info", scene(tmp_path / "scene.obj", ("body", torus(6, 4)), ("skirt", tube(8, 4))))
    assert "objects: body, skirt\n" in capsys.readouterr().out
