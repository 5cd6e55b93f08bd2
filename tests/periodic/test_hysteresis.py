# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Loops of stretch tests: those of springs and sliders, whose memory is exact, and those of a rib with friction."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.periodic.hysteresis import closed_loops, loop_texts
from stitchmesh.periodic.stretch import StretchPath, stretch_test

SLIDERS = ((1.0, 0.02), (0.7, 0.05), (0.4, 0.11))
"""Largest force and slip length of each spring with a slider in series (Jenkins)."""
TURNS = (0.0, 0.4, 0.2, 0.4, 0.2, 0.6, 0.2, 0.4, 0.2, 0.4, 0.6)
"""Inner loops between 20 and 40 % after 40 % and after 60 %."""


def pulled_by_sliders(strain: np.ndarray, sliders: tuple[tuple[float, float], ...]) -> np.ndarray:
    """Force of springs with sliders side by side, along a path: each follows the path until it slides."""
    force = np.zeros(len(strain))
    for most, slip in sliders:
        own = 0.0
        for k, step in enumerate(np.diff(strain), start=1):
            own = np.clip(own + most / slip * step, -most, most)
            force[k] += own
    return force


def test_one_slider_loses_the_work_of_its_slide() -> None:
    """A loop between two strains that are L apart: the slider moves by L - 2 e, there and back, against f."""
    (most, slip), length = SLIDERS[0], 0.2
    strain = StretchPath(course=(0.0, 0.4, 0.2, 0.4), steps=201).strains  # the corners lie on the path
    loop = closed_loops(strain, pulled_by_sliders(strain, SLIDERS[:1]))[0]
    assert (loop.turn, loop.away) == pytest.approx((0.4, 0.2)) and abs(loop.gap) < 1e-12  # rounding
    lost = (1.0 - loop.work_returned) * loop.work_given
    assert lost == pytest.approx(2.0 * most * (length - 2.0 * slip), rel=1e-9)  # rounding


def test_loops_of_sliders_close_and_are_congruent() -> None:
    """Return-point memory and congruence are exact for springs and sliders (Masing's rule)."""
    strain = StretchPath(course=TURNS, steps=31).strains
    loops = closed_loops(strain, pulled_by_sliders(strain, SLIDERS))
    inner = [loop for loop in loops if (loop.turn, loop.away) == pytest.approx((0.4, 0.2))]
    assert len(inner) == 3
    assert {loop.is_inner for loop in loops} == {True, False}
    assert all(abs(loop.gap) < 1e-12 for loop in loops if loop.is_inner)  # rounding
    assert inner[0].difference(inner[2])[1] < 1e-12
    drift = 0.3 * strain  # a spring beside the sliders changes the work that is given, not the loop's shape
    assert closed_loops(strain, pulled_by_sliders(strain, SLIDERS) + drift)[1].gap == pytest.approx(0.0, abs=1e-12)


def test_a_way_that_does_not_come_back_is_no_loop() -> None:
    strain = np.array([0.0, 0.1, 0.2, 0.15, 0.18])
    assert closed_loops(strain, strain) == ()
    one = closed_loops(np.array([0.0, 0.2, 0.1, 0.2, 0.3]), np.array([0.0, 2.0, 0.8, 1.9, 3.0]))
    assert [loop.first for loop in one] == [1]
    assert loop_texts(one) == [
        "from 20 % to 10 % and back: 103.7% of the work returned, open by -5.00% of its largest tension"
    ]


def test_a_path_stops_at_the_strains_at_which_it_turns() -> None:
    path = StretchPath(wale=(0.0, 0.4, 0.1, 0.6), steps=6)
    tenths = [0, 1, 2, 3, 4, 3, 2, 1, 2, 3, 4, 5, 6]
    np.testing.assert_allclose(path.strains, 0.1 * np.array(tenths), atol=1e-15)
    assert path.strains[1] == path.strains[7] == 0.1  # a turning point has the same strain on each way, to the last bit


def test_a_rib_remembers_where_it_turned() -> None:
    """The published behaviour of a 1x1 rib (Dresselhaus 2025): it rejoins at 40 %, and inner loops are congruent."""
    path = StretchPath(course=(0.0, 0.4, 0.2, 0.4, 0.6, 0.2, 0.4, 0.2, 0.4), steps=5, friction=0.3)
    curve = stretch_test("rib1x1", path, quality="draft", device="cpu")
    inner = [loop for loop in curve.loops if (loop.turn, loop.away) == pytest.approx((0.4, 0.2))]
    assert len(inner) == 2
    assert all(abs(loop.gap) < 0.01 for loop in inner)  # a residual of 1e-3 leaves some thousandths
    whole, shape = inner[0].difference(inner[1])
    # normal forces differ a little after 60 %; the figures are in docs/contact.md
    assert whole < 0.05 and shape < 0.02
    assert all(0.7 < loop.work_returned < 0.97 for loop in inner)  # friction takes a part of the work
