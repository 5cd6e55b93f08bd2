# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Small closed bodies for the tests of contact."""

from __future__ import annotations

from unittest.mock import patch

import numpy as np

from stitchmesh.mesh import Mesh
from stitchmesh.mixed.scene import simple_bodies


def box(half: tuple[float, float, float], centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    """A box with sides of twice ``half``."""
    return simple_bodies.box(2.0 * np.array(half), centre)


def ball(radius: float, rounds: int = 3, centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    """A ball of triangles; scenes have finer ones."""
    with patch.object(simple_bodies, "BALL_ROUNDS", rounds):
        return simple_bodies.ball(radius, centre)
