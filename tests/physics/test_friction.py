# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Friction between yarns: its energy between two renewals of the anchors, Coulomb's law in contacts, and the capstan.

References: Coulomb's law F = mu N, where N is the contact force of two crossing yarns integrated from L eq 9; the
capstan equation of Euler and Eytelwein, T1 / T2 = e^(mu phi).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
import warp as wp

from stitchmesh.errors import ParameterError
from stitchmesh.lattice import Lattice
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.collision.captured_search import ContactSearch
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates, make_candidates
from stitchmesh.yarnrelax.energies import evaluation
from stitchmesh.yarnrelax.energies.term import OnYarns
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.spline import place_contact_samples
from stitchmesh.yarnrelax.model.state import State, make_state
from tests.nightly import at_night
from tests.yarnrelax.one_term import on_device

RADIUS = 0.125
MATERIAL = YarnMaterial.named("kaldor-simulation")
BALANCE = 3e-3
"""Largest net force on a control point of the capstan's yarn at equilibrium, divided by the weight that hangs on it."""
ARC_LENGTHS = np.arange(-1.2, 1.25, 0.1)
"""Positions of control points along a line [cm]."""


@dataclass
class FrictionScene:
    """Yarns with friction whose control points are set directly; lengths in units, forces in erg per unit."""

    model: Model
    state: State
    candidates: Candidates
    friction: OnYarns

    @classmethod
    def of(
        cls, yarns: YarnSet, friction: Friction, material: YarnMaterial = MATERIAL, contact_samples: int = 5
    ) -> FrictionScene:
        model = on_device(yarns, material, contact_samples=contact_samples)
        scene = cls(model, make_state(model, external=True), make_candidates(model, 0.5), friction.on(model))
        scene.begin_step(scene.start)
        return scene

    @property
    def start(self) -> np.ndarray:
        return self.model.to_device(self.model.yarns.points)

    def set_points(self, points: np.ndarray) -> None:
        wp.copy(self.state.points, self.model.upload(points, 3))
        place_contact_samples(self.model, self.state, self.model.launch)

    def list_candidates(self) -> None:
        self.candidates.near.invalidate()  # the periods may have been set
        ContactSearch(self.model, self.state, self.candidates).run()

    def begin_step(self, points: np.ndarray) -> None:
        self.set_points(points)
        self.list_candidates()
        self.friction.renew(self.state, self.candidates)

    def energy(self, points: np.ndarray) -> float:
        self.set_points(points)
        return self.friction.energy(self.state)

    def sample_forces(self, points: np.ndarray) -> np.ndarray:
        self.set_points(points)
        self.state.sample_force.zero_()
        self.friction.forces(self.state, self.state.forces, self.model.launch)
        return self.state.sample_force.numpy().astype(np.float64)[:, :3]

    def friction_forces(self, points: np.ndarray) -> np.ndarray:
        self.state.leg_force.zero_()
        self.state.external_force.zero_()
        self.sample_forces(points)
        evaluation.gather_launch(self.model, self.state, self.model.empty(self.model.point_count), self.model.launch)
        return self.state.force.numpy().astype(np.float64)

    def force_launches(self, points: np.ndarray) -> np.ndarray:
        wp.copy(self.state.points, self.model.upload(points, 3))
        point_stiffness = self.model.empty(self.model.point_count)
        terms = [self.friction]
        evaluation.force_launches(self.model, self.state, self.candidates, terms, point_stiffness, self.model.launch)
        return self.state.force.numpy().astype(np.float64)


def line(direction: tuple[float, float, float], through: tuple[float, float, float]) -> np.ndarray:
    return np.asarray(through) + ARC_LENGTHS[:, None] * np.asarray(direction)


def crossing(angle: float, delta: float = 0.9) -> YarnSet:
    """Two straight yarns that cross; their axes are delta diameters apart."""
    turn = np.radians(angle)
    curves = [line((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
              line((np.cos(turn), np.sin(turn), 0.0), (0.03, 0.02, delta * 2 * RADIUS))]  # fmt: skip
    return YarnSet.from_curves(curves, closed=[False, False], radius=RADIUS)


def heap() -> YarnSet:
    """Three yarns with two different radii: two are side by side, and the third crosses both."""
    curves = [line((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)), line((1.0, 0.0, 0.0), (0.02, 0.23, 0.0)),
              line((0.8, 0.6, 0.0), (0.0, 0.1, 0.21))]  # fmt: skip
    return YarnSet.from_curves(curves, closed=[False] * 3, radius=[RADIUS, RADIUS, 0.1])


def repeated() -> YarnSet:
    """Two yarns of which one touches only an image of the other: the period along y is 1 cm, their distance 0.8 cm."""
    curves = [line((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)), line((1.0, 0.0, 0.0), (0.02, 0.8, 0.0))]
    yarns = YarnSet.from_curves(curves, closed=[False] * 2, radius=RADIUS)
    return replace(yarns, lattice=Lattice([[9.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), lattice_step=np.zeros((2, 2)))


def slip(yarns: YarnSet, size: float) -> np.ndarray:
    return size * np.random.default_rng(5).normal(size=yarns.points.shape)


@pytest.mark.parametrize(
    ("yarns", "size", "mu"), [(heap(), 0.003, 0.3), (repeated(), 0.1, (0.5, 0.2))],
    ids=["heap, sticking", "lattice, sliding"],
)  # fmt: skip
def test_force_is_minus_the_gradient(yarns: YarnSet, size: float, mu: float | tuple[float, float]) -> None:
    """The slip of 0.003 radii makes sticking contacts, that of 0.1 sliding contacts; the slip length is 0.05 radii."""
    scene = FrictionScene.of(yarns, Friction(mu))
    points = scene.start + slip(yarns, size)
    direction = np.random.default_rng(3).normal(size=points.shape)
    force = scene.friction_forces(points)
    assert np.abs(force).max() > 0.0
    step = 1e-6  # truncation error: 1e-12 over the squared slip of 1e-3; rounding error 1e-10
    slope = (scene.energy(points + step * direction) - scene.energy(points - step * direction)) / (2 * step)
    assert slope == pytest.approx(-(force * direction).sum(), rel=1e-5)


def test_friction_forces_sum_to_zero() -> None:
    scene = FrictionScene.of(heap(), Friction((0.5, 0.2)))
    force = scene.sample_forces(scene.start + slip(heap(), 0.1))
    # float64 rounding of a hundred terms
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-13 * np.abs(force).sum())


def test_yarns_that_did_not_slip_have_no_friction() -> None:
    """This also holds for yarns in strong contact that were translated together; friction never separates yarns."""
    scene = FrictionScene.of(heap(), Friction(0.3))
    shifted = scene.start + np.array([0.3, -0.2, 0.1])
    # coordinates of 10 units are rounded to 1e-15; friction divides them by the slip length of 0.05
    assert np.abs(scene.friction_forces(shifted)).max() < 1e-11
    assert scene.energy(shifted) < 1e-12


def test_a_sliding_contact_obeys_coulombs_law() -> None:
    """The force is mu N against the slip, with N = 4 pi r k (1 - delta^2)^2 / delta / sin(angle)."""
    angle, delta = 40.0, 0.8
    scene = FrictionScene.of(crossing(angle, delta), Friction(0.3), contact_samples=11)
    points, half = scene.start, len(ARC_LENGTHS)
    direction = np.array([0.6, 0.8, 0.0])
    points[half:] += 0.1 * direction
    force = scene.friction_forces(points)[half:].sum(axis=0) / scene.model.unit
    normal_force = 4 * np.pi * RADIUS * MATERIAL.k_contact * (1 - delta**2) ** 2 / delta / np.sin(np.radians(angle))
    # the midpoint rule computes N with an error of one per cent (test_yarn_closed_forms)
    np.testing.assert_allclose(force, -0.3 * normal_force * direction, atol=0.01 * 0.3 * normal_force)


@pytest.mark.parametrize(("direction", "expected"), [((1.0, 0.0, 0.0), 0.5), ((0.0, 0.0, 1.0), 0.2)])
def test_parallel_yarns_have_their_own_coefficients_along_and_across(
    direction: tuple[float, float, float], expected: float
) -> None:
    curves = [line((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)), line((1.0, 0.0, 0.0), (0.0, 0.22, 0.0))]
    yarns = YarnSet.from_curves(curves, closed=[False] * 2, radius=RADIUS)
    one, two = (FrictionScene.of(yarns, Friction(mu)) for mu in (1.0, (0.5, 0.2)))
    points, half = one.start, len(ARC_LENGTHS)
    points[half:] += 0.2 * np.asarray(direction)
    full, found = (scene.friction_forces(points)[half:].sum(axis=0) @ direction for scene in (one, two))
    # Both contacts slide fully, so the forces differ only by the coefficient; the tolerance is rounding.
    assert found / full == pytest.approx(expected, rel=1e-9)


def test_a_renewal_keeps_the_friction_of_a_slip_that_is_held() -> None:
    """Anchors follow a slide up to the slip length, so a renewal keeps both full friction and partial friction."""
    for share in (0.4, 30.0):
        scene = FrictionScene.of(crossing(90.0), Friction(0.3))
        points, half = scene.start, len(ARC_LENGTHS)
        points[half:, 0] += share * 0.05
        before = scene.friction_forces(points)[half:].sum(axis=0)
        scene.begin_step(points)
        after = scene.friction_forces(points)[half:].sum(axis=0)
        # After the slide other samples are in contact: N changes by the error of the midpoint rule, one per cent.
        np.testing.assert_allclose(after, before, atol=0.02 * np.abs(before).max())


def test_a_contact_remembers_where_it_turned() -> None:
    """A yarn is dragged by 5 slip lengths e, let back by 2 e, dragged to where it turned, and beyond.

    Along the yarn that it crosses, so N stays. The force is f (1 - (1 - s / e)^2) at a slip of s < e from the anchor.
    On the way back the anchor lies e behind the turn, so the force at a distance d from the turn is f (1 - (d / e)^2)
    up to d = e, and -f at 2 e. A shorter way back that stays within e leads to the same force again, and a cycle
    between two points loses 2 f (L - 2 e).
    """
    length, scene = 0.05, FrictionScene.of(crossing(90.0), Friction(0.3), contact_samples=11)
    start, half = scene.start, len(ARC_LENGTHS)

    def dragged(way: np.ndarray) -> np.ndarray:
        found = []
        for place in way * length:
            points = start.copy()
            points[half:, 0] += place
            found.append(-scene.friction_forces(points)[half:, 0].sum())
            scene.begin_step(points)
        return np.array(found)

    there, back = np.linspace(0.0, 5.0, 51), np.linspace(5.0, 3.0, 21)
    full = dragged(there)[-1]
    away = 5.0 - back
    expected = full * np.where(away < 1.0, 1.0 - away**2, (2.0 - away) ** 2 - 1.0)
    # N changes by the error of the midpoint rule, one per cent, while other samples come into contact
    np.testing.assert_allclose(dragged(back), expected, atol=0.02 * full)
    again = dragged(back[::-1])
    assert again[-1] == pytest.approx(full, rel=0.01)
    assert dragged(np.array([4.5, 4.8, 4.6, 5.0]))[-1] == pytest.approx(full, rel=0.01)
    cycle = np.concatenate([np.linspace(5.0, 0.0, 51), np.linspace(0.1, 5.0, 50)])
    force = dragged(cycle)
    lost = ((force[1:] + force[:-1]) / 2 * np.diff(cycle)).sum()
    assert lost == pytest.approx(2 * full * (5.0 - 2.0), rel=0.02)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"mu": -0.1}, "friction: got coefficients"),
        ({"mu": float("nan")}, "friction: got coefficients"),
        ({"mu": (0.3, -1.0)}, "friction: got coefficients"),
        ({"mu": 0.3, "slip_length": 0.0}, "friction: slip length: got 0"),
    ],
)
def test_invalid_values_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        Friction(**options)


class Capstan:
    """A yarn around a fixed cylinder: a weight of 1 dyn acts on its first point, its last three points are held.

    The cylinder is a thick straight yarn. The yarn climbs by three yarn radii per turn, which lengthens it by 0.1 %.
    Each call of ``pull`` moves the held end and finds the new equilibrium by Newton's method with a stiffness matrix of
    difference quotients. The force on a control point depends only on control points at most three away along the
    yarn; every seventh point can therefore be displaced at the same time.
    """

    REACH = 3
    RADIUS, CYLINDER, LEG, TAIL = 0.1, 1.0, 0.2, 6

    def __init__(self, angle: float, mu: float) -> None:
        bend = self.RADIUS + self.CYLINDER
        count = round(angle * bend / self.LEG)
        turn = np.arange(count + 1) / count * angle
        climb = 3 * self.RADIUS * angle / (2 * np.pi)
        arc = np.stack([bend * np.cos(turn), bend * np.sin(turn), climb * turn / angle], axis=1)
        self.outwards = np.array([-np.sin(angle), np.cos(angle), 0.0])
        tail = self.LEG * np.arange(1, self.TAIL + 1)[:, None]
        first = arc[0] + tail[::-1] * [0.0, -1.0, 0.0]
        curve = np.concatenate([first, arc, arc[-1] + tail * self.outwards])
        height = np.arange(-0.8, climb + 0.8, 0.15)
        axis = np.stack([0 * height, 0 * height, height], axis=1)
        yarns = YarnSet.from_curves([curve, axis], closed=[False, False], radius=[self.RADIUS, self.CYLINDER])
        # For tensions of 1 to 7 dyn, the strain is at most 0.2 %, the contacts overlap by 0.03 radii, and the bending
        # stiffness of 1e-3 erg cm is negligible.
        material = YarnMaterial(200.0, 0.0, 1e-3, 150.0, 0.0, 0.0, 0.0, 1.0)
        self.scene = FrictionScene.of(yarns, Friction(mu, slip_length=0.02), material, contact_samples=3)
        self.free = len(curve) - 3
        self.held = slice(self.free, len(curve))
        self.points = self.scene.start
        self.load = np.zeros_like(self.points)
        self.load[0] = [0.0, -self.scene.model.unit, 0.0]

    def pull(self, distance: float) -> float:
        """Tension [dyn] of the held end after it was pulled by ``distance`` [cm]."""
        self.points[self.held] += self.outwards * distance / self.scene.model.unit
        for _ in range(60):
            force = self.net_force(self.points)
            rest = np.abs(force[: self.free]).max() / self.scene.model.unit
            if rest < BALANCE:
                break
            step = self.newton_step(force)
            self.points[: self.free] += step * min(1.0, 0.05 / np.linalg.norm(step, axis=1).max())
        assert rest < BALANCE, "the yarn is not in equilibrium"
        self.scene.begin_step(self.points)
        return float(-force[self.held].sum(axis=0) @ self.outwards / self.scene.model.unit)

    def net_force(self, points: np.ndarray) -> np.ndarray:
        return self.scene.force_launches(points) + self.load

    def newton_step(self, force: np.ndarray) -> np.ndarray:
        values, vectors = np.linalg.eigh(self.stiffness())
        flat = vectors.T @ force[: self.free].ravel() / np.maximum(np.abs(values), 2e-3)
        return (vectors @ flat).reshape(-1, 3)

    def stiffness(self) -> np.ndarray:
        free, step, apart = self.free, 1e-6, 2 * self.REACH + 1
        matrix = np.zeros((free, 3, free, 3))
        for first in range(apart):
            for axis in range(3):
                moved = np.zeros_like(self.points)
                moved[first:free:apart, axis] = step
                change = self.net_force(self.points - moved) - self.net_force(self.points + moved)
                for point in range(first, free, apart):
                    near = slice(max(point - self.REACH, 0), min(point + self.REACH + 1, free))
                    matrix[near, :, point, axis] = change[near] / (2 * step)
        flat = matrix.reshape(3 * free, 3 * free)
        return (flat + flat.T) / 2


@pytest.mark.parametrize(("angle", "expected"), [(np.pi / 2, 1.602), *at_night((2 * np.pi, 6.586))])
def test_capstan(angle: float, expected: float) -> None:
    """T1 / T2 = e^(0.3 phi). The normal forces follow the tension from pull to pull.

    The error after n pulls is of the order 1.9^n / n!, so seven pulls suffice.
    """
    capstan = Capstan(angle, 0.3)
    tensions = [capstan.pull(distance) for distance in [0.0] + 7 * [0.03]]
    assert tensions[-1] == pytest.approx(expected, rel=0.05)
