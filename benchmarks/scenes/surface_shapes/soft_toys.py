# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Closed toys with many limbs; y is up, and they look along +z."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import Mesh

from .level_surface import Cloth
from .solids import ball, both_sides, joined, round_cone


def bear(edge: float = 0.6) -> Mesh:
    """A teddy bear of 27, which sits."""
    limbs = both_sides(
        ball((4.0, 14.0, 0.0), 1.8),
        round_cone((5.0, 3.0, 0.0), (11.0, 0.0, 3.0), 2.2, 2.0),
        round_cone((3.0, -5.0, 2.0), (5.0, -9.0, 9.0), 2.6, 2.4),
    )
    solid = joined([ball((0.0, 0.0, 0.0), 7.0), ball((0.0, 10.0, 0.0), 5.0), ball((0.0, 9.0, 5.0), 1.6), *limbs], 1.0)
    return Cloth(solid, (-15.0, -14.0, -9.0), (15.0, 17.0, 13.0)).triangles(edge)


def octopus(edge: float = 0.6) -> Mesh:
    """An octopus of 30 with eight arms."""
    angles = np.arange(8) * 2.0 * np.pi / 8.0
    arms = [
        round_cone((3.0 * c, 5.0, 3.0 * s), (14.0 * c, -3.0, 14.0 * s), 2.0, 1.2)
        for c, s in zip(np.cos(angles).tolist(), np.sin(angles).tolist(), strict=True)
    ]
    solid = joined([ball((0.0, 10.0, 0.0), 6.5), *arms], 1.0)
    return Cloth(solid, (-17.0, -7.0, -17.0), (17.0, 19.0, 17.0)).triangles(edge)


TOYS = (bear, octopus)
