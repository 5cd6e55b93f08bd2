# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The knits of Leaf et al. 2018, table 3: each is in the library, and its chart agrees with its name."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import check_closes, pattern_names, read_pattern
from tests.patterns.fabrics import is_shift_of, stitches

TABLE_3 = (
    "Alternating Diagonals", "Basketweave Rib Stitch", "Block1", "Block2", "Cartridge Belt Rib",
    "Double Basket Pattern", "Garter Block", "Honeycomb", "Jacquard1", "Jacquard2", "Jacquard3",
    "King Charles Brocade", "Lattice With Seed Stitch", "Left Diagonal", "Left Diagonal Rib", "Long Slip Textured",
    "Parallelograms", "Pie Crust Basketweave", "Pyramid Stitch", "Rhombus Texture", "Right Diagonal",
    "Right Diagonal Rib", "Seersucker", "Slip Stitch Honeycomb", "Slip Stitch Rib", "Stockinette And Garter",
    "Thunderbird", "Tumbling Moss Blocks", "Woven Transverse Herringbone",
)  # fmt: skip
NAMES = tuple(name.lower().replace(" ", "-") for name in TABLE_3)
SLIPS = (Stitch.SLIP_BACK, Stitch.SLIP_FRONT)


def slip_heights(cells: np.ndarray) -> set[int]:
    """Return the numbers of rows over which loops are slipped; the chart repeats upwards."""
    heights = set()
    for column in np.isin(cells, SLIPS).T:
        start = int(np.flatnonzero(~column)[0])
        runs = "".join("s" if slipped else " " for slipped in np.roll(column, -start))
        heights |= {len(run) for run in runs.split()}
    return heights


@pytest.mark.parametrize("name", NAMES)
def test_each_knit_is_in_the_library_closes_and_names_its_source(name):
    assert name in pattern_names()
    pattern = read_pattern(name)
    check_closes(pattern)
    assert pattern.name.replace(" ", "").lower() == name.replace("-", "")
    assert pattern.source.startswith(("Traditional", "Composed"))
    assert "Leaf et al. 2018" in pattern.source
    assert all(row.left == row.right == 0 for row in pattern.rows)
    # A column that is slipped in every row would be a single loop of unlimited length.
    assert not np.isin(stitches(name), SLIPS).all(axis=0).any()


@pytest.mark.parametrize("name", NAMES)
def test_a_chart_holds_exactly_one_repeat(name):
    rows = read_pattern(name).rows
    assert not any(rows == rows[step:] + rows[:step] for step in range(1, len(rows)))
    charts = [[(cell.stitch, cell.yarn) for cell in row.cells] for row in rows]
    width = len(charts[0])
    assert not any(all(row == row[step:] + row[:step] for row in charts) for step in range(1, width))


def test_no_two_names_share_a_chart():
    library = {name: read_pattern(name) for name in pattern_names()}
    assert len({pattern.rows for pattern in library.values()}) == len(library)


@pytest.mark.parametrize("name", ["diagonal", "diagonal-rib"])
def test_left_is_the_mirror_image_of_right(name):
    right, left = stitches(f"right-{name}"), stitches(f"left-{name}")
    assert np.array_equal(left, right[:, ::-1])
    assert not is_shift_of(left, right)


@pytest.mark.parametrize(("name", "step"), [("right-diagonal", 1), ("right-diagonal-rib", 1), ("left-diagonal", -1)])
def test_a_diagonal_moves_by_one_stitch_in_each_row(name, step):
    cells = stitches(name)
    assert np.array_equal(np.roll(cells, step, axis=1), np.roll(cells, -1, axis=0))


@pytest.mark.parametrize(
    "name",
    ["basketweave-rib-stitch", "block1", "block2", "lattice-with-seed-stitch", "rhombus-texture", "pyramid-stitch",
     "garter-block", "honeycomb", "slip-stitch-rib"],
)  # fmt: skip
def test_symmetric_knits_equal_their_mirror_images(name):
    assert is_shift_of(stitches(name)[:, ::-1], stitches(name))


@pytest.mark.parametrize(
    ("name", "heights"),
    [("honeycomb", {6}), ("slip-stitch-rib", {1}), ("long-slip-textured", {3}), ("jacquard1", {2})],
)
def test_loops_are_slipped_over_the_documented_numbers_of_rows(name, heights):
    assert slip_heights(stitches(name)) == heights
