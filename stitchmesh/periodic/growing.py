# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn that grows thicker and cells that are drawn to another size, in steps between which the yarns give way.

Contact parts yarns that overlap by some tenths of a radius and no more (``step_limit``), and a cell that is pulled in
one go carries yarns through one another. So each step changes lengths by a part, and some iterations follow it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stitchmesh.lattice import Lattice
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.cell import lattice_frame
from stitchmesh.yarnrelax.solver import settled_yarns

GROWTH = 1.2
"""Largest factor of a radius in one step."""
STRETCH = 1.1
"""Largest factor of a period in one step, or one over it."""
ITERATIONS = 40
"""Iterations between two steps."""


def grown(
    yarns: YarnSet, factor: float, material: YarnMaterial, quality: Quality, device: str | None = None
) -> YarnSet:
    """Yarns of so many times the radius; they shrink in one step, and grow in several.

    Raises:
        SolverError: there is no room for yarn so thick.
    """
    for step in _steps(factor, GROWTH) if factor > 1.0 else [factor]:
        if step != factor or factor > GROWTH:
            yarns = settled_yarns(yarns, material=material, quality=quality, device=device, iterations=ITERATIONS)
        yarns = replace(yarns, radius=yarns.radius * step)
    return yarns


def stretched_to(
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
            yarns = settled_yarns(yarns, material=material, quality=quality, device=device, iterations=ITERATIONS)
        yarns = stretched(yarns, *step)
    return yarns


def stretched(yarns: YarnSet, along: float, across: float) -> YarnSet:
    """Yarns and their lattice scaled along the courses and across them, in the plane of the lattice."""
    assert yarns.lattice is not None
    first, second, _normal = lattice_frame(yarns.lattice)
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
