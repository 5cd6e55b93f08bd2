# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn that grows thicker or longer and cells drawn to another size, in steps between which the yarns give way.

Contact parts yarns that overlap by some tenths of a radius and no more (``step_limit``), and a cell that is pulled in
one go carries yarns through one another. So each step changes lengths by a part, and some iterations follow it.
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
from stitchmesh.yarnrelax.relax import relax_partly
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell

GROWTH = 1.2
"""Largest factor of a radius in one step."""
LENGTHENING = 1.2
"""Largest factor of a rest length in one step, or one over it."""
STRETCH = 1.1
"""Largest factor of a period in one step, or one over it."""
ITERATIONS = 40
"""Iterations between two steps."""
TOO_THICK = "there is no room for yarn so thick; take thinner or longer yarn, or a smaller gamma"
TOO_SHORT = "yarns of these rest lengths cannot be parted; change them less, or let the cell relax"
TOO_STRETCHED = "yarns cannot be parted in a repeat of this size; give a size nearer to its own, or other rest lengths"


def change_radius(
    yarns: YarnSet, factor: float, material: YarnMaterial, quality: Quality, device: str | None = None
) -> YarnSet:
    """Yarns of so many times the radius; they shrink in one step, and grow in several.

    Raises:
        SolverError: there is no room for yarn so thick.
    """
    steps = _steps(factor, GROWTH) if factor > 1.0 else [factor]
    for step in steps:
        if len(steps) > 1:
            yarns = _settled(yarns, material, quality, device, TOO_THICK)
        yarns = replace(yarns, radius=yarns.radius * step)
    return yarns if len(steps) == 1 else _settled(yarns, material, quality, device, TOO_THICK)


def change_rest_length(
    yarns: YarnSet, rest_length: FloatArray, material: YarnMaterial, quality: Quality, device: str | None = None,
    cell: RelaxCell | None = None,
) -> YarnSet:  # fmt: skip
    """Yarns of other rest lengths, settled.

    Args:
        yarns: on a lattice or not.
        rest_length: of each segment [cm], shape (S,).
        material: of the yarn.
        quality: how finely it is sampled on the way.
        device: where the kernels run.
        cell: what the periods are free to do on the way.

    Raises:
        SolverError: yarns cannot be parted on the way.
    """
    ratio = rest_length / yarns.rest_length
    if (ratio == 1.0).all():
        return yarns
    first = yarns.rest_length
    count = max(len(_steps(factor, LENGTHENING)) for factor in (float(ratio.min()), float(ratio.max())))
    for number in range(count + 1):
        yarns = replace(yarns, rest_length=first * ratio ** (number / count))
        yarns = _settled(yarns, material, quality, device, TOO_SHORT, cell)
    return replace(yarns, rest_length=rest_length)


def change_period(
    yarns: YarnSet, size: Sequence[float | None], material: YarnMaterial, quality: Quality, device: str | None = None
) -> YarnSet:
    """Yarns on a lattice of another size.

    Args:
        yarns: on a lattice.
        size: length of the first period and how far the second reaches across it [cm]; None leaves it.
        material: of the yarn.
        quality: how finely it is sampled on the way.
        device: where the kernels run.

    Raises:
        SolverError: yarns cannot be parted on the way.
    """
    assert yarns.lattice is not None
    factors = [1.0 if new is None else new / old for new, old in zip(size, size_of(yarns.lattice), strict=True)]
    count = max(len(_steps(factor, STRETCH)) for factor in factors)
    step = [factor ** (1.0 / count) for factor in factors]
    for number in range(count if factors != [1.0, 1.0] else 0):
        if number:
            yarns = _settled(yarns, material, quality, device, TOO_STRETCHED)
        yarns = stretch_cell(yarns, *step)
    return yarns if count == 1 else _settled(yarns, material, quality, device, TOO_STRETCHED)


def stretch_cell(yarns: YarnSet, along: float, across: float) -> YarnSet:
    """Yarns and their lattice scaled along the courses and across them, in the plane of the lattice."""
    assert yarns.lattice is not None
    first, second, _normal = lattice_frame(yarns.lattice.periods)
    matrix = np.eye(3) + (along - 1.0) * np.outer(first, first) + (across - 1.0) * np.outer(second, second)
    return replace(yarns, points=yarns.points @ matrix, lattice=Lattice(yarns.lattice.periods @ matrix))


def size_of(lattice: Lattice) -> tuple[float, float]:
    """Length of the first period and how far the second reaches across it [cm]."""
    width = float(np.linalg.norm(lattice.periods[0]))
    return width, lattice.area / width


def _steps(factor: float, largest: float) -> list[float]:
    """Equal factors, each at most ``largest`` or at least one over it, whose product is ``factor``."""
    count = max(math.ceil(abs(math.log(factor)) / math.log(largest) - 1e-9), 1)
    return [factor ** (1.0 / count)] * count


def _settled(
    yarns: YarnSet, material: YarnMaterial, quality: Quality, device: str | None, refusal: str,
    cell: RelaxCell | None = None,
) -> YarnSet:  # fmt: skip
    """Yarns after the iterations between two steps.

    Where they cannot be parted the step is to blame, and not the start, which was given no further than by its steps.
    """
    try:
        return relax_partly(
            yarns, material=material, quality=quality, device=device, iterations=ITERATIONS, cell=cell
        )
    except SolverError as error:
        raise SolverError(f"{str(error).partition(':')[0]}: {refusal}") from error
