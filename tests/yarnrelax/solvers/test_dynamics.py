# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The dynamics solver: damping, time steps, reproducibility, and the state of rest that it reaches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.linking.certificate import linking_certificate
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.yarn import YarnSet, basis
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.model.material import point_masses
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.dynamics import LONGEST_TIME_STEP, STABLE_PART, YarnDynamics
from stitchmesh.yarnrelax.solvers.preconditioner import stiffness_row_sums
from tests.yarnrelax.loops import iterate
from tests.yarnrelax.stockinette import fabric_of, hopf_link, periodic_patch, tube

LEAF = YarnMaterial.named("leaf")
MOTION = replace(PRESETS["draft"], precision="float64", solver="dynamics")
SAMPLES = MOTION.contact_samples
Vectors = NDArray[np.float64]


def started(
    yarns: YarnSet, material: YarnMaterial = LEAF, quality: Quality = MOTION
) -> tuple[YarnSimulation, YarnDynamics]:
    simulation = YarnSimulation.start(yarns, material, quality, device_named("cpu"))
    assert isinstance(simulation.solver, YarnDynamics)
    return simulation, simulation.solver


def overlapping_yarns() -> YarnSet:
    """Two uneven open yarns that cross and overlap; the seed is fixed."""
    noise = np.random.default_rng(7)
    along = np.stack([np.linspace(-0.8, 0.8, 7), np.zeros(7), np.zeros(7)], axis=1)
    curves = [along, along[:, [1, 0, 2]] + [0.1, 0.0, 0.2]]
    return YarnSet.from_curves([curve + noise.normal(scale=0.02, size=(7, 3)) for curve in curves],
                               closed=[False, False], radius=0.15)  # fmt: skip


def damping_forces(yarns: YarnSet, material: YarnMaterial, velocity: Vectors) -> Vectors:
    """Damping forces of the solver on the control points [dyn] at given velocities [cm / s]."""
    simulation, solver = started(yarns, material)
    solver.velocity.assign(velocity / simulation.model.unit)
    simulation.state.force.zero_()
    solver.launches(simulation.inputs, simulation.model.launch)
    return (solver.acceleration.numpy() * solver.mass.numpy()[:, None]) / simulation.model.unit


def dissipation(yarns: YarnSet, material: YarnMaterial, velocity: Vectors) -> float:
    """D_global + D_contact [erg / s] of two yarns, computed independently of the solver."""
    nodes, weights = np.polynomial.legendre.leggauss(6)
    moving = basis((nodes + 1) / 2) @ velocity[yarns.segment_points]
    whole = material.k_global * float((weights / 2 @ (moving**2).sum(axis=2).T).sum())
    place = basis((np.arange(SAMPLES) + 0.5) / SAMPLES)
    y, v = (place @ values[yarns.segment_points] for values in (yarns.points, velocity))
    first, last = yarns.segment_start[1], yarns.segment_start[2]
    weight = np.repeat(yarns.rest_length / SAMPLES, SAMPLES)
    sides = [slice(0, first * SAMPLES), slice(first * SAMPLES, last * SAMPLES)]
    apart = y.reshape(-1, 3)[sides[0], None] - y.reshape(-1, 3)[None, sides[1]]
    dv = v.reshape(-1, 3)[sides[0], None] - v.reshape(-1, 3)[None, sides[1]]
    distance = np.linalg.norm(apart, axis=2)
    along = (apart * dv).sum(axis=2) / distance
    density = material.k_dt * (dv**2).sum(axis=2) - (material.k_dt - material.k_dn) * along**2
    touching = distance < yarns.radius.sum()
    assert touching.sum() > 5
    return whole + float((weight[sides[0], None] * weight[sides[1]] * density * touching).sum())


@pytest.mark.parametrize("only", ["k_global", "k_dt", "k_dn"])
def test_damping_is_minus_the_derivative_of_the_dissipation(only: str) -> None:
    yarns = overlapping_yarns()
    nothing = dict.fromkeys(("k_global", "k_dt", "k_dn"), 0.0)
    material = replace(LEAF, **{**nothing, only: getattr(LEAF, only)})
    velocity = np.random.default_rng(3).normal(scale=10.0, size=yarns.points.shape)
    force = damping_forces(yarns, material, velocity)
    for number in range(velocity.size):
        bump = np.zeros(velocity.size)
        bump[number] = 1.0
        ends = [dissipation(yarns, material, velocity + side * bump.reshape(-1, 3)) for side in (0.5, -0.5)]
        # central differences of a quadratic are exact; the tolerance is the rounding of sums of a few hundred terms
        assert force.flat[number] == pytest.approx(ends[1] - ends[0], rel=1e-10, abs=1e-12 * ends[0])


def straight_yarn(spacing: float) -> YarnSet:
    line = np.stack([spacing * np.arange(9.0), np.zeros(9), np.zeros(9)], axis=1)
    return YarnSet.from_curves([line], closed=[False], radius=0.125)


def test_the_time_step_is_a_fraction_of_two_over_the_highest_frequency() -> None:
    simulation, solver = started(straight_yarn(0.1), replace(LEAF, k_global=0.0))
    iterate(simulation, 1)
    stiffness = stiffness_row_sums(simulation.model) / simulation.model.unit**2
    highest = np.sqrt((stiffness / point_masses(simulation.model)).max())
    assert solver.time_step == pytest.approx(STABLE_PART * 2 / highest, rel=1e-12)
    assert solver.time_step < 0.5 * LONGEST_TIME_STEP


def test_damping_shortens_the_time_step() -> None:
    simulation, solver = started(straight_yarn(0.2), replace(LEAF, k_global=100.0))
    iterate(simulation, 1)
    mass = LEAF.mass_per_length * 0.2
    # The damping rate is 2 k_global / (m l), for which steps up to 2 / rate are stable; stiffness contributes little.
    assert solver.time_step == pytest.approx(STABLE_PART * 2 / (2 * 100.0 / mass), rel=0.05)


def test_row_sums_bound_the_highest_frequency() -> None:
    """A time step that is stable by the row sums is stable: the energy of a yarn that vibrates stays bounded."""
    simulation, solver = started(straight_yarn(0.2), replace(LEAF, k_global=0.0))
    solver.velocity.assign(np.random.default_rng(5).normal(scale=0.01, size=(9, 3)))
    start = solver.kinetic_energy()
    most = 0.0
    for _ in range(20):
        iterate(simulation, 100)
        most = max(most, simulation.assess_cells()[0].energy + solver.kinetic_energy())
    # The integrator conserves a modified energy; the energy is at most 1 / (1 - (w dt / 2)^2) = 1 / (1 - 0.8^2) times
    # as large.
    assert most < 3.0 * start


def test_no_control_point_moves_more_than_the_step_fraction() -> None:
    yarns = hopf_link(0.8)
    simulation, solver = started(yarns, replace(LEAF, k_global=0.1 * LEAF.k_global))
    shortest = np.inf
    for _ in range(40):
        before = simulation.state.points.numpy()
        iterate(simulation, 5)
        moved = np.linalg.norm(simulation.state.points.numpy() - before, axis=1).max()
        assert moved <= 5 * MOTION.step_fraction * (1 + 1e-12)  # rounding
        shortest = min(shortest, solver.time_step)
    assert shortest < 0.1 * LONGEST_TIME_STEP  # the limit shortened steps
    relaxed = replace(yarns, points=simulation.model.from_device(simulation.state.points))
    assert linking_certificate(relaxed)[0, 1] == linking_certificate(yarns)[0, 1] != 0


def test_a_cell_moves_like_its_tiling() -> None:
    one, four = periodic_patch(1, 1), periodic_patch(2, 2)
    velocity = np.random.default_rng(9).normal(scale=50.0, size=one.points.shape)
    ends = []
    for yarns in (one, four):
        simulation, solver = started(yarns)
        solver.velocity.assign(np.tile(velocity, (len(yarns.points) // 12, 1)))
        iterate(simulation, 60)
        ends.append(simulation.model.from_device(simulation.state.points) - yarns.points)
    assert np.abs(ends[0]).max() > 0.1 * one.radius[0]
    # float64 rounding of sixty iterations, which contact may amplify a thousandfold
    np.testing.assert_allclose(ends[1], np.tile(ends[0], (4, 1)), rtol=0, atol=1e-10)


def test_a_yarn_without_mass_is_refused() -> None:
    with pytest.raises(ParameterError, match="mass_per_length"):
        started(straight_yarn(0.2), replace(LEAF, mass_per_length=0.0))


def test_both_solvers_reach_the_same_state_of_rest() -> None:
    """The quasistatic solver, started from the state of rest of the dynamics solver, ends with the same energy."""
    yarns, fabric = tube(3, 4), fabric_of(3, 4, closed=True)
    moving, still = (
        YarnSimulation.start(yarns, LEAF, replace(MOTION, solver=solver), device_named("cpu"), [KeepShape(fabric)],
                        [KeepBorders(fabric)])
        for solver in ("dynamics", "quasistatic")
    )  # fmt: skip
    iterate(moving, 1600)
    end = moving.assess_cells()[0]
    assert end.residual < 1e-3
    assert isinstance(moving.solver, YarnDynamics)
    assert moving.solver.kinetic_energy() < 1e-5 * end.energy
    still.state.points.assign(moving.state.points)
    still.search_contacts()
    iterate(still, 400)
    best = still.assess_cells()[0]
    assert best.residual < 1e-5
    # Relative forces of 1e-3 are left. The error in energy is of second order in them; the error in the positions of
    # soft stitches is of first order.
    assert end.energy == pytest.approx(best.energy, rel=1e-4)
    moved = still.state.points.numpy() - moving.state.points.numpy()
    assert np.sqrt((moved**2).sum(axis=1).mean()) < 0.15  # in radii; the tube has a size of twenty radii
