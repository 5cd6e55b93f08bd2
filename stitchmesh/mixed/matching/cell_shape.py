# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The shape of a fabric of uniform strain and curvature, on which a periodic cell of yarns lies (Sperl et al. 2020).

A point X of the flat fabric is first stretched in its plane, Y = U X, and then rolled on a cylinder of curvature kappa
whose axis is across a direction d: with s = d . Y, e the coordinate of Y across d, and theta = kappa s,

    c(X) = (s sinc theta) d + e d' + (kappa s^2 / 2 sinc^2(theta / 2)) n

A node of the cell that has moved by w in the flat fabric lies at c(X) + R(theta) w, where R turns the plane of d and
the normal n by theta. All copies of a node have the same w: forces and energy are those of an endless fabric. Without
curvature the fabric is flat and x = U X + w.

``shape_derivatives`` differentiates by steps of imaginary numbers, which has no error of cancellation: for real x,
dx/dm = Im x(m + i h) / h with h = 1e-30.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]
PARAMETERS = ("stretch_course", "stretch_wale", "skew", "curvature")
"""Names of the parameters of a shape, in the order of derivatives."""
IMAGINARY_STEP = 1e-30


@dataclass(frozen=True)
class CellShape:
    """Uniform strain and curvature of a fabric; axis 1 along courses (wefts), axis 2 along wales (warps)."""

    stretch_course: Any = 1.0
    """U_11."""
    stretch_wale: Any = 1.0
    """U_22."""
    skew: Any = 0.0
    """U_12 = U_21."""
    curvature: Any = 0.0
    """Curvature kappa of the cylinder [1/cm]."""
    direction: float = 0.0
    """Angle between axis 1 and the direction d along which the fabric is curved [rad]."""

    @property
    def green_strain(self) -> Numbers:
        """E_11, E_22 and 2 E_12 of U, shape (3,)."""
        stretch = np.array([[self.stretch_course, self.skew], [self.skew, self.stretch_wale]])
        strain = (stretch @ stretch - np.eye(2)) / 2.0
        return np.array([strain[0, 0], strain[1, 1], 2.0 * strain[0, 1]])

    @property
    def curvatures(self) -> Numbers:
        """kappa_11, kappa_22 and 2 kappa_12, shape (3,)."""
        c, s = np.cos(self.direction), np.sin(self.direction)
        return float(self.curvature) * np.array([c * c, s * s, 2.0 * c * s])

    def changed(self, name: str, change: Any) -> CellShape:
        """The shape with a number added to one parameter."""
        return replace(self, **{name: getattr(self, name) + change})


def place_nodes(shape: CellShape, flat: Numbers, moved: Numbers) -> Any:
    """Positions of nodes [cm], shape (P, 3).

    Args:
        shape: strain and curvature of the fabric; complex parameters give complex positions.
        flat: X of each node [cm], shape (P, 2).
        moved: w of each node [cm], shape (P, 3).
    """
    c, s = np.cos(shape.direction), np.sin(shape.direction)
    x = shape.stretch_course * flat[:, 0] + shape.skew * flat[:, 1]
    y = shape.skew * flat[:, 0] + shape.stretch_wale * flat[:, 1]
    along, across = c * x + s * y, c * y - s * x
    angle = shape.curvature * along
    sine, cosine = np.sin(angle), np.cos(angle)
    moved_along, moved_across = c * moved[:, 0] + s * moved[:, 1], c * moved[:, 1] - s * moved[:, 0]
    on_axis = along * np.sinc(angle / np.pi) + moved_along * cosine - moved[:, 2] * sine
    height = shape.curvature * along**2 / 2.0 * np.sinc(angle / (2.0 * np.pi)) ** 2
    height = height + moved_along * sine + moved[:, 2] * cosine
    beside = across + moved_across
    return np.stack([c * on_axis - s * beside, s * on_axis + c * beside, height], axis=1)


def turned_back(shape: CellShape, flat: Numbers, vectors: Numbers) -> Numbers:
    """R^T times a vector at each node, shape (P, 3): the derivative by w of a function with these derivatives by x."""
    c, s = np.cos(shape.direction), np.sin(shape.direction)
    x = shape.stretch_course * flat[:, 0] + shape.skew * flat[:, 1]
    y = shape.skew * flat[:, 0] + shape.stretch_wale * flat[:, 1]
    angle = shape.curvature * (c * x + s * y)
    along, across = c * vectors[:, 0] + s * vectors[:, 1], c * vectors[:, 1] - s * vectors[:, 0]
    back = along * np.cos(angle) + vectors[:, 2] * np.sin(angle)
    up = vectors[:, 2] * np.cos(angle) - along * np.sin(angle)
    return np.stack([c * back - s * across, s * back + c * across, up], axis=1)


def shape_derivatives(shape: CellShape, flat: Numbers, moved: Numbers) -> Numbers:
    """Derivatives of the positions by each of the ``PARAMETERS``, shape (4, P, 3)."""
    stepped = (shape.changed(name, 1j * IMAGINARY_STEP) for name in PARAMETERS)
    return np.stack([place_nodes(each, flat, moved).imag / IMAGINARY_STEP for each in stepped])
