# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Narrow phase of the contact search: for each contact sample the samples that may touch it, kept over many iterations.

The candidate list of a sample contains every sample of a segment that may collide with its own segment, up to the
contact distance plus a margin, in ascending order. On a lattice an entry is the sample plus the number of samples times
its image (``lattice_images``). Each pair is listed from both sides. A list stays complete while no control point has
moved by more than half the margin since the list was made: the weights of the spline sum to one, so samples move no
farther than control points. The step limit keeps control points from moving farther. The force does not depend on the
margin, because samples beyond the contact distance add nothing.

The broad phase gives each segment a list of the segments near it, which lasts longer (``broad_phase``). The narrow
phase compares the samples of these segments. Lists of both phases have a fixed capacity. A list that does not fit is
counted in full, and the search is repeated with more capacity (``captured_search``), so that no pair is dropped. On a
GPU the lists of neighbouring samples are interleaved, so that a warp reads whole lines of memory.

Each cell of a batch has its own margin, and gets new lists when it needs them. The launches pass over all other cells
(``Model.only_in``), whose lists stay as they are. A cell therefore has the same lists with any other cells.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import Scalar, Vec3, Vec4, load_vector
from stitchmesh.simulation.pair_lists import FIRST_CAPACITY, allocate_lists
from stitchmesh.yarnrelax.collision.broad_phase import (
    NearSegments,
    make_near_segments,
)
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import cell_of, image_of, rests, shifted_by

NARROWEST_MARGIN = 0.3
"""Margin of the candidate lists where motion is slow, in mean radii."""
MARGIN_CHANGE = 1.5
"""Factor by which the margin becomes narrower or wider."""
SHORT_LIFE, LONG_LIFE = 10, 40
"""Lists that last at most the first number of iterations get a wider margin; above the second, a narrower one."""
WIDEST_MARGIN = 0.6
"""Margin of the candidate lists at the start of a relaxation, in mean radii; it is the widest one."""


@kernel
def list_samples(
    # model
    model: YarnConstants,
    margin: wp.array[wp.float64],
    segment_count: int,
    # state in
    samples: wp.array[Vec4],
    centre: wp.array[Vec3],
    extent: wp.array[Scalar],
    near_count: wp.array[wp.int32],
    near: wp.array2d[wp.int32],
    # state out
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
) -> None:
    """Samples near each sample, in ascending order; an entry counts images by the number of samples."""
    p = wp.tid()
    s = model.sample_segment[p]
    cell = cell_of(model.images, s)
    if rests(model.images, cell):
        return
    here4 = load_vector(samples, p)
    here = type(centre[0])(here4[0], here4[1], here4[2])
    reach = here4[3] + type(here4[3])(margin[cell])
    found = int(0)
    for n in range(wp.min(near_count[s], near.shape[1])):  # a list beyond its capacity is made again
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


@kernel
def renumber_images(
    # model
    sample_count: int,
    number: wp.array[wp.int32],
    # state in
    candidate_count: wp.array[wp.int32],
    # state in and out
    candidates: wp.array2d[wp.int32],
) -> None:
    """Write the numbers that images have in another table."""
    p = wp.tid()
    for c in range(wp.min(candidate_count[p], candidates.shape[1])):
        entry = candidates[p, c]
        image = entry // sample_count
        candidates[p, c] = number[image] * sample_count + entry - image * sample_count


@kernel
def copy_candidates(
    # state in
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    copied: wp.array2d[wp.int32],
) -> None:
    """The same lists with another capacity."""
    p = wp.tid()
    for c in range(wp.min(candidate_count[p], candidates.shape[1])):
        copied[p, c] = candidates[p, c]


@dataclass(eq=False)
class Candidates:
    """Candidate lists of all samples."""

    margins: NDArray[np.float64]
    """Distance beyond contact up to which pairs of each cell are listed, in units, shape (C,); ``set_margins``."""
    margins_there: wp.array[Any]
    """``margins`` on the device."""
    count: wp.array[Any]
    """Length of each list, shape (P,)."""
    lists: wp.array[Any]
    """Samples in each list, ascending, shape (P, capacity)."""
    near: NearSegments
    """The near lists of the broad phase."""

    def set_margins(self, margins: NDArray[np.float64] | float) -> None:
        """Set the margins of the next lists, of each cell, shape (C,), or of all [units]."""
        wanted = np.broadcast_to(np.asarray(margins, dtype=np.float64), self.margins.shape)
        if (wanted != self.margins).any():
            self.margins = wanted.copy()
            self.margins_there.assign(self.margins)

    def enlarge(self, capacity: int) -> None:
        """Give all lists more room; their entries stay."""
        larger = allocate_lists(len(self.count), capacity, self.count.device)
        launch(copy_candidates, len(self.count), [self.count, self.lists], [larger], self.count.device)
        self.lists = larger

    def renumber(self, number: NDArray[np.int64]) -> None:
        """Write the numbers that images have in another table, shape (I,) with -1 for images that no list has."""
        count, device = len(self.count), self.count.device
        there = wp.array(number.astype(np.int32), dtype=wp.int32, device=device)
        launch(renumber_images, count, [count, there, self.count], [self.lists], device)


def make_candidates(model: Model, margin: float) -> Candidates:
    """Return empty lists for the samples of a model."""
    count = wp.zeros(model.sample_count, dtype=wp.int32, device=model.device)
    lists = allocate_lists(model.sample_count, FIRST_CAPACITY, model.device)
    margins = np.full(model.cell_count, margin, dtype=np.float64)
    there = wp.array(margins, dtype=wp.float64, device=model.device)
    return Candidates(margins, there, count, lists, make_near_segments(model))


def narrow_launch(model: Model, samples: wp.array[Any], candidates: Candidates, launcher: Launcher) -> Any:
    """Return the launch that fills the candidate lists from the near lists of the broad phase."""
    near = candidates.near
    inputs = [model.constants, candidates.margins_there, model.segment_count, samples, near.centre, near.extent,
              near.count, near.lists]  # fmt: skip
    return launcher(list_samples, model.sample_count, inputs, [candidates.count, candidates.lists])


def fitting_margins(margins: NDArray[np.float64], age: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the margins of the next candidate lists [units]: wider if lists do not last, narrower if they do.

    Args:
        margins: the margin of each cell's present lists, shape (C,).
        age: number of iterations that they have lasted, shape (C,).
    """
    wider = np.minimum(margins * MARGIN_CHANGE, WIDEST_MARGIN)
    narrower = np.maximum(margins / MARGIN_CHANGE, NARROWEST_MARGIN)
    return np.where(age <= SHORT_LIFE, wider, np.where(age > LONG_LIFE, narrower, margins))
