# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a material of triangles resists in the tests of ``loading_curve``, in closed form.

With the stresses S_1(E_11), S_2(E_22), S_3(2 E_12) and S_4(E_11 + E_22) of a material, its coupling C_12 and its
rigidities B (``cloth_material``), with l = 1 + strain and E = (l^2 - 1) / 2,

    course     tension l (S_1(E) + S_4(E)),               side S_4(E) + C_12 E
    wale       tension l (S_2(E) + S_4(E)),               side S_4(E) + C_12 E
    both       tension l (S_1(E) + S_4(2 E) + C_12 E),    side l (S_2(E) + S_4(2 E) + C_12 E)
    shear      S_3(sin(strain)) cos(strain), because 2 E_12 = sin(strain)
    bend       the rigidity along the direction of curvature, times the strain
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from stitchmesh.mixed.matching.loading_curve import LoadingCurve
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.tension_curve import TensionCurve

Numbers = NDArray[np.float64]


def respond(material: ClothMaterial, curve: LoadingCurve) -> tuple[Numbers, Numbers]:
    """Tension and side tension of a material at the strains of a curve, shapes (K,).

    Args:
        material: the material of the triangles.
        curve: a test of yarns; only its name and its strains are used.
    """
    strain = curve.strain
    none = np.zeros(len(strain))
    if curve.test.startswith("bend"):
        return rigidity(material, curve.test) * strain, none
    course, wale, shear, sum_of_both = material.energies()
    if curve.test == "shear":
        return stress_at(shear, np.sin(strain)) * np.cos(strain), none
    stretch = 1.0 + strain
    green = (stretch**2 - 1.0) / 2.0
    if curve.test == "both":
        side = stress_at(sum_of_both, 2.0 * green) + material.coupling * green
        return stretch * (stress_at(course, green) + side), stretch * (stress_at(wale, green) + side)
    across = stress_at(sum_of_both, green)
    own = stress_at(course if curve.test == "course" else wale, green)
    return stretch * (own + across), across + material.coupling * green


def rigidity(material: ClothMaterial, test: str) -> float:
    """Bending rigidity of a material in a bending test [dyn cm]."""
    rigidities = material.rigidities()
    c, s = {"bend course": (1.0, 0.0), "bend wale": (0.0, 1.0), "bend across": (0.5**0.5, 0.5**0.5)}[test]
    curvature = np.array([c * c, s * s, 2.0 * c * s])
    return float(curvature @ rigidities @ curvature)


def stress_at(curve: TensionCurve, strain: Numbers) -> Numbers:
    """Stress [dyn/cm] at Green strains."""
    low, high = curve.strain[0], curve.strain[-1]
    inside = np.clip(strain, low, high)
    if len(curve.strain) > 1:
        stress = CubicHermiteSpline(curve.strain, curve.stress, curve.slope)(inside)
    else:
        stress = np.full(strain.shape, curve.stress[0])
    slope = np.where(strain < low, curve.slope[0], curve.slope[-1])
    result: Numbers = stress + slope * (strain - inside)
    return result
