# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Traced stitches of AutoKnit: the faces and joins of tubes and short rows, and one message for each bad line."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.io import read_stitches
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarngen import check_loops, generate_yarns

FLAT = """\
0 s a -1 -1 5 -1 0 0 0
0 s a -1 -1 4 -1 1 0 0
0 s a -1 -1 3 -1 2 0 0
0 k c 2 -1 6 -1 2 0.7 0
0 i c 1 -1 8 7 1 0.7 0
0 k c 0 -1 9 -1 0 0.7 0
1 e a 3 -1 -1 -1 2 1.4 0
1 e c 4 -1 -1 -1 0.75 1.4 0
1 e c 4 -1 -1 -1 1.25 1.4 0
1 e c 5 -1 -1 -1 0 1.4 0
"""
"""A row to the right, a row to the left with an increase, and ends of another yarn."""


def tube(around: int, rounds: int) -> str:
    """Return a spiral of knit stitches around the z axis, with a stitch width of 1."""
    count, radius = around * rounds, around / (2 * np.pi)
    lines = []
    for i in range(count):
        angle = 2 * np.pi * i / around
        kind = "s" if i < around else "e" if i >= count - around else "k"
        below, above = (i - around if i >= around else -1), (i + around if i < count - around else -1)
        place = f"{radius * np.cos(angle):.6f} {radius * np.sin(angle):.6f} {0.7 * i / around:.6f}"
        lines.append(f"0 {kind} a {below} -1 {above} -1 {place}")
    return "\n".join(lines)


def read(folder, text) -> StitchMesh:
    (folder / "a.st").write_text(text)
    return read_stitches(folder / "a.st")


def test_a_tube_is_a_spiral_with_two_borders(tmp_path):
    """Each inner corner is the mean of four corners that its stitches put at the same place, up to the curvature."""
    fabric = read(tmp_path, tube(12, 5))
    assert len(fabric.boundary_loops) == 2
    assert fabric.face_count == 60
    assert fabric.stitch.tolist() == [Stitch.CAST_ON] * 12 + [Stitch.KNIT] * 48
    normal = fabric.face_vector_area[30] / np.linalg.norm(fabric.face_vector_area[30])
    outward = fabric.corner_position[fabric.face_start[30] : fabric.face_start[31]].mean(axis=0) * [1, 1, 0]
    assert normal @ outward / np.linalg.norm(outward) > 0.99  # the right side is outside


def test_directions_decide_what_lies_to_the_right(tmp_path):
    fabric = read(tmp_path, FLAT)
    assert fabric.stitch.tolist()[3:6] == [Stitch.KNIT, Stitch.YK, Stitch.KNIT]
    assert fabric.yarn.tolist() == [0] * 6 + [1] * 4
    right = fabric.twin[fabric.right_wale]
    beside = np.where(right == BORDER, -1, fabric.side_face[right])
    assert beside.tolist() == [1, 2, -1, -1, 3, 4, -1, -1, 7, 8]
    # The increase leads left with its second loop; upper sides run from right to left.
    tops = fabric.face_start[4] + np.array([2, 3])
    assert fabric.side_face[fabric.twin[tops]].tolist() == [8, 7]


def short_row(width: int = 6) -> str:
    """Return a flat piece: a row to the right, turned after four stitches of the next row to the right."""
    lines = [f"0 s a -1 -1 {2 * width - 1 - i} -1 {i} 0 0" for i in range(width)]
    first, second = width, 2 * width
    turn = second + 3
    for k in range(width):
        x = width - 1 - k
        up = {0: second, 1: second + 1, 2: second + 2, 3: turn}.get(x, -1)
        kind = "e" if up == -1 else "k"
        lines.append(f"0 {kind} c {x} -1 {up} -1 {x} 0.7 0")
    for x in range(3):
        lines.append(f"0 k a {first + width - 1 - x} -1 {turn + 4 - x} -1 {x} 1.4 0")
    lines.append(f"0 t a {first + width - 4} -1 {turn + 1} -1 3 1.3 0")
    lines.append(f"0 e c {turn} -1 -1 -1 3 1.5 0")
    lines += [f"0 e c {second + x} -1 -1 -1 {x} 2.1 0" for x in (2, 1, 0)]
    return "\n".join(lines)


def test_a_turn_is_a_border_of_a_wrapped_stitch(tmp_path):
    fabric = read(tmp_path, short_row())
    wrapped = int(np.flatnonzero(fabric.stitch == Stitch.WRAP)[0])
    assert fabric.twin[fabric.right_wale[wrapped]] == BORDER
    assert fabric.side_face[fabric.twin[fabric.left_wale[wrapped]]] == wrapped - 1
    assert len(fabric.boundary_loops) == 1


def test_traced_stitches_become_yarns_whose_loops_hold(tmp_path):
    fabric = read(tmp_path, tube(8, 4))
    check_loops(fabric, generate_yarns(fabric, quality="draft"))


def test_a_join_that_would_pinch_a_border_is_left_out(tmp_path):
    """A tube divides in two; the yarn of the first branch crosses the gap, and the other branch begins at the gap."""
    fabric = read(tmp_path, divided_tube())
    start, end = fabric.face_vertex, fabric.face_vertex[fabric.side_next]
    assert (start != end).all()
    assert fabric.side_length.min() > 0.1


def divided_tube() -> str:
    """Return two rounds of 8 stitches, then a branch of 4 stitches and two rounds, then the other branch."""

    def place(i: int) -> str:
        angle = 2 * np.pi * (i % 8) / 8
        return f"{1.3 * np.cos(angle):.4f} {1.3 * np.sin(angle):.4f}"

    below = {i: i - 8 for i in range(8, 16)} | {16 + k: 12 + k for k in range(4)} | {20 + k: 16 + k for k in range(4)}
    below |= {24 + k: 8 + k for k in range(4)} | {28 + k: 24 + k for k in range(4)}
    above = {low: high for high, low in below.items()}
    column = {i: i % 8 for i in range(16)}
    for i in range(16, 32):
        column[i] = column[below[i]]
    levels = [0.0] * 8 + [0.7] * 8 + [1.4] * 4 + [2.1] * 4 + [1.4] * 4 + [2.1] * 4
    lines = []
    for i in range(32):
        kind = "s" if i < 8 else "k" if i in above else "e"
        lines.append(f"0 {kind} a {below.get(i, -1)} -1 {above.get(i, -1)} -1 {place(column[i])} {levels[i]}")
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0 s a -1 -1 5 -1 0 0 0", "0 s a -1 -1 5 -1 0 0", "line 1: .*expected yarn, type, direction"),
        ("0 s a -1 -1 5", "0 p a -1 -1 5", "line 1: .*expected a type of s e k t m i d"),
        ("0 s a -1 -1 5", "-1 s a -1 -1 5", "line 1: .*expected numbers of a yarn"),
        ("0 s a -1 -1 5 -1 0", "0 s a -1 -1 5 -1 nan", "line 1: .*coordinates must be finite"),
        ("0 k c 2 -1 6 -1", "0 k c 2 -1 6 7", "line 4: .*expected 1 below and 1 above"),
        ("0 k c 2 -1 6 -1", "0 k c 1 -1 6 -1", "line 3: stitch 2 is below stitch 3|line 4: stitch 3 is above stitch 1"),
        ("0 i c 1 -1 8 7", "0 i c 1 -1 8 8", "stitch 7 is above stitch 4|stitch 8 is above stitch 4"),
        ("1 e a 3 -1", "1 e a 8 -1", "line 4: stitch 3 is below stitch 6|line 7: stitch 6 is above stitch 8"),
    ],
)
def test_each_bad_line_gets_its_message(tmp_path, old, new, message):
    assert old in FLAT
    with pytest.raises(FileError, match=message):
        read(tmp_path, FLAT.replace(old, new, 1))
