# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Friction on a lattice and in free cells: its virial, Coulomb's bound, dissipation, and independence of images."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from stitchmesh.lattice import Lattice
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.model.state import make_state
from stitchmesh.yarnrelax.relax import Relaxation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell
from tests.physics.test_friction import FrictionScene, repeated, slip
from tests.yarnrelax.stockinette import periodic_patch

KALDOR = YarnMaterial.named("kaldor-simulation")
EXACT = replace(PRESETS["reference"], quadrature_points=3, contact_samples=7, step_fraction=0.2, tolerance=1e-5)
UPRIGHT = RelaxCell(shear=False)


class CellScene(FrictionScene):
    """A friction scene whose cell may be deformed."""

    @classmethod
    def of(cls, yarns: YarnSet, friction: Friction, **choices: Any) -> CellScene:
        scene = super().of(yarns, friction, **choices)
        scene.state = make_state(scene.model, external=True, blocks=True, strains=1)
        scene.begin_step(scene.start)
        return scene

    @property
    def periods(self) -> np.ndarray:
        return self.model.constants.images.periods.numpy().copy()

    def set_strain(self, matrix: np.ndarray, points: np.ndarray, periods: np.ndarray) -> None:
        self.model.constants.images.periods.assign(periods @ matrix.T)
        self.set_points(points @ matrix.T)

    def set_points(self, points: np.ndarray) -> None:
        super().set_points(np.concatenate([points, np.zeros((len(self.state.points) - len(points), 3))]))

    def strain_forces(self, points: np.ndarray) -> np.ndarray:
        self.state.sample_virial.zero_()
        self.sample_forces(points)
        return self.state.sample_virial.numpy().astype(np.float64).sum(axis=0)


def strain(a: float, b: float, c: float) -> np.ndarray:
    """F for courses along x (``cell_strain``)."""
    return np.array([[1.0 + a, c, 0.0], [0.0, 1.0 + b, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("size", [0.003, 0.1], ids=["sticking", "sliding"])
def test_the_virial_is_minus_the_gradient_by_the_strains(size: float) -> None:
    """The energy is that of friction for anchors that stay, of points and periods that both follow the strain."""
    yarns = periodic_patch(1, 1)
    thicker = yarns.with_radius(1.1 * yarns.radius)  # the loops of the formula hardly touch
    scene = CellScene.of(thicker, Friction((0.5, 0.2)))
    points, periods = scene.start + slip(yarns, size), scene.periods
    virial = scene.strain_forces(points)
    assert np.abs(virial[:3]).max() > 0.0
    step = 1e-7  # truncation error: a pair moves by 2e-7 over a slip of 1e-3; rounding error 1e-9
    for axis, expected in enumerate(virial[:3]):
        ends = []
        for side in (1.0, -1.0):
            scene.set_strain(strain(*(side * step * np.eye(3)[axis])), points, periods)
            ends.append(scene.friction.energy(scene.state))
        found = -(ends[0] - ends[1]) / (2 * step)
        assert found == pytest.approx(expected, rel=1e-4, abs=1e-4 * np.abs(virial[:3]).max())


def test_the_stiffness_by_the_strains_bounds_the_change_of_the_virial_where_yarns_stick() -> None:
    yarns = periodic_patch(1, 1)
    scene = CellScene.of(yarns.with_radius(1.1 * yarns.radius), Friction(0.3))
    points, periods = scene.start, scene.periods
    k = scene.strain_forces(points)[3:]
    bound = np.array([[k[0], k[3], k[4]], [k[3], k[1], k[5]], [k[4], k[5], k[2]]])
    step, columns = 1e-6, []  # without slip, the energy is quadratic up to a relative error of 1e-6 * 2 / 0.05
    for axis in np.eye(3):
        sides = []
        for side in (1.0, -1.0):
            scene.set_strain(strain(*(side * step * axis)), points, periods)
            sides.append(scene.strain_forces(points @ strain(*(side * step * axis)).T)[:3])
        columns.append((sides[1] - sides[0]) / (2 * step))
    stiffness = np.array(columns)
    assert np.linalg.eigvalsh((stiffness + stiffness.T) / 2).min() > 0.0
    assert np.linalg.eigvalsh(bound - (stiffness + stiffness.T) / 2).min() > -1e-3 * np.abs(bound).max()


@pytest.mark.parametrize("size", [0.01, 0.4], ids=["sticking", "sliding"])
def test_friction_dissipates_in_a_closed_cycle(size: float) -> None:
    """A yarn is moved around a circle against its neighbour's image, with a renewal at each of 40 places.

    Friction does no positive work. Where the yarn slides, the work is mu N times the length of the path.
    """
    yarns = repeated()
    scene = FrictionScene.of(yarns, Friction(0.3))
    half, start = len(yarns.points) // 2, scene.start
    angle = np.linspace(0.0, 2 * np.pi, 41)
    path = size * np.column_stack([np.sin(angle), 0 * angle, 1 - np.cos(angle)]) * [1.0, 0.0, 0.3]
    work, force = 0.0, scene.friction_forces(start)[half:].sum(axis=0)
    for before, after in pairwise(path):
        points = start.copy()
        points[half:] += after
        now = scene.friction_forces(points)[half:].sum(axis=0)
        work += (now + force) @ (after - before) / 2
        scene.begin_step(points)
        force = scene.friction_forces(points)[half:].sum(axis=0)
    press = scene.friction.arrays()["press"].numpy().astype(np.float64)
    full = 0.3 * np.linalg.norm(press, axis=2).sum() / 2 * np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert work < 1e-4 * full  # the trapezoid rule over a force that bends within a step
    # the slip length is an eighth of the radius of the large circle, over which friction builds up
    assert (work > -0.5 * full) if size < 0.05 else (-1.1 * full < work < -0.6 * full)


@cache
def relaxed(mu: float, load: float = 0.0, start: float = 1.0, moved: bool = False) -> Relaxation:
    """Stockinette in a free cell, from a cell that is ``start`` times as high, along the wales drawn with a load."""
    yarns = drawn(start)
    if moved:
        points = yarns.points.copy()
        points[: len(points) // 2] += yarns.lattice.periods[1] - 2 * yarns.lattice.periods[0]
        yarns = replace(yarns, points=points)
    terms = [Friction(mu)] if mu else []
    cell = RelaxCell(wale=load, shear=False)
    return relax_yarns(yarns, material=KALDOR, quality=EXACT, device="cpu", cell=cell, terms=terms)


@cache
def drawn(factor: float) -> YarnSet:
    """Two stitches at rest, one above the other, in a cell that was made higher without friction."""
    free = relax_yarns(periodic_patch(2, 1), material=KALDOR, quality=EXACT, device="cpu", cell=UPRIGHT).yarns
    matrix = strain(0.0, factor - 1.0, 0.0)
    taller = replace(free, points=free.points @ matrix, lattice=Lattice(free.lattice.periods @ matrix))
    return relax_yarns(taller, material=KALDOR, quality=EXACT, device="cpu").yarns


def height(found: Relaxation) -> float:
    return float(found.yarns.lattice.periods[1][1])


def test_friction_holds_a_part_of_a_stretch() -> None:
    without, held = relaxed(0.0, start=1.1), relaxed(0.3, start=1.1)
    assert without.report["converged"] and held.report["converged"]
    assert height(held) > 1.003 * height(without)
    # without friction the fabric returns to its size: the tolerance of 1e-5 leaves a strain of some 1e-3
    assert height(without) == pytest.approx(drawn(1.0).lattice.periods[1][1], rel=2e-3)


def test_yarns_stick_below_coulombs_bound_and_slide_above_it() -> None:
    """A small load moves a fabric with friction much less than one without; a large load moves both alike."""
    rest = float(drawn(1.0).lattice.periods[1][1])
    small, small_held = (height(relaxed(mu, 100.0)) - rest for mu in (0.0, 0.3))
    assert 0.0 < small_held < 0.3 * small  # what is left is the bending of yarn that sticks
    large, large_held = (height(relaxed(mu, 1000.0)) - rest for mu in (0.0, 0.3))
    assert 0.85 * large < large_held < large


def test_a_load_that_is_taken_off_leaves_a_strain_and_does_more_work_than_it_gets_back() -> None:
    """The work of the load is the gain of elastic energy plus what friction dissipates (loads are dead)."""
    load, rest, pulled = 1000.0, relaxed(0.3), relaxed(0.3, 1000.0)
    terms = [Friction(0.3)]
    off = relax_yarns(pulled.yarns, material=KALDOR, quality=EXACT, device="cpu", cell=UPRIGHT, terms=terms)
    elastic = [sum(found.report["energies"][name] for name in ("stretch", "length", "bend", "contact"))
               for found in (rest, pulled, off)]  # fmt: skip
    assert height(rest) < height(off) < height(pulled)
    assert load * (height(pulled) - height(rest)) > elastic[1] - elastic[0]
    assert elastic[2] < elastic[1]


def test_the_choice_of_the_image_does_not_matter_to_a_free_cell_with_friction() -> None:
    one, two = relaxed(0.3, start=1.1), relaxed(0.3, start=1.1, moved=True)
    # two runs that round differently stop within a tolerance of 1e-5, which leaves a strain of some 1e-3
    np.testing.assert_allclose(two.yarns.lattice.periods, one.yarns.lattice.periods, atol=3e-3 * height(one))


def test_every_sample_of_a_relaxed_cell_obeys_coulombs_bound() -> None:
    yarns = drawn(1.1)
    scene = CellScene.of(yarns, Friction(0.3), contact_samples=EXACT.contact_samples)
    rest = relaxed(0.3, start=1.1).yarns
    for share in (0.5, 1.0):  # a fabric on its way back, and arrived
        periods = yarns.lattice.periods + share * (rest.lattice.periods - yarns.lattice.periods)
        points = yarns.points + share * (rest.points - yarns.points)
        scene.model.constants.images.periods.assign(periods / scene.model.unit)
        scene.begin_step(scene.model.to_device(points))
        force = np.linalg.norm(scene.sample_forces(scene.model.to_device(points)), axis=1)
        press = np.linalg.norm(scene.friction.arrays()["press"].numpy().astype(np.float64), axis=2).sum(axis=1)
        assert (force <= 0.3 * press * (1.0 + 1e-12)).all()  # rounding
        assert (force > 0.15 * press)[press > 0.0].any()  # the pairs of a sample pull in several directions


def test_a_renewal_keeps_the_friction_of_a_change_of_the_periods() -> None:
    """The yarns stay where they are; the period carries the image of one along the other."""
    scene = CellScene.of(repeated(), Friction(0.3))
    points, periods = scene.start, scene.periods
    half = len(points) // 2
    periods[1, 0] += 1.5
    scene.model.constants.images.periods.assign(periods)
    before = scene.friction_forces(points)[half:].sum(axis=0)
    scene.begin_step(points)
    after = scene.friction_forces(points)[half:].sum(axis=0)
    assert np.abs(before).max() > 0.0
    # after the slide of 1.5 radii other samples face each other: N changes by the error of the midpoint rule
    np.testing.assert_allclose(after, before, atol=0.08 * np.abs(before).max())
