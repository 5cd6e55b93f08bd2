# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flat rings of curled yarn: one that is curled more than its circle folds, but no force leads out of the circle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.lattice import Lattice
from stitchmesh.yarn import YarnSet
from tests.yarnrelax.stockinette import periodic_set

COUNT, RADIUS = 24, 0.1
CIRCLE = 1.0
"""Radius of the circle [cm]."""


def ring(curl: float) -> YarnSet:
    """A ring in a cell that it does not fill, with a natural curvature of ``curl`` times that of its circle."""
    angle, number = 2.0 * np.pi * np.arange(COUNT) / COUNT, np.arange(COUNT)
    points = CIRCLE * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    lattice = Lattice(4.0 * CIRCLE * np.eye(3)[:2])
    yarns = periodic_set(points, np.array([0, COUNT]), np.array([[0, 0]]), lattice, RADIUS, number // 4, number % 4)
    return replace(yarns, natural_curvature=np.full(COUNT, curl / CIRCLE))


def height(yarns: YarnSet) -> float:
    """How far a ring reaches out of its plane, over the radius of its yarn."""
    return float(np.ptp(yarns.points[:, 2]) / RADIUS)
