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
import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.lattice import Lattice
from stitchmesh.quality import PRESETS
from stitchmesh.run import CHECKPOINT, Checkpoints, Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.friction.friction_law import resistance_block, slip_stiffness_block
from stitchmesh.yarnrelax.model.image_table import renew_images
from stitchmesh.yarnrelax.model.state import make_state
from stitchmesh.yarnrelax.relax import Relaxation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell
from tests.nightly import at_night
from tests.physics.test_friction import Capstan, FrictionScene, repeated, slip
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


@pytest.mark.parametrize("mu", [(0.5, 0.2), *at_night(0.3)])
@pytest.mark.parametrize("size", [0.003, 0.1], ids=["sticking", "sliding"])
@pytest.mark.parametrize("yarns", [periodic_patch(1, 1), *at_night(repeated())], ids=["stockinette", "lines"])
def test_the_virial_is_minus_the_gradient_by_the_strains(
    yarns: YarnSet, size: float, mu: float | tuple[float, float]
) -> None:
    """The energy is that of friction for anchors that stay, of points and periods that both follow the strain."""
    thicker = yarns.with_radius(1.1 * yarns.radius)  # the loops of the formula hardly touch
    scene = CellScene.of(thicker, Friction(mu))
    points, periods = scene.start + slip(yarns, size), scene.periods
    virial = scene.strain_forces(points)
    assert np.abs(virial[:3]).max() > 0.0
    step = 1e-7  # truncation error: a pair moves by 2e-7 over a slip of 1e-3; rounding error 1e-9
    for axis, expected in enumerate(virial[:3]):
        ends = []
        for side in (1.0, -1.0):
            scene.set_strain(strain(*(side * step * np.eye(3)[axis])), points, periods)
            ends.append(scene.friction.energy(scene.state, scene.candidates))
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


@kernel
def blocks_of_a_pair(
    # model
    press: Any,
    first: Any,
    second: Any,
    law: Any,
    # state in
    slip: wp.array[Any],
    # state out
    blocks: wp.array2d[Any],
) -> None:
    """H and K of a pair for several slips."""
    i = wp.tid()
    zero = type(blocks[0, 0])()
    blocks[i, 0] = slip_stiffness_block(press, slip[i], first, second, law, zero)
    blocks[i, 1] = resistance_block(wp.length(press) * law[0], wp.normalize(press), first, second, law, zero)


def matrix_of(block: np.ndarray) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = block
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@pytest.mark.parametrize("law", [(0.3, 1.0, 1.0), (0.5, 1.0, 0.16)], ids=["one coefficient", "two coefficients"])
def test_the_stiffness_of_a_pair_is_the_second_derivative_and_has_no_negative_eigenvalue(law: tuple) -> None:
    press, first, second = np.array([1.0, 2.0, 2.0]), np.array([0.6, 0.0, 0.8]), np.array([0.0, 1.0, 0.0])
    slips = np.array([[0.0, 0.0, 0.0], [0.01, -0.02, 0.005], [0.03, 0.04, 0.01], [0.3, -0.2, 0.1]])
    given, found = wp.array(slips, dtype=wp.vec3d), wp.zeros((4, 2), dtype=wp.types.vector(6, wp.float64))
    arguments = [wp.vec3d(*press), wp.vec3d(*first), wp.vec3d(*second), wp.vec4d(*law, 0.05), given]
    wp.launch(blocks_of_a_pair, 4, arguments, [found])
    for u, (exact, unit) in zip(slips, found.numpy(), strict=True):
        a = matrix_of(unit) / (3.0 * law[0])  # A: the block of size mu N is mu N A
        hessian = second_derivative(lambda x, a=a: 3.0 * law[0] * mollified(np.sqrt(max(x @ a @ x, 0.0)), 0.05), u)
        # second differences with a step of 1e-4: the third derivative, 2 / e^2, times the step
        np.testing.assert_allclose(matrix_of(exact), hessian, atol=0.02 * 3.0 * law[0] * 2 / 0.05)
        assert np.linalg.eigvalsh(matrix_of(exact)).min() > -1e-12 * 3.0 * 2 / 0.05  # rounding
        assert np.abs(matrix_of(exact) @ press).max() < 1e-12 * 3.0 * 2 / 0.05  # nothing along the normal


def mollified(s: float, e: float) -> float:
    """phi (``friction``)."""
    return s * s / e - s**3 / (3 * e * e) if s < e else s - e / 3


def second_derivative(energy: Any, at: np.ndarray, step: float = 1e-4) -> np.ndarray:
    axes = step * np.eye(3)
    sides = [[energy(at + p + q) - energy(at + p - q) - energy(at - p + q) + energy(at - p - q) for q in axes]
             for p in axes]  # fmt: skip
    return np.array(sides) / (4 * step * step)


def test_a_new_table_of_images_changes_no_force_and_loses_no_pair() -> None:
    yarns = periodic_patch(2, 1)
    scene = CellScene.of(yarns.with_radius(1.1 * yarns.radius), Friction(0.3))
    points = scene.start + slip(yarns, 0.1)
    before, energy = scene.sample_forces(points), scene.energy(points)
    first, table = scene.friction.arrays(), scene.model.constants.images.image.numpy()
    scene.model.constants.images.box = scene.model.empty(2, 3)
    wide = scene.start * [1.0, 1.0, 12.0]  # yarns that are spread need other images
    renew_images(scene.model, scene.model.upload(3.0 * wide, 3), anyway=True)
    assert scene.model.constants.images.image.shape != table.shape
    np.testing.assert_array_equal(scene.sample_forces(points), before)
    assert scene.energy(points) == energy
    scene.begin_step(points)
    kept, count = scene.friction.arrays(), first["count"].numpy()
    assert kept["table"].shape != first["table"].shape
    slid = np.linalg.norm(scene.sample_forces(points), axis=1)
    # pairs that press before and after keep their friction up to the change of N, so most of the force is left
    assert slid[count > 0].sum() > 0.5 * np.linalg.norm(before, axis=1).sum()


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


def test_friction_holds_a_part_of_a_stretch_and_more_friction_holds_more() -> None:
    found = [relaxed(mu, start=1.1) for mu in (0.0, 0.1, 0.2, 0.4)]
    assert all(each.report["converged"] for each in found)
    heights = [height(each) for each in found]
    assert np.all(np.diff(heights) > 0.001 * heights[0])
    # without friction the fabric returns to its size: the tolerance of 1e-5 leaves a strain of some 1e-3
    assert heights[0] == pytest.approx(drawn(1.0).lattice.periods[1][1], rel=2e-3)


def test_yarns_stick_below_coulombs_bound_and_slide_above_it() -> None:
    """A small load moves a fabric with friction much less than one without; a large load moves both alike."""
    rest = float(drawn(1.0).lattice.periods[1][1])
    small = [height(relaxed(mu, 100.0)) - rest for mu in (0.0, 0.2, 0.5)]
    assert 0.0 < small[2] < small[1] < 0.3 * small[0]  # what is left is the bending of yarn that sticks
    large = [height(relaxed(mu, 1000.0)) - rest for mu in (0.0, 0.2, 0.5)]
    assert 0.85 * large[0] < large[2] < large[1] < large[0]


def test_a_load_that_is_taken_off_leaves_a_strain_and_does_more_work_than_it_gets_back() -> None:
    """The work of the load is the gain of elastic energy plus what friction dissipates (loads are dead)."""
    load, rest = 300.0, relaxed(0.3)
    pulled = relaxed(0.3, load)
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


def test_a_relaxation_without_friction_is_the_same_before_and_after_one_with_friction() -> None:
    common: dict[str, Any] = {"material": KALDOR, "quality": EXACT, "device": "cpu", "cell": UPRIGHT}
    before = relax_yarns(periodic_patch(1, 1), **common)
    relax_yarns(periodic_patch(1, 1), terms=[Friction(0.3)], **common)
    after = relax_yarns(periodic_patch(1, 1), **common)
    np.testing.assert_array_equal(after.yarns.points, before.yarns.points)
    np.testing.assert_array_equal(after.yarns.lattice.periods, before.yarns.lattice.periods)
    assert "friction" not in after.report["energies"]


def test_friction_of_coefficient_zero_changes_no_force() -> None:
    """Forces and virials have the same bits as without the term."""
    yarns = periodic_patch(1, 1)
    scene = CellScene.of(yarns.with_radius(1.1 * yarns.radius), Friction(0.0))
    points = scene.start + slip(yarns, 0.1)
    assert not scene.sample_forces(points).any()
    assert not scene.strain_forces(points).any()


def test_a_resumed_relaxation_with_friction_ends_in_the_same_bits(tmp_path) -> None:  # type: ignore[no-untyped-def]
    yarns, terms = drawn(1.1), [Friction(0.3)]
    common: dict[str, Any] = {"material": KALDOR, "device": "cpu", "cell": UPRIGHT, "terms": terms}
    whole = relax_yarns(yarns, quality=EXACT, **common)
    short = replace(EXACT, max_iterations=60)
    relax_yarns(yarns, quality=short, run=Run(checkpoints=Checkpoints(tmp_path, every=20)), **common)
    rest = relax_yarns(yarns, quality=EXACT, run=Run(resume=tmp_path / CHECKPOINT), **common)
    np.testing.assert_array_equal(rest.yarns.points, whole.yarns.points)
    np.testing.assert_array_equal(rest.yarns.lattice.periods, whole.yarns.lattice.periods)


@pytest.mark.nightly
def test_capstan_on_a_lattice() -> None:
    """The cylinder lies in another image than the yarn that is wound around it."""
    capstan = Capstan(np.pi / 2, 0.3, lattice=Lattice([[12.0, 0.0, 0.0], [0.0, 11.0, 0.0]]))
    tensions = [capstan.pull(distance) for distance in [0.0] + 7 * [0.03]]
    assert tensions[-1] == pytest.approx(1.602, rel=0.05)


@pytest.mark.parametrize("share", [0.4, 30.0], ids=["sticking", "sliding"])
def test_a_renewal_keeps_the_friction_of_a_change_of_the_periods(share: float) -> None:
    """The yarns stay where they are; the period carries the image of one along the other."""
    scene = CellScene.of(repeated(), Friction(0.3))
    points, periods = scene.start, scene.periods
    half = len(points) // 2
    periods[1, 0] += share * 0.05
    scene.model.constants.images.periods.assign(periods)
    before = scene.friction_forces(points)[half:].sum(axis=0)
    scene.begin_step(points)
    after = scene.friction_forces(points)[half:].sum(axis=0)
    assert np.abs(before).max() > 0.0
    # after the slide of 1.5 radii other samples face each other: N changes by the error of the midpoint rule
    np.testing.assert_allclose(after, before, atol=0.08 * np.abs(before).max())
