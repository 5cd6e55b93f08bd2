# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How a live swatch moves to its target: in equal increments, so small that yarns can part between two of them.

Each increment changes all lengths by the same part of their total change on a logarithmic scale. A length that is
constant in the fabric, such as the yarn radius while gamma changes, therefore stays constant. The increments have the
limits of ``continuation``. No increment moves a yarn through another: rest lengths and radii move nothing, and an
affine deformation of the whole lattice keeps separate yarns separate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.lattice import Lattice, lattice_frame
from stitchmesh.mesh import FloatArray
from stitchmesh.periodic.relaxation.continuation import GROWTH, LENGTHENING, STRETCH, size_of, stretch_cell
from stitchmesh.periodic.repeat.smallest_cell import SmallestCell
from stitchmesh.periodic.sampling.even_sampling import even_lengths
from stitchmesh.periodic.session.target import GeneratedRepeat, Target, lean_of
from stitchmesh.periodic.swatch import scale_yarns
from stitchmesh.yarn import YarnSet


@dataclass(frozen=True, eq=False)
class SwatchInProgress:
    """The smallest cell of a repeat, which moves to a target."""

    yarns: YarnSet
    """The yarns of that cell in their current state, ``scale`` times as large as in the fabric."""
    scale: float
    """Size of the yarns over their size in the fabric; it equals the gamma of the target once the target is reached."""
    gamma: float
    """Take-up of the current state."""

    @classmethod
    def start(cls, generated: GeneratedRepeat, target: Target) -> SwatchInProgress:
        """Return a generated repeat at the scale at which its yarn has the same radius as in the fabric."""
        yarns = generated.yarns
        if generated.fabric is None:
            # generated wefts and warps are nearly straight, so their rest lengths can equal their lengths at the start
            curves = generated.curves
            yarns = replace(yarns, rest_length=even_lengths(yarns, curves.lengths, curves.segment_start))
        yarns = target.smallest.part_of(yarns)
        reached = target.gamma * float(yarns.radius[0] / target.radius[0])
        return cls(yarns, reached, reached)

    def in_cell(self, before: SmallestCell, after: SmallestCell, like: YarnSet) -> SwatchInProgress:
        """Return the same fabric in another cell; ``like`` holds the yarns of the whole repeat, at any places."""
        return replace(self, yarns=after.part_of(before.repeated(self.yarns, like)))

    def enlarged(self, factor: float) -> SwatchInProgress:
        """Return the same fabric at a scale that is larger by a factor."""
        return replace(self, yarns=scale_yarns(self.yarns, factor), scale=self.scale * factor)

    @property
    def in_fabric(self) -> YarnSet:
        """The yarns at their size in the fabric."""
        return scale_yarns(self.yarns, 1.0 / self.scale)


def increments_left(state: SwatchInProgress, target: Target) -> int:
    """Number of increments to the target; 0 at the target."""
    yarns = state.yarns
    assert yarns.lattice is not None
    lean = lean_of(target.smallest.whole_lattice(yarns.lattice))
    sides = zip(target.size, size_of(yarns.lattice), strict=True)
    # Largest change of the lean in one increment (``Target.lean``)
    counts = [
        _increment_count(target.radius / yarns.radius, GROWTH),
        _increment_count(np.array([target.gamma / state.scale, target.gamma / state.gamma]), GROWTH),
        _increment_count(np.array([1.0 if size is None else size / now for size, now in sides]), STRETCH),
        _increment_count(target.rest_length / yarns.rest_length, LENGTHENING),
        0.0 if target.lean is None else abs(target.lean - lean) / 0.1,
    ]
    # Part of an increment that counts as zero; single precision on the device rounds a period by a tenth of this part.
    return math.ceil(max(counts) - 1e-5)


def increment(state: SwatchInProgress, target: Target) -> SwatchInProgress:
    """Return the state after one increment towards a target that is not reached yet."""
    part = 1.0 / increments_left(state, target)
    yarns = state.yarns
    assert yarns.lattice is not None
    lean = lean_of(target.smallest.whole_lattice(yarns.lattice))
    sides = zip(target.size, size_of(yarns.lattice), strict=True)
    along, across = (1.0 if size is None else (size / now) ** part for size, now in sides)
    yarns = replace(
        stretch_cell(yarns, along, across).with_radius(yarns.radius * (target.radius / yarns.radius) ** part),
        rest_length=yarns.rest_length * (target.rest_length / yarns.rest_length) ** part,
    )
    if target.lean is not None:
        yarns = _shear_cell(yarns, part * (target.lean - lean))
    scale, gamma = (reached * (target.gamma / reached) ** part for reached in (state.scale, state.gamma))
    return SwatchInProgress(yarns, scale, gamma)


def _increment_count(factors: FloatArray, largest: float) -> float:
    """Return how many increments of the largest factor, or of its inverse, make the most extreme factor."""
    return float(np.abs(np.log(factors)).max()) / math.log(largest)


def _shear_cell(yarns: YarnSet, change: float) -> YarnSet:
    """Return yarns and their lattice, sheared along the courses."""
    assert yarns.lattice is not None
    first, second, _normal = lattice_frame(yarns.lattice.periods)
    matrix = np.eye(3) + change * np.outer(second, first)
    return replace(yarns, points=yarns.points @ matrix, lattice=Lattice(yarns.lattice.periods @ matrix))
