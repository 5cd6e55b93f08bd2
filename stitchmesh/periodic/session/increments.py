# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How a live swatch moves to its target: in equal increments, so small that yarns can part between two of them.

Each increment changes all lengths by the same part of their total change on a logarithmic scale. A length that is to
stay as it is in the fabric, such as the yarn radius while gamma changes, therefore stays constant. The increments are
those of ``continuation``. No increment moves a yarn through another: rest lengths and radii move nothing, and an
affine deformation of the whole lattice keeps separate yarns separate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.lattice import Lattice, lattice_frame
from stitchmesh.mesh import FloatArray
from stitchmesh.periodic.continuation import GROWTH, LENGTHENING, STRETCH, size_of, stretch_cell
from stitchmesh.periodic.session.target import Drawing, Target, lean_of
from stitchmesh.periodic.swatch import scale_yarns
from stitchmesh.yarn import YarnSet

LEANING = 0.1
"""Largest change in one step of how far wales lean over their height."""
ARRIVED = 1e-5
"""Part of a step that is none; single precision on the device rounds a period by a tenth of that."""


@dataclass(frozen=True, eq=False)
class SwatchInProgress:
    """A repeat on its way to a target."""

    yarns: YarnSet
    """As they lie, ``scale`` times as large as in the fabric."""
    scale: float
    """Comes to gamma; another while the fabric as a whole grows or shrinks."""
    gamma: float
    """Take-up reached."""

    @classmethod
    def drawn(cls, drawing: Drawing, target: Target) -> SwatchInProgress:
        """As drawn, so large that its yarn is as thick as it will be."""
        yarns = drawing.yarns
        if drawing.fabric is None:
            # wefts and warps lie straight enough to begin with as long at rest as they are drawn
            yarns = replace(yarns, rest_length=yarns.lengths)
        reached = target.gamma * float(yarns.radius[0] / target.radius[0])
        return cls(yarns, reached, reached)

    def enlarged(self, factor: float) -> SwatchInProgress:
        """The same fabric, worked on so many times as large."""
        return replace(self, yarns=scale_yarns(self.yarns, factor), scale=self.scale * factor)

    @property
    def in_fabric(self) -> YarnSet:
        """The yarns as large as in the fabric."""
        return scale_yarns(self.yarns, 1.0 / self.scale)


def steps_left(moving: SwatchInProgress, target: Target) -> int:
    """Steps to the target; 0 there."""
    yarns = moving.yarns
    assert yarns.lattice is not None
    sides = zip(target.size, size_of(yarns.lattice), strict=True)
    steps = [
        _steps(target.radius / yarns.radius, GROWTH),
        _steps(np.array([target.gamma / moving.scale, target.gamma / moving.gamma]), GROWTH),
        _steps(np.array([1.0 if wanted is None else wanted / now for wanted, now in sides]), STRETCH),
        _steps(target.rest_length / yarns.rest_length, LENGTHENING),
        0.0 if target.lean is None else abs(target.lean - lean_of(yarns)) / LEANING,
    ]
    return math.ceil(max(steps) - ARRIVED)


def stepped(moving: SwatchInProgress, target: Target) -> SwatchInProgress:
    """One step nearer to a target that is not reached."""
    part = 1.0 / steps_left(moving, target)
    yarns = moving.yarns
    assert yarns.lattice is not None
    sides = zip(target.size, size_of(yarns.lattice), strict=True)
    along, across = (1.0 if wanted is None else (wanted / now) ** part for wanted, now in sides)
    yarns = replace(
        stretch_cell(yarns, along, across),
        radius=yarns.radius * (target.radius / yarns.radius) ** part,
        rest_length=yarns.rest_length * (target.rest_length / yarns.rest_length) ** part,
    )
    if target.lean is not None:
        yarns = _leaning(yarns, part * (target.lean - lean_of(yarns)))
    scale, gamma = (reached * (target.gamma / reached) ** part for reached in (moving.scale, moving.gamma))
    return SwatchInProgress(yarns, scale, gamma)


def _steps(factors: FloatArray, largest: float) -> float:
    """How many times the largest factor of a step, or one over it, makes the largest of some."""
    return float(np.abs(np.log(factors)).max()) / math.log(largest)


def _leaning(yarns: YarnSet, further: float) -> YarnSet:
    """Yarns and their lattice sheared along the courses."""
    assert yarns.lattice is not None
    first, second, _normal = lattice_frame(yarns.lattice.periods)
    matrix = np.eye(3) + further * np.outer(second, first)
    return replace(yarns, points=yarns.points @ matrix, lattice=Lattice(yarns.lattice.periods @ matrix))
