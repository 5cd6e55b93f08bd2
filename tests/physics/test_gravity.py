# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Gravity in the relaxer: weights, the heavy cantilever and the catenary (reference: mechanics of rods and chains).

A yarn bends as a rod of flexural rigidity EI = 2 k_bend. Each half of a yarn of length 2 L that is pinned in its middle
is a cantilever of length L: by symmetry the yarn stays horizontal at the pin, and the pin carries no moment.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from stitchmesh.compute.device import device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.errors import ParameterError
from stitchmesh.lattice import Lattice
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet, segment_lengths
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.collision.narrow_phase import make_candidates
from stitchmesh.yarnrelax.constraints.pins import Pins
from stitchmesh.yarnrelax.energies import evaluation
from stitchmesh.yarnrelax.energies.gravity import STANDARD, Gravity
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.material import point_masses
from stitchmesh.yarnrelax.model.state import make_state
from stitchmesh.yarnrelax.model.upload import put_model

FALL = -STANDARD[1]
HALF = 16
"""Segments of a cantilever. The spline spreads the force of a pin over two segments: relative error 1.5 / HALF^2."""
EXACT = Quality("float64", 5, 4, 12, 0.2, 1e-4, 20_000)
"""Five Gauss points integrate the energies of these curves to 1e-6. The residual changes the drop by at most 1e-3."""


def material(*, k_bend: float, k_len: float, weight: float) -> YarnMaterial:
    """A yarn with a given weight [dyn/cm] and without contact energy."""
    return YarnMaterial(k_len, 0.0, k_bend, 0.0, 0.0, 0.0, 0.0, weight / FALL)


def straight_yarn(segments: int, spacing: float = 1.0) -> YarnSet:
    points = np.zeros((segments + 3, 3))
    points[:, 0] = (np.arange(segments + 3) - (segments + 2) / 2) * spacing
    return YarnSet.from_curves([points], closed=[False], radius=0.3, rest_lengths=[np.ones(segments)])


def wavy_yarns() -> YarnSet:
    """A closed and an open yarn with uneven rest lengths; the seed is fixed."""
    noise = np.random.default_rng(5)
    curves = [noise.normal(size=(9, 3)), noise.normal(size=(7, 3)) + 5.0]
    return YarnSet.from_curves(
        curves, closed=[True, False], radius=0.01, rest_lengths=[noise.uniform(0.5, 1.5, 9), noise.uniform(0.5, 1.5, 4)]
    )


def on_device(yarns: YarnSet) -> Model:
    matter = YarnMaterial.named("leaf")
    scalar, device = scalar_named("float64"), device_named("cpu")
    return put_model(yarns, matter, quadrature_points=3, contact_samples=2, scalar=scalar, device=device)


def gravity_of(yarns: YarnSet, choice: Gravity, moved: np.ndarray | None = None) -> tuple[float, np.ndarray]:
    """Energy [erg] and forces on the control points [dyn] of gravity alone.

    The control points are those of ``yarns``, or ``moved`` if it is given.
    """
    model = on_device(yarns)
    state, candidates, term = make_state(model, external=True), make_candidates(model, 1e-4), choice.on(model)
    if moved is not None:
        state.points.assign(model.to_device(moved))
    term.forces(state, candidates, model.launch)
    assert not term.stiffness().any()
    evaluation.gather_launch(model, state, model.empty(model.point_count), model.launch)
    return term.energy(state, candidates), state.force.numpy().astype(np.float64) / model.unit


def test_force_is_minus_the_gradient() -> None:
    yarns, choice = wavy_yarns(), Gravity((100.0, -981.0, 30.0))
    force = gravity_of(yarns, choice)[1]
    direction = np.random.default_rng(3).normal(size=yarns.points.shape)
    ends = [gravity_of(yarns, choice, moved=yarns.points + side * direction)[0] for side in (0.5, -0.5)]
    # The energy is linear in the points, so the only error is rounding: 1e-16 of energies whose difference is of
    # about their own size.
    assert ends[0] - ends[1] == pytest.approx(-(force * direction).sum(), rel=1e-13)


def test_the_forces_sum_to_the_weight() -> None:
    yarns = wavy_yarns()
    force = gravity_of(yarns, Gravity())[1]
    weight = YarnMaterial.named("leaf").mass_per_length * yarns.rest_length.sum() * FALL
    # rounding of the masses and of a sum of a dozen terms
    np.testing.assert_allclose(force.sum(axis=0), [0.0, -weight, 0.0], rtol=1e-14)


def test_a_stated_mass_goes_before_that_of_the_material() -> None:
    """The first yarn states three times the mass of the material, the second one states none."""
    yarns, usual = wavy_yarns(), YarnMaterial.named("leaf").mass_per_length
    yarns = replace(yarns, radius=[0.01, 0.03], mass_per_length=[3.0 * usual, np.nan])
    mass = point_masses(on_device(yarns))
    own = np.bincount(yarns.segment_yarn, yarns.rest_length) * [3.0 * usual, usual]
    # rounding of a sum of a dozen terms
    assert np.bincount(yarns.point_yarn, mass) == pytest.approx(own, rel=1e-14)


def test_a_periodic_cell_weighs_as_much_as_its_yarn() -> None:
    lattice = Lattice(np.array([[4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]))
    loop = straight_yarn(4)
    cell = YarnSet(
        points=loop.points[:4], start=[0, 4], closed=[True], radius=[0.1], rest_length=np.ones(4), row=np.zeros(4),
        face=np.zeros(4), part=np.zeros(4), lattice=lattice, lattice_step=[[1, 0]],
    )  # fmt: skip
    force = gravity_of(cell, Gravity())[1]
    assert force[:, 1] == pytest.approx(-YarnMaterial.named("leaf").mass_per_length * FALL, rel=1e-14)


def test_heavy_cantilever() -> None:
    """The drop over L of the heavy elastica for w L^3 / EI = 8."""
    yarns = straight_yarn(2 * HALF)
    # the strains w L / (2 k_len) are below 2e-3
    matter = material(k_bend=1.0, k_len=25.0, weight=8.0 * 2.0 / HALF**3)
    middle = len(yarns.points) // 2
    result = relax_yarns(
        yarns, material=matter, quality=EXACT, device="cpu", terms=[Gravity(), Pins([middle])]
    )
    assert result.report["converged"]
    curve = result.yarns.sampled(2)[0]
    drop = curve[2 * HALF, 1] - (curve[0, 1] + curve[-1, 1]) / 2
    assert drop / HALF == pytest.approx(0.640631, rel=0.01)


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
    pins = Pins([1, len(yarns.points) - 2])
    result = relax_yarns(yarns, material=matter, quality=EXACT, device="cpu", terms=[Gravity(), pins])
    assert result.report["converged"]
    curve = result.yarns.sampled(2)[0]
    span = float(np.linalg.norm(curve[-1] - curve[0]))
    length = segment_lengths(result.yarns.points, result.yarns.segment_points).sum()
    sag = (curve[0, 1] + curve[-1, 1]) / 2 - curve[24, 1]
    assert length / span == pytest.approx(slack, rel=0.02)
    assert sag / span == pytest.approx(sag_of_catenary(length / span), rel=0.01)


@pytest.mark.parametrize("acceleration", [(0.0, -981.0), (0.0, np.nan, 0.0), 981.0])
def test_an_acceleration_must_be_three_finite_numbers(acceleration: object) -> None:
    with pytest.raises(ParameterError, match="acceleration"):
        Gravity(acceleration)  # type: ignore[arg-type]


def test_gravity_refuses_a_yarn_without_mass() -> None:
    yarns = straight_yarn(4)
    with pytest.raises(ParameterError, match="mass_per_length"):
        relax_yarns(yarns, material=material(k_bend=1.0, k_len=1.0, weight=0.0), device="cpu", terms=[Gravity()])
