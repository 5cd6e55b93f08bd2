# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The material of triangles that is nearest to the tests of a fabric of yarns.

The tensions of the linear law are linear in its moduli C_11, C_22, C_12 and C_33. The fitted moduli have the least sum
of squares of

    (tension of triangles - tension of yarns) / strain,

the differences of secant stiffness, over all strains of all stretch and shear tests, with the side tensions. Tension
that the fabric has at strain 0 is left out, because triangles have none. The rigidities are fitted to the moments by
least squares in the same manner. At 45 degrees a cylinder costs B = (B_1 + B_2) / 4 + twist. The Poisson ratio of
bending is zero here, because a cylinder does not show it.

The law with tables takes the tensions of the yarns along both axes, and the stress of shear, as they are, and fits only
C_12.

``respond`` returns in closed form the resistance of a material of triangles in the tests of ``cell_tests``.

With the stresses S_1(E_11), S_2(E_22), S_3(2 E_12) and S_4(E_11 + E_22) of a material, its coupling C_12 and its
rigidities B (``cloth_material``), with l = 1 + strain and E = (l^2 - 1) / 2,

    course     tension l (S_1(E) + S_4(E)),               side S_4(E) + C_12 E
    wale       tension l (S_2(E) + S_4(E)),               side S_4(E) + C_12 E
    both       tension l (S_1(E) + S_4(2 E) + C_12 E),    side l (S_2(E) + S_4(2 E) + C_12 E)
    shear      S_3(sin(strain)) cos(strain), because 2 E_12 = sin(strain)
    bend       the rigidity along the direction of curvature, times the strain
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.matching.cell_tests import BENDS, STRETCHES, LoadingCurve
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial, Table

Numbers = NDArray[np.float64]
SMALLEST_MODULUS = 1e-6
"""Smallest modulus or rigidity over the largest one of its kind."""
LARGEST_POISSON = 0.9
"""Largest Poisson ratio of a fitted material, a bound that keeps the material stable."""


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
        return shear.at(np.sin(strain)) * np.cos(strain), none
    stretch = 1.0 + strain
    green = (stretch**2 - 1.0) / 2.0
    if curve.test == "both":
        side = sum_of_both.at(2.0 * green) + material.coupling * green
        return stretch * (course.at(green) + side), stretch * (wale.at(green) + side)
    across = sum_of_both.at(green)
    own = (course if curve.test == "course" else wale).at(green)
    return stretch * (own + across), across + material.coupling * green


def rigidity(material: ClothMaterial, test: str) -> float:
    """Bending rigidity of a material in a bending test [dyn cm]."""
    rigidities = material.rigidities()
    c, s = {"bend course": (1.0, 0.0), "bend wale": (0.0, 1.0), "bend across": (0.5**0.5, 0.5**0.5)}[test]
    curvature = np.array([c * c, s * s, 2.0 * c * s])
    return float(curvature @ rigidities @ curvature)


def fit_linear(curves: Mapping[str, LoadingCurve], name: str, density: float, source: str = "") -> ClothMaterial:
    """The material of constant moduli that is nearest to tests.

    Args:
        curves: tests by name; all bending tests, ``shear``, ``course`` and ``wale`` are needed.
        name: name of the material.
        density: mass per area [g/cm^2].
        source: where the tests come from.

    Raises:
        ParameterError: a test is missing, or the fabric does not resist stretch.
    """
    missing = [test for test in ("course", "wale", "shear", *BENDS) if test not in curves]
    if missing:
        raise ParameterError(f"match: got no test {missing[0]!r}; expected course, wale, shear and three of bending")
    first, second, coupling, shear = _moduli(curves)
    least = SMALLEST_MODULUS * max(first, second)
    if not least > 0.0:
        raise ParameterError(
            f"match: got moduli {first:g} and {second:g} dyn/cm; expected a fabric that resists stretch"
        )
    first, second, shear = (max(value, least) for value in (first, second, shear))
    poisson = float(np.clip(coupling / np.sqrt(first * second), -LARGEST_POISSON, LARGEST_POISSON))
    course, wale, twist = _rigidities(curves)
    return ClothMaterial(
        name=name,
        stretch_course=first * (1.0 - poisson**2),
        stretch_wale=second * (1.0 - poisson**2),
        shear=shear,
        poisson=poisson,
        bending_course=course,
        bending_wale=wale,
        twist=twist,
        density=density,
        source=source,
    )


def fit_tables(curves: Mapping[str, LoadingCurve], linear: ClothMaterial) -> ClothMaterial:
    """The linear material with tensions and stresses of the yarns as tables, and with a coupling fitted to them.

    Args:
        curves: the tests to which ``linear`` is fitted.
        linear: the linear material.
    """
    along, beside = _table(curves["course"]), _table(curves["wale"])
    shear = _shear_table(curves["shear"])
    alone = replace(linear, poisson=0.0, tension_course=along, tension_wale=beside, shear_table=shear)
    coupling = _coupling(curves, alone)
    course, wale, _shear, _both = alone.energies()
    bound = 0.9 * np.sqrt(course.least_slope * wale.least_slope)  # the smallest stiffness of both axes stays positive
    coupling = float(np.clip(coupling, -bound, bound))
    first, second = float(linear.moduli()[0, 0]), float(linear.moduli()[1, 1])
    poisson = float(np.clip(coupling / np.sqrt(first * second), -LARGEST_POISSON, LARGEST_POISSON))
    rest = 1.0 - poisson**2
    return replace(alone, poisson=poisson, stretch_course=first * rest, stretch_wale=second * rest)


def _moduli(curves: Mapping[str, LoadingCurve]) -> tuple[float, float, float, float]:
    """C_11, C_22, C_12 and C_33 by least squares."""
    rows, values = [], []
    for test in (*STRETCHES, "shear"):
        if test in curves:
            strain, columns, sides = _columns(curves[test])
            for tension, part in zip(curves[test].rise, (columns, sides), strict=True):
                rows.append(part / strain[:, None])
                values.append(tension[curves[test].loaded] / strain)
    found = np.linalg.lstsq(np.concatenate(rows), np.concatenate(values), rcond=None)[0]
    first, second, coupling, shear = (float(value) for value in found)
    return first, second, coupling, shear


def _columns(curve: LoadingCurve) -> tuple[Numbers, Numbers, Numbers]:
    """Strains, and the tension and the side tension of each modulus C_11, C_22, C_12 and C_33 alone, shapes (K, 4)."""
    strain = curve.strain[curve.loaded]
    stretch = 1.0 + strain
    green, zero = (stretch**2 - 1.0) / 2.0, np.zeros(len(strain))
    if curve.test == "shear":
        along, beside = [zero, zero, zero, np.sin(strain) * np.cos(strain)], [zero] * 4
    elif curve.test == "both":
        own = stretch * green
        along, beside = [own, zero, own, zero], [zero, own, own, zero]
    else:
        own = stretch * green
        along = [own, zero, zero, zero] if curve.test == "course" else [zero, own, zero, zero]
        beside = [zero, zero, green, zero]
    return strain, np.stack(along, axis=1), np.stack(beside, axis=1)


def _rigidities(curves: Mapping[str, LoadingCurve]) -> tuple[float, float, float]:
    """Rigidities along both axes, and against twist [dyn cm]."""
    course, wale, across = (_slope(curves[test]) for test in BENDS)
    least = SMALLEST_MODULUS * max(course, wale)
    if not least > 0.0:
        raise ParameterError(
            f"match: got rigidities {course:g} and {wale:g} dyn cm; expected a fabric that resists bending"
        )
    course, wale = max(course, least), max(wale, least)
    twist = across - (course + wale) / 4.0
    # Straight yarns that cross do not resist twist, and triangles without resistance would have no definite shape.
    return course, wale, float(max(twist, 1e-2 * np.sqrt(course * wale)))


def _slope(curve: LoadingCurve) -> float:
    """Mean secant slope of a curve."""
    return float((curve.rise[0][curve.loaded] / curve.strain[curve.loaded]).mean())


def _table(curve: LoadingCurve) -> Table:
    """Strain and tension beyond its value at rest, with tensions that rise; empty where they do not rise at all."""
    stretch, tension = 1.0 + curve.strain, curve.rise[0]
    stress = _risen((stretch**2 - 1.0) / 2.0, tension / stretch, int(np.flatnonzero(curve.strain == 0.0)[0]))
    if stress is None:
        return ()
    return tuple((float(e), float(t)) for e, t in zip(curve.strain, stress * stretch, strict=True))


def _shear_table(curve: LoadingCurve) -> Table:
    """Strain 2 E_12 and stress, the mean of both signs where both are tested; empty for angles of a quarter turn."""
    angle = np.unique(np.abs(curve.strain))
    if angle[-1] >= 1.5:  # nearly a quarter turn
        return ()
    tension = np.sign(curve.strain) * curve.rise[0]
    mean = np.array([tension[np.abs(curve.strain) == size].mean() for size in angle])
    stress = _risen(np.sin(angle), mean / np.cos(angle), 0)
    if stress is None:
        return ()
    return tuple((float(e), float(s)) for e, s in zip(np.sin(angle), stress, strict=True))


def _risen(strain: Numbers, stress: Numbers, zero: int) -> Numbers | None:
    """Stresses that rise with the strain, with zero at the place ``zero``; None where the fabric only gives way."""
    risen = np.array(stress)
    least = 1e-2 * float((np.diff(stress) / np.diff(strain)).max())  # the stress of triangles must rise
    if not least > 0.0:
        return None
    for k in range(zero + 1, len(risen)):
        risen[k] = max(risen[k], risen[k - 1] + least * (strain[k] - strain[k - 1]))
    for k in range(zero - 1, -1, -1):
        risen[k] = min(risen[k], risen[k + 1] - least * (strain[k + 1] - strain[k]))
    return risen


def _coupling(curves: Mapping[str, LoadingCurve], material: ClothMaterial) -> float:
    """C_12 by least squares, with the tensions along both axes of a material without coupling."""
    rows, values = [], []
    for test in STRETCHES:
        if test in curves:
            curve = curves[test]
            strain, columns, sides = _columns(curve)
            for tension, of_material, part in zip(curve.rise, respond(material, curve), (columns, sides), strict=True):
                rows.append(part[:, 2] / strain)
                values.append((tension - of_material)[curve.loaded] / strain)
    row, value = np.concatenate(rows), np.concatenate(values)
    return float(row @ value / (row @ row))
