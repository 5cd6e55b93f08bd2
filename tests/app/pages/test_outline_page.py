# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Outline, without a browser: it shows what the library gives, follows the chart, and keeps its state."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.app.pages.outline import WOVEN, OutlinePage, first_state
from stitchmesh.app.scene.drawing import Lines, Surface
from stitchmesh.patterns import format_pattern, read_pattern
from stitchmesh.periodic.natural_outline import natural_outline
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from tests.app.pages.headless import Headless, call, headless, press, wait_for_task


@pytest.fixture
def shown(tmp_path: Path) -> Iterator[Headless]:
    with headless(tmp_path, None, "Project") as app:
        small = {"pattern": format_pattern(read_pattern("rib2x2")), "form": "flat", "stitches": 8, "rows": 6}
        app.project.set_settings("Outline", small)
        call(app, app.app.open_page, "Outline")
        wait_for_task(app)
        yield app


def page_of(shown: Headless) -> OutlinePage:
    assert isinstance(shown.app.page, OutlinePage)
    return shown.app.page


def test_the_page_shows_the_natural_outline_of_the_chart(shown: Headless) -> None:
    surface, outline = shown.scene.drawings["fabric"], shown.scene.drawings["outline"]
    expected = natural_outline("rib2x2", columns=2, rows=3)
    assert isinstance(surface, Surface) and isinstance(outline, Lines)
    np.testing.assert_array_equal(surface.points, expected.fabric.vertices)
    assert len(outline.segments) == len(expected.outline[0])
    assert f"{expected.width:.3g} x {expected.height:.3g} cm" in shown.controls.text_shown()


def test_another_pattern_or_form_is_relaxed_at_once_and_kept(shown: Headless) -> None:
    call(shown, page_of(shown)._take_pattern, resolve_pattern("garter"))
    call(shown, shown.controls.set, "Form", "Tube")  # The relaxation of the piece ends first.
    wait_for_task(shown)
    expected = natural_outline("garter", "tube", columns=16, rows=3)
    surface = shown.scene.drawings["fabric"]
    assert isinstance(surface, Surface)
    np.testing.assert_array_equal(surface.points, expected.fabric.vertices)
    assert shown.project.settings("Outline")["form"] == "tube"


def test_a_weave_and_a_damaged_state_are_refused_in_one_line(shown: Headless) -> None:
    call(shown, page_of(shown)._take_pattern, resolve_pattern("plain"))
    assert WOVEN in shown.notices()
    shown.project.set_settings("Outline", {"pattern": "k", "form": "flat", "stitches": 0, "rows": 6})
    call(shown, shown.app.open_page, "Project")
    call(shown, shown.app.open_page, "Outline")
    assert "a new one begins" in shown.notices()
    assert page_of(shown).state == first_state()
    press(shown, "Stop")  # a new project begins with a large pattern
    wait_for_task(shown)
