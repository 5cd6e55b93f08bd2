# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Round shapes as functions of space: negative inside, zero on the surface, positive outside.

Near the surface a value is about the distance from it in cm, which is enough to join shapes smoothly.
"""

from collections.abc import Callable, Sequence

import numpy as np

Shape = Callable[[np.ndarray], np.ndarray]
Point = tuple[float, float, float]


def round_cone(start: Point, end: Point, start_radius: float, end_radius: float) -> Shape:
    """Return a limb: balls along a line, whose radius changes from its start to its end."""
    first, axis = np.array(start), np.subtract(end, start)

    def value(points: np.ndarray) -> np.ndarray:
        along = np.clip((points - first) @ axis / (axis @ axis), 0.0, 1.0)
        distance = np.linalg.norm(points - first - along[..., None] * axis, axis=-1)
        return distance - start_radius - (end_radius - start_radius) * along

    return value


def ellipsoid(centre: Point, radii: Point) -> Shape:
    """Return an ellipsoid whose axes are those of space."""

    def value(points: np.ndarray) -> np.ndarray:
        return min(radii) * (np.linalg.norm((points - centre) / radii, axis=-1) - 1.0)

    return value


def trunk(sections: Sequence[tuple[float, float, float, float]]) -> Shape:
    """Return a stack of ovals: height, half width, half depth and the middle in z of each [cm]."""
    height, width, depth, middle = np.array(sections).T

    def value(points: np.ndarray) -> np.ndarray:
        x, y, z = np.moveaxis(points, -1, 0)
        a, b, centre = (np.interp(y, height, each) for each in (width, depth, middle))
        across = np.minimum(a, b) * (np.hypot(x / a, (z - centre) / b) - 1.0)
        return np.maximum(across, np.maximum(height[0] - y, y - height[-1]))

    return value


def mirrored(shape: Shape) -> Shape:
    """Return a shape for x > 0 together with its mirror image."""
    return lambda points: shape(np.abs(points) * [1, 0, 0] + points * [0, 1, 1])


def joined(shapes: Sequence[Shape], blend: float) -> Shape:
    """Return the union of shapes; within about the length ``blend`` they flow into one another."""

    def value(points: np.ndarray) -> np.ndarray:
        total = shapes[0](points)
        for shape in shapes[1:]:
            other = shape(points)
            near = np.maximum(blend - np.abs(total - other), 0.0) / blend
            total = np.minimum(total, other) - 0.25 * blend * near**2
        return total

    return value
