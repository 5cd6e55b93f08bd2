# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Live swatches: their relaxed states, the steps to these states, and how a session handles changes and errors."""

from __future__ import annotations

import dataclasses
import itertools
import threading

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError, PatternError, SolverError
from stitchmesh.linking.certificate import changed_pairs, doubled_linking
from stitchmesh.periodic.relaxation.continuation import GROWTH, LENGTHENING, STRETCH
from stitchmesh.periodic.session.frames import Frame
from stitchmesh.periodic.session.incremental_relaxation import LiveSwatch
from stitchmesh.periodic.session.settings import SwatchSettings
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import Quality
from tests.nightly import at_night
from tests.periodic.free_cells import FREE, free_swatch

pytestmark = pytest.mark.usefixtures("first_state")
EXACT = Quality("float64", 3, 3, 12, 0.2, 1e-6, 20_000, largest_change=1e-6)
"""Fine enough that two different paths to one relaxed state end in sizes that agree within 1e-5."""
PLAIN = sm.parse_pattern("round 1: k1")
"""A cell of one loop, which has few relaxed states. Cells of several loops can buckle and have many relaxed states."""
SAFETY = 60.0
"""Seconds after which a waiting test fails; the event that it waits for takes well under one second."""
CLOSE, STATES = 1e-4, 0.015
"""Bound on the relative difference of sizes and energies of one relaxed state reached on two paths at ``EXACT``, and of
the states of a cell of one loop. Its energy has two minima, which two paths can reach."""
SLID = 1e-3
"""The same for a weave: its yarns lie at other places of their samples, because they slide along themselves."""


def session(pattern="stockinette", **given) -> sm.SwatchSession:
    return sm.SwatchSession(pattern, **({"quality": "draft", "device": "cpu"} | FREE | given))


def live_swatch(pattern="stockinette", *, relax_cell=True, quality="draft", **options) -> LiveSwatch:
    return LiveSwatch(settings_of(pattern, relax_cell, quality, **options), "cpu", 0.0)


def settings_of(pattern="stockinette", relax_cell=True, quality="draft", *, material=None, **options) -> SwatchSettings:
    quality = sm.quality.quality_named(quality)
    chosen = SwatchOptions(relax_cell=relax_cell, relaxation="frictionless", **options)
    return SwatchSettings(pattern, material, chosen, quality)


def to_rest(swatch: LiveSwatch, settings: SwatchSettings | None = None, *, most=500) -> list[Frame]:
    """All frames until the swatch is at rest; the first is the frame before the change."""
    frames = [swatch.frame]
    if settings is not None:
        swatch.take(settings, 0.0)
    while not swatch.idle:
        swatch.advance()
        swatch.publish()
        frames.append(swatch.frame)
        assert len(frames) < most
    return frames


def assert_same_rest(frame: Frame, expected: sm.Swatch, close: float = CLOSE) -> None:
    assert frame.report["at_rest"]
    assert frame.size == pytest.approx((expected.report["width"], expected.report["height"]), rel=close)
    assert frame.report["energy"] == pytest.approx(expected.report["energy"], rel=close)
    np.testing.assert_allclose(frame.yarns.radius, expected.yarns.radius, rtol=1e-6)
    np.testing.assert_allclose(frame.yarns.rest_length, expected.yarns.rest_length, rtol=1e-6)


@pytest.mark.parametrize(
    "pattern, before, change",
    [
        # size of the yarn, size of the cell, load, rest length, chart
        (PLAIN, {"period": (0.94, None)}, {"period": (None, None)}),
        ("plain", {}, {"rest_lengths": sm.RestLengths(warp=0.85)}),
        ("garter", {}, {"pattern": "plain"}),
        *at_night(
            (PLAIN, {}, {"gamma": 1.3}),
            (PLAIN, {}, {"blocked": 30.0}),
            (PLAIN, {}, {"yarn_radius": 0.1, "loop_length": 4.167}),
            (PLAIN, {}, {"material": sm.YarnMaterial.named("kaldor-simulation")}),
            (PLAIN, {}, {"relax_cell": False}),
            (PLAIN, {}, {"unsupported": True}),
            (PLAIN, {"blocked": 30.0}, {"blocked": None}),
            ("plain", {}, {"spacing": 0.5, "yarn_radius": 0.11}),
            ("plain", {"gamma": 1.1}, {"pattern": PLAIN}),
        ),
    ],
)
def test_a_change_ends_in_the_state_of_a_swatch_with_the_same_options(pattern, before, change):
    with session(pattern, quality=EXACT, **before) as running:
        running.wait_until_rest(SAFETY)
        running.set(**change)
        frame = running.wait_until_rest(SAFETY)
    given = {"pattern": pattern, "quality": EXACT, "device": "cpu"} | FREE | before | change
    assert_same_rest(frame, sm.swatch(**given), SLID if given["pattern"] == "plain" else STATES)


def test_the_first_relaxation_has_the_same_bits_as_that_of_a_swatch():
    with session("rib2x2") as running:
        frame = running.wait_until_rest(SAFETY)
    expected = free_swatch("rib2x2")
    assert np.array_equal(frame.yarns.points, expected.yarns.points)
    # the generated yarns come to the lowest state here; the report also counts the other starts of the search
    assert frame.report["iteration"] == expected.history[-1]["iteration"]


@pytest.mark.parametrize(
    "change, measure, limit",
    [
        ({"gamma": 1.6}, lambda frame: frame.report["gamma"], GROWTH),
        ({"period": (1.5, 1.2)}, lambda frame: np.array(frame.size), STRETCH),
        ({"rest_lengths": sm.RestLengths(factor=0.75)}, lambda frame: frame.yarns.rest_length, LENGTHENING),
    ],
)
def test_successive_frames_differ_by_at_most_one_step(change, measure, limit):
    swatch = live_swatch(relax_cell=False, loop_length=5.0)
    to_rest(swatch)
    frames = to_rest(swatch, settings_of(relax_cell=False, **({"loop_length": 5.0} | change)))
    values = [measure(frame) for frame in frames]
    ratios = np.array([after / before for before, after in itertools.pairwise(values)])
    largest = np.abs(np.log(ratios)).max()
    assert largest > 0.5 * np.log(limit)  # the steps are not much smaller than allowed
    assert largest <= np.log(limit) + 1e-6  # single precision rounds periods


@pytest.mark.nightly
def test_a_sheared_swatch_becomes_upright_again_if_shear_is_held():
    swatch = live_swatch(PLAIN, relax_cell=sm.RelaxCell(), quality=EXACT)
    to_rest(swatch)
    moved = swatch.state
    sheared = moved.yarns.lattice.periods + np.array([[0, 0, 0], [0.35, 0, 0]])
    points = moved.yarns.points + 0.35 * moved.yarns.points[:, 1:2] / sheared[1, 1] * [1, 0, 0]
    yarns = dataclasses.replace(moved.yarns, points=points, lattice=sm.Lattice(sheared))
    swatch.state = dataclasses.replace(moved, yarns=yarns)
    frames = to_rest(swatch, settings_of(PLAIN, quality=EXACT))
    assert len(frames) > 4
    assert frames[-1].lattice.periods[1, 0] == pytest.approx(0.0, abs=1e-9)
    assert_same_rest(frames[-1], sm.swatch(PLAIN, quality=EXACT, device="cpu", **FREE))


def test_a_newer_change_replaces_an_unfinished_older_one():
    swatch = live_swatch()
    to_rest(swatch)
    swatch.take(settings_of(gamma=3.0), 0.0)
    for _ in range(5):
        swatch.advance()
    swatch.publish()
    reached_gamma = swatch.frame.report["gamma"]
    frames = to_rest(swatch, settings_of(gamma=1.0))
    assert 1.0 < reached_gamma < 3.0
    assert max(frame.report["gamma"] for frame in frames) == reached_gamma
    assert frames[-1].report["gamma"] == pytest.approx(1.0)


def test_yarn_that_is_too_thick_to_generate_grows_from_a_smaller_gamma():
    swatch = live_swatch(loop_length=3.0)
    first = swatch.frame
    assert first.report["gamma"] < 1.0 and first.yarns.radius == pytest.approx(0.125)
    assert to_rest(swatch)[-1].report["gamma"] == pytest.approx(1.0)


def test_a_change_of_colours_does_not_change_the_state():
    def striped(colour):
        return sm.parse_pattern(f"rounds 1-2 yarn 0: k2\nrounds 3-4 yarn {colour}: k2")

    swatch = live_swatch(striped(1))
    before = to_rest(swatch)[-1]
    frames = to_rest(swatch, settings_of(striped(2)))
    assert swatch.frame.number == before.number + 1 and len(frames) == 1
    assert np.array_equal(swatch.frame.yarns.points, before.yarns.points) and swatch.frame.report["at_rest"]
    assert set(before.yarns.colour) == {0, 1} and set(swatch.frame.yarns.colour) == {0, 2}


def test_a_change_without_effect_starts_no_relaxation():
    with session() as running:
        rest = running.wait_until_rest(SAFETY)
        running.set(gamma=1.0, **FREE)
        running.set(pattern="stockinette")
        running.set(material=default_material())
        assert running.wait_until_rest(SAFETY) is rest


def default_material() -> sm.YarnMaterial:
    """The default material, for yarn of the default radius."""
    return sm.YarnMaterial.named("stitchmesh")


def test_a_bad_pattern_is_reported_in_the_frame_and_a_later_change_recovers():
    with session() as running:
        rest = running.wait_until_rest(SAFETY)
        running.set(pattern="no-such-pattern", gamma=1.1)
        with pytest.raises(ParameterError, match="no-such-pattern"):
            running.wait_until_rest(SAFETY)
        broken = running.frame
        assert isinstance(broken.error, ParameterError) and not broken.report["running"]
        assert np.array_equal(broken.yarns.points, rest.yarns.points)
        running.set(pattern="stockinette")
        recovered = running.wait_until_rest(SAFETY)
    assert recovered.error is None and recovered.report["gamma"] == pytest.approx(1.1)


def test_a_target_that_is_too_small_stops_early_and_a_later_change_recovers():
    with session("plain", relax_cell=False) as running:
        rest = running.wait_until_rest(SAFETY)
        running.set(period=(0.13, 0.13))
        with pytest.raises(SolverError, match=r"yarns cannot be separated on the path.*larger repeat"):
            running.wait_until_rest(SAFETY)
        assert 0.13 < running.frame.size[0] < rest.size[0]
        running.set(period=(None, None))
        recovered = running.wait_until_rest(SAFETY)
        assert recovered.report["gamma"] == 1.0
        assert recovered.size == pytest.approx(rest.size, rel=1e-6)  # single precision


def test_a_state_that_cannot_reach_the_target_starts_again_from_generated_yarns(monkeypatch):
    swatch = live_swatch("plain")
    rest = to_rest(swatch)[-1]
    begin = LiveSwatch._start_loop
    monkeypatch.setattr(LiveSwatch, "_start_loop", lambda *_given: solver_error("yarn 3: too close"))
    swatch.take(settings_of("plain", material=sm.YarnMaterial.named("leaf")), 0.0)
    with pytest.raises(SolverError, match="yarn 3: yarns cannot be separated"):
        swatch.advance()
    assert np.array_equal(swatch.state.yarns.points, rest.yarns.points)
    swatch.advance()
    assert np.array_equal(swatch.frame.yarns.points, swatch.generated.yarns.points)
    monkeypatch.setattr(LiveSwatch, "_start_loop", begin)
    assert to_rest(swatch)[-1].report["at_rest"]


def solver_error(text: str) -> None:
    raise SolverError(text)


def test_an_unexpected_exception_is_raised_in_the_waiting_thread(monkeypatch):
    with session() as running:
        running.wait_until_rest(SAFETY)
        monkeypatch.setattr(LiveSwatch, "take", lambda *_given, **_named: 1 // 0)
        running.set(gamma=1.1)
        with pytest.raises(ZeroDivisionError):
            running.wait_until_rest(SAFETY)


def test_values_out_of_bounds_are_refused_immediately_and_change_nothing():
    with session() as running:
        with pytest.raises(ParameterError, match=r"gamma: got -1; expected 0\.1 to 10"):
            running.set(gamma=-1)
        known = "blocked, columns, drawn_radius, friction, gamma"
        with pytest.raises(ParameterError, match=rf"session: got a change of .device.; expected one of {known}"):
            running.set(device="cuda:0")
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


def test_closing_during_a_relaxation_ends_the_thread_and_wakes_waiting_threads():
    running = session("honeycomb", quality="standard")
    caught: list[Exception] = []

    def wait() -> None:
        try:
            running.wait_until_rest(SAFETY)
        except SolverError as error:
            caught.append(error)

    waiting = threading.Thread(target=wait)
    waiting.start()
    running.close()
    running.close()
    waiting.join(SAFETY)
    assert "closed before" in str(caught[0])
    assert "swatch session" not in [thread.name for thread in threading.enumerate()]
    assert running.wait_for_frame(SAFETY) is None
    assert np.isfinite(running.frame.yarns.points).all()
    with pytest.raises(ParameterError, match="after the session was closed"):
        running.set(gamma=1.1)


def test_a_swatch_that_used_all_iterations_is_not_reported_at_rest(caplog):
    with session("honeycomb", quality=dataclasses.replace(EXACT, max_iterations=40)) as running:
        frame = running.wait_until_rest(SAFETY)
    assert not frame.report["at_rest"] and not frame.report["running"]
    assert "swatch is not at rest: residual" in caplog.text


def test_frames_are_immutable():
    swatch = live_swatch()
    frame, kept = swatch.frame, swatch.frame.yarns.points.copy()
    to_rest(swatch)
    assert np.array_equal(frame.yarns.points, kept)
    with pytest.raises(ValueError, match="read-only"):
        frame.yarns.points[0] = 0.0
    with pytest.raises(TypeError):
        frame.report["gamma"] = 2.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        frame.number = 0


def test_no_change_alters_the_linking():
    swatch = live_swatch("rib1x1")
    for options in ({"gamma": 1.4}, {"gamma": 1.4, "period": (1.2, 0.9)}, {"rest_lengths": sm.RestLengths(factor=1.3)}):
        to_rest(swatch, settings_of("rib1x1", **options))
        linking = [doubled_linking(yarns, device="cpu") for yarns in (swatch.first.yarns, swatch.state.yarns)]
        assert len(changed_pairs(*linking)) == 0


def test_yarns_are_generated_again_after_a_pull_through(monkeypatch):
    swatch = live_swatch()
    relaxation = "stitchmesh.periodic.session.incremental_relaxation"
    monkeypatch.setattr(f"{relaxation}.refuse_pull_through", lambda *_yarns: solver_error("linking number changed"))
    with pytest.raises(SolverError, match="linking number changed"):
        to_rest(swatch)
    generated = swatch.target.smallest.part_of(swatch.generated.yarns)
    assert np.array_equal(swatch.state.yarns.points, generated.points)


def test_a_knit_moves_without_friction_and_ends_off_the_needles_with_the_bits_of_a_swatch():
    with session("stockinette", relaxation=None) as running:
        frames = [running.frame, running.wait_until_rest(SAFETY)]
        running.set(relaxation="frictionless")
        frames.append(running.wait_until_rest(SAFETY))
    assert [frame.report["preview"] for frame in frames] == [True, False, False]
    assert [frame.report["relaxation"] for frame in frames] == ["frictionless", "dry", "frictionless"]
    expected = sm.swatch("stockinette", quality="draft", device="cpu", relax_cell=True, progress=False)
    assert np.array_equal(frames[1].yarns.points, expected.yarns.points)
    assert frames[1].report["at_rest"] and frames[1].report["energy"] == expected.report["energy"]
    free = free_swatch("stockinette").report
    # its control points stem from those of the knit that was let go
    assert frames[2].size == pytest.approx((free["width"], free["height"]), rel=SLID)


@pytest.mark.nightly
def test_a_change_of_colour_keeps_a_knit_that_was_let_go():
    one, two = (sm.parse_pattern(f"rounds 1-2 yarn 0: k2\nrounds 3-4 yarn {colour}: k2") for colour in (1, 2))
    with session(one, relaxation=None) as running:
        before = running.wait_until_rest(SAFETY)
        running.set(pattern=two)
        after = running.wait_until_rest(SAFETY)
    assert np.array_equal(before.yarns.points, after.yarns.points) and after.report["relaxation"] == "dry"
    assert (set(before.yarns.colour), set(after.yarns.colour)) == ({0, 1}, {0, 2})


def test_a_change_interrupts_a_knit_that_is_let_go():
    """Whatever is asked for while a knit is let go ends that at once; the preview then goes on from where it was."""
    asked = []
    swatch = LiveSwatch(
        settings_of("stockinette").changed(relaxation="dry"), "cpu", 0.0,
        is_interrupted=lambda: bool(asked) or asked.append(True),
    )  # fmt: skip
    while not asked:
        swatch.advance()
    kept = swatch.state.yarns.points.copy()
    swatch.advance()
    assert not swatch.idle and swatch.let_go is None and np.array_equal(swatch.state.yarns.points, kept)
