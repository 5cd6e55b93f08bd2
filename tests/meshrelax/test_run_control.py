# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxations that are watched, paused, stepped and stopped."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.meshrelax import RelaxedMesh, relax_mesh
from stitchmesh.run import Run
from stitchmesh.run_control import RunControl, Snapshot
from stitchmesh.time_limit import TimeLimit, limited_to
from tests.meshrelax.fabrics import grid_fabric, rectangle_points

SAFETY = 120.0  # Time after which a test that blocks fails [s]; a test that passes waits for a much shorter time.


def uneven() -> StitchMesh:
    """Knit stitches on a rectangle, with wales that are narrow at the left and wide at the right."""
    points = rectangle_points(12, 8, 6.0, 4.0).copy()
    points[:, :, 0] = 6.0 * (points[:, :, 0] / 6.0) ** 1.5
    return grid_fabric(points)


@pytest.fixture(scope="module")
def surface() -> Mesh:
    return grid_fabric(rectangle_points(3, 2, 6.0, 4.0))


@pytest.fixture(scope="module")
def plain(surface: Mesh) -> RelaxedMesh:
    return relax_mesh(uneven(), surface=surface)


def test_the_snapshots_lead_from_the_start_to_the_result(surface: Mesh, plain: RelaxedMesh):
    shown: list[Snapshot[StitchMesh]] = []
    control = RunControl(shown.append, seconds=0.0)
    made = relax_mesh(uneven(), surface=surface, run=Run(control=control))
    relaxed, report = made.fabric, made.report
    assert np.array_equal(relaxed.vertices, plain.fabric.vertices) and not report.stopped
    assert shown[0].iteration == 0 and shown[0].state.stretch is not None
    np.testing.assert_allclose(shown[0].state.vertices, uneven().vertices, atol=1e-9)
    assert [one.iteration for one in shown] == sorted({one.iteration for one in shown})


def test_a_stopped_relaxation_returns_the_state_that_was_shown_last(
    surface: Mesh, plain: RelaxedMesh, caplog: pytest.LogCaptureFixture
) -> None:
    shown: list[Snapshot[StitchMesh]] = []
    seen = threading.Semaphore(0)

    def watch(snapshot: Snapshot[StitchMesh]) -> None:
        shown.append(snapshot)
        seen.release()

    control, results = RunControl(watch, seconds=1e9, paused=True), []
    work = lambda: results.append(relax_mesh(uneven(), surface=surface, run=Run(control=control)))  # noqa: E731
    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    assert seen.acquire(timeout=SAFETY)
    control.step()
    assert seen.acquire(timeout=SAFETY)
    control.stop()
    thread.join(SAFETY)
    (made,) = results
    relaxed, report = made.fabric, made.report
    assert [one.iteration for one in shown] == [0, 1]
    assert np.array_equal(relaxed.vertices, shown[1].state.vertices)
    assert report.stopped and not report.converged and report.iterations == 1 < plain.report.iterations
    assert not caplog.records


def test_a_relaxation_whose_time_is_over_is_the_one_with_as_many_iterations(surface: Mesh) -> None:
    ticks = iter(range(1000))
    with limited_to(TimeLimit(4.0, lambda: float(next(ticks)))):
        made = relax_mesh(uneven(), surface=surface)
        ended, report = made.fabric, made.report
    again = relax_mesh(uneven(), surface=surface, max_iterations=report.iterations).fabric
    assert report.stopped and report.iterations > 0
    np.testing.assert_array_equal(ended.vertices, again.vertices)
