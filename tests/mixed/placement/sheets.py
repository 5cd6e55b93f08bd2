# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Square cloths with yarn nodes, for the tests of placement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.enrichment.region import Region, region_around
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from tests.mixed.patch import Patch, square_patch

WEAVE = ClothMaterial("weave", 2e5, 1e5, 900.0, 0.0, 0.5, 0.4, 0.02, twist=0.1)


@dataclass(frozen=True, eq=False)
class Sheet:
    """A square cloth of one panel, and its nodes."""

    cloth: Cloth
    patch: Patch

    def region(self, chosen: np.ndarray, rings: int = 1) -> Region:
        return region_around(*self.patch.layout, chosen, rings=rings)

    def rolled(self, curvature: float, direction: float = 0.0) -> np.ndarray:
        """Vertices on a cylinder; the ridge is seen from above."""
        x, y = self.cloth.vertices[:, 0], self.cloth.vertices[:, 1]
        c, s = np.cos(direction), np.sin(direction)
        along, across = c * x + s * y, c * y - s * x
        around, down = np.sin(curvature * along) / curvature, (np.cos(curvature * along) - 1.0) / curvature
        return np.column_stack([c * around - s * across, s * around + c * across, down])


def sheet(squares: int, nodes_a_square: int = 2, side: float = 1.0) -> Sheet:
    patch = square_patch(squares, nodes_a_square, side)
    cloth = Cloth(
        vertices=patch.vertices,
        triangles=patch.triangles,
        rest=patch.vertices[patch.triangles][:, :, :2],
        panel=np.zeros(len(patch.triangles), dtype=int),
        panel_names=("sheet",),
    )
    return Sheet(cloth, patch)
