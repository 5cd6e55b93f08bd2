# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Libraries of drawn faces: what is read, what is derived, and one message for each bad line."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.faces.face_drawing import SideCrossing
from stitchmesh.faces.face_type import FaceType
from stitchmesh.io.stitch_formats.face_libraries import read_face_libraries, read_face_library
from tests.faces.face_files import LIBRARY


def read(folder, text):
    path = folder / "a.sf"
    path.write_text(text)
    return read_face_library(path)


def test_a_drawing_is_read(tmp_path):
    drawing = read(tmp_path, LIBRARY).find(FaceType("over", ("-a1", "+e1", "+a1", "-e1")))
    np.testing.assert_array_equal(drawing.polygon, [[0, 0], [1, 0], [1, 1], [0, 1]])
    assert drawing.strands[0].start == SideCrossing(0, 0.25, 0.1)
    assert drawing.strands[0].points.shape == (0, 3)
    np.testing.assert_array_equal(drawing.strands[1].points, [[0.75, 0.5, -0.1], [0.25, 0.5, -0.1]])


def test_a_mirrored_face_has_its_strands_on_the_mirrored_sides(tmp_path):
    """Side 1 becomes side 3, places along sides are counted from the other end, and heights are negated."""
    drawing = read(tmp_path, LIBRARY).find(FaceType("flipped", ("-a1", "-e1", "+a1", "+e1")))
    np.testing.assert_array_equal(drawing.polygon, [[-1, 0], [0, 0], [0, 1], [-1, 1]])
    assert drawing.strands[0].start == SideCrossing(0, 0.75, -0.1)
    assert drawing.strands[0].end == SideCrossing(2, 0.25, -0.1)
    assert (drawing.strands[1].start.side, drawing.strands[1].end.side) == (3, 1)
    np.testing.assert_array_equal(drawing.strands[1].points, [[-0.75, 0.5, 0.1], [-0.25, 0.5, 0.1]])


def test_labels_decide_the_first_side_of_a_derived_face(tmp_path):
    """A face with two lower sides keeps both of them below when it is mirrored and its yarn is reversed."""
    text = """\
face right
edge (-1,0) -l1
edge (0,-1) -l1
edge (1,0) +y1
edge (1,1) +l1
edge (-1,1) -y1
derive left -l1 -l1 +y1 +l1 -y1 by mirror-x reverse-yarn from right -l1 -l1 +y1 +l1 -y1
"""
    drawing = read(tmp_path, text).find(FaceType("left", ("-l1", "-l1", "+y1", "+l1", "-y1")))
    np.testing.assert_array_equal(drawing.polygon, [[-1, 0], [0, -1], [1, 0], [1, 1], [-1, 1]])


def test_the_first_library_goes_before_the_others(tmp_path):
    for number, share in enumerate(("0.25", "0.5")):
        (tmp_path / f"{number}.sf").write_text(LIBRARY.replace("[0:0.25", f"[0:{share}"))
    library = read_face_libraries([tmp_path / "1.sf", tmp_path / "0.sf"])
    assert library.find(FaceType("over", ("-a1", "+e1", "+a1", "-e1"))).strands[0].start.along == 0.5
    assert library.find(FaceType("under", ("-a1", "+e1", "+a1", "-e1"))) is None


def test_a_face_without_an_area_is_refused(tmp_path):
    with pytest.raises(FileError, match="line 1: the corners of face flat enclose no area"):
        read(tmp_path, "face flat\nedge (0,0) x\nedge (1,1) x\nedge (2,2) x\n")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("face over", "over", "line 2: got 'over'; expected 'face name' first"),
        ("edge (1,0)", "edge (1,0,0)", "line 4: .*expected face, edge, yarn or derive"),
        ("edge (1,0)", "edge (1,1e999)", "line 4: .*expected finite numbers"),
        ("(0.75,0.5,-0.1)", "(0.75,0.5)", "line 8: .*expected points of three numbers"),
        ("[2:0.75", "[4:0.75", "line 2: a yarn of face over crosses side 4"),
        ("[2:0.75", "[2:1.75", "line 7: .*places along sides from 0 to 1"),
        ("mirror-z", "mirror-y", "line 10: derive: got 'mirror-y'; expected mirror-x"),
        ("from over -a1", "from under -a1", "line 9: no face is flipped"),
        ("flipped -a1 -e1 +a1 +e1 by", "flipped -a1 -e1 +a1 -e1 by", "line 10: derive flipped: got sides"),
    ],
)
def test_each_bad_line_gets_its_message(tmp_path, old, new, message):
    assert old in LIBRARY
    with pytest.raises(FileError, match=message):
        read(tmp_path, LIBRARY.replace(old, new, 1))
