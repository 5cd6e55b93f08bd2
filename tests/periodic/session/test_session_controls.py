# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Controls of a session: stop, step, start, reset, iterations per frame, and another quality or solver."""

from __future__ import annotations

import dataclasses
import itertools
import threading

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError, PatternError, SolverError
from stitchmesh.periodic.gauge import swatch_report
from stitchmesh.periodic.session.frames import Frame
from stitchmesh.periodic.session.incremental_relaxation import LiveSwatch
from stitchmesh.quality import PRESETS, Quality
from tests.periodic.free_cells import FREE
from tests.periodic.session.test_session import PLAIN, SAFETY, session

pytestmark = pytest.mark.usefixtures("first_state")
DRAFT = PRESETS["draft"]
EXACT = Quality("float64", 3, 3, 12, 0.2, 1e-4, 20_000, largest_change=1e-5)
"""As fine as ``draft`` in control points, and so accurate that two paths to one state agree within ``CLOSE``."""
CLOSE = 1e-4
"""Bound on the relative difference of sizes and energies of one relaxed state reached on two paths at ``EXACT``."""


def assert_same_bits(frame: Frame, other: Frame) -> None:
    assert np.array_equal(frame.yarns.points, other.yarns.points)
    assert np.array_equal(frame.lattice.periods, other.lattice.periods)


def test_steps_have_the_same_bits_as_one_run_of_as_many_iterations():
    """126 iterations pass several increments of the change, and end within an assessment interval."""
    with session("rib1x1", stopped=True, iterations_per_frame=126) as whole, session("rib1x1", stopped=True) as parts:
        for running in (whole, parts):
            running.set(period=(0.8, None))
        parts.iterations_per_frame = 7
        at_once, stepped = whole.step(timeout=SAFETY), parts.step(18, timeout=SAFETY)
        assert at_once.report["iteration"] == stepped.report["iteration"] == 126
        assert_same_bits(at_once, stepped)
        for running in (whole, parts):
            running.start()
        rest = [running.wait_until_rest(SAFETY) for running in (whole, parts)]
    assert_same_bits(*rest)
    assert rest[0].report["at_rest"]


def test_each_step_moves_the_yarns_and_makes_one_frame():
    with session("rib1x1", stopped=True, iterations_per_frame=1) as running:
        frames = [running.frame, *(running.step(timeout=SAFETY) for _ in range(45))]
    assert [frame.number for frame in frames] == list(range(1, 47))
    assert [frame.report["iteration"] for frame in frames] == list(range(46))
    for before, after in itertools.pairwise(frames):
        assert np.abs(after.yarns.points - before.yarns.points).max() > 0.0
    assert not any(frame.report["running"] for frame in frames)
    # the residual is that of the last assessment
    assert len({frame.report["residual"] for frame in frames[20:40]}) == 1


def test_a_stopped_session_makes_no_frames_until_it_is_started():
    with session("honeycomb") as running:
        running.wait_for_frame(SAFETY, after=1)
        running.stop()
        assert running.stopped
        stopped = running.step(timeout=SAFETY)
        assert not stopped.report["running"] and not stopped.report["at_rest"]
        assert running.wait_for_frame(0.05, after=stopped.number) is None
        with pytest.raises(SolverError, match="did not come to rest: it is stopped; start it first"):
            running.wait_until_rest(SAFETY)
        running.start()
        assert not running.stopped
        assert running.wait_for_frame(SAFETY, after=stopped.number).report["running"]


def test_a_step_at_rest_does_nothing():
    with session(PLAIN) as running:
        rest = running.wait_until_rest(SAFETY)
        assert running.step(3, timeout=SAFETY) is rest
        running.start()
        assert running.wait_until_rest(SAFETY) is rest


def test_a_change_is_taken_while_the_session_is_stopped():
    with session(PLAIN, stopped=True) as running:
        running.set(pattern="garter")
        drawn = running.wait_for_frame(SAFETY, after=1)
        assert drawn.report["residual"] is None and not drawn.report["running"]
        assert drawn.yarns.yarn_count == 2
        running.set(pattern="no-such-pattern")
        with pytest.raises(ParameterError, match="no-such-pattern"):
            running.step(timeout=SAFETY)


def test_a_reset_returns_to_the_first_settings_and_bits():
    with session("rib1x1", stopped=True, gamma=1.1) as running:
        first = running.frame
        running.set(gamma=1.4, pattern="garter", relax_cell=False, quality=EXACT)
        running.step(9, timeout=SAFETY)
        running.reset()
        again = running.wait_for_frame(SAFETY)
        assert again is None or not again.report["running"]
        assert_same_bits(running.frame, first)
        assert running.frame.report["gamma"] == first.report["gamma"] and running.frame.report["iteration"] == 0
        running.start()
        rest = running.wait_until_rest(SAFETY)
        with session("rib1x1", gamma=1.1) as other:
            assert_same_bits(other.wait_until_rest(SAFETY), rest)


def test_another_quality_while_it_runs_ends_where_it_would_have_begun():
    """The other quality has more control points."""
    with session(PLAIN, iterations_per_frame=5) as running:
        running.wait_for_frame(SAFETY, after=1)
        running.set(quality="standard")
        frame = running.wait_until_rest(SAFETY)
    expected = sm.swatch(PLAIN, quality="standard", device="cpu", **FREE)
    assert frame.report["at_rest"] and len(frame.yarns.points) == len(expected.yarns.points)
    # The size at rest is uncertain by a few times the tolerance (docs/accuracy.md).
    bound = 4 * PRESETS["standard"].tolerance
    assert frame.size == pytest.approx((expected.report["width"], expected.report["height"]), rel=bound)
    assert frame.report["energy"] == pytest.approx(expected.report["energy"], rel=bound)


def test_a_quality_with_the_same_control_points_continues_from_the_present_state():
    with session(PLAIN) as running:
        rest = running.wait_until_rest(SAFETY)
        running.set(quality=dataclasses.replace(DRAFT, tolerance=DRAFT.tolerance / 10))
        finer = running.wait_until_rest(SAFETY)
        moved = np.abs(finer.yarns.points - rest.yarns.points).max()
        assert 0.0 < moved < 0.1  # less than the distance from the drawing, a few tenths of a centimetre
        running.set(quality="draft")
        assert running.wait_until_rest(SAFETY).report["at_rest"]


@pytest.mark.nightly
def test_another_solver_while_it_runs_ends_in_the_same_state():
    with session(PLAIN, relax_cell=False, quality=EXACT, iterations_per_frame=5) as running:
        running.wait_for_frame(SAFETY, after=1)
        running.set(solver="dynamics")
        moved = running.wait_until_rest(SAFETY)
        running.restart()
        running.set(solver="quasistatic")
        still = running.wait_until_rest(SAFETY)
    assert moved.report["at_rest"] and still.report["at_rest"]
    # dynamics stays near a symmetric state, which is a saddle; Newton's method leaves it, to a slightly smaller energy
    assert moved.report["energy"] == pytest.approx(still.report["energy"], rel=0.01)


def test_solvers_and_counts_that_are_impossible_are_refused_at_once():
    with session(PLAIN) as running:
        rest = running.wait_until_rest(SAFETY)
        with pytest.raises(ParameterError, match="solver: got 'newton'; expected one of quasistatic, dynamics"):
            running.set(solver="newton")
        with pytest.raises(ParameterError, match="solver: got dynamics for a free cell, which has no mass to move"):
            running.set(solver="dynamics")
        with pytest.raises(ParameterError, match="quality: got 'fine'; expected one of draft"):
            running.set(quality="fine")
        with pytest.raises(ParameterError, match="iterations per frame: got 0; expected at least 1"):
            running.iterations_per_frame = 0
        with pytest.raises(ParameterError, match="step: got 0; expected at least 1"):
            running.step(0)
        assert running.iterations_per_frame == 20 and running.wait_until_rest(SAFETY) is rest
    with pytest.raises(ParameterError, match="iterations per frame: got -3"):
        session("rib1x1", iterations_per_frame=-3)
    with pytest.raises(PatternError, match="floats behind 8 stitches"):
        session(sm.parse_pattern("chart colours:\n000000001\n"))


def test_a_closed_session_refuses_every_request_in_one_line():
    running = session(PLAIN)
    running.close()
    requests = {"step": running.step, "start": running.start, "stop": running.stop, "reset": running.reset,
                "restart": running.restart, "change": lambda: running.set(gamma=1.1)}  # fmt: skip
    for name, request in requests.items():
        expected = f"session: got a {name} after the session was closed; start another session"
        with pytest.raises(ParameterError, match=f"^{expected}$"):
            request()
    assert np.isfinite(running.frame.yarns.points).all()


def test_a_step_that_takes_too_long_is_reported_and_goes_on():
    with session("honeycomb", quality=EXACT, stopped=True, iterations_per_frame=200) as running:
        with pytest.raises(SolverError, match=r"the step did not end: not within 0\.001 s; wait longer"):
            running.step(timeout=0.001)
        frame = running.wait_for_frame(SAFETY, after=1)
        assert frame.report["iteration"] == 200


@pytest.mark.parametrize(
    ("pattern", "change"), [("rib2x2", {"material": sm.YarnMaterial.named("leaf")}), ("twill-2x1", {"gamma": 1.3})]
)
def test_measures_of_the_frame_at_rest_are_those_of_the_report_of_its_swatch(pattern, change):
    with session(pattern) as running:
        running.set(**change)
        frame = running.wait_until_rest(SAFETY)
    report = swatch_report(frame.yarns, frame.fabric, frame.material, DRAFT, frame.report["energy"], "cpu")
    measures = dataclasses.asdict(frame.measures)
    assert measures == {name: report[name] for name in measures}
    mass = frame.material.mass_per_length * frame.yarns.lengths.sum()
    # The rounding error of the scaling by gamma and back.
    assert frame.measures.areal_density == pytest.approx(mass / frame.lattice.area, rel=1e-12)
    assert frame.measures.gauge.stitches * frame.size[0] == pytest.approx(10.0 * frame.measures.wales, rel=1e-12)


def test_requested_steps_are_made_as_waited_for_steps():
    with session("rib1x1", stopped=True) as asked, session("rib1x1", stopped=True) as waited:
        asked.request_steps(2)
        asked.request_steps()
        frame = asked.step(timeout=SAFETY)
        assert_same_bits(frame, waited.step(4, timeout=SAFETY))
    with pytest.raises(ParameterError, match="got a step after the session was closed"):
        asked.request_steps()
    with pytest.raises(ParameterError, match="step: got 0"):
        waited.request_steps(0)


@pytest.mark.parametrize("change", ["restart", "reset"])
def test_a_step_after_a_change_is_not_used_up_by_the_frame_before_the_change(monkeypatch, change):
    """The change and the step arrive while the worker iterates for the frame before."""
    entered, release, advance = threading.Event(), threading.Event(), LiveSwatch.advance

    def slow_advance(swatch, most):
        entered.set()
        assert release.wait(SAFETY)
        return advance(swatch, most)

    monkeypatch.setattr(LiveSwatch, "advance", slow_advance)
    with session("rib1x1", iterations_per_frame=5) as running:
        assert entered.wait(SAFETY)
        getattr(running, change)()
        running.request_steps(2)
        release.set()
        frame = running.wait_for_frame(SAFETY)
        while frame is not None and frame.report["iteration"] < 10:
            frame = running.wait_for_frame(SAFETY, after=frame.number)
        assert frame is not None and running.frame.report["iteration"] == 10
