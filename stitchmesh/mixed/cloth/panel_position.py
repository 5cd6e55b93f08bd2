# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where a flat panel lies in space at the start: in a plane, or wrapped round a cylinder.

A point (x, y) of a panel in a plane lies at

    origin + x X + y Y

with unit axes X and Y. A cylinder of radius R has an axis in direction Y and touches that plane from behind, along the
line x = 0. On this cylinder the point lies at

    origin + R sin(x / R) X + y Y + R (cos(x / R) - 1) X x Y

Both maps keep lengths, and the front of the panel is the side of X x Y, which is the outside of the cylinder.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray

Triple = tuple[float, float, float]

@dataclass(frozen=True, kw_only=True)
class PanelPosition:
    """Where a panel lies in space.

    Raises:
        ParameterError: a number is not finite, an axis is zero, the axes are not at right angles, or the radius is not
            positive.
    """

    origin: Triple = (0.0, 0.0, 0.0)
    """Where the point (0, 0) of the panel lies [cm]."""
    x_axis: Triple = (1.0, 0.0, 0.0)
    """Direction of x; its length does not count."""
    y_axis: Triple = (0.0, 1.0, 0.0)
    """Direction of y; its length does not count."""
    radius: float | None = None
    """Radius of the cylinder round which the panel is wrapped [cm]; None for a panel in a plane."""

    def __post_init__(self) -> None:
        for name in ("origin", "x_axis", "y_axis"):
            value = getattr(self, name)
            if len(value) != 3 or not all(math.isfinite(number) for number in value):
                raise ParameterError(f"position: {name}: got {value}; expected three finite numbers")
        for name in ("x_axis", "y_axis"):
            if not any(getattr(self, name)):
                raise ParameterError(f"position: {name}: got a zero vector; expected a direction")
        cosine = float(_unit(self.x_axis) @ _unit(self.y_axis))
        if abs(cosine) > 1e-6:  # a user writes the axes with a few digits
            angle = math.degrees(math.acos(max(-1.0, min(1.0, cosine))))
            raise ParameterError(f"position: x_axis and y_axis: got an angle of {angle:.4g} degrees; expected 90")
        if self.radius is not None and not (math.isfinite(self.radius) and self.radius > 0.0):
            raise ParameterError(f"position: radius: got {self.radius}; expected a positive number of cm")

    def place(self, points: ArrayLike) -> FloatArray:
        """Return where points of the panel lie in space [cm], shape (n, 2) to (n, 3)."""
        x, y = np.asarray(points, dtype=np.float64).T
        along, up = _unit(self.x_axis), _unit(self.y_axis)
        back = np.zeros_like(x)
        if self.radius is not None:
            angle = x / self.radius
            x, back = self.radius * np.sin(angle), self.radius * (np.cos(angle) - 1.0)
        placed: FloatArray = (
            np.array(self.origin) + x[:, None] * along + y[:, None] * up + back[:, None] * np.cross(along, up)
        )
        return placed


def _unit(axis: Triple) -> FloatArray:
    direction = np.array(axis, dtype=np.float64)
    direction = direction / np.abs(direction).max()
    return direction / np.linalg.norm(direction)
