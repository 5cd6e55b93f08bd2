# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact candidates: for each contact sample the samples that may touch it, kept over many iterations.

The list of a sample holds every sample of a segment that may collide with its own, up to the contact distance plus a
margin, in ascending order; on a lattice an entry is the sample plus the number of samples times its image
(``images``). Each pair is listed from both sides. A list stays complete while no control point
has moved by more than half the margin since it was made (the weights of the spline sum to one, so samples move no
farther), and the step limit keeps them from moving farther. The force does not depend on the margin: samples beyond the
contact distance add nothing.

They are found coarsely and filtered finely: each segment has a list of the segments near it, which is kept longer
(``broad_phase``), and their samples are compared. Both kinds of lists have a fixed capacity. The longest one is
measured while they are filled; if it does not fit they are made again with more room, so that nothing is dropped. On a
GPU the lists of neighbouring samples lie interleaved, so that a warp reads whole lines of memory.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.reduction import maximum
from stitchmesh.compute.vector_loads import load_vector
from stitchmesh.yarnrelax.collision.broad_phase import (
    FIRST_CAPACITY,
    NearSegments,
    allocate_lists,
    checked_length,
    find_near_segments,
    make_near_segments,
)
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.lattice_images import cell_of, image_of, shifted_by


@kernel
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
    """Samples near each sample, in ascending order; an entry counts images by the number of samples."""
    p = wp.tid()
    s = model.sample_segment[p]
    here4 = load_vector(samples, p)
    here = type(centre[0])(here4[0], here4[1], here4[2])
    cell = cell_of(model.images, s)
    reach = here4[3] + margin
    found = int(0)
    for n in range(wp.min(near_count[s], near.shape[1])):  # lists that are too short are seen and made again
        entry = near[s, n]
        image = image_of(model.images, entry, segment_count)
        j = entry - image * segment_count
        seen_from = here + here - shifted_by(model.images, here, cell, image)
        away = centre[j] - seen_from
        limit = reach + extent[j]
        if wp.dot(away, away) < limit * limit:
            for q in range(model.sample_start[j], model.sample_start[j + 1]):
                there = load_vector(samples, q)
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
    """Samples in each list, ascending, shape (P, capacity)."""
    near: NearSegments
    """The segments whose samples are compared."""


def make_candidates(model: Model, margin: float) -> Candidates:
    """Empty lists for the samples of a model."""
    count = wp.zeros(model.sample_count, dtype=wp.int32, device=model.device)
    lists = allocate_lists(model, model.sample_count, FIRST_CAPACITY)
    return Candidates(margin, count, lists, make_near_segments(model))


def find_candidates(model: Model, samples: wp.array[Any], candidates: Candidates) -> bool:
    """Fill the lists for samples as they lie now.

    Returns:
        Whether the lists had to grow, so that ``candidates.lists`` is a new array.

    Raises:
        SolverError: yarns lie so dense that the lists would take more than ``MOST_ENTRIES``; it names the worst place.
    """
    found, near = candidates, candidates.near
    find_near_segments(model, samples, near, found.margin)
    inputs = [model.constants, model.number(found.margin), model.segment_count, samples, near.centre, near.extent,
              near.count, near.lists]  # fmt: skip
    grown = False
    while True:
        model.launch(list_samples, model.sample_count, inputs, [found.count, found.lists])
        needed = int(maximum(found.count))
        if needed <= found.lists.shape[1]:
            return grown
        found.lists = allocate_lists(model, model.sample_count, checked_length(model, found.count, needed))
        grown = True
