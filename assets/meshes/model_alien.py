# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A sweater for a small character with a round belly, long arms and a large head.

It has the rows of the sweater. Heights are shorter, the belly is wider, arms are longer, and the neck is open wide.
"""

import numpy as np
from curves import smooth_step
from model_sweater import model_sweater
from quad_mesh import Garment

HEIGHT = 0.62  # Height over that of the sweater.
BELLY, BELLY_HEIGHT, BELLY_SPREAD = 0.3, 12.0, 11.0  # Widening, its height and its extent on the sweater [cm].
ARM_BEGIN, ARM_LENGTH = 24.0, 1.2  # Distance from the middle where arms become longer [cm], and by how much.
NECK_BEGIN, NECK_END, NECK_WIDTH = 46.0, 60.0, 1.35  # Heights on the sweater between which it widens [cm].
SIZE = 0.8  # Size over that of an adult.


def model_alien() -> Garment:
    """Return the sweater of the character."""
    garment = model_sweater()
    garment.mesh.points = [SIZE * point for point in moved(np.array(garment.mesh.points))]
    return Garment("alien", garment.mesh, garment.borders)


def moved(points: np.ndarray) -> np.ndarray:
    """Return the points of the sweater in their new places [cm], shape (n, 3)."""
    x, y, z = points.T
    torso = 1.0 - smooth_step((np.abs(x) - 12.0) / 20.0)
    belly = 1.0 + BELLY * torso * np.exp(-(((y - BELLY_HEIGHT) / BELLY_SPREAD) ** 2))
    neck = 1.0 + (NECK_WIDTH - 1.0) * torso * smooth_step((y - NECK_BEGIN) / (NECK_END - NECK_BEGIN))
    beyond = np.maximum(np.abs(x) - ARM_BEGIN, 0.0)
    along = x + np.sign(x) * (ARM_LENGTH - 1.0) * beyond
    return np.column_stack([along * belly * neck, HEIGHT * y, z * belly * neck])
