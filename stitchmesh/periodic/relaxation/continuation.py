# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Changes of radius, rest length and period in steps, with some iterations of relaxation between the steps.

Contact forces separate yarns that overlap by a few tenths of a radius, but not more (``step_limit``). A large change in
one step would therefore carry yarns through one another. Each step changes a length by a limited factor, and the yarns
are relaxed for a few iterations before the next step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stitchmesh.errors import SolverError
from stitchmesh.lattice import Lattice, lattice_frame
from stitchmesh.mesh import FloatArray
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.relax import relax_partly
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell

GROWTH = 1.2
"""Largest factor of the radius in one step."""
LENGTHENING = 1.2
"""Largest factor of a rest length in one step; the smallest factor is its inverse."""
STRETCH = 1.1
"""Largest factor of a period in one step; the smallest factor is its inverse."""
ITERATIONS = 40
"""Iterations of relaxation between two steps."""
TOO_THICK = "yarn of this radius does not fit; take thinner or longer yarn, or a smaller gamma"
TOO_SHORT = "yarns of these rest lengths cannot be separated; change them less, or let the cell relax"
TOO_STRETCHED = (
    "yarns cannot be separated in a repeat of this size; give a size closer to that of the free repeat, or other rest "
    "lengths"
)


def change_radius(
    yarns: YarnSet, factor: float, material: YarnMaterial, quality: Quality, device: str | None = None
) -> YarnSet:
    """Multiply the radius of yarns by a factor: in one step if the radius falls, otherwise in several steps.

    Args:
        yarns: the yarns.
        factor: factor of the radius.
        material: material of the yarns.
        quality: resolution of the relaxation between the steps.
        device: device of the kernels, for example ``cpu`` or ``cuda:0``.

    Raises:
        SolverError: yarn of this radius does not fit.
    """
    steps = _steps(factor, GROWTH) if factor > 1.0 else [factor]
    for step in steps:
        if len(steps) > 1:
            yarns = _relax_between_steps(yarns, material, quality, device, TOO_THICK)
        yarns = yarns.with_radius(yarns.radius * step)
    if len(steps) == 1:
        return yarns
    return _relax_between_steps(yarns, material, quality, device, TOO_THICK)


def change_rest_length(
    yarns: YarnSet, rest_length: FloatArray, material: YarnMaterial, quality: Quality, device: str | None = None,
    cell: RelaxCell | None = None, terms: Sequence[YarnChoice] = (),
) -> YarnSet:  # fmt: skip
    """Change the rest lengths of yarns in steps.

    Args:
        yarns: the yarns, on a lattice or not.
        rest_length: the new rest length of each segment [cm], shape (S,).
        material: material of the yarns.
        quality: resolution of the relaxation between the steps.
        device: device of the kernels, for example ``cpu`` or ``cuda:0``.
        cell: degrees of freedom of the periods between the steps; None keeps the periods fixed.
        terms: further energies between the steps.

    Raises:
        SolverError: the yarns cannot be separated at a step.
    """
    ratio = rest_length / yarns.rest_length
    if (ratio == 1.0).all():
        return yarns
    first = yarns.rest_length
    count = max(len(_steps(factor, LENGTHENING)) for factor in (float(ratio.min()), float(ratio.max())))
    for number in range(count + 1):
        yarns = replace(yarns, rest_length=first * ratio ** (number / count))
        yarns = _relax_between_steps(yarns, material, quality, device, TOO_SHORT, cell, terms)
    return replace(yarns, rest_length=rest_length)


def change_period(
    yarns: YarnSet, size: Sequence[float | None], material: YarnMaterial, quality: Quality, device: str | None = None
) -> YarnSet:
    """Change the periods of yarns on a lattice in steps.

    Args:
        yarns: the yarns, on a lattice.
        size: length of the first period, and height of the cell at right angles to it [cm]; None keeps a size.
        material: material of the yarns.
        quality: resolution of the relaxation between the steps.
        device: device of the kernels, for example ``cpu`` or ``cuda:0``.

    Raises:
        SolverError: the yarns cannot be separated at a step.
    """
    assert yarns.lattice is not None
    factors = [1.0 if new is None else new / old for new, old in zip(size, size_of(yarns.lattice), strict=True)]
    count = max(len(_steps(factor, STRETCH)) for factor in factors)
    step = [factor ** (1.0 / count) for factor in factors]
    for number in range(count if factors != [1.0, 1.0] else 0):
        if number:
            yarns = _relax_between_steps(yarns, material, quality, device, TOO_STRETCHED)
        yarns = stretch_cell(yarns, *step)
    if count == 1:
        return yarns
    return _relax_between_steps(yarns, material, quality, device, TOO_STRETCHED)


def stretch_cell(yarns: YarnSet, along: float, across: float) -> YarnSet:
    """Scale yarns and their lattice by one factor along the courses and another across them, in the lattice plane."""
    assert yarns.lattice is not None
    first, second, _normal = lattice_frame(yarns.lattice.periods)
    matrix = np.eye(3) + (along - 1.0) * np.outer(first, first) + (across - 1.0) * np.outer(second, second)
    return replace(yarns, points=yarns.points @ matrix, lattice=Lattice(yarns.lattice.periods @ matrix))


def size_of(lattice: Lattice) -> tuple[float, float]:
    """Return the length of the first period, and the height of the cell at right angles to this period [cm]."""
    width = float(np.linalg.norm(lattice.periods[0]))
    return width, lattice.area / width


def _steps(factor: float, largest: float) -> list[float]:
    """Return equal factors between 1 / ``largest`` and ``largest`` whose product is ``factor``."""
    count = max(math.ceil(abs(math.log(factor)) / math.log(largest) - 1e-9), 1)
    return [factor ** (1.0 / count)] * count


def _relax_between_steps(
    yarns: YarnSet, material: YarnMaterial, quality: Quality, device: str | None, reason: str,
    cell: RelaxCell | None = None, terms: Sequence[YarnChoice] = (),
) -> YarnSet:  # fmt: skip
    """Relax yarns for the iterations between two steps.

    An error of these iterations becomes an error with ``reason``. The yarns were separated before the step, so the
    change of the step is too large.
    """
    try:
        return relax_partly(
            yarns, material=material, quality=quality, device=device, iterations=ITERATIONS, cell=cell, terms=terms
        )
    except SolverError as error:
        raise SolverError(f"{str(error).partition(':')[0]}: {reason}") from error
