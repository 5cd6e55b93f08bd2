# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The materials of the yarns of a fabric: of wefts or courses, of warps, and of the rods along seams."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.mixed.crossings.materials.crossing_material import CrossingMaterial


@dataclass(frozen=True)
class FabricMaterials:
    """A material for each family of yarns."""

    weft: CrossingMaterial
    """Of wefts, and of all yarns of a knit."""
    warp: CrossingMaterial
    """Of warps."""
    rod: CrossingMaterial
    """Of the rods along seams."""

    @staticmethod
    def of(material: CrossingMaterial) -> FabricMaterials:
        """The same material for all yarns."""
        return FabricMaterials(material, material, material)

    @property
    def by_family(self) -> tuple[CrossingMaterial, CrossingMaterial, CrossingMaterial]:
        """The materials in the order of the numbers of families in ``CrossingYarns.yarn_family``."""
        return self.weft, self.warp, self.rod
