# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Motion in time: conservation laws, prescribed motion, the full-yarn run, adaptive steps, stopping and resuming."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.mixed.dynamics.backward_euler import Dynamics, DynamicsSettings
from stitchmesh.mixed.enrichment.region import region_around
from tests.mixed.dynamics.scene import Scene, masses_of, spring_scene
from tests.mixed.patch import enriched_everywhere, square_patch

PATCH = square_patch(6, 4)
SQUARE = region_around(*PATCH.layout, PATCH.near((0.5, 0.5), 0.2))
REGIONS = {
    "square": SQUARE,
    "one triangle": region_around(*PATCH.layout, [30]),
    "at the border": region_around(*PATCH.layout, PATCH.near((0.0, 0.5), 0.2)),
    "everywhere": enriched_everywhere(*PATCH.layout),
    "none": region_around(*PATCH.layout, []),
}
TIGHT = DynamicsSettings(time_step=5e-3, velocity_tolerance=1e-10, solve_tolerance=1e-4)


def swinging(points: np.ndarray) -> np.ndarray:
    """Velocities of a motion that bends, stretches, turns and moves a patch [cm/s]."""
    x, y, _ = points.T
    return np.stack([1.0 + 2.0 * y, 3.0 * x, 2.0 + 4.0 * np.sin(3.0 * x) * y], axis=1)


def moving(scene: Scene, settings: DynamicsSettings = TIGHT, **more) -> Dynamics:
    velocities = scene.vector(swinging(PATCH.vertices), swinging(PATCH.nodes))
    scene.system.make_motion(velocities)
    return Dynamics(scene.system, scene.at_rest(), settings, velocities=velocities, **more)


def momentum_of(run: Dynamics) -> np.ndarray:
    """Momentum of vertices and nodes [g cm/s], shape (3,)."""
    product = run.positions.like()
    run.system.update_masses(run.positions)
    run.system.set_mass_product(run.velocities, product)
    vertices, nodes, _ = product.numpy()
    return vertices.sum(axis=0) + nodes.sum(axis=0)


@pytest.mark.parametrize("name", REGIONS)
def test_momentum_is_kept_and_energy_never_grows_without_loads(name):
    scene = spring_scene(PATCH, REGIONS[name])
    run = moving(scene)
    momentum, energy = momentum_of(run), sum(run.energies().values())
    for _ in range(6):
        run.step()
        # The error of the velocities that the tolerance allows, times the mass; rounding of some 1,000 numbers.
        np.testing.assert_allclose(momentum_of(run), momentum, atol=1e-10 * scene.masses.total + 1e-14)
        after = sum(run.energies().values())
        assert after <= energy * (1 + 1e-12)
        energy = after
    v, p, _ = run.positions.numpy()
    assert np.abs(scene.embedding.constraint(v, p)).max(initial=0.0) < 1e-12  # rounding of positions of size 1


def test_what_is_fixed_moves_as_prescribed():
    vertices, nodes = [0, 1, 7], SQUARE.nodes[[3, 100]]
    scene = spring_scene(PATCH, SQUARE, fixed_vertices=vertices, fixed_nodes=nodes)
    numbers = SQUARE.node_number[nodes]

    def prescribed(begin: float, end: float):
        of_vertices, of_nodes = np.zeros((49, 3)), np.zeros((len(SQUARE.nodes), 3))
        of_vertices[vertices], of_nodes[numbers] = [0.0, 0.0, 5.0 * (end**2 - begin**2)], [end - begin, 0.0, 0.0]
        return of_vertices, of_nodes, np.zeros((len(SQUARE.nodes), 2))

    run = Dynamics(scene.system, scene.at_rest(), TIGHT, prescribed=prescribed)
    reports = [run.step() for _ in range(5)]
    v, p, _ = run.positions.numpy()
    rest_v, rest_p, _ = scene.at_rest().numpy()
    assert run.time == reports[-1].time
    np.testing.assert_allclose((v - rest_v)[vertices], np.tile([0, 0, 5.0 * run.time**2], (3, 1)), atol=1e-14)
    np.testing.assert_allclose((p - rest_p)[numbers], np.tile([run.time, 0, 0], (2, 1)), atol=1e-14)
    assert np.abs(scene.embedding.constraint(v, p)).max() < 1e-12  # rounding of positions of size 1
    assert np.abs(v - rest_v)[8].max() > 0.0


def test_rayleigh_damping_takes_the_energy_that_the_closed_form_says():
    scene = spring_scene(PATCH, SQUARE)
    shift = np.ones(3)
    velocities = scene.vector(np.ones((49, 3)), np.ones((len(PATCH.nodes), 3)))
    settings = replace(TIGHT, damping_mass=20.0, damping_stiffness=1e-2)
    run = Dynamics(scene.system, scene.at_rest(), settings, velocities=velocities)
    start = momentum_of(run)
    for _ in range(3):
        run.step()
    # A translation is damped by mass alone: u_n+1 = u_n / (1 + a h).
    np.testing.assert_allclose(momentum_of(run), start / (1 + 20.0 * TIGHT.time_step) ** 3, rtol=1e-9)
    assert shift @ momentum_of(run) > 0.0


def test_damping_by_stiffness_lets_vibrations_fade_and_keeps_momentum():
    scene = spring_scene(PATCH, SQUARE)
    stretching = [(points - 0.5) * [3.0, -3.0, 0.0] + 1.0 for points in (PATCH.vertices, PATCH.nodes)]  # and moving on
    energies = []
    for damping in (0.0, 0.05):
        velocities = scene.vector(*stretching)
        scene.system.make_motion(velocities)
        settings = replace(TIGHT, damping_stiffness=damping)
        run = Dynamics(scene.system, scene.at_rest(), settings, velocities=velocities)
        momentum = momentum_of(run)
        while run.time < 0.019:
            run.step()
        np.testing.assert_allclose(momentum_of(run), momentum, atol=1e-10)
        energies.append(sum(run.energies().values()) - 0.5 * momentum @ momentum / scene.masses.total)
    assert energies[1] < 0.1 * energies[0]  # the deformation has faded; the motion as a whole goes on


def test_damping_does_not_multiply_the_negative_curvature_of_pressed_yarns():
    scene = spring_scene(PATCH, SQUARE, rest=1.2, stiffness=200.0)
    step = 5e-4
    for damping in (0.0, 40 * step):
        report = moving(scene, replace(TIGHT, time_step=step, damping_stiffness=damping)).step()
        # The inertia of a node holds the negative stiffness of its springs, and would not hold 41 times of it.
        assert report.halvings == 0
        assert report.newton_iterations <= 6


def test_a_checkpoint_of_another_scene_is_refused():
    run = moving(spring_scene(PATCH, SQUARE))
    arrays = run.arrays()
    with pytest.raises(ParameterError, match=r"resume: array 'positions' of the checkpoint has the shape \(3,\)"):
        run.resume({**arrays, "positions": np.zeros(3)})
    del arrays["clock"]
    with pytest.raises(ParameterError, match="resume: array 'clock' of the checkpoint is missing"):
        run.resume(arrays)


def test_the_step_is_halved_where_newton_does_not_converge_and_grows_again():
    scene = spring_scene(PATCH, SQUARE, stiffness=5e5)
    run = moving(scene, replace(TIGHT, time_step=0.1, most_newton_iterations=8, velocity_tolerance=1e-6))
    reports = [run.step() for _ in range(12)]
    assert reports[0].halvings > 0
    assert reports[0].time_step == 0.1 * 0.5 ** reports[0].halvings
    steps = [report.time_step for report in reports]
    assert max(steps) > steps[0]
    assert max(steps) <= 0.1
    assert np.isfinite(run.positions.values.numpy()).all()


def test_a_step_that_never_converges_is_an_error():
    scene = spring_scene(PATCH, SQUARE, stiffness=5e5)
    settings = replace(TIGHT, time_step=0.1, smallest_time_step=0.09, most_newton_iterations=1)
    with pytest.raises(SolverError, match=r"does not converge at time 0 s with time steps down to 0\.09 s"):
        moving(scene, settings).step()


@pytest.mark.parametrize("time_step", [1e-6, 1e-1])
def test_time_steps_over_five_decades_stay_finite(time_step):
    scene = spring_scene(PATCH, SQUARE)
    run = moving(scene, replace(TIGHT, time_step=time_step))
    before = sum(run.energies().values())
    for _ in range(3):
        run.step()
    assert sum(run.energies().values()) <= before * (1 + 1e-12)


@pytest.mark.parametrize("ratio", [1e-6, 1e6])
def test_extreme_mass_ratios_and_weights_converge(ratio):
    region = region_around(*PATCH.layout, PATCH.near((0.5, 0.5), 0.2), smallest_alpha=1e-3)
    masses = masses_of(PATCH, region)
    masses = replace(masses, vertices=masses.vertices * np.sqrt(ratio), yarns=masses.yarns / np.sqrt(ratio))
    run = moving(spring_scene(PATCH, region, masses=masses), replace(TIGHT, velocity_tolerance=1e-6))
    momentum = momentum_of(run)
    for _ in range(2):
        run.step()
    np.testing.assert_allclose(momentum_of(run), momentum, rtol=1e-6)  # the tolerance of the velocities
    assert np.isfinite(run.positions.values.numpy()).all()


@pytest.mark.parametrize(("name", "value"), [("damping_mass", -1.0), ("time_step", np.nan)])
def test_settings_out_of_range_are_refused(name, value):
    with pytest.raises(ParameterError, match=f"dynamics: {name}: got {value}; expected a number"):
        DynamicsSettings(**{name: value})


def test_masses_of_another_region_are_refused():
    other = REGIONS["one triangle"]
    with pytest.raises(ParameterError, match="mixed system: got masses of 49 vertices"):
        spring_scene(PATCH, SQUARE, masses=masses_of(PATCH, other))
