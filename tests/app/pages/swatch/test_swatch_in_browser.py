# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Swatch in a real browser: paint, turn a dial, watch, compare and take the yarns home."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import stitchmesh as sm
from stitchmesh.app.pages.swatch.page import SwatchPage
from stitchmesh.app.pages.swatch.state import Look, SwatchState, state_table
from stitchmesh.app.project.project import Project
from stitchmesh.periodic.swatch_design import SwatchDesign
from tests.app.browser import Rig

MIDDLE = (0.25, 0.25, 0.75, 0.75)
"""Part of the scene that the fabric covers."""
REST_LIMIT = 120.0
"""Longest time for which a swatch may relax [s]: far beyond what one takes, so that a session that hangs is named."""


def page_of(rig: Rig) -> SwatchPage:
    assert isinstance(rig.app.page, SwatchPage)
    return rig.app.page


@pytest.fixture(autouse=True)
def small_garter(tmp_path: Path) -> None:
    """The project keeps a small garter knit: others relax for seconds, and a browser alone draws many rows slowly."""
    project = Project.create(tmp_path / "project")
    design = SwatchDesign(sm.read_pattern("garter"))
    project.set_settings("Swatch", state_table(SwatchState((design,), look=Look(columns=3, rows=2))))
    project.close()


def rest(rig: Rig) -> None:
    """Wait until the fabric rests, and the browser has drawn it."""
    rig.settle()
    variants = page_of(rig).variants
    for variant in variants:
        variant.session.wait_until_rest(REST_LIMIT)  # Until a change is taken, the frame before it is at rest too.
    rig.wait_for(
        lambda: all(
            variant.frame is not None and variant.frame is variant.session.frame
            and not variant.frame.report["running"]
            for variant in variants
        ),
        "the fabric rests",
    )  # fmt: skip
    rig.settle()


def fabric_seen(rig: Rig) -> np.ndarray:
    """The middle of the scene, as the browser shows it, shape (h, w, 3)."""
    rig.browser_page.wait_for_timeout(400)  # The renderer draws when it is idle.
    picture = np.asarray(Image.open(io.BytesIO(rig.screenshot())).convert("RGB"), dtype=np.int64)
    (left, top), (right, bottom) = rig.place(MIDDLE[:2]), rig.place(MIDDLE[2:])
    return picture[int(top) : int(bottom), int(left) : int(right)]


def changed_pixels(before: np.ndarray, after: np.ndarray) -> float:
    """Part of the pixels that differ by more than the noise of two drawings of one scene."""
    return float((np.abs(after - before).max(axis=2) > 12).mean())


def test_a_painted_square_and_a_turned_dial_change_the_fabric_and_its_yarns_come_home(app_in_browser, tmp_path):
    with app_in_browser("Swatch") as rig:
        rest(rig)
        before = fabric_seen(rig)
        # The fabric covers the middle: the background is white.
        assert (before.min(axis=2) < 250).mean() > 0.5
        square = page_of(rig).state.design.pattern.rows[0].cells[0].stitch
        other = sm.Stitch.PURL if square == sm.Stitch.KNIT else sm.Stitch.KNIT
        rig.act("stitch", "p" if other == sm.Stitch.PURL else "k")
        rig.settle()
        rig.browser_page.locator("[data-chart] canvas").focus()
        rig.browser_page.keyboard.press("Space")
        rig.wait_for(lambda: page_of(rig).state.design.pattern != sm.read_pattern("garter"), "the chart is painted")
        rest(rig)
        painted = fabric_seen(rig)
        assert changed_pixels(before, painted) > 0.05
        assert page_of(rig).state.design.pattern.rows[0].cells[0].stitch == other
        rig.type("Tightness", 1.3)
        rig.wait_for(lambda: page_of(rig).state.design.dials.gamma == 1.3, "the dial is turned")
        rest(rig)
        assert changed_pixels(painted, fabric_seen(rig)) > 0.05
        rig.browser_page.get_by_text("Download", exact=True).click()
        name, content = rig.downloaded(lambda: rig.press("Download the yarns"))
        (tmp_path / name).write_bytes(content)
        frame = page_of(rig).variant.frame
        assert frame is not None
        np.testing.assert_array_equal(sm.read_yarns(tmp_path / name).points, frame.yarns.points)


@pytest.mark.nightly
def test_two_variants_and_a_second_browser_that_sees_the_same(app_in_browser):
    with app_in_browser("Swatch", size=(1280, 800)) as rig:
        rig.choose("Start from", "twill-2x1")
        rig.browser_page.get_by_text("Two variants", exact=True).click()
        rig.tick("Compare two variants")
        rig.wait_for(lambda: len(page_of(rig).variants) == 2, "two variants")
        rig.type("Warp length", 1.3)
        rest(rig)
        first, second = page_of(rig).variants
        assert first.frame is not None and second.frame is not None
        assert second.frame.measures.loop_length > first.frame.measures.loop_length
        other = rig.another_window()
        other.wait_for_text("Warps in 10 cm")
        for frame in (first.frame, second.frame):
            other.wait_for_text(f"{frame.measures.gauge.stitches:.1f}")
        assert not other.faults
        other.close()


BROKEN_CHARTS = [
    ("broken.txt", b'pattern "x"\nround 1: k1 zz3\n', "zz3"),
    ("huge.txt", b"1" * 600 + b"\n", "500"),
    ("broken.png", b"\x89PNG no picture", "broken.png"),
]
"""Names and contents of charts, and what is said of them."""


@pytest.mark.nightly
def test_broken_charts_are_notices_and_the_fabric_stays(app_in_browser, tmp_path):
    with app_in_browser("Swatch") as rig:
        rest(rig)
        design = page_of(rig).state.design
        for file, content, message in BROKEN_CHARTS:
            (tmp_path / file).write_bytes(content)
            rig.upload(tmp_path / file)
            rig.wait_for(lambda: any(message in text for text in rig.notices()), file)  # noqa: B023
            assert page_of(rig).state.design == design
            rig.close_notices()
