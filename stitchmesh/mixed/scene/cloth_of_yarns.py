# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A material of cloth that follows from a weave of straight yarns, for scenes that name none.

With e warps and p wefts for each cm, and for each family the stiffnesses of stretch k_s and of bending k_b, the shear
stiffness k_x of a quadrant, and the linear density rho of its yarns (Cirio et al. 2014):

    stretch p k_s, e k_s    [dyn/cm],     bending p k_b, e k_b    [dyn cm],     density p rho + e rho    [g/cm^2],
    shear 4 k_x L e p       [dyn/cm],     because each crossing has four quadrants, and L is the mean of their legs.

Crossings turn freely about the normal, so that nothing but shear of quadrants resists twist; a tenth of the geometric
mean of both rigidities is chosen. Sliding, crimp and contact of yarns are left out: a material that is fitted to the
yarns (``matching``) agrees better.
"""

from __future__ import annotations

from dataclasses import replace

from stitchmesh.mixed.crossings.materials.crossing_material import CrossingMaterial
from stitchmesh.mixed.crossings.materials.fabric_materials import FabricMaterials
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.measured_cloths import named_material

TWIST_SHARE = 0.1
"""Rigidity against twist over the geometric mean of the rigidities of bending."""
KNIT = "interlock"
"""Name of the measured cloth whose stiffness stands for knits."""


def cloth_of_weave(materials: FabricMaterials, ends: float, picks: float) -> ClothMaterial:
    """Return the material of a weave.

    Args:
        materials: materials of its yarns.
        ends: warps for each cm.
        picks: wefts for each cm.
    """
    weft, warp = materials.weft, materials.warp
    shear = 0.5 * (weft.shear + warp.shear) * weft.radius * warp.radius
    leg = 0.5 * (1.0 / ends + 1.0 / picks)
    bending = picks * weft.bending_stiffness, ends * warp.bending_stiffness
    return ClothMaterial(
        name="weave of straight yarns",
        stretch_course=picks * weft.stretch_stiffness,
        stretch_wale=ends * warp.stretch_stiffness,
        shear=4.0 * shear * leg * ends * picks,
        poisson=0.0,
        bending_course=bending[0],
        bending_wale=bending[1],
        density=picks * weft.density + ends * warp.density,
        twist=TWIST_SHARE * (bending[0] * bending[1]) ** 0.5,
    )


def cloth_of_knit(material: CrossingMaterial, length: float) -> ClothMaterial:
    """Return a measured knit with the mass of the given yarn.

    Args:
        material: material of the yarn.
        length: length of yarn on each cm^2 of cloth [cm].
    """
    return replace(named_material(KNIT), density=material.density * length)
