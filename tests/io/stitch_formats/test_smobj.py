# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The text format of stitch meshes: written files are read without loss, and files of other programs are read."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.cli import main as cli
from stitchmesh.errors import FileError
from stitchmesh.io import read_mesh, read_stitches, write_stitches
from stitchmesh.io.any_file import read_any
from stitchmesh.io.stitch_formats.smobj import FACE_NAMES
from stitchmesh.labeling import label
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.stitch import SIDE_COUNTS, VOCABULARY, Stitch
from stitchmesh.tessellate import tessellate
from tests.gallery import ROOT
from tests.io.test_stitches import increase_on_a_decrease, one_stitch_torus
from tests.meshrelax.fabrics import grid_fabric, tube_points

EXACT = [field.name for field in dataclasses.fields(StitchMesh) if field.name not in ("lattice", "stretch")]


def marked() -> StitchMesh:
    """Return a tube with a cable, twisted loops, two yarns and rows that are not in the order of the faces."""
    plain = grid_fabric(tube_points(6, 3, 2.0, 3.0), wrap=True)
    shift, layer, twist = np.zeros((3, plain.side_count), dtype=np.int64)
    for face, places, front in [(6, 1, 0), (7, 1, 0), (8, -2, 1)]:
        shift[4 * face + 2], layer[4 * face + 2] = places, front
    twist[[2, 6]] = 1, -1
    return dataclasses.replace(
        plain, yarn=plain.row % 2, row=plain.row + 4, twist=twist, cable_shift=shift, cable_layer=layer
    )


def hat() -> StitchMesh:
    """Return a garment of few stitches, with increases and decreases."""
    return tessellate(label(read_mesh(ROOT / "assets" / "meshes" / "hat.obj")), stitch_width=2.0)


def all_stitches() -> StitchMesh:
    """Return one separate face of each kind; the positions have no short decimal form."""
    counts = [SIDE_COUNTS.get(stitch, (1, 2)) for stitch in Stitch]
    counts[Stitch.DRAW_THROUGH] = (2, 0)
    corners: list[np.ndarray] = []
    for number, (n_bottom, n_top) in enumerate(counts):
        angle = 2.0 * np.pi * np.arange(n_bottom + n_top + 2) / (n_bottom + n_top + 2)
        corners.append(np.stack([3.0 * number + np.cos(angle), np.sin(angle), np.pi * angle], axis=1))
    start = np.concatenate([[0], np.cumsum([len(face) for face in corners])])
    return StitchMesh(
        np.concatenate(corners), start, np.arange(start[-1]), np.full(start[-1], BORDER),
        n_bottom=[below for below, _ in counts], n_top=[above for _, above in counts],
        stitch=list(Stitch), row=np.arange(len(Stitch)),
    )  # fmt: skip


@pytest.mark.parametrize("make", [increase_on_a_decrease, one_stitch_torus, marked, all_stitches, hat])
def test_round_trip_is_the_identity(tmp_path, make):
    """All fields except the stretch have the same bits."""
    fabric = make()
    write_stitches(tmp_path / "s.smobj", fabric)
    again = read_any(tmp_path / "s.smobj")
    assert type(again) is StitchMesh
    for name in EXACT:
        np.testing.assert_array_equal(getattr(again, name), getattr(fabric, name), err_msg=name)
    if fabric.lattice is not None:
        np.testing.assert_array_equal(again.lattice.periods, fabric.lattice.periods)


def test_the_documentation_names_the_faces():
    """The table lists the names that do not follow the rule for increases and decreases."""
    table = (ROOT / "docs" / "formats.md").read_text()
    for stitch, name in FACE_NAMES.items():
        code = VOCABULARY[stitch].code if stitch in VOCABULARY else ""
        by_rule = name in (f"make-{code}+", f"decrease-{code[1:]}+")
        assert by_rule or f"`{name}`" in table


def test_convert_writes_and_reads_smobj(tmp_path):
    first, text, last = (str(tmp_path / name) for name in ("a.h5", "b.smobj", "c.h5"))
    fabric = marked()
    write_stitches(first, fabric)
    assert cli.main(["convert", first, text]) == 0
    assert cli.main(["convert", text, last]) == 0
    for name in EXACT:
        np.testing.assert_array_equal(getattr(read_stitches(last), name), getattr(fabric, name), err_msg=name)


FOREIGN = """\
L knit- -lX -yX +lX +yX # its row runs to the left
L knit-to-right -l1 +y1 +l1 -y1
L decrease-left+ -lX -lX +yX +lX -yX
L edge) x x x +y1 -y1
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 1.5 0 0
v 2.5 0 0
v 2.5 1 0
v 1.5 1 0
v 0 1.5 0
v 1.25 1.5 0
v 2.5 1.5 0
v 2.5 2.5 0
v 0 2.5 0
f 1 2 3 4
T 1
N 7
f 5/1 6/2 7/2 8/4
T 2
N 8
f 9 10 11 12 13
T 3
N 0
e 1/2 2/-4
e 1/-3 3/1
e 2/3 3/-2
U 1 1.0
"""
"""A file as other programs write it: two stitches below a decrease, no shared vertices, gaps between the faces."""


def read_text(tmp_path: Path, text: str) -> StitchMesh:
    path = tmp_path / "foreign.smobj"
    path.write_text(text)
    return read_stitches(path)


def test_records_that_describe_no_stitches_are_left_out_unread(tmp_path):
    expected = read_text(tmp_path, FOREIGN)
    found = read_text(tmp_path, FOREIGN.replace("U 1 1.0", "U of another form\nh 99/1 q\nc 1"))
    np.testing.assert_array_equal(found.twin, expected.twin)


def test_yarn_without_a_direction_runs_either_way(tmp_path):
    found = read_text(tmp_path, FOREIGN.replace("-lX -yX +lX +yX", "-lX yX +lX yX"))
    assert found.stitch.tolist() == [Stitch.KNIT, Stitch.KNIT, Stitch.D21K]


def test_connections_join_the_faces_of_other_programs(tmp_path):
    fabric = read_text(tmp_path, FOREIGN)
    assert fabric.stitch.tolist() == [Stitch.KNIT, Stitch.KNIT, Stitch.D21K]
    assert fabric.row.tolist() == [0, 0, 1]
    assert len(fabric.vertices) == 8  # Of 13 vertices in the file, three pairs and one triple are merged.
    # The vertex between all three faces is at the mean of (1, 1), (1.5, 1) and (1.25, 1.5).
    np.testing.assert_allclose(fabric.vertices[fabric.face_vertex[2]], [1.25, 3.5 / 3.0, 0.0], atol=1e-15)
    assert fabric.twin.tolist() == [-1, 7, 8, -1, -1, -1, 9, 1, 2, 6, -1, -1, -1]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("T 3\n", "T 1\n", "line 25: got 'T 1'; the face has 5 corners and its type knit- has 4 sides"),
        ("-lX -lX +yX +lX -yX", "-lX +yX -lX +lX -yX", r"line 3: decrease-left\+: got sides -lX \+yX -lX .*expected"),
        ("e 1/2 2/-4", "e 1/2 2/4", "line 27: faces 1 and 2 are joined without reversal"),
        ("e 1/-3 3/1", "e 1/-4 3/1", "wale to one face and course to face 2"),
        ("U 1 1.0", "Q 1 1.0", "line 30: got 'Q 1 1.0'; expected a record of an .smobj file"),
        ("U 1 1.0", "#stitchmesh row 3", "line 30: got #stitchmesh 'row 3'; expected counts"),
        ("U 1 1.0", "#stitchmesh counts 4 3", "got 3 faces and 3 connections of 4 and 3; the file was cut short"),
        ("U 1 1.0", "#stitchmesh face 0 0 9 1 0 0", "line 30: side 9 has marks but does not exist"),
        ("U 1 1.0", "#stitchmesh face 0 0 4 2 0 0", "twist 2; expected -1, 0 or 1"),
    ],
)
def test_each_bad_line_gets_its_message(tmp_path, old, new, message):
    assert old in FOREIGN
    with pytest.raises(FileError, match=message) as caught:
        read_text(tmp_path, FOREIGN.replace(old, new, 1))
    assert "\n" not in str(caught.value) and str(caught.value).startswith(str(tmp_path))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "is a folder"),
        (b"", "the file is empty"),
        (b"\x89HDF\0\0", "holds binary data"),
        (b"solid cube\n", "line 1: got 'solid cube'; expected a record of an .smobj file"),
        (b"# nothing\n", "got no faces"),
    ],
)
def test_other_files_give_their_messages_on_the_command_line(tmp_path, capsys, content, message):
    path = tmp_path / "s.smobj"
    if content is None:
        path.mkdir()
    else:
        path.write_bytes(content)
    assert cli.main(["convert", str(path), str(tmp_path / "s.h5")]) == 2
    printed = capsys.readouterr().err
    assert message in printed and printed.count("\n") == 1
    assert not (tmp_path / "s.h5").exists()
