# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns under dead loads as rods and chains: Euler's elastica, the buckling of a column, the catenary, and tension.

A yarn bends as a rod of flexural rigidity EI = 2 k_bend. The values of the elastica were found to six digits by
shooting. Each half of a yarn of length 2 L that is pinned in its middle is a cantilever of length L: by symmetry the
yarn stays horizontal at the pin, and the pin carries no moment.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from stitchmesh.quality import Quality
from stitchmesh.simulation.dead_load import EARTH, Gravity
from stitchmesh.yarn import YarnSet, basis, segment_lengths
from stitchmesh.yarnrelax import Relaxation, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.constraints.pins import Pins
from stitchmesh.yarnrelax.energies.point_load import PointLoad
from stitchmesh.yarnrelax.energies.term import YarnChoice
from tests.yarnrelax.hessian.scenes import assembled_hessian, started

FALL = -EARTH[1]
HALF = 16
"""Segments of a cantilever. The spline spreads the force of a pin over two segments: relative error 1.5 / HALF^2."""
EXACT = Quality("float64", 3, 4, 12, 0.2, 1e-4, 20_000)
"""Five Gauss points integrate the energies of these curves to 1e-6. The residual changes the drop by at most 1e-3."""


def material(*, k_bend: float, k_len: float, weight: float) -> YarnMaterial:
    """A yarn with a given weight [dyn/cm], without contact energy, for segments of length 1."""
    return YarnMaterial(k_len, 0.0, k_bend, 0.0, 0.0, 0.0, 0.0, weight / FALL, segment_length=1.0)


def straight_yarn(segments: int, spacing: float = 1.0) -> YarnSet:
    points = np.zeros((segments + 3, 3))
    points[:, 0] = (np.arange(segments + 3) - (segments + 2) / 2) * spacing
    return YarnSet.from_curves([points], closed=[False], radius=0.3, rest_lengths=[np.ones(segments)])


def at_rest(yarns: YarnSet, matter: YarnMaterial, terms: list[YarnChoice]) -> Relaxation:
    result = relax_yarns(yarns, material=matter, quality=EXACT, device="cpu", terms=terms)
    assert result.report["converged"]
    return result


@pytest.mark.parametrize(("load", "expected"), [("at the ends", 0.713792), ("uniform", 0.640631)])
def test_cantilever(load: str, expected: float) -> None:
    """The drop over L of the elastica for P L^2 / EI = 5, and of the heavy elastica for w L^3 / EI = 8."""
    yarns = straight_yarn(2 * HALF)
    count = len(yarns.points)
    if load == "uniform":
        term, weight = Gravity(), 8.0 * 2.0 / HALF**3
    else:
        # at both ends, on the three control points of each that have their middle there; an end is not curved
        ends = [0, 1, 2, count - 3, count - 2, count - 1]
        term, weight = PointLoad((0.0, -2 * 5.0 * 2.0 / HALF**2, 0.0), ends), 0.0
    # the strains w L / (2 k_len) and P / (2 k_len) are below 2e-3
    found = at_rest(yarns, material(k_bend=1.0, k_len=25.0, weight=weight), [term, Pins([count // 2])])
    curve = found.yarns.sampled(2)[0]
    drop = curve[2 * HALF, 1] - (curve[0, 1] + curve[-1, 1]) / 2
    assert drop / HALF == pytest.approx(expected, rel=0.01)


def test_euler_load_of_a_free_column() -> None:
    """A column compressed between two hinged ends becomes unstable at P = pi^2 EI / L^2 and not at smaller loads.

    The compressive force is a dead load along the column; the second derivatives of its potential are zero. The test
    compresses the straight rod until it carries P. The rod buckles where the smallest eigenvalue of the Hessian of its
    energy vanishes.
    """
    critical = np.pi**2 * 2.0 / HALF**2
    below, above = (smallest_eigenvalue(share * critical) for share in (0.99, 1.01))
    assert below > 0.0 > above


def smallest_eigenvalue(compression: float) -> float:
    """Smallest eigenvalue of the Hessian for displacements across a compressed column whose ends stay on its axis.

    E_len = k_len (1 - lambda)^2 for a segment of length 1, so a compressive force P shortens each by P / (2 k_len).
    """
    k_len = 1e3
    yarns = straight_yarn(HALF, 1.0 - compression / (2 * k_len))
    across = assembled_hessian(started(yarns, material(k_bend=1.0, k_len=k_len, weight=1.0))).toarray()[1::3, 1::3]
    held = np.zeros((2, len(yarns.points)))
    held[0, :4] = basis(0.0)[0]
    held[1, -4:] = basis(1.0)[0]
    free = np.linalg.svd(held)[2][2:].T
    return float(np.linalg.eigvalsh(free.T @ across @ free)[0])


def sag_of_catenary(slack: float) -> float:
    """Sag / span of a catenary y = a cosh(x / a) whose length is ``slack`` times its span."""
    half = brentq(lambda u: np.sinh(u) / u - slack, 1e-3, 10.0)  # half of the span, divided by a
    return float((np.cosh(half) - 1.0) / (2.0 * half))


def test_catenary() -> None:
    """A yarn with very small bending stiffness hangs as a chain between the ends of its curve.

    The pins hold the ends of the curve only approximately, so length and span are measured at rest. k_bend is so small
    that the boundary layers at the ends, of length sqrt(EI / H), are shorter than a hundredth of the span.
    """
    slack = 1.5
    yarns = straight_yarn(24, 1.0 / slack)
    matter = material(k_bend=1e-3, k_len=3e3, weight=0.1)  # strains w L / (2 k_len) of 4e-4
    found = at_rest(yarns, matter, [Gravity(), Pins([1, len(yarns.points) - 2])]).yarns
    curve = found.sampled(2)[0]
    span = float(np.linalg.norm(curve[-1] - curve[0]))
    length = segment_lengths(found.points, found.segment_points).sum()
    sag = (curve[0, 1] + curve[-1, 1]) / 2 - curve[24, 1]
    assert length / span == pytest.approx(slack, rel=0.02)
    assert sag / span == pytest.approx(sag_of_catenary(length / span), rel=0.01)


def test_the_strain_of_a_yarn_under_tension() -> None:
    """The tension is EA (lambda - 1), with EA = 2 (k_len + k_length) / l0, whatever the length of the segments."""
    yarns, tension = straight_yarn(30), 500.0
    matter = YarnMaterial(1000.0, 500.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, segment_length=0.5)
    pulled = len(yarns.points) - np.arange(1, 5)
    found = at_rest(yarns, matter, [PointLoad((tension, 0.0, 0.0), pulled), Pins(np.arange(4))])
    strain = tension / 6000.0
    assert matter.axial_stiffness == 6000.0
    # Near the held control points, the strain of the spline is not uniform; ten segments away it is.
    np.testing.assert_allclose(found.yarns.strain[10:-10], strain, rtol=1e-3)
