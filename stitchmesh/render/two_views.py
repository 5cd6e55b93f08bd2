# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Layout of a picture of a mesh from the front and from the back, with a legend on the right."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.render.camera import camera_around, picture_axes
from stitchmesh.render.options import Size
from stitchmesh.render.stage import KEY_LEFT, PAPER, WHOLE, Viewport, look
from stitchmesh.render.view import FLAT, view_directions

if TYPE_CHECKING:
    import pyvista

PANELS = KEY_LEFT - 0.01
"""Width of the views, divided by the width of the picture; the legend is beside them."""
LOW = 0.045
"""Lower border of the views, divided by the height of the picture; the caption is below them."""


@dataclass(frozen=True, eq=False)
class TwoViews:
    """The panels of a picture, and the direction from which each of them shows the mesh."""

    points: FloatArray
    """Points of the mesh [cm], shape (n, 3)."""
    towards: tuple[FloatArray, ...]
    """Direction from the mesh to the camera of each view."""
    up: FloatArray
    """Direction that is vertical in the picture."""
    views: tuple[Viewport, ...]
    """Panel of each view."""
    size: Size
    """Width and height of the picture [pixels]."""

    @property
    def panels(self) -> tuple[Viewport, ...]:
        """The panel of the background, and the panels of the views."""
        return (WHOLE, *self.views)

    def shown(self, plotter: pyvista.Plotter) -> Iterator[None]:
        """Make each view the active one in turn; the caller adds its objects, and its camera is set afterwards."""
        plotter.set_background(PAPER)  # One colour, so that the panels have no visible borders.
        left, low, right, high = self.views[0]
        aspect = self.size[0] * (right - left) / (self.size[1] * (high - low))
        for number, direction in enumerate(self.towards, start=1):
            plotter.subplot(0, number)
            yield
            look(plotter, camera_around(self.points, direction, self.up, aspect))


def two_views(points: FloatArray, size: Size, *, back: bool = True) -> TwoViews:
    """Return the views of a mesh from the front and, if it is not flat, from the back.

    Args:
        points: points of the mesh [cm], with y upwards, shape (n, 3).
        size: width and height of the picture [pixels].
        back: whether to show the back too.
    """
    towards, up = view_directions(points)
    extent = np.sort(np.ptp(points, axis=0))
    if not back or extent[0] <= FLAT * extent[1]:
        return TwoViews(points, (towards,), up, ((0.0, LOW, PANELS, 1.0),), size)
    return TwoViews(points, (towards, -towards), up, _panels(points, towards, up, size), size)


def _panels(points: FloatArray, towards: FloatArray, up: FloatArray, size: Size) -> tuple[Viewport, ...]:
    """Return the panels of two views: one beside the other, or one above the other if the mesh is larger then."""
    width, height, _ = np.ptp(points @ picture_axes(towards, up), axis=0)
    free = PANELS * size[0] / width, (1 - LOW) * size[1] / height  # Pixels per cm of one view in the whole free part.
    if min(free[0] / 2, free[1]) > min(free[0], free[1] / 2):
        return (0.0, LOW, PANELS / 2, 1.0), (PANELS / 2, LOW, PANELS, 1.0)
    middle = (LOW + 1.0) / 2
    return (0.0, middle, PANELS, 1.0), (0.0, LOW, PANELS, middle)
