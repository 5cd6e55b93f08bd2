# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Verdicts and figures as HTML: marks and words beside the colours, and no text that becomes a tag."""

from __future__ import annotations

from stitchmesh.app.controls.html_pieces import MOST, figures_html, verdict_html
from stitchmesh.reporting.figures import Figure
from stitchmesh.reporting.verdict import Finding, Verdict

BAD = Verdict((Finding("crowded", "yarns are <crowded>", "use thinner yarn"), Finding("strained", "strained")), "p")


def test_a_good_verdict_has_a_mark_its_title_and_its_figures():
    text = verdict_html(Verdict((), "all within 20 %"), "Even", "Uneven")
    assert "✓" in text and "Even: all within 20 %." in text and "Uneven" not in text


def test_each_finding_is_a_sentence_of_a_list_and_is_escaped():
    text = verdict_html(BAD, "Good", "Not good yet")
    assert text.count("<li>") == 2 and "&#9888;" in text and "Not good yet" in text
    assert "Yarns are &lt;crowded&gt;; use thinner yarn." in text and "<crowded>" not in text


def test_findings_that_can_be_clicked_are_buttons_with_their_number():
    text = verdict_html(BAD, "Good", "Not good yet", action="rows")
    assert text.count('<button type="button" data-action="rows"') == 2
    assert 'data-value="0"' in text and 'data-value="1"' in text
    assert "<button" not in verdict_html(BAD, "Good", "Not good yet")


def test_many_findings_are_cut_and_counted():
    many = Verdict(tuple(Finding("crowded", f"place {k}") for k in range(MOST + 3)), "p")
    text = verdict_html(many, "Good", "Not good yet", action="rows")
    assert f"Place {MOST - 1}." in text and f"Place {MOST}." not in text and "And 3 more" in text


def test_a_figure_that_is_not_good_is_marked():
    good, bad = (Figure("strain", "5 %", "How much.", good=good) for good in (True, False))
    assert "&#9888;" not in figures_html([good]) and "&#9888;" in figures_html([bad])
    assert "strain" in figures_html([good]) and "How much." in figures_html([good])
