# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A region of a fabric becomes the pattern that was laid there, and is laid elsewhere with the same stitches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit, apply_changes, apply_edit
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh.change import Marks, apply_change
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import (
    apply_pattern,
    capture_pattern,
    format_pattern,
    parse_pattern,
    pattern_mesh,
    read_pattern,
    smallest_repeat,
)
from stitchmesh.selection import select
from tests.chosen_patterns import CHOSEN_PATTERNS
from tests.editing.random_edits import bits
from tests.patterns.fabrics import flat, pattern, tube


def worked(fabric):
    return np.flatnonzero(fabric.stitch != Stitch.CAST_ON)


@pytest.mark.parametrize("name", CHOSEN_PATTERNS)
def test_one_tile_on_a_flat_piece_is_the_pattern(name):
    laid = read_pattern(name)
    piece = pattern_mesh(laid, stitch_width=1.0, stitch_height=1.0)
    assert capture_pattern(piece, worked(piece), name=laid.name, source=laid.source) == laid


@pytest.mark.parametrize("name", CHOSEN_PATTERNS)
def test_one_repeat_of_a_tube_is_the_smallest_repeat_of_the_pattern(name):
    laid = read_pattern(name)
    ring = apply_pattern(tube(3 * laid.width, 1 + laid.height), laid, remainder="refuse")
    captured = smallest_repeat(capture_pattern(ring, worked(ring)))
    assert captured.rows == smallest_repeat(laid).rows
    again = apply_pattern(tube(3 * laid.width, 1 + laid.height), captured, remainder="refuse")
    assert smallest_repeat(capture_pattern(again, worked(again))) == captured


def test_a_region_laid_elsewhere_gives_the_same_stitches_and_is_undone_exactly():
    """Every mark of a captured pattern that was edited by hand is laid again: twists, cables, yarns and increases."""
    piece = pattern_mesh(read_pattern("moss-cable"), 2, 3, stitch_width=1.0, stitch_height=1.0)
    some = np.flatnonzero(piece.row == 4)[[0, 1, 2]]
    piece = apply_change(piece, Marks("yarn", some, np.array([1, 2, 1])))
    piece = apply_change(piece, Marks("twist", piece.left_wale[some] - 1, np.array([1, -1, -1])))
    captured = capture_pattern(piece, select(piece, "rows 3-6"))
    assert parse_pattern(format_pattern(captured)) == captured
    other = flat(captured.width + 6, captured.height + 5)
    inner = (other.row >= 2) & (other.row < 2 + captured.height)
    column = np.arange(other.face_count) % (captured.width + 6)
    faces = np.flatnonzero(inner & (column >= 3) & (column < 3 + captured.width))
    edit = Edit("paste_pattern", {"pattern": format_pattern(captured), "faces": faces, "remainder": "refuse"})
    edited = apply_edit(other, edit)
    new = np.flatnonzero((edited.fabric.row >= 2) & (edited.fabric.row < 2 + captured.height))
    x = edited.fabric.vertices[edited.fabric.face_vertex[edited.fabric.face_start[new]]][:, 0]
    region = new[(x >= 2.99) & (x < 2.99 + captured.width)]
    assert capture_pattern(edited.fabric, region) == captured
    assert bits(apply_changes(edited.fabric, edited.inverse).fabric) == bits(other)


def test_colours_of_the_fabric_are_kept():
    piece = flat(4, 3)
    dyed = replace(piece, yarn=piece.yarn + 1, palette=np.array([[1, 2, 3], [9, 8, 7]], dtype=np.uint8))
    assert capture_pattern(dyed, worked(dyed)).palette == ((1, 2, 3), (9, 8, 7))
    assert capture_pattern(piece, worked(piece)).palette == ()


def test_a_ring_is_cut_beside_its_cables():
    """The cable joins the last two loops of the ring below and the first two; the cut lies on its right."""
    edit = Edit("set_cable", {"side": 4 * 10 + 2, "destinations": [2, 3, 0, 1], "layers": [1, 1, 0, 0]})
    ring = apply_edit(tube(12, 3), edit).fabric
    captured = capture_pattern(ring, worked(ring))
    assert captured.rows == parse_pattern("row 1 RS: c4b k8\nrow 2 WS: p12", "rope").rows


REFUSED = {
    "a cast-on row": (lambda: flat(6, 4), lambda fabric: None, "face 0, 1, 2 (+3 more): is cast-on"),
    "a face is missing": (lambda: flat(6, 4), lambda _: [7, 8, 13], "leaves out 1 of the 2 loops of the row below"),
    "a step below": (lambda: flat(6, 4), lambda _: [7, 13, 14], "takes 1 from elsewhere"),
    "two parts": (lambda: flat(6, 4), lambda _: [7, 8, 10, 11], "2 of its rows lie on no other row"),
    "two parts one above the other": (lambda: flat(6, 6), lambda _: [7, 8, 25, 26], "2 of its rows lie on no other"),
    "nothing": (lambda: flat(6, 4), lambda _: [], "got an empty region"),
    "a ring and a part of one": (lambda: tube(6, 4), lambda _: range(6, 17), "is a whole ring and row 2 (face 12) is"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_region_that_is_no_pattern_is_refused_in_one_line(case):
    make, choose, message = REFUSED[case]
    fabric = make()
    with pytest.raises(StitchMeshError) as error:
        capture_pattern(fabric, choose(fabric))
    assert message in str(error.value) and "\n" not in str(error.value)


def test_a_cable_at_the_limit_of_the_region_is_refused():
    piece = apply_pattern(flat(6, 3), parse_pattern("row 1 RS: c4f p2\nrow 2 WS: k2 p4", "rope"))
    row = np.flatnonzero(piece.row == 1)
    with pytest.raises(StitchMeshError, match=r"row 1 \(face 7\): loop 2 of the tile is crossed to place 4 of 3"):
        capture_pattern(piece, row[1:4])


def test_shaping_that_changes_the_number_of_loops_is_refused():
    piece = apply_edit(flat(4, 4), Edit("split_course_edge", {"side": 4 * 9 + 2})).fabric
    with pytest.raises(StitchMeshError, match=r"its tile leaves 5 loops, but row 1 is worked on 4.*row 2 by \+1"):
        capture_pattern(piece, np.flatnonzero((piece.row > 0) & (piece.row < 3)))


def test_the_smallest_repeat_keeps_borders_and_does_not_divide_cables():
    bordered = parse_pattern("row 1 RS: k1 | k1 p1 k1 p1 | p1\nrow 2 WS: k1 | k1 p1 k1 p1 | p1", "rib")
    least = smallest_repeat(bordered)
    assert (least.width, least.height, least.rows[0].left, least.rows[0].right) == (2, 1, 1, 1)
    assert smallest_repeat(parse_pattern("row 1 RS: c4f\nrow 2 WS: p4", "rope")).width == 4
    open_above = pattern("k ky", "k k k")
    assert smallest_repeat(open_above) == open_above
