# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Extreme input relaxes to rest, is reported as not at rest, or is refused with an error that names the yarns."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.collision import broad_phase
from tests.extremes.outcome import AT_REST, NOT_AT_REST, REFUSED
from tests.extremes.yarns import STITCHMESH, cases, coil, far_apart, outcome
from tests.nightly import mostly_at_night
from tests.yarnrelax.loops import assessed

DRAFT = PRESETS["draft"]
SHORT, LONG = 60, 300
"""Iterations. The first steps are the most extreme, so few iterations show a failure; yarns come to rest in more."""
SMALL = {case.name: case for case in cases() if not case.large}
HOPELESS = {"axes cross", "one yarn on another", "4 control points in one place"}
"""Cases where a distance is zero or a direction is undefined: the relaxation cannot start."""
QUICK = {
    "overlapping by half",
    "overlapping by nine tenths",
    "axes side by side, 0.2 radii apart",
    "just touching",
    "open yarn of 4 points",
    "closed yarn of 3 points",
    "linked yarns of 3 points",
    "isolated ring",
    "all pinned",
}
"""Cases with few control points, or few that can move, which come to rest within ``LONG`` iterations."""
BY_DAY = HOPELESS | QUICK | {
    "2 control points in one place",
    "rest lengths x 0.2",
    "rest lengths x 5",
    "k_bend x 1e4",
    "k_contact x 1e-4",
    "two scenes 1e5 radii apart",
    "hairpin around 0.05 radii",
    "half as wide",
}
PLACE_IN_YARN = re.compile(r"yarn \d+ \(control point \d+\)")


@pytest.mark.parametrize("name", mostly_at_night(SMALL, by_day=BY_DAY))
def test_an_extreme_case_ends_in_a_defined_outcome(name: str) -> None:
    case = SMALL[name]
    found = outcome(case, replace(DRAFT, max_iterations=LONG if name in QUICK else SHORT), "cpu")
    if name in HOPELESS:
        assert found.kind == REFUSED
    if name in QUICK:
        assert found.kind == AT_REST
    assert found.kind in {AT_REST, NOT_AT_REST, REFUSED}, found.words
    if found.kind == REFUSED:
        assert PLACE_IN_YARN.search(found.words)
    if found.kind == NOT_AT_REST:
        assert "not at rest: residual" in found.words
    if name == "axes cross":  # both yarns are named, and what to do
        assert len(PLACE_IN_YARN.findall(found.words)) == 2
        assert "contact energy" in found.words and "k_contact" in found.words


def test_the_yarns_of_a_fabric_compressed_to_half_its_width_separate() -> None:
    pressed = outcome(SMALL["half as wide"], replace(DRAFT, max_iterations=0), "cpu")
    found = outcome(SMALL["half as wide"], replace(DRAFT, max_iterations=LONG), "cpu")
    # Yarns touch at 2. The compressed yarns start below 1.5; at rest, contact allows an overlap of at most a quarter.
    assert pressed.report["min_distance_over_radius"] < 1.5 < found.report["min_distance_over_radius"]


def test_a_straight_yarn_has_no_force_at_any_rounding_of_its_coordinates() -> None:
    line = np.arange(20_000)[:, None] * 0.2731 * np.array([0.48, -0.6, 0.64])
    yarn = YarnSet.from_curves([line], closed=[False], radius=0.125)
    assert assessed(yarn, STITCHMESH, "float32").residual == 0.0


def test_a_small_force_in_a_large_scene_is_not_mistaken_for_rounding() -> None:
    # the turns of the coil overlap by a tenth; float32 rounds its coordinates of 380 radii to 3e-5 radii
    assert assessed(coil(20_000), STITCHMESH, "float32").residual > 0.5


def test_the_remedy_names_float64_if_rounding_prevents_convergence() -> None:
    coarse, fine = (assessed(far_apart(1e5), STITCHMESH, precision) for precision in ("float32", "float64"))
    # Half of 1e5 radii in float32: representable coordinates are 0.004 radii apart, but a strain of 0.001 moves the
    # ends of these yarns by less.
    assert coarse.rounding > DRAFT.tolerance
    assert coarse.residual > DRAFT.tolerance
    assert "max_iterations" in fine.remedy(DRAFT.tolerance)
    rounding_only = replace(coarse, residual=coarse.rounding)
    assert "float64" in rounding_only.remedy(DRAFT.tolerance)


def test_candidate_lists_that_exceed_the_memory_are_refused_by_place(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(broad_phase, "MOST_ENTRIES", 100_000)  # each of the 864 samples is in contact with all others
    found = outcome(SMALL["radius x 100"], DRAFT, "cpu")
    assert found.kind == REFUSED
    assert PLACE_IN_YARN.search(found.words)
    assert "smaller radius" in found.words
