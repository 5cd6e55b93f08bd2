# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The lattice of a periodic fabric: two period vectors and integer images.

The vector to a neighbour across the border of the cell is always ``x_j + a*u + b*v - x_i`` with a stored integer
image (a, b). The nearest-image rule is never used, because a cell of one stitch is smaller than twice the contact
range.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import MeshError, SolverError

LARGEST_LENGTH = 1e60
"""Largest length or coordinate [cm]; with it, areas and their squares are still finite numbers."""
_NEXT, _LAST = [1, 2, 0], [2, 0, 1]
"""The axes that follow and that precede x, y and z."""
MOST_IMAGES = 1_000_000
"""Largest number of images of a cell that is searched. A weave with a spacing of 1/12 of the yarn radius has 150,000;
a cell that its yarns fit into has some hundreds."""


@dataclass(frozen=True, eq=False)
class Lattice:
    """The two period vectors of a periodic fabric.

    Raises:
        MeshError: the periods are not finite, are larger than ``LARGEST_LENGTH``, or do not span a plane.
    """

    periods: NDArray[np.float64]
    """Period along the courses and period along the wales [cm], shape (2, 3)."""

    def __post_init__(self) -> None:
        periods = np.array(self.periods, dtype=np.float64)
        if periods.shape != (2, 3) or not (np.abs(periods) <= LARGEST_LENGTH).all():
            raise MeshError(f"lattice: got periods {periods.tolist()}; expected two finite vectors of three numbers")
        if np.linalg.norm(cross_product(periods[0], periods[1])) == 0.0:
            raise MeshError(f"lattice: the periods {periods.tolist()} are parallel; expected two that span a plane")
        periods.setflags(write=False)
        object.__setattr__(self, "periods", periods)

    def __repr__(self) -> str:
        """Return one line: both periods."""
        return f"Lattice({self.periods.round(6).tolist()})"

    @property
    def area(self) -> float:
        """Area of a cell [cm^2]."""
        return float(np.linalg.norm(cross_product(*self.periods)))

    def shift(self, image: ArrayLike) -> NDArray[np.float64]:
        """Displacement ``a*u + b*v`` [cm] of integer images, shape (..., 2) to (..., 3)."""
        return np.asarray(image, dtype=np.float64) @ self.periods

    def fractions(self, points: ArrayLike) -> NDArray[np.float64]:
        """Coordinates of points in units of the periods, shape (n, 3) to (n, 2)."""
        return np.asarray(points, dtype=np.float64) @ self._dual.T

    def image_of(self, points: ArrayLike) -> NDArray[np.int64]:
        """Image of the cell in which each point lies; the cell at the origin is (0, 0), shape (n, 3) to (n, 2)."""
        image: NDArray[np.int64] = np.floor(self.fractions(points)).astype(np.int64)
        return image

    def near_images(self, points: ArrayLike, reach: float) -> NDArray[np.int64]:
        """Images whose copies of the points may be near the points themselves, with (0, 0), shape (m, 2).

        An image is left out if its copy of the points' bounding box is farther than ``reach`` from the box itself.

        Args:
            points: positions [cm], shape (n, 3).
            reach: distance up to which two points are near each other [cm].

        Raises:
            SolverError: there are too many images (``images_up_to``).
        """
        places = np.asarray(points, dtype=np.float64)
        span = np.ptp(places @ self._dual.T, axis=0) + reach * np.linalg.norm(self._dual, axis=1)
        images = images_up_to(np.ceil(span))
        near: NDArray[np.int64] = images[(np.abs(self.shift(images)) <= np.ptp(places, axis=0) + reach).all(axis=1)]
        return near

    @cached_property
    def _dual(self) -> NDArray[np.float64]:
        """Dual basis [1/cm], shape (2, 3): row k times a displacement is the number of periods k that it spans."""
        return np.asarray(np.linalg.pinv(self.periods).T, dtype=np.float64)


def images_up_to(most: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the images (a, b) with ``-most <= (a, b) <= most``, shape (n, 2).

    Raises:
        SolverError: there are more than ``MOST_IMAGES``, because the cell is far smaller than its yarns.
    """
    if (count := float(np.prod(2.0 * most + 1.0))) > MOST_IMAGES:
        raise SolverError(
            f"images of the cell: {count:.3g} copies of the cell may touch it; expected at most {MOST_IMAGES:,}; the "
            "cell is too small for its yarns: take a larger spacing or loop length, or thinner yarn"
        )
    a, b = (np.arange(-largest, largest + 1) for largest in most.astype(np.int64))
    return np.stack(np.meshgrid(a, b, indexing="ij"), axis=2).reshape(-1, 2)


def cross_product(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cross products of vectors, shape (..., 3); for a few vectors this is six times as fast as ``np.cross``."""
    return first[..., _NEXT] * second[..., _LAST] - first[..., _LAST] * second[..., _NEXT]


def lattice_frame(periods: NDArray[np.float64]) -> NDArray[np.float64]:
    """Orthonormal frame of one or many lattices, shape (..., 2, 3) to (..., 3, 3).

    The first vector points along the courses, the second across the courses in the plane of the lattice, and the third
    is the normal of that plane.

    Args:
        periods: period vectors of each lattice [cm].
    """
    first, second = periods[..., 0, :], periods[..., 1, :]
    along = first / np.linalg.norm(first, axis=-1, keepdims=True)
    normal = cross_product(first, second)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return np.stack([along, cross_product(normal, along), normal], axis=-2)
