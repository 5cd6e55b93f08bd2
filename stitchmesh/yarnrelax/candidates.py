# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact candidates: for each contact sample the samples that may touch it, kept over many iterations.

The list of a sample holds every sample of a segment that may collide with its own, up to the contact distance plus a
margin, in ascending order. Each pair is listed from both sides. A list stays complete while no control point has moved
by more than half the margin since it was made (the weights of the spline sum to one, so samples move no farther), and
the step limit keeps them from moving farther. The force does not depend on the margin: samples beyond the contact
distance add nothing.

They are found coarsely and filtered finely: a hash grid of the balls around segments gives pairs of segments, whose
samples are then compared. Lists have a fixed capacity. The longest one is measured while they are filled; if it does
not fit they are made again with more room, so that nothing is dropped.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.yarnrelax.model import Model

wp.set_module_options({"enable_backward": False})

FIRST_CAPACITY = 16
"""Capacity of a list before its first growth."""
GRID_CELLS = 64
"""Cells along each axis of the hash grid; cells wrap around, so this bounds memory and not space."""


@wp.func
def may_collide(model: Any, i: int, j: int) -> Any:
    """Whether segments i and j are of different yarns, or far enough apart along one."""
    if model.segment_yarn[i] != model.segment_yarn[j]:
        return True
    cycle = model.segment_cycle[i]
    ahead = j - i
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
    """A ball around the samples of each segment: its centre and its radius [cm]."""
    s = wp.tid()
    first = s * model.contact_samples
    middle = (samples[first] + samples[first + model.contact_samples - 1]) * type(extent[0])(0.5)
    farthest = type(extent[0])(0.0)
    for k in range(model.contact_samples):
        farthest = wp.max(farthest, wp.length(samples[first + k] - middle))
    centre[s] = middle
    extent[s] = farthest


@wp.func
def list_pairs(
    model: Any,
    margin: Any,
    samples: wp.array[Any],
    centre: wp.array[Any],
    extent: wp.array[Any],
    i: int,
    j: int,
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
) -> None:
    """Put the samples of segment j that are near into the lists of the samples of segment i."""
    count = model.contact_samples
    limit = model.sample_radius[i * count] + model.sample_radius[j * count] + margin
    for p in range(i * count, i * count + count):
        here = samples[p]
        if wp.length(centre[j] - here) > limit + extent[j]:
            continue
        for q in range(j * count, j * count + count):
            apart = samples[q] - here
            if wp.dot(apart, apart) < limit * limit:
                place = candidate_count[p]
                candidate_count[p] = place + 1
                if place < candidates.shape[1]:
                    while place > 0 and candidates[p, wp.max(place - 1, 0)] > q:
                        candidates[p, place] = candidates[p, place - 1]
                        place -= 1
                    candidates[p, place] = q


@wp.kernel(module="unique")
def list_candidates(
    # model
    model: Any,
    margin: Any,
    search_radius: Any,
    # state in
    grid: wp.uint64,
    samples: wp.array[Any],
    centre: wp.array[Any],
    extent: wp.array[Any],
    # state out
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    longest: wp.array[wp.int32],
) -> None:
    """List the candidates of each segment's samples in ascending order; ``longest`` tells whether all fitted."""
    i = wp.tid()
    first = i * model.contact_samples
    for k in range(model.contact_samples):
        candidate_count[first + k] = 0
    here = centre[i]
    reach = model.sample_radius[first] + margin + extent[i]
    for j in wp.hash_grid_query(grid, here, search_radius):
        apart = centre[j] - here
        limit = reach + model.sample_radius[j * model.contact_samples] + extent[j]
        if wp.dot(apart, apart) < limit * limit and may_collide(model, i, j):
            list_pairs(model, margin, samples, centre, extent, i, j, candidate_count, candidates)
    most = int(0)
    for k in range(model.contact_samples):
        most = wp.max(most, candidate_count[first + k])
        candidate_count[first + k] = wp.min(candidate_count[first + k], candidates.shape[1])
    wp.atomic_max(longest, 0, most)


@dataclass(eq=False)
class Candidates:
    """Candidate lists of all samples."""

    margin: float
    """Distance beyond contact up to which pairs are listed [cm]."""
    count: wp.array[Any]
    """Length of each list, shape (P,)."""
    lists: wp.array[Any]
    """Samples in each list, ascending, shape (P, capacity)."""
    grid: wp.HashGrid
    """The grid that finds them."""


def make_candidates(model: Model, margin: float) -> Candidates:
    """Empty lists for the samples of a model."""
    count = wp.zeros(model.sample_count, dtype=wp.int32, device=model.device)
    lists = wp.zeros((model.sample_count, FIRST_CAPACITY), dtype=wp.int32, device=model.device)
    grid = wp.HashGrid(GRID_CELLS, GRID_CELLS, GRID_CELLS, device=model.device, dtype=model.scalar)
    return Candidates(margin, count, lists, grid)


def find_candidates(model: Model, samples: wp.array[Any], candidates: Candidates) -> bool:
    """Fill the lists for samples as they lie now.

    Returns:
        Whether the lists had to grow, so that ``candidates.lists`` is a new array.
    """
    centre, extent = model.empty(model.segment_count, 3), model.empty(model.segment_count)
    model.launch(bound_segments, model.segment_count, [model.constants, samples], [centre, extent])
    radius = 2.0 * float(model.yarns.radius.max()) + candidates.margin + 2.0 * float(extent.numpy().max())
    candidates.grid.build(centre, 2.0 * radius)  # eight cells a query, most of them not empty
    longest = wp.zeros(1, dtype=wp.int32, device=model.device)
    inputs = [model.constants, model.number(candidates.margin), model.number(radius), wp.uint64(candidates.grid.id),
              samples, centre, extent]  # fmt: skip
    grown = False
    while True:
        longest.zero_()
        outputs = [candidates.count, candidates.lists, longest]
        model.launch(list_candidates, model.segment_count, inputs, outputs)
        needed = int(longest.numpy()[0])
        if needed <= candidates.lists.shape[1]:
            return grown
        capacity = int(np.ceil(needed * 1.25 / 8)) * 8
        candidates.lists = wp.zeros((model.sample_count, capacity), dtype=wp.int32, device=model.device)
        grown = True
