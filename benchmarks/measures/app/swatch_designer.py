# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Response of the page Swatch: from an edit of the chart, or a turned dial, to the fabric as drawn and as it moves.

The first command measures the server: from the event to the frame that is handed to the browsers, with its size. The
second one measures in Chromium with software rendering: from the key that paints a square to the picture.
An edit of the chart is first shown as drawn; the next frame that is shown has moved. A turned dial moves at once.
"""

from __future__ import annotations

import platform
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import stitchmesh as sm
from benchmarks.table import Rows
from stitchmesh.app.application import App
from stitchmesh.app.pages.swatch.page import SwatchPage
from stitchmesh.app.project.project import Project
from stitchmesh.app.server import open_server
from stitchmesh.app.viser_front import ViserFront
from stitchmesh.patterns import Cell, Pattern
from stitchmesh.periodic.resolve_pattern import Source

RUNS = 9
"""Number of edits of which the median and the largest time are printed."""
LONGEST = 120.0
"""Longest time for which a frame is awaited [s]."""
LIBRARY = ("rib2x2", "peerie", "honeycomb", "twill-2x1")
"""Patterns of the library that are edited."""
SQUARES = 40
"""Stitches along each side of the large chart."""
PROBE = """() => {
  const seen = window.__swatch = {shown: [], key: 0, vertices: new Map()};
  addEventListener('keydown', () => { seen.key = performance.now(); seen.shown = []; }, true);
  const look = () => {
    const state = window.__viserSceneTree.getState(), now = new Map();
    for (const name of Object.keys(state)) {
      const props = state[name] && state[name].message && state[name].message.props;
      if (props && props.batched_positions && props.vertices) now.set(name, props.vertices);
    }
    let changed = now.size !== seen.vertices.size;
    for (const [name, vertices] of now) changed = changed || seen.vertices.get(name) !== vertices;
    seen.vertices = now;
    if (changed) requestAnimationFrame(() => requestAnimationFrame(() => seen.shown.push(performance.now())));
    requestAnimationFrame(look);
  };
  look();
}"""
"""Remembers when the key was pressed, and when each change of the fabric had been drawn."""


def charts() -> dict[str, Source]:
    """Return the patterns that are edited, by name."""
    named: dict[str, Source] = {name: sm.resolve_pattern(name) for name in LIBRARY}
    row = " ".join(["k2 p2"] * (SQUARES // 4))
    named[f"rib {SQUARES} x {SQUARES}"] = sm.parse_pattern("\n".join(f"round {n + 1}: {row}" for n in range(SQUARES)))
    return named


def edited(source: Source, number: int) -> Source:
    """Return a pattern with one square changed and, the next time, changed back."""
    if isinstance(source, Pattern):
        cells = list(source.rows[0].cells)
        other = sm.Stitch.PURL if cells[0].stitch == sm.Stitch.KNIT else sm.Stitch.KNIT
        cells[0] = Cell(other, yarn=cells[0].yarn) if number % 2 else cells[0]
        return replace(source, rows=(replace(source.rows[0], cells=tuple(cells)), *source.rows[1:]))
    matrix = np.array(source.matrix)
    return replace(source, matrix=tuple(map(tuple, (np.roll(matrix, number % 2, axis=1)).tolist())))


@contextmanager
def opened_page() -> Iterator[tuple[App, SwatchPage, str]]:
    """Run the application on a new project with the page open; give its address too."""
    with tempfile.TemporaryDirectory() as folder:
        opened = open_server(port=0)
        app = App(Project.create(Path(folder) / "project"), ViserFront(opened.server))
        app.post(app.open_page, "Swatch")
        app.queue.settle()
        assert isinstance(app.page, SwatchPage)
        try:
            yield app, app.page, opened.address
        finally:
            app.close()
            opened.stop()


class Watch:
    """Times at which frames were handed to the browsers."""

    def __init__(self, app: App, page: SwatchPage) -> None:
        """Watch the scene of the page."""
        self.shown: list[tuple[float, int, int]] = []
        self._page, self._show = page, app.scene.show
        app.scene.show = self._timed  # type: ignore[method-assign]

    def _timed(self, name: str, drawing: Any) -> None:
        self._show(name, drawing)
        frame = self._page.variant.frame
        if frame is not None and frame.error is None:
            self.shown.append((time.perf_counter(), frame.number, frame.report["iteration"]))

    def times(self, app: App, change: Callable[[], object]) -> tuple[float, float]:
        """Return the times from a change to its first frame and to its first frame that has moved [ms]."""
        before = self._page.variant.session.frame.number
        self.shown.clear()
        began = time.perf_counter()
        app.post(change)
        drawn = self._first(lambda number, iteration: number > before, began)
        return drawn, self._first(lambda number, iteration: number > before and iteration > 0, began)

    def _first(self, fits: Callable[[int, int], bool], began: float) -> float:
        while time.perf_counter() - began < LONGEST:
            for moment, number, iteration in list(self.shown):
                if fits(number, iteration):
                    return 1e3 * (moment - began)
            time.sleep(0.0005)
        raise TimeoutError(f"no frame within {LONGEST:g} s")


def settled(app: App, page: SwatchPage, seconds: float = LONGEST) -> None:
    """Wait until the fabric rests and is shown; a fabric that does not rest in time is stopped and started again."""
    try:
        page.variant.session.wait_until_rest(seconds)
    except sm.StitchMeshError:
        pass
    time.sleep(0.25)
    app.queue.settle()


def measure_server() -> Rows:
    """Yield the table of the server."""
    yield "server", "points", "kB", "drawn ms", "moves ms", "dial ms"
    with opened_page() as (app, page, _):
        watch = Watch(app, page)
        for name, source in charts().items():
            app.post(page._take_pattern, source)
            settled(app, page)
            changes = [edited(source, number + 1) for number in range(RUNS)]
            edits = [watch.times(app, partial(page._take_pattern, change)) for change in changes]
            settled(app, page)
            dials = []
            for number in range(RUNS):
                gamma = 1.05 if number % 2 == 0 else 1.0
                dials.append(watch.times(app, partial(page._turn, gamma=gamma))[1])
                settled(app, page)
            drawing, frame = page.variant.drawing, page.variant.frame
            assert drawing is not None and frame is not None
            size = sum(part.vertices.nbytes for part in drawing.parts) + drawing.offsets.nbytes
            drawn, moves = zip(*edits, strict=True)
            yield (
                name, len(frame.yarns.points), f"{size / 1e3:.0f}", _figures(drawn), _figures(moves),
                _figures(dials),
            )  # fmt: skip
            app.post(page._set_back)


def measure_browser() -> Rows:
    """Yield the table of the browser; squares are painted by the space bar."""
    from tests.app.browser import READY, started_browser

    yield ""
    yield "browser", "drawn ms", "moves ms"
    with opened_page() as (app, page, address), started_browser() as browser:
        window = browser.new_page(viewport={"width": 1000, "height": 700})
        window.goto(f"{address}{'&' if '?' in address else '?'}fixedDpr=1")
        window.wait_for_function(READY)
        window.evaluate(PROBE)
        for name in LIBRARY[:2]:
            app.post(page._chart._choose, name)
            settled(app, page)
            window.wait_for_timeout(1500)
            found = [_painted(app, page, window, ("k", "p")[number % 2]) for number in range(RUNS)]
            drawn, moves = zip(*[times for times in found if len(times) == 2], strict=True)
            yield name, _figures(drawn), _figures(moves)


def _painted(app: App, page: SwatchPage, window: Any, stitch: str) -> tuple[float, ...]:
    """Paint the first square, and return the times from the key to the first two pictures [ms]; () without a change."""
    window.locator(f'[data-action="stitch"][data-value="{stitch}"]').first.click()
    window.wait_for_timeout(300)
    window.locator("[data-chart] canvas").focus()
    before = page.state.design.pattern
    window.keyboard.press("Space")
    window.wait_for_timeout(1500)
    if page.state.design.pattern == before:
        return ()
    settled(app, page)
    shown = window.evaluate("() => window.__swatch.shown.map(t => t - window.__swatch.key)")
    return tuple(shown[:2])


def _figures(times: Any) -> str:
    return f"{np.median(times):.0f} to {max(times):.0f}"


def swatch_designer(*, browser: bool = False) -> Rows:
    """Measure the page.

    Args:
        browser: measure in Chromium, with its rendering
    """
    yield f"{platform.machine()}; median to largest of {RUNS} edits; Python {platform.python_version()}"
    if browser:
        yield from measure_browser()
    else:
        yield from measure_server()
