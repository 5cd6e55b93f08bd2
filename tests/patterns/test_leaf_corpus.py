# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The knits of Leaf et al. 2018, table 3: each is in the library, and its chart agrees with its name."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh.stitch import Stitch, turned_over
from stitchmesh.patterns import Pattern, check_closes, pattern_names, read_pattern
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


def exchange_knit_and_purl(cells: np.ndarray) -> np.ndarray:
    """Return a chart with knit and purl exchanged."""
    return np.vectorize(lambda stitch: int(turned_over(Stitch(stitch))))(cells)


def slip_heights(cells: np.ndarray) -> set[int]:
    """Return the numbers of rows over which loops are slipped; the chart repeats upwards."""
    heights = set()
    for column in np.isin(cells, SLIPS).T:
        start = int(np.flatnonzero(~column)[0])
        runs = "".join("s" if slipped else " " for slipped in np.roll(column, -start))
        heights |= {len(run) for run in runs.split()}
    return heights


def test_the_table_has_29_knits():
    assert len(set(NAMES)) == 29


@pytest.mark.parametrize("name", NAMES)
def test_each_knit_is_in_the_library_closes_and_names_its_source(name):
    assert name in pattern_names()
    pattern = read_pattern(name)
    check_closes(pattern)
    assert pattern.name.replace(" ", "").lower() == name.replace("-", "")
    assert pattern.source.startswith(("Traditional", "Composed"))
    assert "Leaf et al. 2018" in pattern.source
    assert all(row.left == row.right == 0 for row in pattern.rows)


@pytest.mark.parametrize("name", NAMES)
def test_no_wale_is_slipped_in_every_row(name):
    # a column that is slipped in every row would be a single loop of unlimited length
    assert all(not np.isin(column, SLIPS).all() for column in stitches(name).T)


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


def test_herringbone_zigzags():
    floats = stitches("woven-transverse-herringbone")
    assert floats.shape == (24, 4)
    assert (np.count_nonzero(floats == Stitch.SLIP_FRONT, axis=1) == 2).all()
    steps = [
        step
        for below, above in zip(floats, np.roll(floats, -1, axis=0), strict=True)
        for step in (1, -1)
        if np.array_equal(np.roll(below, step), above)
    ]
    assert steps == [1] * 11 + [-1] * 12 + [1]
    assert is_shift_of(floats[:, ::-1], floats)


@pytest.mark.parametrize(
    "name",
    ["basketweave-rib-stitch", "block1", "block2", "lattice-with-seed-stitch", "rhombus-texture", "pyramid-stitch",
     "garter-block", "honeycomb", "slip-stitch-rib"],
)  # fmt: skip
def test_symmetric_knits_equal_their_mirror_images(name):
    assert is_shift_of(stitches(name)[:, ::-1], stitches(name))


def test_a_thunderbird_has_two_equal_wings_and_an_asymmetric_head():
    bird = stitches("thunderbird")[::-1] == Stitch.PURL
    mirror = bird[:, ::-1]
    body = slice(5, None)
    assert np.array_equal(bird[body], mirror[body])
    assert not np.array_equal(bird[:5], mirror[:5])
    spans = bird.sum(axis=1)
    assert spans.max() == 19 == spans[9]
    assert not bird[[0, -1]].any()
    assert not bird[:, [0, -1]].any()


def test_blocks_are_knit_where_their_neighbours_are_purl():
    for name, columns in (("block1", 8), ("block2", 5)):
        assert np.array_equal(np.roll(stitches(name), columns, axis=1), exchange_knit_and_purl(stitches(name)))


@pytest.mark.parametrize("name", ["tumbling-moss-blocks", "pyramid-stitch", "honeycomb", "garter-block"])
def test_the_second_half_equals_the_first_half_shifted_by_half_a_repeat(name):
    cells = stitches(name)
    rows, columns = cells.shape
    assert np.array_equal(np.roll(cells, (rows // 2, columns // 2), axis=(0, 1)), cells)


def test_tumbling_blocks_have_three_faces():
    rows = ["".join(Stitch(stitch).name[0] for stitch in row) for row in stitches("tumbling-moss-blocks")]
    assert rows[:6] == ["KPKPKPKPKP", "KKPKPKPKPP", "KKKPKPKPPP", "KKKKPKPPPP", "KKKKKPPPPP", "KKKKKPPPPP"]


def test_diamonds_of_stockinette_and_garter_are_separated_by_eyelets():
    pattern = read_pattern("stockinette-and-garter")
    assert (pattern.width, pattern.height) == (22, 36)
    for lace, plain in zip(pattern.rows[::2], pattern.rows[1::2], strict=True):
        made = [cell.stitch for cell in lace.cells]
        assert made.count(Stitch.YARN_OVER) == 2
        assert made.count(Stitch.D12K) == made.count(Stitch.D21K) == 1
        assert set(made) <= {Stitch.KNIT, Stitch.YARN_OVER, Stitch.D12K, Stitch.D21K}
        assert {cell.stitch for cell in plain.cells} == {Stitch.KNIT, Stitch.PURL}
    halves = stitches_of_plain_rows(pattern)
    assert np.array_equal(np.roll(halves[9:], 11, axis=1), exchange_knit_and_purl(halves[:9]))


def stitches_of_plain_rows(pattern: Pattern) -> np.ndarray:
    return np.array([[cell.stitch for cell in row.cells] for row in pattern.rows[1::2]])


@pytest.mark.parametrize(
    ("name", "heights"),
    [("honeycomb", {6}), ("slip-stitch-rib", {1}), ("long-slip-textured", {3}), ("jacquard1", {2})],
)
def test_loops_are_slipped_over_the_documented_numbers_of_rows(name, heights):
    assert slip_heights(stitches(name)) == heights


def test_each_jacquard_has_its_own_arrangement_of_slipped_loops():
    charts = {name: stitches(name) for name in ("jacquard1", "jacquard2", "jacquard3")}
    assert all(read_pattern(name).yarn_count == 2 for name in charts)
    behind, motif, brick = charts.values()
    back = behind == Stitch.SLIP_BACK
    assert not (back & np.roll(back, 1, axis=1)).any()  # no float is longer than one loop
    first, second = (motif[yarn::2] == Stitch.KNIT for yarn in (0, 1))
    assert np.array_equal(first, ~second)  # every loop of a course is knit by one of its two yarns
    assert (first.any(axis=1) & second.any(axis=1)).all()
    assert {Stitch.SLIP_FRONT, Stitch.SLIP_BACK} <= set(brick.ravel())
