# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Times of the chart editor: the server alone, and with ``--browser`` from the press of a key of the mouse.

The server's time is that of a stroke of one square up to the answer for the browser, and of a new text. In the browser,
a square is drawn in the frame after the press, before the server knows of it; then the time up to the call of the page
is measured, in which the server, the browser and the network have a part.
"""

from __future__ import annotations

import json
import platform
import tempfile
import time
from pathlib import Path

from benchmarks.table import Rows
from benchmarks.timing import median_and_largest, milliseconds
from stitchmesh.app.controls.chart_editor import ChartEditor
from stitchmesh.patterns import parse_pattern
from stitchmesh.patterns.pattern import Pattern
from tests.app.null_front import NullControls

SIDES = (24, 100, 500)
"""Number of rows and columns of the charts."""
RUNS = 11
PRESSED = """([row, column]) => new Promise((done) => {
  const chart = Object.values(stitchmeshCharts).find((each) => each.root);
  const box = chart.canvas.getBoundingClientRect();
  const clientX = box.left + chart.left + (column + 0.5) * chart.cell, clientY = box.top + chart.top + 0.5 * chart.cell;
  const values = { clientX, clientY, button: 0, buttons: 1, pointerId: 1, bubbles: true };
  const start = performance.now(), draw = chart.drawNow.bind(chart);
  chart.canvas.setPointerCapture = () => {};
  chart.drawNow = () => { draw(); chart.drawNow = draw; done([performance.now() - start, Date.now()]); };
  chart.canvas.dispatchEvent(new PointerEvent("pointerdown", values));
  chart.canvas.dispatchEvent(new PointerEvent("pointerup", { ...values, buttons: 0 }));
})"""


def pattern_of(side: int) -> Pattern:
    """Return a pattern of knit and purl stitches with this number of rows and columns."""
    row = "kp" * (side // 2)
    return parse_pattern("chart letters:\n" + "\n".join([row] * side))


def server_times(side: int) -> tuple[object, ...]:
    """Return the times of a stroke and of a text, and the bytes of the answer to a stroke."""
    controls = NullControls()
    editor = ChartEditor(controls, pattern_of(side), lambda _: None)
    strokes = [json.dumps({"places": [[1, 2 * run]], "word": "p", "yarn": None}) for run in range(RUNS)]
    stroke = milliseconds(lambda run: editor.act("stroke", strokes[run]), RUNS)
    answer = sum(len(made.content) for made in controls.made if "data-chart-changes" in made.content)
    texts = [editor.text.replace("kp", "pk", run + 1) for run in range(RUNS)]
    typed = milliseconds(lambda run: editor.act("text", json.dumps({"text": texts[run]})), RUNS)
    return *median_and_largest(stroke), *median_and_largest(typed), answer


def browser_times(sides: tuple[int, ...]) -> Rows:
    """Yield the times from a press to the frame with its square, and to the call of the page."""
    from stitchmesh.app.pages import all_pages
    from stitchmesh.app.pages.page import Page
    from tests.app.browser import rig_on, started_browser

    given: list[float] = []

    class ChartPage(Page):
        name, hint = "Project", "Paint the chart."

        def build(self) -> None:
            self.editor = ChartEditor(
                self.app.left_controls, pattern_of(sides[0]), lambda _: given.append(1e3 * time.time())
            )

    all_pages.PAGES["Project"] = ChartPage
    with started_browser() as browser, tempfile.TemporaryDirectory() as folder:
        with rig_on(browser, Path(folder) / "project", "Project") as rig:
            for side in sides:
                rig.call(rig.app.page.editor.show, pattern_of(side))
                rig.settle()
                rig.browser_page.wait_for_timeout(1000)
                drawn, called = [], []
                for run in range(RUNS):
                    given.clear()
                    frame, at = rig.browser_page.evaluate(PRESSED, [0, 2 * run])
                    rig.wait_for(lambda: given, "the call of the page")
                    drawn.append(frame)
                    called.append(given[0] - at + frame)
                yield f"{side} x {side}", *median_and_largest(drawn), *median_and_largest(called)


def chart_editor(*, browser: bool = False) -> Rows:
    """Yield a table for the server, and one for the browser.

    Args:
        browser: measure in Chromium too, which draws in software here
    """
    yield f"{platform.processor() or platform.machine()}, median and largest of {RUNS} runs [ms]"
    yield "chart", "stroke", "largest", "text", "largest", "bytes"
    for side in SIDES:
        yield f"{side} x {side}", *server_times(side)
    if browser:
        yield ""
        yield "chart", "drawn", "largest", "called", "largest"
        yield from browser_times(SIDES)
