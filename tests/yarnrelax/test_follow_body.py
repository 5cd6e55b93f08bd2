# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns that follow a moving body: contact, friction, carried points, checkpoints and refusals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.vertex_motion import MovingMesh
from stitchmesh.quality import PRESETS
from stitchmesh.run import CHECKPOINT, QUIET, Checkpoints, Run
from stitchmesh.simulation.dead_load import Gravity
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.body_follower import BodyFollower, FollowInputs
from stitchmesh.yarnrelax.constraints.pins import Pins
from stitchmesh.yarnrelax.energies.body import Body
from stitchmesh.yarnrelax.follow_body import follow_body
from stitchmesh.yarnrelax.motion.moving_body import MovingBody
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.dynamics import YarnDynamics
from tests.yarnrelax.energies.test_body import ring, sphere

LEAF = YarnMaterial.named("leaf")
EXACT = replace(PRESETS["draft"], precision="float64", solver="dynamics")
RADIUS, GRAVITY, MU = 0.125, 981.0, 0.5
SLIP_LENGTH = MovingBody.slip_length * RADIUS
FLOOR = Mesh.from_polygons(np.array([[-40.0, 0, -40], [-40, 0, 40], [40, 0, 40], [40, 0, -40]]), [[0, 1, 2, 3]])


def moving(mesh: Mesh, times: list[float], velocity: tuple[float, float, float]) -> MovingMesh:
    """A mesh in motion at constant velocity [cm / s]."""
    frames = [replace(mesh, vertices=mesh.vertices + np.array(velocity) * time) for time in times]
    return MovingMesh.of_frames(frames, times)


def yarn_on_the_floor(load: float) -> YarnSet:
    """A straight yarn along z that presses the floor with a load [dyn / cm], where the floor carries the load."""
    stiffness = 2.0 * RADIUS * LEAF.k_contact
    x = brentq(lambda x: stiffness * (2 / x**3 - 2 * x) / RADIUS - load, 0.5, 1.0)
    points = np.stack([np.zeros(7), np.full(7, x * RADIUS), np.linspace(-1.0, 1.0, 7)], axis=1)
    return YarnSet.from_curves([points], closed=[False], radius=RADIUS)


def on_the_floor(times: list[float], velocity: tuple[float, float, float], angle: float) -> list[float]:
    """Mean x of the yarn in each frame; gravity leans by an angle from the normal of the floor, towards x."""
    pull = (GRAVITY * np.sin(angle), -GRAVITY * np.cos(angle), 0.0)
    yarns = yarn_on_the_floor(LEAF.mass_per_length * GRAVITY * np.cos(angle))
    body = MovingBody(moving(FLOOR, times, velocity), friction=MU)
    frames = follow_body(
        yarns, body, material=LEAF, quality=EXACT, device="cpu", terms=[Gravity(pull)], drag=0.0, run=QUIET
    )
    return [float(frame.yarns.points[:, 0].mean()) for frame in frames]


def test_a_moving_floor_accelerates_a_yarn_by_mu_g_until_the_yarn_has_its_speed() -> None:
    speed, times = 20.0, [0.0, 0.03, 0.05, 0.07]
    places = on_the_floor(times, (speed, 0.0, 0.0), 0.0)
    # friction grows over the slip length, which delays the motion by less than the time in which the floor covers it
    assert places[1] == pytest.approx(0.5 * MU * GRAVITY * times[1] ** 2, rel=4.0 * SLIP_LENGTH / speed / times[1])
    slips = [speed * time - place for time, place in zip(times, places, strict=True)]
    # the end: friction has taken the speed; an anchored yarn swings within the slip length
    assert slips[2:] == pytest.approx([speed**2 / (2.0 * MU * GRAVITY)] * 2, abs=2.0 * SLIP_LENGTH)


def test_a_yarn_slides_on_a_moving_slope_beyond_the_angle_of_friction() -> None:
    time = 0.05
    angle = np.arctan(1.4 * MU)
    fall = GRAVITY * (np.sin(angle) - MU * np.cos(angle))
    place = on_the_floor([0.0, time], (-10.0, 0.0, 0.0), float(angle))[1]
    # the floor moves uphill, so friction is full from the beginning, but for the time in which it covers a slip length
    late = MU * GRAVITY * np.cos(angle) * SLIP_LENGTH / 10.0
    assert place == pytest.approx(0.5 * fall * time**2, abs=late * time)


def ball_in_a_ring(velocity: tuple[float, float, float], times: list[float]) -> tuple[YarnSet, MovingMesh]:
    """A ring that touches a moving ball."""
    return ring(1.085, 0.3, 24, RADIUS), moving(sphere(1.0), times, velocity)


def follower(yarns: YarnSet, body: MovingBody) -> BodyFollower:
    still = replace(LEAF, k_global=0.0)
    return BodyFollower(FollowInputs(yarns, body, still, EXACT, (), device_named("cpu")))


def test_places_relative_to_a_body_of_constant_speed_are_those_on_a_body_at_rest() -> None:
    velocity, times = (1.0, -0.5, 0.25), [0.0, 0.01]
    places = []
    for speed in (np.zeros(3), np.array(velocity)):
        yarns, body = ball_in_a_ring(tuple(speed.tolist()), times)
        run = follower(yarns, MovingBody(body))
        model = run.simulation.model
        run.solver.velocity.assign(np.tile(speed / model.unit, (model.point_count, 1)))
        run.advance()
        places.append(run.yarns().points - speed * times[1])
    # the mesh moves along the chords of the same triangles; what is left is the tree in single precision, which decides
    # between features that are equally near
    np.testing.assert_allclose(places[1], places[0], atol=1e-6)
    assert np.abs(places[0] - yarns.points).max() > 1e-3


def test_a_body_at_rest_gives_what_a_still_body_gives() -> None:
    yarns, body = ball_in_a_ring((0.0, 0.0, 0.0), [0.0, 0.01])
    run = follower(yarns, MovingBody(body, friction=0.0))
    run.advance()
    still = replace(LEAF, k_global=0.0)
    simulation = YarnSimulation.start(yarns, still, EXACT, device_named("cpu"), [Body(body.mesh)])
    solver, loop = simulation.solver, RelaxationLoop(simulation, EXACT.tolerance)
    assert isinstance(solver, YarnDynamics)
    solver.clock.run_until(0.01)
    while solver.time < 0.01:
        loop.iterate(1)
    found = simulation.model.from_device(simulation.state.points)
    np.testing.assert_allclose(run.yarns().points, found, rtol=1e-12)  # rounding of two kernels


def test_a_body_carries_points_to_their_places_on_it() -> None:
    times = [0.0, 0.01]
    yarns, body = ball_in_a_ring((3.0, 2.0, 0.0), times)
    run = follower(yarns, MovingBody(body, carried=Pins(points=[2, 3])))
    run.advance()
    moved = run.yarns().points[[2, 3]] - yarns.points[[2, 3]]
    # a point is where the body was at the begin of the last time step, of at most 4e-4 s
    np.testing.assert_allclose(moved, np.tile([0.03, 0.02, 0.0], (2, 1)), atol=3.6 * 4e-4)


def test_a_resumed_run_has_the_bits_of_one_that_never_stopped(tmp_path: Path) -> None:
    yarns, body = ball_in_a_ring((20.0, 0.0, 0.0), [0.0, 0.005, 0.01, 0.015])
    options: dict[str, Any] = {"material": LEAF, "quality": EXACT, "device": "cpu", "terms": [Gravity()]}
    whole = list(follow_body(yarns, MovingBody(body), **options, run=QUIET))
    kept = replace(QUIET, checkpoints=Checkpoints(tmp_path, 1))
    begun = follow_body(yarns, MovingBody(body), **options, run=kept)
    assert [next(begun).number for _ in range(3)] == [0, 1, 2]  # the checkpoint is of frame 1
    begun.close()
    resumed = replace(kept, resume=tmp_path / CHECKPOINT)
    rest = list(follow_body(yarns, MovingBody(body), **options, run=resumed))
    assert [frame.number for frame in rest] == [2, 3]
    unbegun = follow_body(yarns, MovingBody(body), **options, run=replace(QUIET, resume=tmp_path / "new.smc"))
    assert next(unbegun).number == 0  # there is no checkpoint yet
    for found, expected in zip(rest, whole[2:], strict=True):
        np.testing.assert_array_equal(found.yarns.points, expected.yarns.points)
        assert {**found.report, "seconds": 0} == {**expected.report, "seconds": 0}
    with pytest.raises(ParameterError, match=r"body.friction is 0.1 and was 0.3; give it the same"):
        follow_body(yarns, MovingBody(body, friction=0.1), **options, run=resumed)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"drag": -1.0}, "got a drag of -1.0; expected a number from 0 to 100000"),
        ({"run": Run(start=ring(1.2, 0.0, 12, RADIUS))}, "follow_body, run: got start, which it does not obey"),
        ({"friction": -0.1}, "got a coefficient of friction of -0.1; expected a number from 0 to 2"),
    ],
)
def test_wrong_options_are_refused(options: dict[str, Any], message: str) -> None:
    yarns, body = ball_in_a_ring((0.0, 0.0, 0.0), [0.0, 0.01])
    with pytest.raises(ParameterError, match=message):
        follow_body(yarns, MovingBody(body, friction=options.pop("friction", 0.3)), **options)


def test_a_body_that_passes_into_yarn_is_an_error_that_names_the_frame() -> None:
    grown = [sphere(size) for size in (1.0, 1.0, 2.5)]
    body = MovingBody(MovingMesh.of_frames(grown, [0.0, 0.001, 0.011]), stiffness=1e-6)
    frames = follow_body(ring(1.2, 0.0, 12, RADIUS), body, material=LEAF, quality=EXACT, device="cpu", run=QUIET)
    with pytest.raises(
        SolverError, match=r"frame 2 \(0.011 s\): yarn 0 .* reaches inside the body; expected at most"
    ):
        list(frames)
