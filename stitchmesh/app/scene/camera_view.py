# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A camera on the side of the server, which maps points to the screen and places on the screen to rays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from stitchmesh.mesh import FloatArray


@dataclass(frozen=True, eq=False)
class CameraView:
    """A pinhole camera. Its axes are right, down and forward."""

    position: FloatArray
    """Position, shape (3,) [cm]."""
    wxyz: FloatArray
    """Orientation as a quaternion, from the axes of the camera to the axes of the scene, shape (4,)."""
    fov: float
    """Vertical field of view [radians]."""
    aspect: float
    """Width of the screen over its height."""

    @property
    def axes(self) -> FloatArray:
        """Right, down and forward as columns, shape (3, 3)."""
        w, x, y, z = self.wxyz
        return Rotation.from_quat([x, y, z, w]).as_matrix()

    def on_screen(self, points: FloatArray) -> FloatArray:
        """Return places on the screen, shape (n, 3) to (n, 2): (0, 0) is the upper left corner, (1, 1) the lower right.

        A point behind the camera has no place: both its numbers are nan.
        """
        seen = (np.asarray(points) - self.position) @ self.axes
        depth = np.where(seen[:, 2] > 0.0, seen[:, 2], np.nan)
        scale = 0.5 / np.tan(0.5 * self.fov)
        across, down = scale * seen[:, 0] / depth / self.aspect, scale * seen[:, 1] / depth
        return np.stack([0.5 + across, 0.5 + down], axis=1)

    def ray(self, x: float, y: float) -> tuple[FloatArray, FloatArray]:
        """Return origin and unit direction of the ray through a place on the screen."""
        half = np.tan(0.5 * self.fov)
        direction = self.axes @ np.array([(2.0 * x - 1.0) * half * self.aspect, (2.0 * y - 1.0) * half, 1.0])
        return np.asarray(self.position, dtype=np.float64), direction / np.linalg.norm(direction)
