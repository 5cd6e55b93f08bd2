# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Drape in tests: scenes are opened, painted, run and read without a browser."""

from __future__ import annotations

import re
import threading
from html import unescape
from pathlib import Path

import numpy as np

from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.app.pages.drape.page import RUN, DrapePage
from stitchmesh.app.scene.scene import Stroke
from stitchmesh.compute.device import alone
from stitchmesh.mixed.scene.region_section import RegionSection
from tests.app.pages.headless import SAFETY, Headless, call, press, wait_for_task

EYE = np.array([1.5, 1.5, 30.0])


def open_file(shown: Headless, path: Path) -> None:
    call(shown, shown.controls.set, "Path", str(path))
    press(shown, "Open path")
    wait_for_task(shown)


def page_of(shown: Headless) -> DrapePage:
    assert isinstance(shown.app.page, DrapePage)
    return shown.app.page


def opened(shown: Headless) -> OpenedScene:
    found = page_of(shown).session.opened
    assert found is not None
    return found


def region(shown: Headless) -> RegionSection:
    return opened(shown).scene.region


def words(shown: Headless) -> str:
    """All that the page says, without marks."""
    return " ".join(unescape(re.sub("<[^>]*>", " ", shown.controls.text_shown())).split())


def run(shown: Headless, button: str) -> None:
    press(shown, button)
    wait_for_task(shown)


def run_to_a_pause(shown: Headless) -> None:
    """Begin a run, and pause it after its first steps, when the page has got a state."""
    live = page_of(shown).run
    with alone():  # The run cannot begin before it is paused.
        press(shown, RUN)
        assert live.live is not None
        call(shown, live.live.control.pause)
        call(shown, live.live.control.step)
    for _ in range(int(SAFETY / 0.01)):
        if live.live.newest is not None:
            return
        threading.Event().wait(0.01)
    raise AssertionError("no state has come")


def paint(shown: Headless, *points: tuple[float, float]) -> None:
    """Drag over places of the flat cloth, seen from the front."""
    phases = ["start", *["move"] * (len(points) - 2), "end"]
    for (x, y), phase in zip(points, phases, strict=True):
        stroke = Stroke(EYE, np.array([x, y, 0.0]) - EYE, phase=phase)
        call(shown, page_of(shown).stroked, stroke)
