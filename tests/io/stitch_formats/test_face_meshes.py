# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Face meshes in ``.smobj`` files: every record is kept, stitches become stitches, and bad lines get one message."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.cli import main as cli
from stitchmesh.errors import FileError
from stitchmesh.faces.face_mesh import Checkpoint, FaceMesh
from stitchmesh.faces.face_type import FaceType, is_foreign, stitch_of
from stitchmesh.io import read_stitches
from stitchmesh.io.any_file import read_any
from stitchmesh.io.stitch_formats.face_meshes import holds_foreign_faces, read_face_mesh, write_face_mesh
from stitchmesh.mesh.stitch import Stitch
from tests.faces.face_files import EVERY_RECORD, KNIT, WEAVE, assert_same_faces, flat_file


def written(folder, text, name="a.smobj"):
    path = folder / name
    path.write_text(text)
    return path


def test_every_record_is_read(tmp_path):
    mesh = read_face_mesh(written(tmp_path, EVERY_RECORD))
    assert [mesh.type_of(face).name for face in range(4)] == ["knit+", "drop", "edge(", "tuck-behind-to-right"]
    assert mesh.source_line.tolist() == [12, -1, 0, 7]
    assert mesh.face_vertex.tolist() == [0, 1, 2, 3, 1, 4, 2, 2, 0, 1, 4, 2, 3, 0, 1, 2, 3]
    assert mesh.reverses.tolist() == [True, False, True]
    assert [mesh.side_at(corner) for corner in mesh.joins[1].tolist()] == [(0, 2), (3, 2)]
    assert [record[0] for record in mesh.hints] == ["h", "h", "o", "t", "I", "o", "ci", "xfer"]
    assert mesh.units == (("1", 1.0), ("na", 0.125))
    assert mesh.checkpoints == (Checkpoint(0, 3, 0, ((1.0, 0), (2.0, 1))), Checkpoint(2, 2, 0, ()))
    assert mesh.corner_texture[:3] == ("/1", "/2", "")
    assert len(mesh.texture) == 3


@pytest.mark.parametrize("text", [EVERY_RECORD, flat_file(WEAVE, ["01", "10"])])
def test_nothing_is_lost_when_a_file_is_written_back(tmp_path, text):
    mesh = read_face_mesh(written(tmp_path, text))
    write_face_mesh(tmp_path / "b.smobj", mesh)
    assert_same_faces(read_face_mesh(tmp_path / "b.smobj"), mesh)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("T 5", "T 6", "line 23: got 'T 6'; expected a number of the 5 L lines"),
        ("T 5", "T 4", "line 23: .*the face has 4 corners and its type edge. has 5 sides"),
        ("N 12", "N 12\nN 1 2", "line 17: got 'N 1 2'; expected 'N' and a line number"),
        ("L edge( x -y1 +y1 x x", "L edge( x x", "line 4: .*at least three labels"),
        ("v 3 0 0", "v 3 0 inf", "line 10: .*coordinates must be finite"),
        ("f 2 5 3 -3", "f 2 5 3 -6", "line 17: .*vertex -6 does not exist; 5 vertices"),
        ("e 1/2 2/-4", "e 1/2 2/-5", "line 25: .*side 5 of face 2 does not exist; it has 4 sides"),
        ("e 1/2 2/-4", "e 1/3 2/-4", "line 26: .*side 3 of face 1 is joined twice"),
        ("h 1/1 f20 u", "h 9/1 f20 u", "line 28: .*face 9 does not exist; 4 faces"),
        ("o 1/1", "o x/1", "line 30: .*expected 'o' and a face"),
        ("U 1 1", "U n 1", "line 36: .*the first unit is named 1"),
        ("1 1 2 2", "1 1 2 3", "line 38: .*numbers of the 2 U lines"),
        ("U na", "Q na", "line 37: .*expected a record of an .smobj file"),
    ],
)
def test_each_bad_line_gets_its_message(tmp_path, old, new, message):
    assert old in EVERY_RECORD
    with pytest.raises(FileError, match=message) as caught:
        read_face_mesh(written(tmp_path, EVERY_RECORD.replace(old, new, 1)))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("words", "stitch"),
    [
        ("knit-to-left -l1 -y1 +l1 +y1", Stitch.KNIT),
        ("decrease-right- -lX -lX -yX +lX +yX", Stitch.D12K),
        ("tuck-twist+ -l0 +y1 +l1 -y1", Stitch.CAST_ON),
        ("knit-to-right -l1 +y0 +l0 -y0", None),  # a dropped loop, by its counts
        ("knit-to-right -l2 +y1 +l1 -y1", None),
        ("knit+ -lX +yX +lX +yX", None),  # both yarns leave
        ("knit-fair-isle-1+ -lX +yX +lX -yX", None),
    ],
)
def test_a_type_is_a_stitch_by_its_name_and_its_counts(words, stitch):
    name, *labels = words.split()
    assert stitch_of(FaceType(name, tuple(labels))) is stitch


def test_faces_that_only_end_loops_are_left_out_of_the_stitches(tmp_path, caplog):
    """The stitches have the connections and corners that they have in a file without the last row."""
    caplog.set_level("INFO")
    with_drops = read_stitches(written(tmp_path, flat_file(KNIT, ["000", "111", "222"])))
    without = read_stitches(written(tmp_path, flat_file(KNIT, ["000", "111"])))
    assert "3 drop" in caplog.text
    np.testing.assert_array_equal(with_drops.twin, without.twin)
    np.testing.assert_array_equal(with_drops.corner_position, without.corner_position)
    assert with_drops.stitch.tolist() == [Stitch.CAST_ON] * 3 + [Stitch.KNIT] * 3


def test_a_file_without_stitches_is_a_face_mesh_but_no_stitch_mesh(tmp_path):
    path = written(tmp_path, flat_file(WEAVE, ["01", "10"]))
    assert holds_foreign_faces(path)
    assert isinstance(read_any(path), FaceMesh)
    with pytest.raises(FileError, match="2 over, 2 under are no stitches; `stitchmesh yarns` draws"):
        read_stitches(path)


def test_unused_foreign_types_do_not_make_a_file_foreign(tmp_path):
    assert is_foreign(FaceType("drop", ("-l1", "+y0", "+l0", "-y0")))
    assert not holds_foreign_faces(written(tmp_path, flat_file(KNIT, ["00", "11"])))


def test_info_lists_the_faces(tmp_path, capsys):
    assert cli.main(["info", str(written(tmp_path, EVERY_RECORD))]) == 0
    assert "4 faces, 3 of them no stitches, 3 joins" in capsys.readouterr().out
