# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cameras that frame the drawn object, and the place on its front that the close-up shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray

VIEW_ANGLE = 24.0
"""Vertical view angle [degrees]; it is small, so that near and far stitches have about the same size."""
MARGIN = 1.06
"""Size of the picture divided by the size that the object needs."""
FLOOR_SEEN = (0.05, 0.95)
"""Bounds of the sine of the elevation from which a floor is seen: 3 to 72 degrees."""


@dataclass(frozen=True)
class Camera:
    """A perspective camera."""

    position: FloatArray
    """Position [cm], shape (3,)."""
    focus: FloatArray
    """Point in the centre of the picture [cm], shape (3,)."""
    up: FloatArray
    """Direction that is vertical in the picture, shape (3,)."""
    side: FloatArray
    """Direction that points to the right in the picture, shape (3,)."""
    floor: float | None = None
    """Height of the floor on which the object stands [cm]; None if the ground is a wall behind it."""

    @property
    def towards(self) -> FloatArray:
        """Unit direction to the camera, shape (3,)."""
        depth = self.position - self.focus
        return np.asarray(depth / np.linalg.norm(depth))

    @property
    def axes(self) -> FloatArray:
        """Directions to the right, upwards and to the camera, shape (3, 3)."""
        return np.stack([self.side, self.up, self.towards])


def camera_around(
    points: FloatArray,
    towards: FloatArray,
    up: FloatArray,
    aspect: float,
    *,
    part: tuple[float, float] = (1.0, 1.0),
    clearance: float = 0.0,
) -> Camera:
    """Return the nearest camera in a direction whose picture contains all points.

    Args:
        points: points that must be visible [cm], shape (n, 3).
        towards: direction from the points to the camera, shape (3,).
        up: direction that is vertical in the picture, shape (3,).
        aspect: width of the picture divided by its height.
        part: part of the width and of the height of the picture, around its centre, in which the points must lie.
        clearance: distance by which the object extends beyond the points [cm].
    """
    axes = picture_axes(towards, up)
    side, upright, depth = axes.T
    place = points @ axes
    middle = (place.min(axis=0) + place.max(axis=0)) / 2
    half_height = np.tan(np.radians(VIEW_ANGLE / 2)) / MARGIN
    offset = np.abs(place - middle) + clearance
    reach = np.maximum(offset[:, 0] / (half_height * aspect * part[0]), offset[:, 1] / (half_height * part[1]))
    distance = float((reach + place[:, 2] - middle[2]).max())
    focus = axes @ middle
    stands = FLOOR_SEEN[0] < depth[1] < FLOOR_SEEN[1]
    floor = float(points[:, 1].min()) - clearance if stands else None
    return Camera(focus + distance * depth, focus, upright, side, floor)


def camera_at(focus: FloatArray, towards: FloatArray, up: FloatArray, height: float) -> Camera:
    """Return a camera whose picture is ``height`` [cm] high at the focus.

    Args:
        focus: point in the centre of the picture [cm], shape (3,).
        towards: direction from the focus to the camera, shape (3,).
        up: direction that is vertical in the picture, shape (3,).
        height: height of the picture at the focus [cm].
    """
    side, upright, depth = picture_axes(towards, up).T
    distance = height / 2 / np.tan(np.radians(VIEW_ANGLE / 2))
    return Camera(focus + distance * depth, focus, upright, side)


def front_patch(points: FloatArray, towards: FloatArray, up: FloatArray, size: float) -> tuple[FloatArray, FloatArray]:
    """Find a patch in the middle of the front, and its outward normal.

    Args:
        points: points distributed over the surface [cm], shape (n, 3).
        towards: direction from the surface to the camera, shape (3,).
        up: direction that is vertical in the picture, shape (3,).
        size: width of the patch [cm].

    Returns:
        The centre of the patch [cm] and its unit normal, shape (3,) each.
    """
    axes = picture_axes(towards, up)
    place = points @ axes
    middle = (place[:, :2].min(axis=0) + place[:, :2].max(axis=0)) / 2
    nearest = place[np.linalg.norm(place[:, :2] - middle, axis=1).argmin()]
    around = np.linalg.norm(place[:, :2] - nearest[:2], axis=1) < size / 2
    front = place[around, 2] > place[around, 2].max() - size / 2
    patch = points[around][front]
    normal = np.linalg.svd(patch - patch.mean(axis=0), full_matrices=False)[2][2]
    return patch.mean(axis=0), normal if normal @ axes[:, 2] > 0 else -normal


def picture_axes(towards: FloatArray, up: FloatArray) -> FloatArray:
    """Return the unit directions to the right, upwards and to the camera as columns of a matrix, shape (3, 3).

    Args:
        towards: direction from the object to the camera, shape (3,).
        up: direction that is vertical in the picture, shape (3,).
    """
    depth = towards / np.linalg.norm(towards)
    side = np.cross(up, depth)
    if np.linalg.norm(side) < 1e-6:  # The camera looks along the vertical direction.
        side = np.cross(np.array([0.0, 0.0, -1.0]), depth)
    side /= np.linalg.norm(side)
    return np.stack([side, np.cross(depth, side), depth], axis=1)
