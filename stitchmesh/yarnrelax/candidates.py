# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact candidates: for each contact sample the samples that may touch it, kept over many iterations.

The list of a sample holds every sample of a segment that may collide with its own, up to the contact distance plus a
margin, in ascending order. Each pair is listed from both sides. A list stays complete while no control point has moved
by more than half the margin since it was made (the weights of the spline sum to one, so samples move no farther), and
the step limit keeps them from moving farther. The force does not depend on the margin: samples beyond the contact
distance add nothing.

Lists have a fixed capacity. The longest one is measured while they are filled; if it does not fit they are made again
with more room, so that nothing is dropped.
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
def may_collide(model: Any, i: int, j: int):
    """Whether segments i and j are of different yarns, or far enough apart along one."""
    if model.segment_yarn[i] != model.segment_yarn[j]:
        return True
    cycle = model.segment_cycle[i]
    ahead = j - i
    if ahead < 0:
        ahead += cycle
    return ahead > model.segment_skip[i] and cycle - ahead > model.segment_skip[j]


@wp.kernel(module="unique")
def list_candidates(
    # model
    model: Any,
    margin: Any,
    search_radius: Any,
    # state in
    grid: wp.uint64,
    samples: wp.array[Any],
    # state out
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    longest: wp.array[wp.int32],
):
    """List the candidates of each sample in ascending order; ``longest`` tells whether all of them fitted."""
    p = wp.tid()
    segment = p // model.contact_samples
    here = samples[p]
    reach = model.sample_radius[p] + margin
    count = int(0)
    for q in wp.hash_grid_query(grid, here, search_radius):
        apart = samples[q] - here
        limit = reach + model.sample_radius[q]
        if wp.dot(apart, apart) < limit * limit and may_collide(model, segment, q // model.contact_samples):
            if count < candidates.shape[1]:
                place = count
                while place > 0 and candidates[p, wp.max(place - 1, 0)] > q:
                    candidates[p, place] = candidates[p, place - 1]
                    place -= 1
                candidates[p, place] = q
            count += 1
    candidate_count[p] = wp.min(count, candidates.shape[1])
    wp.atomic_max(longest, 0, count)


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
    radius = 2.0 * float(model.yarns.radius.max()) + candidates.margin
    candidates.grid.build(samples, 2.0 * radius)
    longest = wp.zeros(1, dtype=wp.int32, device=model.device)
    grown = False
    while True:
        longest.zero_()
        wp.launch(
            list_candidates,
            dim=model.sample_count,
            inputs=[model.constants, model.number(candidates.margin), model.number(radius),
                    wp.uint64(candidates.grid.id), samples],
            outputs=[candidates.count, candidates.lists, longest],
            device=model.device,
        )  # fmt: skip
        needed = int(longest.numpy()[0])
        if needed <= candidates.lists.shape[1]:
            return grown
        capacity = int(np.ceil(needed * 1.25 / 8)) * 8
        candidates.lists = wp.zeros((model.sample_count, capacity), dtype=wp.int32, device=model.device)
        grown = True
