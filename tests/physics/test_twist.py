# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Twist of yarns: its energy, its force, writhe, and Michell's instability of a ring.

References: the energy GJ theta^2 / (2 L) of a straight rod; the theorem of Calugareanu and Fuller, twist + writhe =
link, with the writhe of a polygon by the double sum of Klenin and Langowski 2000; a helix, whose tangent runs around a
circle of latitude of the unit sphere; Michell 1889 and Zajac 1962: a ring that is bent from a straight rod leaves its
plane at a twist of 2 pi sqrt(3) EI / GJ; Greenhill 1883: a straight rod under a torque M and a tension T leaves its
line in a helix of the wave number q where M = EI q + T / q.
"""

from __future__ import annotations

from dataclasses import astuple, replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from stitchmesh.errors import ParameterError
from stitchmesh.lattice import Lattice, lattice_frame
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.cell_stress import cell_stress
from stitchmesh.yarnrelax.energies.twist import Twist
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.yarnrelax.hessian.scenes import forces_at, points_of, started
from tests.yarnrelax.one_term import OneTerm, on_device
from tests.yarnrelax.solvers.test_cell_strain import sheared
from tests.yarnrelax.stockinette import periodic_patch
from tests.yarnrelax.stockinette import shaken as shaken_yarns

RADIUS = 0.05
MATERIAL = YarnMaterial(2000.0, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.006)


def twisted(yarns: YarnSet, twist: Twist) -> OneTerm:
    return OneTerm.of(on_device(yarns, MATERIAL), twist)


def ring(count: int, radius: float = 1.0) -> np.ndarray:
    angle = np.arange(count) / count * 2 * np.pi
    return radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)


def helix(turns: float, rise: float, count: int) -> np.ndarray:
    """Points of a right-handed helix of radius 1 that rises by ``rise`` per radian."""
    angle = np.linspace(0.0, 2 * np.pi * turns, count)
    return np.stack([np.cos(angle), np.sin(angle), rise * angle], axis=1)


def shaken(points: np.ndarray, size: float = 0.05) -> np.ndarray:
    return points + size * np.random.default_rng(2).normal(size=points.shape)


def tangle() -> YarnSet:
    """A closed and an open yarn; the closed yarn is long enough to be processed in two strands."""
    curves = [shaken(ring(40)), shaken(helix(1.5, 0.3, 12))]
    return YarnSet.from_curves(curves, closed=[True, False], radius=RADIUS)


def yarn_through_lattice() -> YarnSet:
    """A wavy yarn that runs through a lattice; it closes after two periods along z."""
    place = np.arange(24) / 24
    curve = np.stack([np.cos(4 * np.pi * place), np.sin(4 * np.pi * place), 3.0 * place], axis=1)
    yarns = YarnSet.from_curves([shaken(curve)], closed=[True], radius=RADIUS)
    lattice = Lattice([[4.0, 0.0, 0.0], [0.0, 0.0, 1.5]])
    yarns = replace(yarns, lattice=lattice, lattice_step=[[0, 2]])
    return replace(yarns, rest_length=yarns.lengths)


@pytest.mark.parametrize("yarns", [tangle(), yarn_through_lattice()], ids=["garment", "lattice"])
def test_force_is_minus_the_gradient(yarns: YarnSet) -> None:
    scene = twisted(yarns, Twist(0.2, 5.0))
    points = yarns.points + 0.01 * np.random.default_rng(4).normal(size=yarns.points.shape)
    direction = np.random.default_rng(3).normal(size=points.shape)
    expected = -(scene.forces(points) * direction).sum()
    # truncation error 1e-10; rounding error 1e-9 for an energy of order one
    assert scene.slope(points, direction, 1e-7) == pytest.approx(expected, rel=1e-6)


def test_a_straight_yarn_has_the_energy_of_a_rod_and_no_force() -> None:
    """The energy is GJ theta^2 / (2 L) with GJ = 2 k_twist. One of the three yarns is not twisted."""
    lines = [np.stack([0.2 * np.arange(n), np.full(n, 1.0 * n), np.zeros(n)], axis=1) for n in (11, 40, 200)]
    yarns = YarnSet.from_curves(lines, closed=[False] * 3, radius=RADIUS)
    angles = [3.0, 0.0, -40.0]
    scene = twisted(yarns, Twist(0.2, angles))
    expected = sum(0.2 * angle**2 / (0.2 * (n - 3)) for angle, n in zip(angles, (11, 40, 200), strict=True))
    assert scene.energy() == pytest.approx(expected, rel=1e-12)  # rounding
    assert np.abs(scene.forces()).max() < 1e-10  # rounding of 40 rad times 0.2 erg cm over a radius of 0.05 cm


def knots(points: np.ndarray) -> np.ndarray:
    """Points of the curve of a closed yarn at its spline knots."""
    return (points + 4 * np.roll(points, -1, axis=0) + np.roll(points, -2, axis=0)) / 6


def writhe(corners: np.ndarray) -> float:
    """Writhe of a closed polygon: sum over pairs of edges of signed solid angles / 2 pi (Klenin and Langowski, 1a)."""
    ends = np.roll(corners, -1, axis=0)
    i, j = np.triu_indices(len(corners), 2)
    i, j = (k[(i > 0) | (j < len(corners) - 1)] for k in (i, j))
    r13, r14 = corners[j] - corners[i], ends[j] - corners[i]
    r23, r24 = corners[j] - ends[i], ends[j] - ends[i]
    normals = np.stack([np.cross(*pair) for pair in ((r13, r14), (r14, r24), (r24, r23), (r23, r13))])
    size = np.linalg.norm(normals, axis=2, keepdims=True)
    normals = normals / np.where(size > 0.0, size, 1.0)
    angles = np.arcsin(np.clip((normals * np.roll(normals, -1, axis=0)).sum(axis=2), -1.0, 1.0)).sum(axis=0)
    sign = np.sign((np.cross(ends[j] - corners[j], ends[i] - corners[i]) * r13).sum(axis=1))
    return float(angles @ sign / (2 * np.pi))


def test_twist_changes_by_minus_the_writhe() -> None:
    """A ring deforms into a curve that winds three times around a torus: theta = imposed angle - 2 pi writhe.

    The relation is exact for the polygon of knots. The curve stays on a torus, so that it never crosses itself and the
    writhe does not jump.
    """
    around = np.arange(70) / 70 * 2 * np.pi
    yarns = YarnSet.from_curves([ring(70)], closed=[True], radius=RADIUS)
    scene = twisted(yarns, Twist(0.2, 1.0))
    for width in np.linspace(0.0, 0.6, 7):
        curve = ring(70) * (1 + width * np.cos(3 * around))[:, None]
        curve[:, 2] = width * np.sin(3 * around)
        angle = np.sqrt(scene.energy(curve) * yarns.rest_length.sum() / 0.2)
        expected = abs(1.0 - 2 * np.pi * writhe(knots(curve)))
        assert angle == pytest.approx(expected, abs=1e-9)  # rounding
    assert abs(writhe(knots(curve))) > 1.0


def test_twist_is_tracked_over_many_turns() -> None:
    """A helix is pulled out: theta is the change of psi = 2 pi n cos(alpha).

    n is the number of turns and alpha the angle between the tangent and the axis of the helix: the tangent runs n times
    around a circle of latitude of the unit sphere. The clamps keep the orientations that the ends had in the initial
    helix; as the end tangents rise, the clamps add less than one turn to psi in total.
    """
    turns, rises = 8.0, np.linspace(0.05, 6.0, 200)
    yarns = YarnSet.from_curves([helix(turns, rises[0], 400)], closed=[False], radius=RADIUS)
    scene = twisted(yarns, Twist(0.2))
    energies = [scene.energy(helix(turns, rise, 400)) for rise in rises]
    angle = np.sqrt(energies[-1] * yarns.rest_length.sum() / 0.2)
    sines = [rise / np.hypot(1.0, rise) for rise in (rises[0], rises[-1])]
    assert angle == pytest.approx(2 * np.pi * turns * (sines[1] - sines[0]), abs=2 * np.pi)


def second_variation(twist: Twist, count: int = 60) -> np.ndarray:
    """Eigenvalues of the Hessian of the total energy of a ring in equilibrium, ascending [erg / unit^2].

    The radius of the ring is such that its tension balances the outward force of bending.
    """
    yarns = YarnSet.from_curves([ring(count)], closed=[True], radius=1e-3)
    simulation = started(yarns, MATERIAL, [twist])
    start = points_of(simulation)
    scale = brentq(lambda scale: (forces_at(simulation, scale * start) * start).sum(), 0.99, 1.05, xtol=1e-14)
    return stiffnesses(simulation, scale * start)


def stiffnesses(simulation: YarnSimulation, points: np.ndarray) -> np.ndarray:
    """Eigenvalues of the Hessian of the total energy in equilibrium, ascending [erg / unit^2]."""
    step, columns = 1e-4, []  # in units, the radius of the yarn
    for moved in step * np.eye(points.size):
        offset = moved.reshape(points.shape)
        change = forces_at(simulation, points - offset) - forces_at(simulation, points + offset)
        columns.append(change.ravel() / (2 * step))
    matrix = np.array(columns)
    return np.linalg.eigvalsh((matrix + matrix.T) / 2)


@pytest.mark.parametrize(("share", "unstable"), [(0.97, 0), (1.03, 2)])
def test_michells_instability_of_a_twisted_ring(share: float, unstable: int) -> None:
    """A ring becomes unstable at a twist of 2 pi sqrt(3) EI / GJ.

    Two modes become unstable together, because the buckled shape can be rotated about the axis of the ring.
    """
    k_twist = 0.2
    critical = 2 * np.pi * np.sqrt(3.0) * MATERIAL.k_bend / k_twist
    values = second_variation(Twist(k_twist, share * critical))
    # The eigenvalues of the six rigid motions are zero except for the rounding of differences, 1e-9 of the next
    # bending modes. With 60 points the critical twist has an error of one per cent.
    assert (values < -1e-6 * values[12]).sum() == unstable


PERIOD = 3.0
"""Width of the cell of ``line`` [cm]."""


def line(strain: float = 0.0, helix_radius: float = 0.0, turns: int = 0, count: int = 48) -> YarnSet:
    """A yarn that runs straight through a cell along x, or in a right-handed helix."""
    along = np.arange(count) / count
    angle = 2 * np.pi * turns * along
    curve = [PERIOD * along, helix_radius * np.cos(angle), helix_radius * np.sin(angle)]
    yarns = YarnSet.from_curves([np.stack(curve, axis=1)], closed=[True], radius=0.01)
    yarns = replace(yarns, lattice=Lattice([[PERIOD, 0.0, 0.0], [0.0, 2.0, 0.0]]), lattice_step=[[1, 0]])
    return replace(yarns, rest_length=yarns.lengths / (1.0 + strain))


def test_residual_twist_of_a_straight_yarn_in_a_cell() -> None:
    """Yarn that would lose the twist tau in a length has the energy GJ tau^2 L / 2 in a cell of length L; no force."""
    scene = twisted(line(), Twist(0.2, residual=3.0, laid=True))
    assert scene.energy() == pytest.approx(0.2 * 3.0**2 * PERIOD, rel=1e-12)  # rounding
    assert np.abs(scene.forces()).max() < 1e-9  # rounding of 9 rad times 0.2 erg cm over chords of 0.06 cm


def test_a_helix_that_was_laid_straight_has_lost_the_area_of_its_tangents() -> None:
    """A right-handed helix of n turns with the angle alpha to its axis has psi = 2 pi n (1 - cos alpha)."""
    yarns = line(helix_radius=0.4, turns=3, count=480)
    inside = (2 + np.cos(2 * np.pi * 3 / 480)) / 3  # the spline runs inside its control points
    speed = 2 * np.pi * 3 * 0.4 * inside / PERIOD
    psi = 2 * np.pi * 3 * (1.0 - 1.0 / np.hypot(1.0, speed))
    length = yarns.rest_length.sum()
    for residual in (2.0, -2.0):
        scene = twisted(yarns, Twist(0.2, residual=residual, laid=True))
        expected = 0.2 * (residual * length - psi) ** 2 / length
        assert scene.energy() == pytest.approx(expected, rel=1e-3)  # chords of 0.04 rad, squared


@pytest.mark.parametrize("strain", [0.0, 1e-4])
@pytest.mark.parametrize(("share", "unstable"), [(0.97, 0), (1.03, 2)])
def test_greenhills_instability_of_a_yarn_through_a_cell(strain: float, share: float, unstable: int) -> None:
    """A straight yarn buckles into a helix, whose turns are whole in a period; two modes are its two phases."""
    material, k_twist = MATERIAL, 0.2
    tension = material.axial_stiffness * strain
    waves = 2 * np.pi / PERIOD * np.arange(1, 9)
    torque = (material.flexural_rigidity * waves + tension / waves).min()
    twist = Twist(k_twist, residual=share * torque / (2 * k_twist), laid=True)
    simulation = started(line(strain), MATERIAL, [twist])
    values = stiffnesses(simulation, points_of(simulation))
    # Three translations are zero except for the rounding of differences, 1e-15. With 48 points the error is 0.3 %.
    assert (values < -1e-9 * values[-1]).sum() == unstable


def chiral_cell() -> YarnSet:
    """A stitch that leans, with noise."""
    return shaken_yarns(sheared(periodic_patch(1, 1), 0.1))


def strained(yarns: YarnSet, strain: np.ndarray) -> YarnSet:
    """Yarns and their lattice after a strain (a, b, c) of the cell (``cell_strain``)."""
    assert yarns.lattice is not None
    e1, e2, _normal = lattice_frame(yarns.lattice.periods)
    a, b, c = strain
    change = np.eye(3) + a * np.outer(e1, e1) + b * np.outer(e2, e2) + c * np.outer(e1, e2)
    return replace(yarns, points=yarns.points @ change.T, lattice=Lattice(yarns.lattice.periods @ change.T))


def test_forces_on_the_strains_are_minus_the_gradient() -> None:
    yarns, twist = chiral_cell(), Twist(0.2, residual=8.0, laid=True)
    found = cell_stress(yarns, MATERIAL, device="cpu", twist=twist)
    plain = cell_stress(yarns, MATERIAL, device="cpu")
    assert yarns.lattice is not None
    own = yarns.lattice.area * (np.array(astuple(found)) - np.array(astuple(plain)))[:3]
    step = 1e-5
    ends = [[twisted(strained(yarns, side * step * along), twist).energy() for side in (1.0, -1.0)]
            for along in np.eye(3)]  # fmt: skip
    # truncation 1e-9, rounding 1e-9 of energies of order 100
    assert own == pytest.approx(np.diff(np.flip(ends, axis=1), axis=1)[:, 0] / (2 * step), rel=1e-5, abs=1e-5)


def test_a_mirror_image_with_the_other_twist_has_the_mirrored_forces() -> None:
    """Z twist in a stitch acts as S twist does in its mirror image."""
    yarns, mirror = chiral_cell(), np.array([-1.0, 1.0, 1.0])
    assert yarns.lattice is not None and yarns.lattice_step is not None
    periods = yarns.lattice.periods * mirror * np.array([[-1.0], [1.0]])  # the first period points along x again
    other = replace(yarns, points=yarns.points * mirror, lattice=Lattice(periods), lattice_step=-yarns.lattice_step)
    z_twist, s_twist = Twist(0.2, residual=8.0, laid=True), Twist(0.2, residual=-8.0, laid=True)
    here, there = twisted(yarns, z_twist), twisted(other, s_twist)
    assert there.energy() == pytest.approx(here.energy(), rel=1e-12)  # rounding
    assert there.forces() == pytest.approx(here.forces() * mirror, abs=1e-10)  # rounding of forces of order 10
    pairs = ((yarns, z_twist), (other, s_twist))
    stresses = [cell_stress(each, MATERIAL, device="cpu", twist=twist) for each, twist in pairs]
    assert stresses[1].shear == pytest.approx(-stresses[0].shear, rel=1e-9)
    assert stresses[1].course == pytest.approx(stresses[0].course, rel=1e-9)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"k_twist": 0.0}, "twist: got k_twist"),
        ({"k_twist": float("inf")}, "twist: got k_twist"),
        ({"imposed": float("nan")}, "an imposed angle is not finite"),
        ({"imposed": [1.0, 2.0, 3.0]}, "one, or 2"),
        ({"residual": float("nan")}, "residual twist of nan"),
    ],
)
def test_invalid_values_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        twisted(tangle(), Twist(**{"k_twist": 0.2} | options))
