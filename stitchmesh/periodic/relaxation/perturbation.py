# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Smooth random displacements of a periodic fabric, which move no yarn through another one.

A displacement is a sum of a few waves over the cell and a strain of the cell. With s and t the coordinates of a place
in periods,

    u = sum over m, n of  Re c_mn exp(2 pi i (m s + n t))        |m|, |n| <= WAVES, c_mn random in space

u does not depend on the height. If its gradient has a norm below 1, places move without meeting: x -> x + u(x) is a
homeomorphism that can be shrunk to the identity, and no yarn passes through another one. Two places approach each
other by at most the norm times their distance. Waves and strain are therefore scaled to ``STEEPEST`` and ``STRAIN``:
yarns that touch then overlap by less than half of their thickness, which contact forces can separate.

The splines follow their control points, and so they move like the yarns, up to the curvature of u over a segment.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.lattice import Lattice, lattice_frame
from stitchmesh.mesh import FloatArray
from stitchmesh.yarn import YarnSet

WAVES = 2
"""Largest number of waves in a period of the cell, in each direction."""
STEEPEST = 0.25
"""Largest norm of the gradient of the waves."""
STRAIN = 0.1
"""Largest strain along the courses and along the wales, and largest change of the lean."""
Random = np.random.Generator


def perturb(yarns: YarnSet, random: Random, free: NDArray[np.bool_]) -> YarnSet:
    """Return yarns on a lattice after a random displacement; equal states of ``random`` give equal displacements.

    Args:
        yarns: the yarns, on their lattice.
        random: source of random numbers.
        free: whether the strain along the courses, the strain along the wales and the lean may change, shape (3,).
    """
    assert yarns.lattice is not None
    e1, e2, normal = lattice_frame(yarns.lattice.periods)
    first, second, lean = STRAIN * random.uniform(-1.0, 1.0, 3) * free
    strain = np.eye(3) + first * np.outer(e1, e1) + second * np.outer(e2, e2) + lean * np.outer(e2, e1)
    waved = yarns.points + waves(yarns, random) @ np.stack([e1, e2, normal])
    return replace(yarns, points=waved @ strain, lattice=Lattice(yarns.lattice.periods @ strain))


def waves(yarns: YarnSet, random: Random) -> FloatArray:
    """Return displacements of the control points along courses, across them and along the normal [cm], shape (N, 3)."""
    assert yarns.lattice is not None
    numbers = np.array([(m, n) for m in range(WAVES + 1) for n in range(-WAVES, WAVES + 1) if (m, n) > (0, 0)])
    size = random.normal(size=(len(numbers), 3)) + 1j * random.normal(size=(len(numbers), 3))
    size /= (numbers**2).sum(axis=1)[:, None]
    frame = lattice_frame(yarns.lattice.periods)[:2]
    # rows of ``dual`` take a place in the frame to its coordinates in periods
    dual = np.linalg.inv(yarns.lattice.periods @ frame.T).T
    turns = np.exp(2j * np.pi * (yarns.points @ frame.T @ dual.T) @ numbers.T)
    slopes = 2j * np.pi * np.einsum("pw,wk,wd->pdk", turns, size, numbers @ dual)
    displacement: FloatArray = (turns @ size).real * (STEEPEST / _steepest(slopes.real))
    return displacement


def _steepest(slopes: FloatArray) -> float:
    """Largest norm of gradients (N, 3, 2): the root of the larger eigenvalue of each J^T J, faster than by SVD."""
    first, second = slopes[:, :, 0], slopes[:, :, 1]
    squares, others = (first**2).sum(axis=1), (second**2).sum(axis=1)
    apart = np.hypot((squares - others) / 2.0, (first * second).sum(axis=1))
    return float(np.sqrt((squares + others) / 2.0 + apart).max())
