# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Directions from which an object is seen: named views, and views by azimuth and elevation.

The y axis is vertical, and the front is the wide side of the object. A flat object is seen perpendicular to its plane;
if the plane is the xz plane, it is seen from above with -z upwards in the picture. The azimuth turns the camera from
the front to the right of the picture, and the elevation raises it, both in degrees.
"""

from __future__ import annotations

import difflib

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray

View = str | tuple[float, float]
"""Name of a view, or azimuth and elevation [degrees], as text with a comma between them or as two numbers."""
FRONT = "front"
"""The default view of a picture."""
TURN, LIFT = 14.0, 10.0
"""Azimuth and elevation of the front view of an object that is not flat [degrees]; it shows the depth of the object."""
VIEWS: dict[str, tuple[float, float]] = {
    FRONT: (TURN, LIFT),
    "back": (180.0 + TURN, LIFT),
    "left": (-90.0, LIFT),
    "right": (90.0, LIFT),
    "top": (0.0, 90.0),
    "bottom": (0.0, -90.0),
}
"""Azimuth and elevation of each named view [degrees]; left and right mean the sides of the picture of the front
view."""
STRAIGHT = {FRONT: (0.0, 0.0), "back": (180.0, 0.0)}
"""Views of a flat object that differ from ``VIEWS``."""
FLAT = 0.08
"""An object is flat if its smallest extent is at most this part of its middle one."""


def view_directions(points: FloatArray, view: View = FRONT) -> tuple[FloatArray, FloatArray]:
    """Return the direction towards the viewer and the vertical direction of the picture, shape (3,) each.

    Args:
        points: points of the object [cm], shape (n, 3).
        view: the view.

    Raises:
        ParameterError: the view is unknown, the azimuth is not finite, or the elevation is not between -90 and 90
            degrees.
    """
    towards, up, flat = _front(points)
    azimuth, elevation = np.radians(view_angles(view, flat=flat))
    return turned_view(towards, up, azimuth, elevation)


def turned_view(
    towards: FloatArray, up: FloatArray, azimuth: float, elevation: float
) -> tuple[FloatArray, FloatArray]:
    """Return the direction towards a viewer who turns around an object, and the vertical direction of the picture.

    Args:
        towards: direction towards the viewer of the front, shape (3,).
        up: the vertical direction, shape (3,).
        azimuth: angle to the right of the front [radians].
        elevation: angle above the horizon [radians].
    """
    level = np.cos(azimuth) * towards + np.sin(azimuth) * np.cross(up, towards)
    steep = abs(np.cos(elevation)) < 1e-6  # From the top, the front of the object is at the bottom.
    upright = -np.sign(elevation) * level if steep else up
    return np.cos(elevation) * level + np.sin(elevation) * up, upright


def view_angles(view: View, *, flat: bool = False) -> tuple[float, float]:
    """Return the azimuth and the elevation of a view [degrees].

    Args:
        view: the view.
        flat: whether the object is flat.

    Raises:
        ParameterError: the view is unknown, the azimuth is not finite, or the elevation is not between -90 and 90
            degrees.
    """
    named = VIEWS | STRAIGHT if flat else VIEWS
    if isinstance(view, str) and view.strip().lower() in named:
        return named[view.strip().lower()]
    azimuth, elevation = _numbers(view)
    if not np.isfinite(azimuth):
        raise ParameterError(f"view: got an azimuth of {azimuth:g} degrees; expected a finite number")
    if not -90.0 <= elevation <= 90.0:
        raise ParameterError(f"view: got an elevation of {elevation:g} degrees; expected -90 to 90")
    return azimuth, elevation


def _numbers(view: View) -> tuple[float, float]:
    try:
        azimuth, elevation = (float(part) for part in (view.split(",") if isinstance(view, str) else view))
    except (TypeError, ValueError):
        near = difflib.get_close_matches(str(view).lower(), VIEWS, n=1, cutoff=0.5)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        expected = f"{', '.join(VIEWS)}, or azimuth,elevation in degrees"
        raise ParameterError(f"view: got {view!r}; expected {expected}{hint}") from None
    return azimuth, elevation


def _front(points: FloatArray) -> tuple[FloatArray, FloatArray, bool]:
    """Return the direction straight to the front, the vertical direction, and whether the object is flat."""
    extent = np.ptp(points, axis=0)
    thin = int(extent.argmin())
    if extent[thin] <= FLAT * np.sort(extent)[1]:
        up = np.array([0.0, 0.0, -1.0]) if thin == 1 else np.array([0.0, 1.0, 0.0])
        return np.eye(3)[thin], up, True
    return np.eye(3)[0 if extent[2] > 1.3 * extent[0] else 2], np.array([0.0, 1.0, 0.0]), False
