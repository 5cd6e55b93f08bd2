# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Layout of a picture of yarns: the panels for the whole object and for the close-up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.render.camera import picture_axes
from stitchmesh.render.stage import WHOLE, Viewport

CLOSE_UP_AREA = 7600.0
"""Area of the close-up in squared yarn radii: about 150 plain stitches of about 8 by 6 yarn radii each."""
WIDE = 2.0
"""Ratio of width to height from which the close-up is placed below the object instead of beside it."""


@dataclass(frozen=True)
class Layout:
    """The panels of a picture."""

    panels: tuple[Viewport, ...]
    """The panel of the whole object and, if there is one, the panel of the close-up, which covers a part of it."""
    part: tuple[float, float]
    """Part of the width and of the height that remains for the whole object."""
    centre: tuple[float, float]
    """Centre of the window relative to the centre of that part, in units of half a window."""

    def close_up_aspect(self, size: tuple[int, int]) -> float:
        """Return the width of the close-up divided by its height, for a picture of ``size`` [pixels]."""
        left, low, right, high = self.panels[1]
        return (right - left) * size[0] / ((high - low) * size[1])

    def close_up_height(self, size: tuple[int, int], radius: float) -> float:
        """Return the height of the region that the close-up shows [cm].

        Args:
            size: width and height of the picture [pixels].
            radius: yarn radius [cm].
        """
        return radius * float(np.sqrt(CLOSE_UP_AREA / self.close_up_aspect(size)))


BESIDE = Layout((WHOLE, (0.61, 0.03, 0.98, 0.97)), (0.61, 1.0), (0.39, 0.0))
BELOW = Layout((WHOLE, (0.02, 0.03, 0.98, 0.6)), (1.0, 0.4), (0.0, -0.6))
ALONE = Layout((WHOLE,), (1.0, 1.0), (0.0, 0.0))


def layout_for(points: FloatArray, towards: FloatArray, up: FloatArray, radius: float) -> Layout:
    """Choose the layout for yarns; an object that is not larger than a close-up has no close-up.

    Args:
        points: control points of the yarns [cm], shape (n, 3).
        towards: direction from the yarns to the camera, shape (3,).
        up: direction that is vertical in the picture, shape (3,).
        radius: yarn radius [cm].
    """
    width, height, _ = np.ptp(points @ picture_axes(towards, up), axis=0)
    if width * height < CLOSE_UP_AREA * radius**2:
        return ALONE
    return BELOW if width > WIDE * height else BESIDE
