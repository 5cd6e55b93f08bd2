# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The ground of all pictures, and the shadow that an object throws on it.

The ground is the floor on which an object stands, or the wall behind it. The surface that the camera sees is projected
onto the ground, along the key light for the shadow and straight down for the sky that the object hides. What is higher
above the ground has a softer shadow, as under a light of some width.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray
from stitchmesh.render.camera import Camera
from stitchmesh.render.light import GROUND_LEAST, KEY, KEY_POWER, KEY_SOFTNESS, Image

HORIZON = 40.0
"""Distance of the ground where no floor is seen, over the distance of the object."""
CELLS = 240
"""Number of cells along the longer side of the map of the shadow."""
POINTS = 400
"""Number of seen points along a side of the picture that throw the shadow."""
BANDS = (0.0, 0.01, 0.03, 0.08, 0.2, 0.5, np.inf)
"""Bounds of the bands of height above the ground that have shadows of one softness, over the size of the map."""
SKY_SOFTNESS = 0.8
"""Width of the shadow of the sky over the height above the ground."""
BORDER = 0.2
"""Width of the border of a panel in which shadows on the floor fade, over the size of the panel."""
EVERY = 8
"""Width of the blocks of pixels of which the shadow on the ground is looked up once."""


@dataclass(frozen=True, eq=False)
class Rays:
    """The rays from the camera through the pixels of a panel."""

    camera: Camera
    across: FloatArray
    """How far the ray of each column leads to the right in a unit of distance along the view, shape (columns,)."""
    upwards: FloatArray
    """How far the ray of each row leads upwards, shape (rows,)."""

    def along(self, direction: FloatArray) -> FloatArray:
        """Return how far each ray leads in a direction in a unit of distance along the view, shape (rows, columns)."""
        camera = self.camera
        ahead = -camera.towards @ direction
        return ahead + self.upwards[:, None] * (camera.up @ direction) + self.across * (camera.side @ direction)

    def points(self, distance: Image) -> FloatArray:
        """Return the points at distances along the view [cm], shape (rows, columns, 3)."""
        return self.camera.position + distance[..., None] * np.stack([self.along(axis) for axis in np.eye(3)], axis=2)

    def some(self, step: int) -> Rays:
        """Return the rays of every so many rows and columns."""
        return Rays(self.camera, self.across[::step], self.upwards[::step])


@dataclass(frozen=True, eq=False)
class Ground:
    """A plane on which shadows fall."""

    origin: FloatArray
    """A point of the plane [cm], shape (3,)."""
    normal: FloatArray
    """Unit normal towards the object, shape (3,)."""
    right: FloatArray
    """Unit direction in the plane that is the right of the picture, shape (3,)."""

    def distance(self, rays: Rays) -> Image:
        """Return the distance of the plane along the view at each pixel [cm]."""
        towards_it = np.maximum(-rays.along(self.normal), 1e-9)
        distance = ((rays.camera.position - self.origin) @ self.normal) / towards_it
        far = HORIZON * np.linalg.norm(rays.camera.position - rays.camera.focus)
        return np.minimum(distance, far).astype(np.float32)

    def places(self, points: FloatArray, direction: FloatArray) -> FloatArray:
        """Return where rays through points meet the plane, in its two directions [cm], shape (n, 2)."""
        offset = points - self.origin
        offset = offset - (offset @ self.normal / (direction @ self.normal))[:, None] * direction
        return offset @ np.stack([self.right, np.cross(self.normal, self.right)], axis=1)


def ground_of(camera: Camera, behind: float) -> Ground:
    """Return the floor of a camera, or a wall at a distance along the view [cm]."""
    if camera.floor is None:
        return Ground(camera.position - behind * camera.towards, camera.towards, camera.side)
    normal = np.array([0.0, 1.0, 0.0])
    return Ground(camera.floor * normal, normal, camera.side)


def ground_shadow(ground: Ground, rays: Rays, distance: Image, is_object: NDArray[np.bool_]) -> Image:
    """Return the light that the shadow of an object leaves on the ground at each pixel, from ``GROUND_LEAST`` to 1.

    Args:
        ground: the ground.
        rays: the rays of the pixels.
        distance: distance of what is seen along the view [cm].
        is_object: whether the object is seen.
    """
    step = max(1, max(distance.shape) // POINTS)
    points = rays.some(step).points(distance[::step, ::step])[is_object[::step, ::step]]
    rows, columns = distance.shape
    at = rays.some(EVERY)
    seen = at.points(ground.distance(at)).reshape(-1, 3)
    hidden = np.zeros(len(seen))
    key = KEY @ rays.camera.axes
    for direction, softness, power in ((key, KEY_SOFTNESS, KEY_POWER), (ground.normal, SKY_SOFTNESS, 1.0 - KEY_POWER)):
        if direction @ ground.normal > 0.1 and len(points):
            hidden += power * _hidden(ground, points, direction, softness, ground.places(seen, ground.normal))
    light = 1.0 - (1.0 - GROUND_LEAST) * hidden.reshape(len(at.upwards), len(at.across))
    if rays.camera.floor is not None:  # Fabric before a wall may fill the picture, with its holes.
        light = 1.0 - (1.0 - light) * np.outer(_inside(len(at.upwards)), _inside(len(at.across)))
    return _enlarged(light.astype(np.float32), rows, columns)


def _inside(count: int) -> FloatArray:
    """Return 1 for each row or column of a panel, and less near the borders, at which no shadow may end abruptly."""
    from_border = np.minimum(np.arange(count), np.arange(count)[::-1])
    part = np.clip(from_border / (BORDER * count), 0.0, 1.0)
    return np.asarray(part * part * (3.0 - 2.0 * part))


def _hidden(
    ground: Ground, points: FloatArray, direction: FloatArray, softness: float, places: FloatArray
) -> FloatArray:
    """Return the part of a light that points hide from places of the ground, shape (n,)."""
    from scipy.ndimage import gaussian_filter, map_coordinates

    shadow = ground.places(points, direction)
    height = (points - ground.origin) @ ground.normal
    margin = 0.7 * np.ptp(shadow, axis=0).max()
    low = shadow.min(axis=0) - margin
    cell = (np.ptp(shadow, axis=0).max() + 2.0 * margin) / CELLS
    counts = np.ceil((np.ptp(shadow, axis=0) + 2.0 * margin) / cell).astype(int) + 1
    free = np.ones(counts)
    for least, most in pairwise(BANDS):
        own = (height >= least * CELLS * cell) & (height < most * CELLS * cell)
        if own.any():
            column, row = ((shadow[own] - low) / cell).astype(int).T
            covered = np.zeros(counts)
            covered[column, row] = 1.0
            free *= 1.0 - gaussian_filter(covered, 1.0 + softness * float(height[own].mean()) / cell)
    return 1.0 - map_coordinates(free, ((places - low) / cell).T, order=1, mode="constant", cval=1.0)


def _enlarged(values: Image, rows: int, columns: int) -> Image:
    """Return values of every so many pixels in between them too."""
    from PIL import Image as Pictures

    part = (0.0, 0.0, columns / EVERY, rows / EVERY)
    return np.asarray(Pictures.fromarray(values).resize((columns, rows), Pictures.Resampling.BILINEAR, box=part))
