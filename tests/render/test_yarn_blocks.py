# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Blocks hold every segment once, in runs that need no other run; packed places and colours are as good as promised."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.render.yarn_blocks import (
    LEVELS,
    PALETTE_SIZE,
    RUN,
    RUNS_OF_BLOCK,
    YarnBlocks,
    indexed_colours,
    make_blocks,
    pack_colours,
    pack_points,
)
from stitchmesh.yarn import YarnSet
from tests.yarn.test_strand_distance import lines
from tests.yarnrelax.stockinette import tube, woven_cell


def segments_of(blocks: YarnBlocks) -> np.ndarray:
    """The four stored points of each segment of all runs, shape (S, 4)."""
    counts = np.diff(blocks.run_start) - 3
    first = np.concatenate([start + np.arange(count) for start, count in zip(blocks.run_start, counts, strict=False)])
    return first[:, None] + np.arange(4)


@pytest.mark.parametrize("yarns", [tube(12, 30), lines(0.0, 1.0, 2.0)], ids=["closed", "open"])
def test_the_runs_hold_the_control_points_of_each_segment_once(yarns: YarnSet):
    blocks = make_blocks(yarns)
    own = blocks.source[segments_of(blocks)]
    order = np.lexsort(own.T)
    expected = yarns.segment_points[np.lexsort(yarns.segment_points.T)]
    np.testing.assert_array_equal(own[order], expected)
    assert (np.diff(blocks.run_start) <= RUN + 3).all() and (np.diff(blocks.block_start) <= RUNS_OF_BLOCK).all()
    assert blocks.block_start[-1] == len(blocks.radius) == len(blocks.run_start) - 1


def test_runs_of_a_periodic_cell_continue_in_its_images():
    """The curves of the runs are those of the segments with their lattice shifts, up to whole periods."""
    yarns = woven_cell()
    blocks = make_blocks(yarns)
    assert blocks.shift is not None and yarns.point_shift is not None
    stored = yarns.points[blocks.source] + blocks.shift
    corners = segments_of(blocks)
    whole = yarns.points[yarns.segment_points] + yarns.point_shift
    found = {tuple(points): np.ptp(places, axis=0) for points, places in zip(
        blocks.source[corners].tolist(), stored[corners], strict=True)}  # fmt: skip
    for points, places in zip(yarns.segment_points.tolist(), whole, strict=True):
        # single precision of coordinates of order one
        np.testing.assert_allclose(found[tuple(points)], np.ptp(places, axis=0), atol=1e-6)


def test_segments_can_be_left_out():
    yarns = tube(6, 30)
    chosen = np.flatnonzero(yarns.points[yarns.segment_points[:, 1], 0] > 0.0)
    blocks = make_blocks(yarns, chosen)
    own = blocks.source[segments_of(blocks)]
    expected = yarns.segment_points[chosen]
    np.testing.assert_array_equal(own[np.lexsort(own.T)], expected[np.lexsort(expected.T)])


def test_blocks_are_small_in_space():
    """The boxes of the blocks together are much smaller than that many boxes of the whole fabric."""
    yarns = tube(40, 208)
    blocks = make_blocks(yarns)
    packed = pack_points(blocks, yarns.points)
    diagonal = np.linalg.norm(packed.step * LEVELS, axis=1)
    assert diagonal.max() < 0.3 * np.linalg.norm(np.ptp(yarns.points, axis=0))


def test_packed_positions_are_right_to_half_a_step():
    yarns = tube(12, 60)
    moved = replace(yarns, points=yarns.points * [1.0, 3.0, 0.5] + [400.0, -80.0, 3.0])
    blocks = make_blocks(moved)
    packed = pack_points(blocks, moved.points)
    per_block = np.diff(blocks.block_points)
    back = packed.low.repeat(per_block, axis=0) + packed.values * packed.step.repeat(per_block, axis=0)
    error = np.abs(back - moved.points[blocks.source])
    # half a step, and the rounding of coordinates of a few hundred cm to single precision
    assert (error <= 0.5 * packed.step.repeat(per_block, axis=0) + 400 * 2.0**-23).all()


def test_a_flat_fabric_can_be_packed():
    yarns = lines(0.0, 1.0)
    packed = pack_points(make_blocks(yarns), yarns.points)
    assert (packed.values[:, 2] == 0).all() and (packed.low[:, 2] == 0.0).all()


def test_few_colours_are_kept_exactly_and_many_become_near_ones():
    yarns = tube(6, 20)
    own = np.random.default_rng(2).integers(0, 256, (250, 3)).astype(np.uint8)[np.arange(len(yarns.points)) % 250]
    blocks = make_blocks(yarns)
    index, palette = pack_colours(blocks, own)
    np.testing.assert_array_equal(palette[index], own[blocks.source])
    ramp = np.stack([np.arange(1000) * 255 // 999, np.arange(1000) % 7, np.full(1000, 40)], axis=1).astype(np.uint8)
    index, palette = indexed_colours(ramp)
    assert len(palette) <= PALETTE_SIZE
    # 1792 colours at most; three low bits of each channel leave at most 32 * 1 * 1 of them
    assert np.abs(palette[index].astype(int) - ramp).max() <= 4
    colours = np.random.default_rng(3).integers(0, 256, (50_000, 3)).astype(np.uint8)
    index, palette = indexed_colours(colours)
    assert len(palette) <= PALETTE_SIZE and index.max() < len(palette)
