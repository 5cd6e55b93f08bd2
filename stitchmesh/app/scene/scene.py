# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The scene of the application, as pages use it, and the cameras that look at it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from stitchmesh.app.scene.drawing import Drawing
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


Modifier = Literal["", "shift", "ctrl", "alt"]
"""Modifier key during a click or a drag."""
ViewName = Literal["front", "back", "left", "right", "top"]
"""Side from which the camera looks; garments stand upright along y, with their front towards z."""


@dataclass(frozen=True, eq=False)
class Pick:
    """A click in the scene."""

    ray_origin: FloatArray
    """Origin of the ray under the pointer, shape (3,) [cm]."""
    ray_direction: FloatArray
    """Direction of the ray, shape (3,)."""
    modifier: Modifier = ""
    client: int = 0
    """Number of the browser."""


@dataclass(frozen=True, eq=False)
class Stroke(Pick):
    """One moment of a drag that began on a surface that takes strokes."""

    phase: Literal["start", "move", "end"] = "start"


@dataclass(frozen=True, eq=False)
class ScreenBox:
    """A rectangle that the user has drawn on the screen."""

    camera: CameraView
    low: tuple[float, float]
    """Upper left corner, from (0, 0) to (1, 1)."""
    high: tuple[float, float]
    """Lower right corner."""

    def inside(self, points: FloatArray) -> NDArray[np.bool_]:
        """Return whether each point lies in the rectangle and in front of the camera, shape (n, 3) to (n,)."""
        place = self.camera.on_screen(points)
        return np.all((place >= self.low) & (place <= self.high), axis=1)


class DrawingScene(Protocol):
    """Draws by name. All methods belong to the event thread."""

    def show(self, name: str, drawing: Drawing | None) -> None:
        """Draw under a name, in place of the earlier drawing; only arrays that are other objects are sent.

        None, or a drawing without triangles, lines and texts, removes the earlier drawing.
        """

    def remove(self, name: str) -> None:
        """Remove the drawing under a name; an unknown name is no error."""

    def clear(self) -> None:
        """Remove all drawings."""

    def look_at(self, low: FloatArray, high: FloatArray, view: ViewName | None = None) -> None:
        """Show a box, corners of shape (3,), in the whole window of each present and future browser.

        Without a view the camera looks at the box from the front; cameras that already show nearly the same box stay as
        the users turned them.
        """

    def cameras(self) -> list[CameraView]:
        """Return the cameras of the connected browsers."""

    def screenshot(self, width: int, height: int) -> bytes:
        """Return a picture of the scene as a PNG file, as the first browser sees it.

        Raises:
            DisplayError: no browser is connected, or it does not answer.
        """
