# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Live swatches: where they come to rest, how they move there, and what a session does with changes and errors."""

from __future__ import annotations

import dataclasses
import itertools
import threading

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.compute import device
from stitchmesh.compute.device import alone
from stitchmesh.errors import ParameterError, PatternError, SolverError
from stitchmesh.periodic.continuation import GROWTH, LENGTHENING, STRETCH
from stitchmesh.periodic.session.frames import Frame
from stitchmesh.periodic.session.incremental_relaxation import LiveSwatch
from stitchmesh.periodic.session.settings import SwatchSettings
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import Quality
from stitchmesh.yarn.tiling import instances
from stitchmesh.yarnrelax.linking.certificate import changed_pairs, doubled_linking

EXACT = Quality("float64", 3, 3, 12, 0.2, 1e-4, 20_000)
"""Fine enough for two ways to one state of rest to end within 1e-5 of each other's sizes."""
PLAIN = sm.parse_pattern("round 1: k1")
"""One loop, which has one state of rest; where several loops may buckle against one another there are many."""
SAFETY = 60.0
"""Seconds after which a test that waits fails; what it waits for takes well under one."""
CLOSE = 1e-4
"""Relative difference of sizes and energies of one state of rest reached in two ways at ``EXACT``, with room."""
GENTLE = 1.0 + 1e-9
"""Rounding of a product of two ratios."""


def session(pattern="stockinette", **given) -> sm.SwatchSession:
    return sm.SwatchSession(pattern, **({"quality": "draft", "device": "cpu", "relax_cell": True} | given))


def live(pattern="stockinette", *, relax_cell=True, quality="draft", **options) -> LiveSwatch:
    settings = SwatchSettings(pattern, None, relax_cell, SwatchOptions(**options))
    return LiveSwatch(settings, sm.quality.quality_named(quality), "cpu", 0.0)


def to_rest(swatch: LiveSwatch, settings: SwatchSettings | None = None, *, most=500) -> list[Frame]:
    """Frames on the way to rest, the one before the change first."""
    frames = [swatch.frame]
    if settings is not None:
        swatch.take(settings, 0.0)
    while not swatch.idle:
        swatch.advance()
        frames.append(swatch.frame)
        assert len(frames) < most
    return frames


def assert_same_rest(frame: Frame, expected: sm.Swatch) -> None:
    assert frame.report["at_rest"]
    assert frame.size == pytest.approx((expected.report["width"], expected.report["height"]), rel=CLOSE)
    assert frame.report["energy"] == pytest.approx(expected.report["energy"], rel=CLOSE)
    np.testing.assert_allclose(frame.yarns.radius, expected.yarns.radius, rtol=1e-6)
    np.testing.assert_allclose(frame.yarns.rest_length, expected.yarns.rest_length, rtol=1e-6)


@pytest.mark.parametrize(
    "pattern, before, change",
    [
        (PLAIN, {}, {"gamma": 1.3}),
        (PLAIN, {"gamma": 1.3}, {"gamma": 1.0}),
        (PLAIN, {}, {"period": (0.94, None)}),
        (PLAIN, {"period": (0.94, None)}, {"period": (None, None)}),
        (PLAIN, {}, {"yarn_radius": 0.1}),
        (PLAIN, {}, {"yarn_radius": 0.1, "loop_length": 4.167}),
        (PLAIN, {}, {"material": sm.YarnMaterial.named("kaldor-simulation")}),
        (PLAIN, {}, {"relax_cell": False}),
        (PLAIN, {}, {"rest_lengths": sm.RestLengths(factor=0.8)}),
        ("plain", {}, {"rest_lengths": sm.RestLengths(warp=0.85)}),
        ("plain", {}, {"spacing": 0.5, "yarn_radius": 0.11}),
        ("plain", {}, {"period": (1.1, None), "gamma": 1.1}),
        ("plain", {"gamma": 1.1}, {"pattern": PLAIN}),
        ("garter", {}, {"pattern": "plain"}),
    ],
)
def test_a_change_ends_where_a_swatch_of_the_same_options_does(pattern, before, change):
    with session(pattern, quality=EXACT, **before) as running:
        running.wait_until_rest(SAFETY)
        running.set(**change)
        frame = running.wait_until_rest(SAFETY)
    given = {"pattern": pattern, "quality": EXACT, "device": "cpu", "relax_cell": True} | before | change
    assert_same_rest(frame, sm.swatch(**given))


def test_the_first_relaxation_is_that_of_the_swatch_to_the_last_bit():
    with session("rib2x2") as running:
        frame = running.wait_until_rest(SAFETY)
    expected = sm.swatch("rib2x2", quality="draft", device="cpu", relax_cell=True)
    assert np.array_equal(frame.yarns.points, expected.yarns.points)
    assert frame.report["iteration"] == expected.report["iterations"]


def test_gamma_grows_in_steps_and_the_yarn_keeps_its_radius():
    swatch = live(relax_cell=False)
    to_rest(swatch)
    frames = to_rest(swatch, SwatchSettings("stockinette", None, False, SwatchOptions(gamma=1.6)))
    reached = np.array([frame.report["gamma"] for frame in frames])
    assert reached[-1] == pytest.approx(1.6, rel=1e-12)
    assert (np.diff(reached) >= 0.0).all() and (reached[1:] / reached[:-1] <= GROWTH * GENTLE).all()
    assert np.ptp([frame.yarns.radius for frame in frames]) < 1e-12
    widths = np.array([frame.size[0] for frame in frames])
    np.testing.assert_allclose(widths * reached, widths[0], rtol=1e-6)  # single precision


@pytest.mark.parametrize(
    "change, measure, limit",
    [
        ({"yarn_radius": 0.2, "loop_length": 5.0}, lambda frame: frame.yarns.radius, GROWTH),
        ({"period": (1.5, 1.2)}, lambda frame: np.array(frame.size), STRETCH),
        ({"rest_lengths": sm.RestLengths(factor=0.75)}, lambda frame: frame.yarns.rest_length, LENGTHENING),
    ],
)
def test_no_frame_is_more_than_a_step_from_the_one_before(change, measure, limit):
    swatch = live(relax_cell=False, loop_length=5.0)
    to_rest(swatch)
    options = SwatchOptions(**({"loop_length": 5.0} | change))
    frames = to_rest(swatch, SwatchSettings("stockinette", None, False, options))
    values = [measure(frame) for frame in frames]
    ratios = np.array([after / before for before, after in itertools.pairwise(values)])
    largest = np.abs(np.log(ratios)).max()
    assert largest > 0.5 * np.log(limit)  # it did move
    assert largest <= np.log(limit) + 1e-6  # single precision rounds periods


def test_a_swatch_that_leaned_stands_up_again_where_shear_is_held():
    swatch = live(PLAIN, relax_cell=sm.RelaxCell(), quality=EXACT)
    to_rest(swatch)
    moved = swatch.state
    sheared = moved.yarns.lattice.periods + np.array([[0, 0, 0], [0.35, 0, 0]])
    points = moved.yarns.points + 0.35 * moved.yarns.points[:, 1:2] / sheared[1, 1] * [1, 0, 0]
    yarns = dataclasses.replace(moved.yarns, points=points, lattice=sm.Lattice(sheared))
    swatch.state = dataclasses.replace(moved, yarns=yarns)
    frames = to_rest(swatch, SwatchSettings(PLAIN, None, True, SwatchOptions()))
    assert len(frames) > 4
    assert frames[-1].lattice.periods[1, 0] == pytest.approx(0.0, abs=1e-9)
    assert_same_rest(frames[-1], sm.swatch(PLAIN, quality=EXACT, device="cpu", relax_cell=True))


def test_a_newer_change_takes_the_place_of_an_older_one_midway():
    swatch = live()
    to_rest(swatch)
    swatch.take(SwatchSettings("stockinette", None, True, SwatchOptions(gamma=3.0)), 0.0)
    for _ in range(5):
        swatch.advance()
    midway = swatch.frame.report["gamma"]
    frames = to_rest(swatch, SwatchSettings("stockinette", None, True, SwatchOptions(gamma=1.0)))
    assert 1.0 < midway < 3.0
    assert max(frame.report["gamma"] for frame in frames) == midway
    assert frames[-1].report["gamma"] == pytest.approx(1.0)


def test_of_many_changes_the_last_one_counts():
    with session() as running:
        for gamma in np.linspace(1.0, 1.3, 50):
            running.set(gamma=float(gamma))
        running.set(pattern="garter")
        running.set(pattern="stockinette", gamma=1.1)
        frame = running.wait_until_rest(SAFETY)
    assert frame.report["gamma"] == pytest.approx(1.1)
    assert frame.yarns.yarn_count == sm.swatch("stockinette", quality="draft", device="cpu").yarns.yarn_count


def test_a_new_chart_is_seen_as_drawn_first_and_keeps_the_options():
    swatch = live(gamma=1.2, yarn_radius=0.1)
    to_rest(swatch)
    swatch.take(SwatchSettings("garter", None, True, SwatchOptions(gamma=1.2, yarn_radius=0.1)), 0.0)
    assert swatch.frame.report["residual"] is None and not swatch.frame.report["at_rest"]
    assert swatch.frame.yarns.radius == pytest.approx(0.1)
    assert to_rest(swatch)[-1].report["gamma"] == pytest.approx(1.2)


def test_yarn_too_thick_to_be_drawn_grows_from_what_can_be():
    swatch = live(loop_length=3.0)
    first = swatch.frame
    assert first.report["gamma"] < 1.0 and first.yarns.radius == pytest.approx(0.125)
    assert to_rest(swatch)[-1].report["gamma"] == pytest.approx(1.0)


def test_colours_alone_leave_the_state_as_it_lies():
    def striped(colour):
        return sm.parse_pattern(f"rounds 1-2 yarn 0: k2\nrounds 3-4 yarn {colour}: k2")

    swatch = live(striped(1))
    before = to_rest(swatch)[-1]
    frames = to_rest(swatch, SwatchSettings(striped(2), None, True, SwatchOptions()))
    assert swatch.frame.number == before.number + 1 and len(frames) == 1
    assert np.array_equal(swatch.frame.yarns.points, before.yarns.points) and swatch.frame.report["at_rest"]
    assert set(before.yarns.colour) == {0, 1} and set(swatch.frame.yarns.colour) == {0, 2}


def test_what_changes_nothing_is_not_relaxed_again():
    with session() as running:
        rest = running.wait_until_rest(SAFETY)
        running.set(gamma=1.0, relax_cell=True)
        running.set(pattern="stockinette")
        running.set(relax_cell=sm.RelaxCell(shear=False), material=rest_material())
        assert running.wait_until_rest(SAFETY) is rest


def rest_material() -> sm.YarnMaterial:
    """What the default material is for yarn of the default radius."""
    return sm.YarnMaterial.named("stitchmesh")


def test_a_bad_pattern_is_the_error_of_a_frame_and_a_later_change_mends_it():
    with session() as running:
        rest = running.wait_until_rest(SAFETY)
        running.set(pattern="no-such-pattern", gamma=1.1)
        with pytest.raises(ParameterError, match="no-such-pattern"):
            running.wait_until_rest(SAFETY)
        broken = running.frame
        assert isinstance(broken.error, ParameterError) and not broken.report["running"]
        assert np.array_equal(broken.yarns.points, rest.yarns.points)
        running.set(pattern="stockinette")
        mended = running.wait_until_rest(SAFETY)
    assert mended.error is None and mended.report["gamma"] == pytest.approx(1.1)


def test_a_target_without_room_ends_before_the_step_too_far_and_a_later_change_mends_it():
    with session("plain", relax_cell=False) as running:
        rest = running.wait_until_rest(SAFETY)
        running.set(period=(0.13, 0.13))
        with pytest.raises(SolverError, match=r"yarns cannot be separated on the path.*larger repeat"):
            running.wait_until_rest(SAFETY)
        assert 0.13 < running.frame.size[0] < rest.size[0]
        running.set(period=(None, None))
        mended = running.wait_until_rest(SAFETY)
        assert mended.report["gamma"] == 1.0 and mended.size == pytest.approx(rest.size, rel=1e-6)  # single precision


def test_a_state_that_cannot_reach_the_target_starts_again_from_generated_yarns(monkeypatch):
    swatch = live("plain")
    rest = to_rest(swatch)[-1]
    begin = LiveSwatch._start_loop
    monkeypatch.setattr(LiveSwatch, "_start_loop", lambda *_given: solver_error("yarn 3: too close"))
    swatch.take(SwatchSettings("plain", sm.YarnMaterial.named("leaf"), True, SwatchOptions()), 0.0)
    with pytest.raises(SolverError, match="yarn 3: yarns cannot be separated"):
        swatch.advance()
    assert np.array_equal(swatch.state.yarns.points, rest.yarns.points)
    swatch.advance()
    assert np.array_equal(swatch.frame.yarns.points, swatch.generated.yarns.points)
    monkeypatch.setattr(LiveSwatch, "_start_loop", begin)
    assert to_rest(swatch)[-1].report["at_rest"]


def solver_error(text: str) -> None:
    raise SolverError(text)


def test_what_is_no_error_of_ours_reaches_who_waits(monkeypatch):
    with session() as running:
        running.wait_until_rest(SAFETY)
        monkeypatch.setattr(LiveSwatch, "take", lambda *_given, **_named: 1 // 0)
        running.set(gamma=1.1)
        with pytest.raises(ZeroDivisionError):
            running.wait_until_rest(SAFETY)


def test_values_out_of_bounds_are_refused_at_once_and_change_nothing():
    with session() as running:
        with pytest.raises(ParameterError, match=r"gamma: got -1; expected 0\.1 to 10"):
            running.set(gamma=-1)
        with pytest.raises(ParameterError, match=r"session: got a change of 'quality'; expected one of columns, gamma"):
            running.set(quality="standard")
        assert running.wait_until_rest(SAFETY).report["gamma"] == 1.0
    with pytest.raises(PatternError, match="row 1"):
        session(sm.parse_pattern("round 1: k2 yo\nround 2: k3"))
    with pytest.raises(ParameterError, match="device: got 'abacus'"):
        session(device="abacus")


def test_a_restart_begins_with_generated_yarns():
    with session() as running:
        first = running.wait_until_rest(SAFETY)
        running.set(gamma=1.3)
        running.wait_until_rest(SAFETY)
        running.set(gamma=1.0)
        running.restart()
        again = running.wait_until_rest(SAFETY)
    assert np.array_equal(again.yarns.points, first.yarns.points)


def test_closing_midway_ends_the_thread_and_wakes_who_waits():
    running = session("honeycomb", quality="standard")
    told: list[Exception] = []

    def wait() -> None:
        try:
            running.wait_until_rest(SAFETY)
        except SolverError as error:
            told.append(error)

    waiting = threading.Thread(target=wait)
    waiting.start()
    running.close()
    running.close()
    waiting.join(SAFETY)
    assert "closed before" in str(told[0])
    assert "swatch session" not in [thread.name for thread in threading.enumerate()]
    assert running.wait_for_frame(SAFETY) is None
    assert np.isfinite(running.frame.yarns.points).all()
    with pytest.raises(ParameterError, match="after the session was closed"):
        running.set(gamma=1.1)


def test_sessions_side_by_side_end_in_the_bits_that_each_ends_in_alone():
    names = ("rib2x2", "garter")
    singly = [to_rest(live(name))[-1].yarns.points for name in names]
    with session(names[0]) as first, session(names[1]) as second:
        together = [running.wait_until_rest(SAFETY).yarns.points for running in (first, second)]
    assert all(np.array_equal(*pair) for pair in zip(singly, together, strict=True))


def test_threads_launch_in_the_order_in_which_they_ask():
    turns: list[int] = []
    threads = [threading.Thread(target=lambda number=number: take_turn(turns, number)) for number in range(8)]
    with alone(), alone():  # a thread may ask again during its turn
        for count, thread in enumerate(threads, start=2):
            thread.start()
            while len(device._queue) < count:
                pass
        assert turns == []
    for thread in threads:
        thread.join(SAFETY)
    assert turns == list(range(8))


def take_turn(turns: list[int], number: int) -> None:
    with alone():
        turns.append(number)


def test_waiting_too_short_says_so():
    with session("honeycomb", quality=EXACT) as running, pytest.raises(SolverError, match=r"in 0\.01 s; wait longer"):
        running.wait_until_rest(0.01)


def test_iterations_used_up_are_not_called_rest(caplog):
    with session("honeycomb", quality=dataclasses.replace(EXACT, max_iterations=40)) as running:
        frame = running.wait_until_rest(SAFETY)
    assert not frame.report["at_rest"] and not frame.report["running"]
    assert "swatch is not at rest: residual" in caplog.text


def test_frames_ascend_and_do_not_change():
    frames: list[Frame] = []
    with session() as running:
        frames.append(running.frame)
        kept = running.frame.yarns.points.copy()
        running.set(gamma=1.4)
        while (frame := running.wait_for_frame(SAFETY, after=frames[-1].number)) is not None:
            frames.append(frame)
            if not frame.report["running"]:
                break
    assert (np.diff([frame.number for frame in frames]) > 0).all()
    assert np.array_equal(frames[0].yarns.points, kept)
    with pytest.raises(ValueError, match="read-only"):
        frames[-1].yarns.points[0] = 0.0
    with pytest.raises(TypeError):
        frames[-1].report["gamma"] = 2.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        frames[-1].number = 0


def test_linking_is_kept_by_every_change():
    swatch = live("rib1x1")
    for options in ({"gamma": 1.4}, {"gamma": 1.4, "period": (1.2, 0.9)}, {"rest_lengths": sm.RestLengths(factor=1.3)}):
        to_rest(swatch, SwatchSettings("rib1x1", None, True, SwatchOptions(**options)))
        linking = [doubled_linking(yarns, device="cpu") for yarns in (swatch.first.yarns, swatch.state.yarns)]
        assert len(changed_pairs(*linking)) == 0


def test_yarns_that_passed_through_each_other_are_generated_again(monkeypatch):
    swatch = live()
    relaxation = "stitchmesh.periodic.session.incremental_relaxation"
    monkeypatch.setattr(f"{relaxation}.refuse_pull_through", lambda *_yarns: solver_error("linking number changed"))
    with pytest.raises(SolverError, match="linking number changed"):
        to_rest(swatch)
    assert np.array_equal(swatch.state.yarns.points, swatch.generated.yarns.points)


def test_curves_of_a_frame_go_on_in_the_next_copy():
    frame = live("rib2x2").frame
    shifts = instances(frame.lattice, 2, 1)
    for curve, step in zip(frame.curves(3), frame.yarns.lattice_step, strict=True):
        np.testing.assert_allclose(curve[-1], curve[0] + frame.lattice.shift(step), atol=1e-12)
    along = np.flatnonzero((frame.yarns.lattice_step == [1, 0]).all(axis=1))
    curve = frame.curves(3)[along[0]]
    np.testing.assert_allclose(curve[0] + shifts[1], curve[-1] + shifts[0], atol=1e-12)
