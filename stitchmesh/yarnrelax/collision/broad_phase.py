# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Broad phase of the contact search: the segments near each segment.

Each segment lies in a ball around the yarn at its samples. A hash grid finds, for each ball, the balls that are nearer
to it than a reach. The lists are kept as long as they contain all pairs within the margin that is needed: if no ball
has moved and grown by more than d since the lists were made with a reach R, they contain all pairs within R - 2 d. The
lists are ascending, so what is selected from them does not depend on when they were made. Each cell of a batch gets new
lists when it needs them.
"""

# overloads for fabrics without a lattice, which Warp distinguishes by the types of their arguments
# ruff: noqa: F811
# mypy: disable-error-code="no-redef"

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import GridBuild
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import BLOCK
from stitchmesh.compute.precision import Scalar, Vec3, Vec4
from stitchmesh.errors import SolverError
from stitchmesh.simulation.pair_lists import FIRST_CAPACITY, allocate_lists, insert_sorted
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import LatticeImages, NoImages, cell_of, rests, shifted_by

SPARE_REACH = 1.0
"""The near lists reach farther than the margin by this, in mean radii, so that they last for several searches."""
NOTHING_LISTED = -1.0
"""``NearSegments.complete_within`` for lists that are out of date."""
CELL = 2.0
"""Width of a cell of the hash grid over the radius of a search."""
APART = 6.0
"""Distance between the cells of several fabrics in the hash grid, over the width of a cell of the grid."""
SMALL_GRID, LARGE_GRID, MANY_SEGMENTS = 64, 192, 200_000
"""Cells along each axis of the hash grid, for up to ``MANY_SEGMENTS`` segments and for more. The grid is periodic, so
its size limits the memory but not the space."""
MOST_ENTRIES = 2**31
"""Largest number of entries of all lists, 8 GB."""
NO_TURNS = wp.constant(2147483647)
"""Mark of an image that no number of turns of a yarn reaches."""


@wp.func
def image_count(images: NoImages) -> int:
    """Number of images, including the fabric itself."""
    return 1


@wp.func
def image_count(images: LatticeImages) -> int:
    """Number of images, including the fabric itself."""
    return images.image.shape[0]


@wp.func
def turns_to(images: NoImages, yarn_step: wp.vec2i, number: int) -> int:
    """Number of turns of a yarn that lead to an image; ``NO_TURNS`` where there is none."""
    return 0


@wp.func
def turns_to(images: LatticeImages, yarn_step: wp.vec2i, number: int) -> int:
    """Number of turns of a yarn that lead to an image; ``NO_TURNS`` where there is none."""
    image = images.image[number]
    turns = int(0)
    if yarn_step[0] != 0:
        turns = image[0] // yarn_step[0]
    elif yarn_step[1] != 0:
        turns = image[1] // yarn_step[1]
    if turns * yarn_step[0] != image[0] or turns * yarn_step[1] != image[1]:
        turns = NO_TURNS
    return turns


@wp.func
def apart_from_cell(images: NoImages, place: Vec3, cell: int, reach: Scalar) -> bool:
    """Whether a place is farther than a reach from the box around all segments of a cell."""
    return False


@wp.func
def apart_from_cell(images: LatticeImages, place: Vec3, cell: int, reach: Scalar) -> bool:
    """Whether a place is farther than a reach from the box around all segments of a cell."""
    low, high = images.box[2 * cell], images.box[2 * cell + 1]
    return (
        place[0] < low[0] - reach or place[1] < low[1] - reach or place[2] < low[2] - reach
        or place[0] > high[0] + reach or place[1] > high[1] + reach or place[2] > high[2] + reach
    )  # fmt: skip


@wp.func
def grid_place(images: NoImages, place: Vec3, cell: int, pitch: Scalar) -> Any:
    """Coordinates of a place in the hash grid."""
    return place


@wp.func
def grid_place(images: LatticeImages, place: Vec3, cell: int, pitch: Scalar) -> Any:
    """Coordinates of a place in the hash grid, where the cells of different fabrics are far from each other."""
    along, up, out = cell % 10, (cell // 10) % 10, cell // 100
    return place + type(place)(type(pitch)(along), type(pitch)(up), type(pitch)(out)) * pitch


@wp.func
def may_collide(model: YarnConstants, i: int, j: int, image: int) -> bool:
    """Whether segment i and segment j of an image are of different strands, or far enough apart along one strand."""
    yarn = model.segment_yarn[i]
    if yarn != model.segment_yarn[j]:
        return True
    turns = turns_to(model.images, model.yarn_step[yarn], image)
    if turns == NO_TURNS:
        return True
    cycle = model.segment_cycle[i]
    ahead = j - i
    if turns != 0:  # the same strand, some turns later
        count = model.yarn_segments[yarn]
        far = wp.int64(ahead) + wp.int64(turns) * wp.int64(count)
        if far < wp.int64(0):
            return -far > wp.int64(model.segment_skip[j])
        return far > wp.int64(model.segment_skip[i])
    if ahead < 0:
        ahead += cycle
    return ahead > model.segment_skip[i] and cycle - ahead > model.segment_skip[j]


@kernel
def bound_segments(
    # model
    model: YarnConstants,
    # state in
    samples: wp.array[Vec4],
    # state out
    centre: wp.array[Vec3],
    extent: wp.array[Scalar],
) -> None:
    """A ball around the yarn of each segment: its centre and its radius."""
    s = wp.tid()
    if rests(model.images, cell_of(model.images, s)):
        return
    first, last = model.sample_start[s], model.sample_start[s + 1] - 1
    middle = (samples[first] + samples[last]) * type(extent[0])(0.5)
    farthest = type(extent[0])(0.0)
    for p in range(first, last + 1):
        apart = samples[p] - middle
        farthest = wp.max(farthest, apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2])
    centre[s] = type(centre[0])(middle[0], middle[1], middle[2])
    extent[s] = wp.sqrt(farthest) + samples[first][3]


@kernel
def list_segments(
    # model
    model: YarnConstants,
    reaches: wp.array[wp.float64],
    search_radius: Scalar,
    pitch: Scalar,
    # state in
    grid: wp.uint64,
    centre: wp.array[Vec3],
    extent: wp.array[Scalar],
    # state out
    near_count: wp.array[wp.int32],
    near: wp.array2d[wp.int32],
) -> None:
    """Segments near each segment, in ascending order; an entry counts images by the number of segments.

    A cell with a negative reach keeps its lists.
    """
    i = wp.tid()
    here = centre[i]
    cell = cell_of(model.images, i)
    if reaches[cell] < wp.float64(0.0):
        return
    reach = type(search_radius)(reaches[cell]) + extent[i]
    found = int(0)
    for image in range(image_count(model.images)):
        seen_from = here + here - shifted_by(model.images, here, cell, image)
        if apart_from_cell(model.images, seen_from, cell, search_radius):
            continue
        for j in wp.hash_grid_query(grid, grid_place(model.images, seen_from, cell, pitch), search_radius):
            apart = centre[j] - seen_from
            limit = reach + extent[j]
            same_cell = cell_of(model.images, j) == cell
            if same_cell and wp.dot(apart, apart) < limit * limit and may_collide(model, i, j, image):
                entry = image * centre.shape[0] + j
                insert_sorted(near, i, found, entry)
                found += 1
    near_count[i] = found


@kernel
def place_in_grid(
    # model
    model: YarnConstants,
    reaches: wp.array[wp.float64],
    pitch: Scalar,
    # state in
    centre: wp.array[Vec3],
    extent: wp.array[Scalar],
    # state out
    listed_centre: wp.array[Vec3],
    listed_extent: wp.array[Scalar],
    place: wp.array[Vec3],
) -> None:
    """Coordinates of each ball in the hash grid; the balls are stored in the cells that get new lists."""
    s = wp.tid()
    cell = cell_of(model.images, s)
    place[s] = grid_place(model.images, centre[s], cell, pitch)
    if reaches[cell] >= wp.float64(0.0):
        listed_centre[s] = centre[s]
        listed_extent[s] = extent[s]


@kernel(tile=BLOCK)
def bound_cells(
    # model
    cell_segments: wp.array[wp.int32],
    # state in
    centre: wp.array[Vec3],
    # state out
    box: wp.array[Vec3],
) -> None:
    """The box around the middles of each cell's segments; a block of 64 threads for each cell."""
    cell, lane = wp.tid()
    first, last = cell_segments[cell], cell_segments[cell + 1]
    low = centre[first]
    high = low
    for s in range(first + lane, last, wp.block_dim()):
        low = wp.min(low, centre[s])
        high = wp.max(high, centre[s])
    for axis in range(3):
        least, most = wp.tile_min(wp.tile(low[axis])), wp.tile_max(wp.tile(high[axis]))
        if lane == 0:
            low[axis] = least[0]
            high[axis] = most[0]
    if lane == 0:
        box[2 * cell] = low
        box[2 * cell + 1] = high


@kernel
def measure_drift(
    # state in
    centre: wp.array[Vec3],
    extent: wp.array[Scalar],
    listed_centre: wp.array[Vec3],
    listed_extent: wp.array[Scalar],
    # state out
    drift: wp.array[Scalar],
) -> None:
    """Distance by which each ball may have approached others since the lists were made."""
    s = wp.tid()
    grown = extent[s] - listed_extent[s]
    drift[s] = wp.length(centre[s] - listed_centre[s]) + wp.max(grown, grown - grown)


@dataclass(eq=False)
class NearSegments:
    """Lists of the segments near each segment."""

    count: wp.array[Any]
    """Length of each list, shape (S,)."""
    lists: wp.array[Any]
    """The segments near each segment, ascending, shape (S, capacity)."""
    centre: wp.array[Any]
    """Middle of each segment's samples, shape (S, 3)."""
    extent: wp.array[Any]
    """Radius of the ball around the middle that contains the yarn of the segment, shape (S,)."""
    listed_centre: wp.array[Any]
    """The middles at the time when the lists were made, shape (S, 3)."""
    listed_extent: wp.array[Any]
    """The radii at that time, shape (S,)."""
    grid: wp.HashGrid
    """The hash grid."""
    grid_place: wp.array[Any]
    """Coordinates of each segment in the grid, shape (S, 3)."""
    wanted: wp.array[Any]
    """Distance within which the next broad phase lists the balls of each cell [units], shape (C,); negative for a cell
    that keeps its lists."""
    reach: NDArray[np.float64]
    """Distance within which the balls of each cell were listed when its lists were made [units], shape (C,)."""
    complete_within: NDArray[np.float64]
    """Distance within which the lists of each cell contain all pairs now [units], shape (C,); negative if they must be
    made again."""

    def invalidate(self, cells: NDArray[np.bool_] | None = None) -> None:
        """Declare the lists of some cells or all out of date: segments were moved, or the capacity is too small."""
        self.complete_within[slice(None) if cells is None else cells] = NOTHING_LISTED


def make_near_segments(model: Model) -> NearSegments:
    """Return empty lists."""
    cells, count = SMALL_GRID if model.segment_count <= MANY_SEGMENTS else LARGE_GRID, model.segment_count
    grid = wp.HashGrid(cells, cells, cells, device=model.device, dtype=model.scalar)
    return NearSegments(
        wp.zeros(count, dtype=wp.int32, device=model.device),
        allocate_lists(count, FIRST_CAPACITY, model.device),
        model.empty(count, 3),
        model.empty(count),
        model.empty(count, 3),
        model.empty(count),
        grid,
        model.empty(count, 3),
        wp.full(model.cell_count, NOTHING_LISTED, dtype=wp.float64, device=model.device),
        np.zeros(model.cell_count),
        np.full(model.cell_count, NOTHING_LISTED),
    )


def grid_launches(model: Model, near: NearSegments, reach: float, longest: float) -> list[Any]:
    """Return the launches that sort the balls, of radii up to ``longest``, into the grid and store their places.

    ``reach`` is the largest reach of all cells.
    """
    count, launcher = model.segment_count, model.prepare
    radius = reach + 2.0 * longest
    launches: list[Any] = []
    if model.on_lattice:
        box = model.constants.images.box
        launches.append(launcher(bound_cells, model.cell_count, [model.cell_segments, near.centre], [box]))
    inputs = [model.constants, near.wanted, model.number(_pitch(radius)), near.centre, near.extent]
    outputs = [near.listed_centre, near.listed_extent, near.grid_place]
    launches.append(launcher(place_in_grid, count, inputs, outputs))
    return [*launches, GridBuild(near.grid, near.grid_place, CELL * radius)]


def near_launches(model: Model, near: NearSegments, reach: float, longest: float) -> list[Any]:
    """Return the launch that lists the balls that are nearer than the wanted reaches, of which one is ``reach``."""
    radius = reach + 2.0 * longest
    # places in the grid are rounded; a thousandth of a radius covers the rounding in the farthest cell
    numbers = [model.number(value) for value in (radius + 1e-3, _pitch(radius))]
    inputs = [model.constants, near.wanted, *numbers, wp.uint64(near.grid.id), near.centre, near.extent]
    return [model.prepare(list_segments, model.segment_count, inputs, [near.count, near.lists])]


def _pitch(radius: float) -> float:
    """Distance between the cells of several fabrics in the hash grid."""
    return APART * CELL * radius


def checked_length(model: Model, count: wp.array[Any], needed: int) -> int:
    """Return ``needed``, the length of the longest list, if the memory is sufficient."""
    if needed * len(count) > MOST_ENTRIES:
        worst = int(count.numpy().argmax())
        whole = len(count) == model.segment_count
        segment = worst if whole else int(np.searchsorted(model.sample_start, worst, side="right") - 1)
        point = int(model.yarns.segment_points[segment, 1])
        where = f"yarn {model.yarns.point_yarn[point]} (control point {point})"
        found = f"{needed} pieces of yarn within contact of one, {len(count)} pieces in all"
        expected = f"expected at most {MOST_ENTRIES} pairs"
        raise SolverError(f"{where}: {found}; {expected}; give the yarns a smaller radius")
    return needed
