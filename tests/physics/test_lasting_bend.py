# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bends that stay: set by steam, and the plasticity of yarn that was bent sharply.

References: a ring of the radius R that was set by the share s has the moment EI (1 - s) / R; an elastic, perfectly
plastic rod that was bent to kappa above its yield curvature k_y and let go keeps kappa - M / EI = kappa - k_y.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.lasting_bend import bend_at_knots, set_yarns, yielded_yarns
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.evaluate import yarn_energies
from tests.periodic.free_cells import free_swatch

K_BEND = 0.4
MATERIAL = YarnMaterial(2000.0, 1000.0, K_BEND, 0.0, 0.0, 0.0, 0.0, 0.006)
COARSE = {"quadrature_points": 3, "contact_samples": 3}
QUALITY = replace(PRESETS["reference"], **COARSE, tolerance=1e-6)


def ring(radius: float, points: int = 60) -> YarnSet:
    """A ring whose curve has the given radius."""
    angle = np.arange(points) / points * 2 * np.pi
    outside = radius * 3 / (2 + np.cos(2 * np.pi / points))
    circle = outside * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    return YarnSet.from_curves([circle], closed=[True], radius=0.05)


def arc(curvature: float, count: int = 20, spacing: float = 0.25) -> YarnSet:
    """An open yarn whose curve lies on a circle."""
    angle = curvature * spacing * np.arange(count)
    outside = 3 / (2 + np.cos(curvature * spacing)) / curvature
    points = np.stack([np.sin(angle), 1 - np.cos(angle), 0 * angle], axis=1) * outside
    return YarnSet.from_curves([points], closed=[False], radius=0.05)


def wave(count: int = 48, waves: float = 2.25) -> YarnSet:
    """An open yarn in waves in a plane, whose curvature is a sine along its length; it ends at crests."""
    along = np.linspace(0.0, 12.0, 24 * count + 1)
    angle = 1.0 * np.sin(2 * np.pi * waves * along / 12.0)
    path = np.cumsum(np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1) * along[1], axis=0)
    return YarnSet.from_curves([path[::24]], closed=[False], radius=0.05)


def let_go(yarns: YarnSet) -> YarnSet:
    """The yarns at rest, without any load."""
    found = relax_yarns(yarns, material=MATERIAL, quality=QUALITY, device="cpu")
    assert found.report["converged"]
    return found.yarns


def energy(yarns: YarnSet) -> float:
    """Bending energy [erg]."""
    return yarn_energies(yarns, MATERIAL, **COARSE)["bend"]


def inside(yarns: YarnSet) -> np.ndarray:
    """Magnitudes of the curvature at the knots of an open yarn."""
    return np.abs(bend_at_knots(yarns))[1:-1]


def test_curvature_at_the_knots() -> None:
    # the curvature of the spline at a knot differs from the circle's by (2 pi / 60)^2 / 12 = 0.1 %
    assert bend_at_knots(ring(2.0)) == pytest.approx(0.5, rel=2e-3)
    bend = bend_at_knots(wave())
    assert (np.diff(np.sign(bend[1:-1])) != 0).sum() == 4  # inflections between the crests


@pytest.mark.parametrize("share", [0.0, 0.3, 0.8])
def test_a_set_ring_carries_the_rest_of_its_moment(share: float) -> None:
    """E = EI / 2 times the square of (1 - s) / R along the ring: its moment is EI (1 - s) / R."""
    radius = 2.0
    expected = 2 * np.pi * radius * K_BEND * ((1.0 - share) / radius) ** 2
    assert energy(set_yarns(ring(radius), share)) == pytest.approx(expected, rel=0.01)  # spline error 0.1 % of 1 / R


def test_each_wash_sets_a_share_of_what_is_left() -> None:
    twice = set_yarns(set_yarns(ring(2.0), 0.5), 0.5)
    once = set_yarns(ring(2.0), 0.75)
    assert twice.natural_curvature == pytest.approx(once.natural_curvature, rel=1e-12)


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_a_set_arc_that_is_let_go_keeps_that_share_of_its_curvature(share: float) -> None:
    # segments of 0.25 cm differ from the circle's curvature by (0.6 * 0.25)^2 / 12 = 0.2 %
    assert inside(let_go(set_yarns(arc(0.6), share))) == pytest.approx(0.6 * share, rel=0.005)


@pytest.mark.parametrize("bent", [0.3, 0.6, 0.9])
def test_a_yarn_that_was_bent_beyond_yield_keeps_the_curvature_less_the_moment(bent: float) -> None:
    """The moment follows EI kappa up to EI k_y and stays there; unloading is elastic, and leaves kappa - M / EI."""
    limit = 0.4
    loaded = yielded_yarns(arc(bent), limit)
    moment = 2 * K_BEND * (np.abs(bend_at_knots(loaded)) - np.abs(loaded.natural_curvature))[1:-1]
    assert moment == pytest.approx(2 * K_BEND * min(bent, limit), rel=0.005)  # spline error (0.9 * 0.25)^2 / 12
    if bent > limit:  # a straight yarn has no curvature to compare with
        assert inside(let_go(loaded)) == pytest.approx(bent - limit, abs=0.01 * bent)
    else:
        assert not loaded.natural_curvature.any()


def test_yarn_that_is_bent_back_yields_the_other_way() -> None:
    """Kinematics of a cycle: after yield at 0.9 the straight yarn of today is bent by -0.5, beyond the limit of 0.4."""
    bent = yielded_yarns(arc(0.9), 0.4)
    straight = replace(bent, points=np.stack([0.25 * np.arange(20), np.zeros(20), np.zeros(20)], axis=1))
    again = yielded_yarns(straight, 0.4)
    # spline error of the first curvature, 1 %
    assert np.abs(again.natural_curvature[1:-1]) == pytest.approx(0.4, rel=0.02)


@pytest.mark.parametrize(("share", "least", "most"), [(1.0, 0.98, 1.02), (0.5, 0.2, 0.8)])
def test_an_unravelled_yarn_keeps_its_crimp(share: float, least: float, most: float) -> None:
    """A wave that was set keeps its crimp when its yarn is pulled out; half set, it keeps a part."""
    given = wave()
    freed = let_go(set_yarns(given, share))
    assert least * crimp(given) < crimp(freed) < most * crimp(given)


def crimp(yarns: YarnSet) -> float:
    """Length over the distance of the ends, minus one."""
    return float(yarns.lengths.sum() / np.linalg.norm(yarns.points[-2] - yarns.points[1])) - 1.0


def test_a_yarn_of_a_stitch_has_no_bending_left_after_a_whole_set() -> None:
    """In the cell of a knit, whose yarn runs through the lattice."""
    made = free_swatch("stockinette").at_rest
    assert made is not None
    # natural curvature is linear between knots, which leaves 0.3 % with the 16 segments of a stitch at draft
    assert energy(set_yarns(made.yarns, 1.0)) < 0.01 * energy(made.yarns)


@pytest.mark.parametrize("share", [-0.1, 1.1, float("nan")])
def test_other_shares_are_refused(share: float) -> None:
    with pytest.raises(ParameterError, match="set: got a share of"):
        set_yarns(ring(2.0), share)


def test_a_yield_curvature_is_positive() -> None:
    with pytest.raises(ParameterError, match="yield curvature"):
        yielded_yarns(ring(2.0), 0.0)
