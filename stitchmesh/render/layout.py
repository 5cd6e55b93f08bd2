# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How a picture of yarns is divided between the whole and the close-up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.render.camera import picture_axes
from stitchmesh.render.stage import WHOLE, Viewport

CLOSE_UP_AREA = 7600.0
"""Area of the close-up in squared yarn radii: some 150 stitches of plain knitting, which take about 8 by 6 each."""
WIDE = 2.0
"""Width over height from which a thing has its close-up below it instead of beside it."""


@dataclass(frozen=True)
class Layout:
    """The parts of a picture."""

    panels: tuple[Viewport, ...]
    """The panel with everything and, if there is one, the close-up that covers part of it."""
    part: tuple[float, float]
    """Part of the width and of the height that is left for everything."""
    centre: tuple[float, float]
    """Where the middle of the window lies, seen from the middle of that part; half a window is 1."""

    def close_up_aspect(self, size: tuple[int, int]) -> float:
        """Width of the close-up over its height."""
        left, low, right, high = self.panels[1]
        return (right - left) * size[0] / ((high - low) * size[1])

    def close_up_height(self, size: tuple[int, int], radius: float) -> float:
        """Height of what the close-up shows [cm]."""
        return radius * float(np.sqrt(CLOSE_UP_AREA / self.close_up_aspect(size)))


BESIDE = Layout((WHOLE, (0.61, 0.03, 0.98, 0.97)), (0.61, 1.0), (0.39, 0.0))
BELOW = Layout((WHOLE, (0.02, 0.03, 0.98, 0.6)), (1.0, 0.4), (0.0, -0.6))
ALONE = Layout((WHOLE,), (1.0, 1.0), (0.0, 0.0))


def layout_for(points: FloatArray, towards: FloatArray, up: FloatArray, radius: float) -> Layout:
    """The layout for yarns of these control points; a thing as small as a close-up needs none."""
    width, height, _ = np.ptp(points @ picture_axes(towards, up), axis=0)
    if width * height < CLOSE_UP_AREA * radius**2:
        return ALONE
    return BELOW if width > WIDE * height else BESIDE
