# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Dynamics: free fall, terminal speed, conservation of momentum and energy, vibration of a string and of a ring."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from stitchmesh.compute.device import device_named
from stitchmesh.quality import Quality
from stitchmesh.simulation.dead_load import EARTH, Gravity
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.constraints.pins import Pins
from stitchmesh.yarnrelax.energies.term import ConstraintChoice, YarnChoice
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.dynamics import YarnDynamics
from tests.yarnrelax.loops import iterate

FALL = -EARTH[1]
MOTION = Quality("float64", 3, 3, 12, 0.2, 1e-4, 20_000, "dynamics")


def undamped(**values: float) -> YarnMaterial:
    return replace(YarnMaterial.named("leaf"), k_global=0.0, k_dt=0.0, k_dn=0.0, **values)


def started(
    yarns: YarnSet,
    material: YarnMaterial,
    terms: list[YarnChoice] | None = None,
    constraints: list[ConstraintChoice] | None = None,
) -> tuple[YarnSimulation, YarnDynamics]:
    simulation = YarnSimulation.start(yarns, material, MOTION, device_named("cpu"), terms or [], constraints or [])
    assert isinstance(simulation.solver, YarnDynamics)
    return simulation, simulation.solver


def positions(simulation: YarnSimulation) -> NDArray[np.float64]:
    return simulation.model.from_device(simulation.state.points)


def velocities(simulation: YarnSimulation, solver: YarnDynamics) -> NDArray[np.float64]:
    return solver.velocity.numpy() * simulation.model.unit


def straight_yarn(segments: int, spacing: float = 1.0, radius: float = 0.3) -> YarnSet:
    points = np.zeros((segments + 3, 3))
    points[:, 0] = np.arange(segments + 3) * spacing
    return YarnSet.from_curves([points], closed=[False], radius=radius, rest_lengths=[np.ones(segments)])


def crossing_yarns() -> YarnSet:
    """Two straight yarns whose axes are one diameter apart, and a third yarn that is a little closer to the second."""
    along = np.stack([np.linspace(-1.0, 1.0, 12), np.zeros(12), np.zeros(12)], axis=1)
    across = along[:, [1, 0, 2]] + [0.1, 0.0, 0.25]
    above = along @ [[0.8, 0.6, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] + [0.0, 0.1, 0.48]
    return YarnSet.from_curves([along, across, above], closed=[False] * 3, radius=0.125)


def test_a_yarn_in_free_fall() -> None:
    simulation, solver = started(straight_yarn(5), undamped(segment_length=5.0), [Gravity()])
    solver.restart(np.array([0.5]))
    iterate(simulation, 100)
    time, step = solver.time, 0.5 * 4e-4
    assert time == pytest.approx(100 * step, rel=1e-12)  # nothing is stiff enough to shorten the step
    # float64 rounding of a hundred steps
    np.testing.assert_allclose(velocities(simulation, solver)[:, 1], -FALL * time, rtol=1e-13)
    drop = -positions(simulation)[:, 1]
    # Semi-implicit Euler is of first order: the sum of n steps of increasing speed is g t^2 / 2 + g t dt / 2.
    np.testing.assert_allclose(drop, FALL * time**2 / 2 + FALL * time * step / 2, rtol=1e-12)


def test_terminal_speed_shows_the_factor_of_global_damping() -> None:
    """The damping force is minus the derivative of k_global v.v, which is -2 k_global v.

    A segment of mass m l therefore falls at the speed m l g / (2 k_global).
    """
    material = replace(YarnMaterial.named("leaf"), k_dt=0.0, k_dn=0.0)
    simulation, solver = started(straight_yarn(5), material, [Gravity()])
    iterate(simulation, 400)
    rate = 2 * material.k_global / material.mass_per_length
    assert rate * solver.time > 40  # the speed approaches its limit exponentially; e^-40 is left
    terminal = material.mass_per_length * FALL / (2 * material.k_global)
    np.testing.assert_allclose(velocities(simulation, solver)[:, 1], -terminal, rtol=1e-10)


def test_angular_momentum_is_conserved_without_damping() -> None:
    yarns = crossing_yarns()
    simulation, solver = started(yarns, undamped())
    start = np.random.default_rng(2).normal(scale=5.0, size=yarns.points.shape)
    solver.velocity.assign(start / simulation.model.unit)
    mass = solver.mass.numpy()[:, None]
    before = np.cross(positions(simulation), mass * start).sum(axis=0)
    iterate(simulation, 200)
    after = np.cross(positions(simulation), mass * velocities(simulation, solver)).sum(axis=0)
    # Internal forces have no torque, and a semi-implicit Euler step conserves angular momentum: x' x v' = x x v'. Only
    # rounding is left.
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-12 * np.abs(before).max())


def test_damped_yarns_never_gain_energy() -> None:
    yarns = crossing_yarns()
    simulation, solver = started(yarns, YarnMaterial.named("leaf"))
    solver.velocity.assign(np.random.default_rng(2).normal(scale=100.0, size=yarns.points.shape))
    # The phase of the fastest modes advances by 0.16 rad per step. The integrator makes their energy oscillate by 0.08
    # of it, which is less than the loss by damping.
    solver.set_step_scale(np.array([0.1]))
    energies = []
    for _ in range(100):
        energies.append(simulation.assess_cells()[0].energy + solver.kinetic_energy())
        iterate(simulation, 10)
    assert (np.diff(energies) < 0.0).all()
    assert energies[-1] < 0.2 * energies[0]


def test_energy_is_conserved_without_damping() -> None:
    yarns = crossing_yarns()
    simulation, solver = started(yarns, undamped())
    solver.velocity.assign(np.random.default_rng(2).normal(scale=100.0, size=yarns.points.shape))
    solver.set_step_scale(np.array([0.1]))
    energies = []
    for _ in range(60):
        energies.append(simulation.assess_cells()[0].energy + solver.kinetic_energy())
        iterate(simulation, 20)
    # The energy of semi-implicit Euler oscillates about the true energy by the fraction w dt / 2, at most 0.08 here,
    # and does not drift.
    assert np.mean(energies[-10:]) == pytest.approx(energies[0], rel=0.04)


def half_period_of(simulation: YarnSimulation, solver: YarnDynamics, displacement: Callable[[], float]) -> float:
    """Mean time [s] between the zero crossings of a vibration: half a period."""
    crossing_times: list[float] = []
    last_time, last = solver.time, displacement()
    while len(crossing_times) < 3:
        iterate(simulation, 5)
        time, now = solver.time, displacement()
        if (now > 0.0) != (last > 0.0):
            crossing_times.append(last_time + (time - last_time) * last / (last - now))
        last_time, last = time, now
        assert solver.time < 1.0
    return float(np.diff(crossing_times).mean())


def test_a_plucked_string_vibrates_at_its_frequency() -> None:
    """Half a period is L / c with c^2 = tension / mass per length."""
    segments, stretch = 60, 1.05
    yarns = straight_yarn(segments, stretch)
    material = undamped(k_bend=0.0, k_contact=0.0, k_length=0.0, k_len=1000.0, mass_per_length=1e-4, segment_length=1.0)
    middle = len(yarns.points) // 2
    pins = Pins([0, 1, 2, segments, segments + 1, segments + 2])
    simulation, solver = started(yarns, material, constraints=[pins])
    length = segments * stretch
    pluck = yarns.points.copy()
    pluck[3:-3, 1] = 0.1 * np.sin(np.pi * (yarns.points[3:-3, 0] - stretch) / length)
    simulation.state.points.assign(simulation.model.to_device(pluck))
    simulation.search_contacts()
    half_period = half_period_of(simulation, solver, lambda: float(positions(simulation)[middle, 1]))
    tension = material.axial_stiffness * (stretch - 1)
    wave_speed = np.sqrt(tension * stretch / material.mass_per_length)
    # The pins also fix the slope, so that a part of one of the 60 segments does not vibrate at each end.
    assert half_period == pytest.approx(length / wave_speed, rel=0.03)


def test_a_ring_vibrates_at_its_frequency() -> None:
    """In-plane vibration with n waves: w^2 = EI / (m R^4) n^2 (n^2 - 1)^2 / (n^2 + 1), EI = 2 k_bend (Hoppe 1871)."""
    segments, waves = 48, 2
    material = undamped(k_bend=1.0, k_contact=0.0, k_length=0.0, k_len=200.0, mass_per_length=1e-4)
    angle = 2 * np.pi * np.arange(segments) / segments
    outward = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    around = np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1)
    yarns = YarnSet.from_curves([outward], closed=[True], radius=0.05)
    simulation, solver = started(yarns, material)
    # inextensible mode: the tangential displacement is minus the integral of the radial displacement
    mode = np.cos(waves * angle)[:, None] * outward - np.sin(waves * angle)[:, None] / waves * around
    simulation.state.points.assign(simulation.model.to_device(yarns.points + 0.01 * mode))
    simulation.search_contacts()

    def displacement() -> float:
        return float(((positions(simulation) - yarns.points) * mode).sum())

    half_period = half_period_of(simulation, solver, displacement)
    stiffness = 2 * material.k_bend / material.mass_per_length
    frequency = np.sqrt(stiffness * waves**2 * (waves**2 - 1) ** 2 / (waves**2 + 1))
    # Lumped masses and the spline have an error of second order in the segments per wave: (n h)^2 / 6, h = 2 pi / 48.
    assert half_period == pytest.approx(np.pi / frequency, rel=0.012)
