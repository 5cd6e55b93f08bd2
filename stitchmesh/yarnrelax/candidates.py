# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact candidates: for each contact sample the samples that may touch it, kept over many iterations.

The list of a sample holds every sample of a segment that may collide with its own, up to the contact distance plus a
margin, in the fixed order in which a hash grid finds them; on a lattice an entry is the sample plus the number of
samples times its image (``images``). Each pair is listed from both sides. A list stays complete while no control point
has moved by more than half the margin since it was made (the weights of the spline sum to one, so samples move no
farther), and the step limit keeps them from moving farther. The force does not depend on the margin: samples beyond the
contact distance add nothing.

They are found coarsely and filtered finely: a hash grid of the balls around segments gives each segment the segments
near it, whose samples are then compared. Both kinds of lists have a fixed capacity. The longest one is measured while
they are filled; if it does not fit they are made again with more room, so that nothing is dropped. On a GPU the lists
of neighbouring samples lie interleaved, so that a warp reads whole lines of memory.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.errors import SolverError
from stitchmesh.yarnrelax.aligned import read_whole
from stitchmesh.yarnrelax.images import image_count, image_of, shifted_by, turns_to
from stitchmesh.yarnrelax.model import Model
from stitchmesh.yarnrelax.reduction import maximum

wp.set_module_options({"enable_backward": False})

FIRST_CAPACITY = 16
"""Capacity of a list before its first growth."""
CELL = 2.0
"""Width of a cell of the hash grid over the radius of a search."""
SMALL_GRID, LARGE_GRID, MANY_SEGMENTS = 64, 192, 200_000
"""Cells along each axis of the hash grid, up to that many segments and beyond; cells wrap around, so this bounds
memory and not space."""
MOST_ENTRIES = 2**31
"""Entries that the lists may have, 8 GB."""


@wp.func
def may_collide(model: Any, i: int, j: int, image: int) -> bool:
    """Whether segment i and segment j of an image are of different strands, or far enough apart along one."""
    yarn = model.segment_yarn[i]
    if yarn != model.segment_yarn[j]:
        return True
    turns = turns_to(model.images, model.yarn_step[yarn], image)
    if turns == 2147483647:
        return True
    cycle = model.segment_cycle[i]
    ahead = j - i
    if turns != 0:  # the same strand, some turns farther along
        count = model.yarn_segments[yarn]
        far = wp.int64(ahead) + wp.int64(turns) * wp.int64(count)
        if far < wp.int64(0):
            return -far > wp.int64(model.segment_skip[j])
        return far > wp.int64(model.segment_skip[i])
    if ahead < 0:
        ahead += cycle
    return ahead > model.segment_skip[i] and cycle - ahead > model.segment_skip[j]


@wp.kernel(module="unique")
def bound_segments(
    # model
    model: Any,
    # state in
    samples: wp.array[Any],
    # state out
    centre: wp.array[Any],
    extent: wp.array[Any],
) -> None:
    """A ball around the yarn of each segment: its centre and its radius."""
    s = wp.tid()
    first, last = model.sample_start[s], model.sample_start[s + 1] - 1
    middle = (samples[first] + samples[last]) * type(extent[0])(0.5)
    farthest = type(extent[0])(0.0)
    for p in range(first, last + 1):
        apart = samples[p] - middle
        farthest = wp.max(farthest, apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2])
    centre[s] = type(centre[0])(middle[0], middle[1], middle[2])
    extent[s] = wp.sqrt(farthest) + samples[first][3]


@wp.kernel(module="unique")
def list_segments(
    # model
    model: Any,
    margin: Any,
    search_radius: Any,
    # state in
    grid: wp.uint64,
    centre: wp.array[Any],
    extent: wp.array[Any],
    # state out
    near_count: wp.array[wp.int32],
    near: wp.array2d[wp.int32],
) -> None:
    """Segments near each segment, in the order of the grid; an entry counts images by the number of segments."""
    i = wp.tid()
    here = centre[i]
    reach = margin + extent[i]
    found = int(0)
    for image in range(image_count(model.images)):
        seen_from = here + here - shifted_by(model.images, here, image)
        for j in wp.hash_grid_query(grid, seen_from, search_radius):
            apart = centre[j] - seen_from
            limit = reach + extent[j]
            if wp.dot(apart, apart) < limit * limit and may_collide(model, i, j, image):
                if found < near.shape[1]:
                    near[i, found] = image * centre.shape[0] + j
                found += 1
    near_count[i] = found


@wp.kernel(module="unique")
def list_samples(
    # model
    model: Any,
    margin: Any,
    segment_count: int,
    # state in
    samples: wp.array[Any],
    centre: wp.array[Any],
    extent: wp.array[Any],
    near_count: wp.array[wp.int32],
    near: wp.array2d[wp.int32],
    # state out
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
) -> None:
    """Samples near each sample, in the same order; an entry counts images by the number of samples."""
    p = wp.tid()
    s = model.sample_segment[p]
    here4 = read_whole(samples, p)
    here = type(centre[0])(here4[0], here4[1], here4[2])
    reach = here4[3] + margin
    found = int(0)
    for n in range(near_count[s]):
        entry = near[s, n]
        image = image_of(model.images, entry, segment_count)
        j = entry - image * segment_count
        seen_from = here + here - shifted_by(model.images, here, image)
        away = centre[j] - seen_from
        limit = reach + extent[j]
        if wp.dot(away, away) < limit * limit:
            for q in range(model.sample_start[j], model.sample_start[j + 1]):
                there = read_whole(samples, q)
                apart = type(here)(there[0], there[1], there[2]) - seen_from
                limit = reach + there[3]
                if wp.dot(apart, apart) < limit * limit:
                    if found < candidates.shape[1]:
                        candidates[p, found] = image * samples.shape[0] + q
                    found += 1
    candidate_count[p] = found


@dataclass(eq=False)
class Candidates:
    """Candidate lists of all samples."""

    margin: float
    """Distance beyond contact up to which pairs are listed, in units."""
    count: wp.array[Any]
    """Length of each list, shape (P,)."""
    lists: wp.array[Any]
    """Samples in each list, shape (P, capacity)."""
    near_count: wp.array[Any]
    """How many segments are near each segment, shape (S,)."""
    near: wp.array[Any]
    """Segments near each segment, shape (S, capacity)."""
    centre: wp.array[Any]
    """Middle of each segment's samples, shape (S, 3)."""
    extent: wp.array[Any]
    """How far their yarn reaches from it, shape (S,)."""
    grid: wp.HashGrid
    """The grid that finds the segments."""


def make_candidates(model: Model, margin: float) -> Candidates:
    """Empty lists for the samples of a model."""
    cells = SMALL_GRID if model.segment_count <= MANY_SEGMENTS else LARGE_GRID
    return Candidates(
        margin,
        wp.zeros(model.sample_count, dtype=wp.int32, device=model.device),
        _lists(model, model.sample_count, FIRST_CAPACITY),
        wp.zeros(model.segment_count, dtype=wp.int32, device=model.device),
        _lists(model, model.segment_count, FIRST_CAPACITY),
        model.empty(model.segment_count, 3),
        model.empty(model.segment_count),
        wp.HashGrid(cells, cells, cells, device=model.device, dtype=model.scalar),
    )


def find_candidates(model: Model, samples: wp.array[Any], candidates: Candidates) -> bool:
    """Fill the lists for samples as they lie now.

    Returns:
        Whether the lists had to grow, so that ``candidates.lists`` is a new array.

    Raises:
        SolverError: yarns lie so dense that the lists would take more than ``MOST_ENTRIES``; it names the worst place.
    """
    found = candidates
    model.launch(bound_segments, model.segment_count, [model.constants, samples], [found.centre, found.extent])
    radius = found.margin + 2.0 * maximum(found.extent)
    found.grid.build(found.centre, CELL * radius)
    inputs = [model.constants, model.number(found.margin), model.number(radius), wp.uint64(found.grid.id),
              found.centre, found.extent]  # fmt: skip
    while True:
        model.launch(list_segments, model.segment_count, inputs, [found.near_count, found.near])
        needed = int(maximum(found.near_count))
        if needed <= found.near.shape[1]:
            break
        found.near = _lists(model, model.segment_count, _bearable(model, found.near_count, needed))
    inputs = [model.constants, model.number(found.margin), model.segment_count, samples, found.centre, found.extent,
              found.near_count, found.near]  # fmt: skip
    grown = False
    while True:
        model.launch(list_samples, model.sample_count, inputs, [found.count, found.lists])
        needed = int(maximum(found.count))
        if needed <= found.lists.shape[1]:
            return grown
        found.lists = _lists(model, model.sample_count, _bearable(model, found.count, needed))
        grown = True


def _bearable(model: Model, count: wp.array[Any], needed: int) -> int:
    """The length ``needed`` of the longest list, if all fit."""
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


def _lists(model: Model, count: int, needed: int) -> wp.array[Any]:
    """Room for ``count`` lists of a quarter more entries than needed."""
    capacity = int(np.ceil(needed * 1.25 / 8)) * 8 if needed > FIRST_CAPACITY else needed
    if model.device.is_cuda:
        return wp.zeros((capacity, count), dtype=wp.int32, device=model.device).transpose()
    return wp.zeros((count, capacity), dtype=wp.int32, device=model.device)
