# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The displays of a run whose region may change: frames of the same region share one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.enrichment.region import Region
from stitchmesh.mixed.layout.laid_yarns import LaidYarns
from stitchmesh.mixed.output.display import ROUNDS, Display, Shown
from stitchmesh.mixed.output.frames import DrapeFrame


class Displays:
    """Makes the display of each frame, and keeps the one that it has made last."""

    def __init__(self, cloth: Cloth, yarns: LaidYarns, region: Region, rounds: int = ROUNDS) -> None:
        """Begin with the region at the start; arguments are those of ``Display``."""
        self.cloth, self.yarns, self.rounds = cloth, yarns, rounds
        self._region = region
        self._made: Display | None = None  # Runs that nobody looks at need none, and large ones take seconds.

    def of(self, frame: DrapeFrame) -> Display:
        """Return the display of a frame."""
        made = self._made  # Another thread may ask for another frame meanwhile.
        region = self._region if made is None else made.region
        same = np.array_equal(region.triangle_kind, frame.triangle_kind)
        if not (same and np.array_equal(region.vertex_alpha, frame.vertex_alpha)):
            region = replace(region, triangle_kind=frame.triangle_kind, vertex_alpha=frame.vertex_alpha)
        if made is None or region is not made.region:
            self._made = made = Display(self.cloth, self.yarns, region, self.rounds)
        return made

    def show(self, frame: DrapeFrame) -> Shown:
        """Return vertices, yarn nodes and smooth surface of a frame [cm]."""
        return self.of(frame).show(frame.vertices, frame.nodes)
