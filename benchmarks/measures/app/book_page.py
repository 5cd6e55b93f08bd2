# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of a swatch book, opened from its folder: times to its first picture and to a fabric that turns, its size.

The browser is Chromium, which draws in software. The folder ``swatches`` does not count, because the page does not need
it.
"""

from __future__ import annotations

import io
import time
from pathlib import Path
from statistics import median

from PIL import Image
from playwright.sync_api import Browser, Page

from benchmarks.table import Rows
from stitchmesh.jobs.book.leaf import FOLDERS
from stitchmesh.jobs.book.swatch_book import PAGE
from tests.app.browser import started_browser

SIZES = ((1280, 900), (390, 844))
"""Windows of a computer and of a telephone [pixels]."""
OPENED = 5
"""How often the page is opened for each time."""
SHOWN = "image => image.complete && image.naturalWidth > 0"
WIDTH = 1000
"""Width of the picture that is kept [pixels]."""


def book_page(folder: Path, /, leaf: str = "stockinette", picture: Path | None = None) -> Rows:
    """Open a book several times.

    Args:
        folder: folder of the book, from `stitchmesh book`.
        leaf: name of the pattern whose leaf is opened.
        picture: a picture of this leaf, a ``.jpg`` file; None for no picture.
    """
    sizes = [path.stat().st_size for name in FOLDERS for path in (folder / name).iterdir()]
    size, count = sum(sizes) + (folder / PAGE).stat().st_size, len(list((folder / "leaves").glob("*.js")))
    yield f"{count} patterns, {size / 1e6:.1f} MB, {size / count / 1e3:.0f} kB a pattern"
    address = (folder / PAGE).resolve().as_uri()
    yield "window", "first picture, s", "fabric that turns, s"
    with started_browser() as browser:
        for window in SIZES:
            times = [_opened(browser, address, leaf, window) for _ in range(OPENED)]
            yield f"{window[0]} x {window[1]}", *(f"{median(column):.2f}" for column in zip(*times, strict=True))
        if picture is not None:
            _draw(browser, f"{address}#{leaf}", picture)


def _opened(browser: Browser, address: str, leaf: str, window: tuple[int, int]) -> tuple[float, float]:
    """Return the times to the first picture of the list, and from a click to a fabric that turns [s]."""
    page = _page(browser, window)
    began = time.perf_counter()
    page.goto(address, wait_until="commit")
    page.wait_for_function(f"() => [...document.querySelectorAll('#cards img')].some({SHOWN})")
    first, clicked = time.perf_counter() - began, time.perf_counter()
    page.locator(f'#cards a[href="#{leaf}"]').click()
    page.locator("#turning").wait_for(state="visible")
    turning = time.perf_counter() - clicked
    page.close()
    return first, turning


def _draw(browser: Browser, address: str, path: Path) -> None:
    """Write a picture of a leaf, whose fabric is turned a little."""
    page = _page(browser, SIZES[0])
    page.goto(address)
    page.locator("#turning").wait_for(state="visible")
    page.locator("#turning").focus()
    for key in ("ArrowRight", "ArrowRight", "ArrowDown", "ArrowDown"):
        page.keyboard.press(key)
    page.locator("#title").focus()
    page.wait_for_timeout(500)
    shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    shot.resize((WIDTH, round(shot.height * WIDTH / shot.width)), Image.Resampling.LANCZOS).save(path, quality=85)
    page.close()


def _page(browser: Browser, window: tuple[int, int]) -> Page:
    return browser.new_page(viewport={"width": window[0], "height": window[1]})
