# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flat stitch meshes of patterns."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import Loop, pattern_mesh, pattern_names, read_pattern
from stitchmesh.patterns.placement.block import NARROWEST, course_points
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from tests.chosen_patterns import CHOSEN_PATTERNS
from tests.patterns.fabrics import checked, pattern

SIZE = {"stitch_width": 0.8, "stitch_height": 0.6}


def row_stitches(fabric, row):
    """Return the stitches of a row of a flat piece, left to right."""
    faces = np.flatnonzero(fabric.row == row)
    across = np.add.reduceat(fabric.corner_position[:, 0], fabric.face_start[:-1]) / np.diff(fabric.face_start)
    return fabric.stitch[faces[np.argsort(across[faces])]].tolist()


@pytest.mark.parametrize("name", CHOSEN_PATTERNS)
def test_the_rows_of_a_flat_piece_equal_the_rows_of_its_pattern(name):
    chosen = read_pattern(name)
    piece = checked(pattern_mesh(chosen, 2, 2, **SIZE))
    for row, cells in enumerate([*chosen.rows, *chosen.rows], start=1):
        left, tile, right = ([int(cell.stitch) for cell in section] for section in cells.sections)
        assert row_stitches(piece, row) == left + 2 * tile + right
    assert (piece.face_vector_area[:, 2] > 0.0).all()
    width = (chosen.rows[0].n_bottom + chosen.width) * 0.8
    whole = width * (2 * chosen.height + 1) * 0.6
    assert piece.face_vector_area[:, 2].sum() == pytest.approx(whole, rel=1e-12)  # sums of rounded numbers


@pytest.mark.parametrize("name", pattern_names())
def test_every_pattern_of_the_library_gives_yarns_that_are_linked_as_the_stitches_require(name):
    chosen = read_pattern(name)
    piece = pattern_mesh(chosen, 1, 2 if chosen.height < 8 else 1, **SIZE)  # rows meet in one repeat if there are many
    yarns = generate_yarns(piece, yarn_radius=0.06, quality="draft")
    assert set(yarns.face.tolist()) == set(range(piece.face_count))
    check_loops(piece, yarns)


def test_borders_occur_once_at_the_edges():
    piece = pattern_mesh(pattern("p k b p", left=1, right=1), 3, 1, **SIZE)
    k, p, slipped = Stitch.KNIT, Stitch.PURL, Stitch.SLIP_BACK
    assert row_stitches(piece, 1) == [p, *[k, slipped] * 3, p]


def test_borders_with_increases_and_decreases_lie_beside_the_tiles():
    piece = checked(pattern_mesh(pattern("y d12k k k y d12k p", left=2, right=1), 2, 1, **SIZE))
    tile = [Stitch.KNIT, Stitch.KNIT, Stitch.YARN_OVER, Stitch.D12K]
    assert row_stitches(piece, 1) == [Stitch.YARN_OVER, Stitch.D12K, *tile, *tile, Stitch.PURL]


def test_marks_lie_on_the_loops_below():
    twisted = (Loop(twist=-1), *(Loop(),) * 3)
    piece = pattern_mesh(pattern("k k k k", below={0: twisted}), 2, 1, **SIZE)
    marked = np.flatnonzero(piece.twist)
    assert piece.side_face[marked].tolist() == [0, 4]
    assert (piece.twist[marked] == -1).all()
    assert (piece.stitch[[0, 4]] == Stitch.CAST_ON).all()


@pytest.mark.parametrize("first", ["k k k k k", "k d12k y k k"])
def test_crossings_lie_on_the_loops_below_their_row(first):
    held = tuple(Loop(shift, layer) for shift, layer in ((1, 1), (-1, 0), (2, 1), (0, 0), (-2, 2)))
    piece = pattern_mesh(pattern("k k k k k", first, below={1: held}), 2, 2, **SIZE)
    groups = cable_groups(piece)
    assert sorted({tuple(group.destination) for group in groups}) == [(1, 0), (2, 1, 0)]
    assert len(groups) == 8
    rows = {int(row) for group in groups for row in piece.row[piece.side_face[group.sides]]}
    assert rows == {1, 3}


@pytest.mark.parametrize("first", ["k k k k k", "k d12k y k k"])
def test_the_first_row_crosses_the_last_of_the_repeat_below(first):
    held = (Loop(1, 1), Loop(-1, 0), Loop(twist=1), Loop(), Loop())
    piece = pattern_mesh(pattern(first, "k k k k k", below={0: held}), 1, 2, **SIZE)
    groups = cable_groups(piece)
    assert [piece.row[piece.side_face[group.sides[0]]] for group in groups] == [0, 2]
    assert (piece.twist != 0).sum() == 2


def test_equal_loop_counts_give_equal_loop_widths():
    lines = course_points([4, 4, 4], [(row, place, place) for row in (0, 1) for place in (1, 2, 3)])
    assert all(np.allclose(line, range(5), atol=1e-12) for line in lines)  # rounding of the solver


def test_no_loop_is_narrow_even_if_wales_lean_strongly():
    rows = 12
    loops = [16] * (rows + 1)
    wales = [(row, place, max(place - 3, 0)) for row in range(rows) for place in range(1, 16)]
    for line in course_points(loops, wales):
        assert np.diff(line).min() >= NARROWEST


@pytest.mark.parametrize(
    ("columns", "rows", "size", "message"),
    [
        (0, 1, SIZE, "columns: got 0"),
        (1, 0, SIZE, "rows: got 0"),
        (1, 1, {**SIZE, "stitch_width": -1.0}, "stitch width: got -1.0 cm"),
        (1, 1, {**SIZE, "stitch_height": np.nan}, "stitch height: got nan cm"),
    ],
)
def test_sizes_are_checked(columns, rows, size, message):
    with pytest.raises(ParameterError, match=message):
        pattern_mesh(read_pattern("rib2x2"), columns, rows, **size)


def test_a_pattern_that_does_not_close_is_refused():
    with pytest.raises(PatternError, match=r"its tile leaves 3 loops, but row 1 is worked on 2; .* row 1 by \+1"):
        pattern_mesh(pattern("k y k"), 1, 1, **SIZE)
