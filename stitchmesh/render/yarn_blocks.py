# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns in blocks of space, for pictures with several levels of detail.

A fabric of a million control points is too much to draw as tubes of full detail at once. Each yarn is therefore cut
into runs of consecutive segments, and runs that lie near one another form a block. A viewer chooses the detail of each
block by its distance. A run of m segments holds its own m + 3 control points, so that each block is complete in itself.

Positions are packed into 16 bits for each coordinate, relative to the bounding box of the block: 6 bytes for a control
point, with an error below a hundred-thousandth of the size of the block. Colours are packed into one byte for each
control point and a palette of at most 256 colours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet

RUN = 48
"""Segments of a run; the three control points that two runs share are then 6 % of all points."""
RUNS_OF_BLOCK = 64
"""Largest number of runs of a block."""
LEVELS = 65_535
"""Largest packed coordinate."""
PALETTE_SIZE = 256
"""Largest number of colours that one byte can name."""


@dataclass(frozen=True, eq=False)
class YarnBlocks:
    """Runs of segments of yarns, block by block: P stored points, R runs, B blocks."""

    source: IntArray
    """Control point of the yarns at each stored point, shape (P,)."""
    shift: NDArray[np.float32] | None
    """Lattice shift of each stored point [cm], shape (P, 3); None without a lattice."""
    run_start: IntArray
    """First stored point of each run, and P at the end, shape (R + 1,)."""
    block_start: IntArray
    """First run of each block, and R at the end, shape (B + 1,)."""
    radius: NDArray[np.float32]
    """Apparent radius of the yarn of each run [cm], shape (R,)."""

    @property
    def block_points(self) -> IntArray:
        """First stored point of each block, and P at the end, shape (B + 1,)."""
        return self.run_start[self.block_start]


@dataclass(frozen=True, eq=False)
class PackedPoints:
    """Positions of the stored points in 16 bits for each coordinate."""

    values: NDArray[np.uint16]
    """Coordinates in steps from the lowest corner of the block, shape (P, 3)."""
    low: NDArray[np.float32]
    """Lowest corner of each block [cm], shape (B, 3)."""
    step: NDArray[np.float32]
    """Size of a step along each axis in each block [cm], shape (B, 3)."""


def make_blocks(yarns: YarnSet, segments: IntArray | None = None) -> YarnBlocks:
    """Cut yarns into runs, and gather the runs into blocks of space.

    Args:
        yarns: the yarns.
        segments: the segments to draw, ascending, at least one; all by default.
    """
    chosen = np.arange(len(yarns.segment_yarn)) if segments is None else np.asarray(segments)
    first, count = _runs(yarns, chosen)
    middle = yarns.points[yarns.segment_points[chosen[first + count // 2], 1]]
    order, block_start = _gathered(middle)
    first, count = first[order], count[order]
    run_start = np.concatenate([[0], np.cumsum(count + 3)])
    place = np.arange(run_start[-1]) - np.repeat(run_start[:-1], count + 3)
    # The last three points of a run are the later control points of its last segment.
    slot = np.maximum(place - np.repeat(count - 1, count + 3), 0)
    segment = chosen[np.repeat(first, count + 3) + place - slot]
    shift = None if yarns.point_shift is None else yarns.point_shift[segment, slot].astype(np.float32)
    radius = yarns.drawn_radius[yarns.segment_yarn[chosen[first]]].astype(np.float32)
    return YarnBlocks(yarns.segment_points[segment, slot], shift, run_start, block_start, radius)


def pack_points(blocks: YarnBlocks, points: FloatArray) -> PackedPoints:
    """Pack the positions of control points.

    Args:
        blocks: the blocks of the yarns.
        points: positions of the control points of the yarns [cm], shape (N, 3).
    """
    places = np.ascontiguousarray(points, dtype=np.float32).take(blocks.source, axis=0)
    if blocks.shift is not None:
        places += blocks.shift
    start = blocks.block_points
    low = np.empty((len(start) - 1, 3), dtype=np.float32)
    step = np.empty_like(low)
    values = np.empty(places.shape, dtype=np.uint16)
    for block, (begin, end) in enumerate(zip(start[:-1].tolist(), start[1:].tolist(), strict=True)):
        own = places[begin:end]
        low[block] = own.min(axis=0)
        step[block] = np.maximum((own.max(axis=0) - low[block]) / LEVELS, np.float32(1e-12))
        own -= low[block]
        own /= step[block]
        own += np.float32(0.5)  # The cast cuts off the fraction.
        values[begin:end] = np.minimum(own, LEVELS)
    return PackedPoints(values, low, step)


def pack_colours(blocks: YarnBlocks, colours: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Pack the colours of control points.

    Args:
        blocks: the blocks of the yarns.
        colours: colour of each control point of the yarns (sRGB), shape (N, 3).

    Returns:
        The number of the colour of each stored point, shape (P,), and the palette, shape (n, 3).
    """
    number, palette = indexed_colours(colours)
    return number[blocks.source], palette


def indexed_colours(colours: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return colours as numbers in a palette; near colours are merged if there are more than 256.

    Args:
        colours: colours (sRGB), shape (n, 3).

    Returns:
        The number of each colour, shape (n,), and the palette, shape (m, 3) with m at most 256.
    """
    channels = np.asarray(colours, dtype=np.uint32)
    for lost in range(8):  # The low bits of the channels are dropped until few enough colours remain.
        kept = channels >> lost
        code = (kept[:, 0] << 16) | (kept[:, 1] << 8) | kept[:, 2]
        seen = np.zeros(1 << 24, dtype=np.bool_)
        seen[code] = True
        found = np.flatnonzero(seen)
        if len(found) <= PALETTE_SIZE:
            break
    table = np.zeros(1 << 24, dtype=np.uint8)
    table[found] = np.arange(len(found))
    middle = (1 << lost) >> 1
    palette = np.stack([found >> 16, found >> 8 & 255, found & 255], axis=1) << lost
    return table[code], (palette + middle).astype(np.uint8)


def _runs(yarns: YarnSet, segments: IntArray) -> tuple[IntArray, IntArray]:
    """Return the first place in ``segments`` of each run, and the number of segments of each run, shape (R,) each."""
    owner = yarns.segment_yarn[segments]
    breaks = np.flatnonzero((np.diff(segments) != 1) | (np.diff(owner) != 0)) + 1
    start = np.concatenate([[0], breaks, [len(segments)]])
    runs = -(-np.diff(start) // RUN)
    piece = np.arange(runs.sum()) - np.repeat(np.cumsum(runs) - runs, runs)
    first = np.repeat(start[:-1], runs) + piece * RUN
    return first, np.minimum(RUN, np.repeat(start[1:], runs) - first)


def _gathered(places: FloatArray) -> tuple[IntArray, IntArray]:
    """Return an order of places in which near ones follow one another, and the start of each block in it, (B + 1,)."""
    blocks: list[IntArray] = []
    waiting = [np.arange(len(places))]
    while waiting:
        own = waiting.pop()
        if len(own) <= RUNS_OF_BLOCK:
            blocks.append(own)
            continue
        axis = int(np.ptp(places[own], axis=0).argmax())
        half = len(own) // 2
        sides = own[np.argpartition(places[own, axis], half)]
        waiting += [sides[half:], sides[:half]]
    start = np.cumsum([0, *(len(own) for own in blocks)])
    return np.concatenate([np.sort(own) for own in blocks]), start
