# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns of face meshes: which strands become one yarn, where they lie, and how long they are."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.cli import main as cli
from stitchmesh.errors import ParameterError, YarnError
from stitchmesh.io import read_yarns
from stitchmesh.io.stitch_formats.face_libraries import read_face_library
from stitchmesh.io.stitch_formats.face_meshes import read_face_mesh
from stitchmesh.yarngen.face_yarns.generate import face_yarns
from stitchmesh.yarnrelax import relax_yarns
from tests.faces.face_files import KNIT, LIBRARY, WEAVE, flat_file

STRAIGHT = """\
face over
edge (0,0) -a1
edge (1,0) +e1
edge (1,1) +a1
edge (0,1) -e1
yarn [0:0.25,0.1] [2:0.75,0.1]
"""


def faces(folder, text):
    (folder / "a.smobj").write_text(text)
    return read_face_mesh(folder / "a.smobj")


def library(folder, text):
    (folder / "a.sf").write_text(text)
    return read_face_library(folder / "a.sf")


def test_a_straight_strand_stays_straight_across_faces(tmp_path):
    """The faces are twice as large as the drawing, so that the height doubles too."""
    mesh = faces(tmp_path, flat_file(WEAVE, ["0", "0", "0"], size=(2.0, 2.0)))
    yarns = face_yarns(mesh, library(tmp_path, STRAIGHT), yarn_radius=0.05).yarns
    assert yarns.yarn_count == 1
    samples = yarns.sampled(2)[0]
    np.testing.assert_allclose(samples[:, [0, 2]], np.broadcast_to([0.5, 0.2], samples[:, [0, 2]].shape), atol=1e-12)
    assert yarns.lengths.sum() == pytest.approx(6.0, rel=1e-12)


def test_a_join_without_reversal_turns_the_cloth_over(tmp_path):
    """The other face lies turned over beside the first; a strand keeps its place along the side and its height."""
    vertices = [f"v {x} {y} 0" for x, y in [(0, 0), (1, 0), (1, 1), (0, 1), (1, 2), (0, 2)]]
    two_faces = ["f 1 2 3 4", "T 1", "f 3 4 6 5", "T 1", "e 1/3 2/1"]
    text = "\n".join(["L over -a1 +e1 +a1 -e1", *vertices, *two_faces])
    drawn = library(tmp_path, STRAIGHT.replace("[2:0.75,0.1]", "[2:0.75,-0.1]").replace("[0:0.25", "[0:0.75"))
    yarns = face_yarns(faces(tmp_path, text), drawn, yarn_radius=0.05).yarns
    assert yarns.yarn_count == 1
    heights = yarns.sampled(2)[0][:, 2]
    assert np.abs(heights).max() <= 0.1 + 1e-3  # interpolation overshoots where the slope changes, at the join
    assert heights[0] == pytest.approx(0.1) == heights[-1]


def test_a_weave_has_a_yarn_for_each_warp_and_weft(tmp_path):
    yarns = face_yarns(faces(tmp_path, flat_file(WEAVE, ["010", "101", "010"])), yarn_radius=0.1).yarns
    assert yarns.yarn_count == 6
    assert not yarns.closed.any()
    warps = [curve for curve in yarns.sampled(4) if np.ptp(curve[:, 1]) > np.ptp(curve[:, 0])]
    for column, warp in enumerate(sorted(warps, key=lambda curve: curve[0, 0])):
        middle = warp[np.abs(warp[:, 1] - 1.5).argmin(), 2]
        assert (middle > 0) == (column == 1)  # The middle row is under, over, under.


def test_one_yarn_knits_a_row_and_loops_end_at_the_top(tmp_path):
    """Each row is one yarn; the loops of the last row are closed by the faces that drop them, or at the border."""
    for rows in (["000", "111", "222"], ["000", "111"]):
        made = face_yarns(faces(tmp_path, flat_file(KNIT, rows, size=(2.0, 1.4))), yarn_radius=0.15)
        assert made.yarns.yarn_count == 2
        assert made.by_labels == (("drop",) if len(rows) == 3 else ())


def test_a_yarn_runs_as_its_labels_say(tmp_path):
    for sign, rightwards in (("+", True), ("-", False)):
        words = {"+": "tuck-twist+ -lX +yX +lX -yX", "-": "tuck-twist- -lX -yX +lX +yX"}[sign]
        yarns = face_yarns(faces(tmp_path, flat_file([words], ["000"])), yarn_radius=0.1).yarns
        assert (yarns.points[-1, 0] > yarns.points[0, 0]) == rightwards


CHECKPOINTS = "U 1 1\nU loop 0.5\nc {2}/1/1 2 1 3 2\nc {1}/3/1 1 1\nc {0}/3/1\n"


def test_checkpoints_give_lengths_and_direction(tmp_path):
    """The parts between checkpoints are 3.5 and 1 long, and what is beyond them keeps its length."""
    text = flat_file(WEAVE, ["0", "0", "0", "0"])
    drawn = library(tmp_path, STRAIGHT)
    plain = face_yarns(faces(tmp_path, text), drawn, yarn_radius=0.01).yarns
    assert plain.points[0, 1] < plain.points[-1, 1]
    made = face_yarns(faces(tmp_path, text + CHECKPOINTS.format(1, 2, 4)), drawn, yarn_radius=0.01).yarns
    assert made.points[0, 1] > made.points[-1, 1]
    # Checkpoints at y = 3, 2 and 1 of a yarn from 4 to 0: segments belong to the part of their middles.
    expected = 1.0 + 3.5 + 1.0 + 1.0
    assert made.rest_length.sum() == pytest.approx(expected, rel=2 / len(made.rest_length))


def test_yarns_of_faces_relax_without_passing_through_each_other(tmp_path):
    yarns = face_yarns(faces(tmp_path, flat_file(WEAVE, ["01", "10"])), yarn_radius=0.1, quality="draft").yarns
    report = relax_yarns(yarns, quality="draft", device="cpu").report
    assert report["converged"]
    assert report["certificate"] == "unchanged"


def test_the_command_takes_libraries_and_writes_yarns(tmp_path, capsys):
    faces(tmp_path, flat_file(WEAVE, ["00"]))
    library(tmp_path, LIBRARY)
    words = ["yarns", str(tmp_path / "a.smobj"), "--faces", str(tmp_path / "a.sf"), "--yarn-radius", "0.05"]
    assert cli.main([*words, "-o", str(tmp_path / "y.h5")]) == 0
    assert "3 yarns" in capsys.readouterr().out
    assert read_yarns(tmp_path / "y.h5").yarn_count == 3


def test_what_has_no_yarn_is_refused(tmp_path):
    mesh = faces(tmp_path, flat_file(["empty x x x x"], ["0"]))
    with pytest.raises(YarnError, match="no type of its faces has yarn"):
        face_yarns(mesh, yarn_radius=0.1)
    crowded = faces(tmp_path, flat_file(["split -l99 +l99 x x"], ["0"]))
    with pytest.raises(YarnError, match="more than 20 strands on a side"):
        face_yarns(crowded, yarn_radius=0.1)
    with pytest.raises(ParameterError, match="yarn_radius: got -1"):
        face_yarns(mesh, yarn_radius=-1.0)
