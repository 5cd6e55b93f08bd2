# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The second derivatives of contact: the pairs of samples that touch, and the stiffness of each.

A pair at the distance d < R has the energy E(d) of ``contact``. By the vector from one sample to the other, with the
unit vector n along it, the second derivative is

    E'' n n^T + E' / d (I - n n^T)  =  a a^T - b I,        b = - E' / d > 0,    a = sqrt(E'' + b) n

The part b makes the matrix indefinite: a pair that is pressed could also turn aside. Far from rest only a share of b is
taken (``exact``).
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec4, load_vector, vector
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.energies.contact import contact_force_scale
from stitchmesh.yarnrelax.energies.pair_stiffness import PairStiffness
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import cell_of_sample, rests, sample_number
from stitchmesh.yarnrelax.model.spline import from_entry


@kernel
def find_touching_pairs(
    # model
    model: YarnConstants,
    # state in
    exact: wp.array[Scalar],
    samples: wp.array[Vec4],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    touching_count: wp.array[wp.int32],
    touching: wp.array2d[wp.int32],
    stiffness: wp.array2d[Vec4],
) -> None:
    """The entries of each sample's list that touch it, in their order; of each the vector a and the number b."""
    p = wp.tid()
    if rests(model.images, cell_of_sample(model.images, p)):
        return
    here = load_vector(samples, p)
    own = model.sample_stiffness[p]
    of_segment = exact[model.sample_segment[p]]
    found = int(0)
    for c in range(candidate_count[p]):
        entry = candidates[p, c]
        gap = from_entry(model.images, samples, p, here, entry)
        distance2 = gap[0] * gap[0] + gap[1] * gap[1] + gap[2] * gap[2]
        reach2 = gap[3] * gap[3]
        if distance2 < reach2:
            q = sample_number(model.images, entry)
            weight = own * model.sample_weight[q]
            wanted = wp.min(of_segment, exact[model.sample_segment[q]])
            push, stiff, inverse = contact_force_scale(model.contact, p, distance2, reach2, weight)
            push = push * wanted
            size = wp.sqrt((stiff + push) * inverse)
            touching[p, found] = entry
            stiffness[p, found] = type(here)(gap[0] * size, gap[1] * size, gap[2] * size, push)
            found += 1
    touching_count[p] = found


class TouchingPairs:
    """The pairs that touch, on a device."""

    def __init__(self, model: Model, candidates: Candidates) -> None:
        """Allocate room for as many pairs as the candidate lists hold."""
        self.model, self.candidates = model, candidates
        self.count = wp.zeros(model.sample_count, dtype=wp.int32, device=model.device)
        """Number of samples that touch each sample, shape (P,)."""
        self.entries = _lists_like(candidates.lists, wp.int32)
        """These samples as entries of the candidate lists, shape (P, capacity)."""
        self.stiffness = _lists_like(candidates.lists, vector(4, model.scalar))
        """The vector a and the number b of each pair [erg^(1/2) / unit, erg / unit^2], shape (P, capacity)."""

    def pair_stiffness(self, exact: wp.array[Any], samples: wp.array[Any], launcher: Launcher) -> PairStiffness:
        """Return the pairs for the assembled Hessian; ``exact`` is the share of b for each segment, shape (S,)."""
        inputs = [self.model.constants, exact, samples, self.candidates.count, self.candidates.lists]
        outputs = [self.count, self.entries, self.stiffness]
        launch = launcher(find_touching_pairs, self.model.sample_count, inputs, outputs)
        return PairStiffness(self.model.constants.images, self.count, self.entries, self.stiffness, [launch])


def _lists_like(lists: wp.array[Any], dtype: Any) -> wp.array[Any]:
    """Return an array with the shape and the order in memory of candidate lists."""
    if lists.device.is_cuda:
        return wp.zeros(lists.shape[::-1], dtype=dtype, device=lists.device).transpose()
    return wp.zeros(lists.shape, dtype=dtype, device=lists.device)
