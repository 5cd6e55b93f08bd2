# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The verdict on relaxed yarns, and the figures of a report in words."""

from __future__ import annotations

from typing import Any

import pytest

from stitchmesh.reporting.figures import duration, joules, report_figures, shares
from stitchmesh.reporting.verdict import relaxation_verdict
from stitchmesh.yarnrelax import relax_yarns
from tests.yarnrelax.stockinette import tube

GOOD = {"converged": True, "stopped": False, "iterations": 140, "max_strain": 0.0123, "min_distance_over_radius": 1.756}


def test_a_good_report_has_no_findings():
    verdict = relaxation_verdict(GOOD)
    assert verdict.good and str(verdict).startswith("Good: the yarns are at rest, strained by at most 1.2 %")


@pytest.mark.parametrize(
    ("changed", "kind", "words"),
    [
        ({"converged": False}, "not at rest", "not at rest after 140 iterations; allow more iterations"),
        ({"converged": False, "stopped": True}, "stopped", "was stopped after 140 iterations"),
        ({"remaining_change": None, "residual": 1e-3}, "change not known", "how far the spacing"),
        ({"steps": 13, "steps_not_at_rest": 2}, "moved on the way", "in 2 of the 13 steps before they were not"),
        ({"max_strain": 0.06}, "strained", "strained by 6.0 %"),
        (
            {"yarns_in_row": 3, "wale_spacing": 0.7, "course_spacing": 1.1},
            "drawn in", "0.7 cm wide and 1.1 cm high: the floats of up to 3 yarns in a row draw it together",
        ),
        ({"shape": "folded", "thickness_ratio": 1.8, "yarns_in_row": 3}, "not flat", "up to 3 yarns in a row"),
        ({"min_distance_over_radius": 1.4}, "crowded", "1.40 radii apart (2 is touching); use a thinner yarn"),
    ],
)
def test_each_fault_is_a_finding_in_words(changed: dict[str, Any], kind: str, words: str):
    verdict = relaxation_verdict(GOOD | changed)
    (finding,) = verdict.findings
    assert not verdict.good and finding.kind == kind and words in str(finding)
    assert str(verdict) == f"Not good: {finding}."


def test_an_older_report_does_not_say_whether_it_was_stopped():
    report = {key: value for key, value in GOOD.items() if key != "stopped"} | {"converged": False}
    assert relaxation_verdict(report).findings[0].kind == "not at rest"


def test_uneven_stitches_are_named_first():
    verdict = relaxation_verdict(GOOD | {"converged": False}, mesh_converged=False)
    assert [found.kind for found in verdict.findings] == ["uneven stitches", "not at rest"]


def test_every_figure_of_a_real_report_has_a_value_and_a_sentence():
    report = relax_yarns(tube(2, 4), quality="draft", device="cpu").report
    figures = report_figures(report, tolerance=0.01)
    assert {figure.name for figure in figures} >= {"residual", "largest strain", "closest yarns", "energy", "time"}
    for figure in figures:
        assert figure.value and figure.meaning.endswith(".") and figure.meaning[0].isupper()
    agree = relaxation_verdict(report).good
    assert agree == all(figure.good for figure in figures)


def test_shares_sum_up_and_begin_with_the_largest():
    assert shares({"bend": 25.0, "stretch": 75.0}) == "stretch 75 %, bend 25 %"
    assert shares({"bend": 0.0}) == "none"


@pytest.mark.parametrize(
    ("energy", "text"),
    [(2.5e7, "2.5 J"), (-3e4, "-3 mJ"), (5.0, "0.5 \N{MICRO SIGN}J"), (0.0, "0 \N{MICRO SIGN}J")],
)
def test_energies_have_a_unit_that_needs_few_zeros(energy: float, text: str):
    assert joules(energy) == text


@pytest.mark.parametrize(("seconds", "text"), [(1.23, "1.2 s"), (45.4, "45 s"), (600.0, "10 min")])
def test_long_durations_are_in_minutes(seconds: float, text: str):
    assert duration(seconds) == text
