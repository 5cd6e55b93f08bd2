# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The application in a real browser: a page that tests click, drag, type and read.

    def test_a_row_is_labeled(app_in_browser):
        with app_in_browser() as rig:
            rig.app.open_page("Label")          # or rig.page_button("Label")
            rig.click_at(point)                 # a point of the scene [cm]
            rig.press("Label all")
            assert rig.app.project.labeled is not None

``rig.browser_page`` is the page of Playwright, for everything that has no method here. A test fails if the browser
reports an error, if the server prints a traceback, or if the page asks for anything outside this machine.
"""

from __future__ import annotations

import contextlib
import itertools
import logging
import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, ConsoleMessage, Locator, Page, Request, sync_playwright

from stitchmesh.app.application import App
from stitchmesh.app.project.project import Project
from stitchmesh.app.scene.viser_scene import view_of
from stitchmesh.app.server import OpenServer, open_server
from stitchmesh.app.viser_front import ViserFront
from stitchmesh.mesh import FloatArray

NAMES = ("chromium", "chromium-browser", "google-chrome")
"""Names of the programs that can be the browser."""
ARGUMENTS = [
    "--no-sandbox", "--use-gl=angle", "--use-angle=gl-egl", "--ignore-gpu-blocklist", "--disable-quic",
    "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--hide-scrollbars", "--disable-dev-shm-usage", "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1",
]  # fmt: skip
"""Mesa draws in software where there is no graphics card; no request leaves the machine."""
SIZE = (1000, 700)
"""Width and height of the window of most tests [pixels]."""
WAIT = 60_000
"""Longest time for which a test waits for the page before it fails [ms]."""
LONGEST_TASK = 600_000
"""Longest time for which a test waits for the end of a task [ms]; a relaxation takes long where others compute too."""
HARMLESS = (
    "Unable to preventDefault inside passive event listener", "GPU stall due to ReadPixels",
    "Tried to update non-existent component",
)  # fmt: skip
"""Parts of messages of the browser that mean no fault of the application.

Viser joins messages that it has not sent yet. The last value of a control that was removed at once can therefore arrive
without the control.
"""
READY = """() => {
  const state = window.__viserMutable, points = window.__viserTestpoints;
  if (!state || !state.scene || !state.canvas || !points || !window.stitchmesh?.inbox) return false;
  const opacity = state.canvas.style.opacity;
  return state.messageQueue.length === 0 && points.rendererInfo.render.frame > 5
    && (opacity === "" || parseFloat(opacity) >= 1);
}"""
"""Whether the page has drawn everything that it was sent; viser fades its canvas in."""
CLOSE_NOTICE_OF_SLOWNESS = """(() => {
  const close = () => {
    for (const notice of document.querySelectorAll(".mantine-Notification-root")) {
      if (notice.textContent.includes("Software WebGL")) notice.querySelector("button")?.click();
    }
  };
  new MutationObserver(close).observe(document, { childList: true, subtree: true });
})();"""
"""Closes the notice by which viser says that the browser draws in software, at whatever time it comes."""
CLOSE_NOTICES = "() => document.querySelectorAll('.mantine-Notification-root button').forEach(each => each.click())"
SEND_FENCE = """(number) => new Promise(done => setTimeout(() => {
  window.stitchmesh.send("fence", { fence: number });
  done();
}, 80))"""
"""Sends a message after all that the page has to send; viser keeps the newest value of an input for up to 50 ms."""
TWO_FRAMES = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
CANVAS = """() => {
  const box = window.__viserMutable.canvas.getBoundingClientRect();
  return [box.left, box.top, box.width, box.height];
}"""


def chromium_path() -> str:
    """Return the path of the browser, or skip the test on a machine that has none."""
    for name in NAMES:
        if (path := shutil.which(name)) is not None:
            return path
    if os.environ.get("STITCHMESH_NEEDS_BROWSER"):
        raise FileNotFoundError(f"none of {', '.join(NAMES)} is installed, and the variable asks for one")
    pytest.skip(f"none of {', '.join(NAMES)} is installed; on Debian: apt-get install chromium libatomic1")


@contextlib.contextmanager
def started_browser() -> Iterator[Browser]:
    """Start the browser without a window."""
    path = chromium_path()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=ARGUMENTS)
        yield browser
        browser.close()


class BrowserWindow:
    """A page in the browser, with what went wrong in it."""

    _fences = itertools.count(1)

    def __init__(self, browser: Browser, address: str, size: tuple[int, int] = SIZE, *, dark: bool = False) -> None:
        """Open a page and wait until it is drawn."""
        context = browser.new_context(
            viewport={"width": size[0], "height": size[1]}, accept_downloads=True,
            color_scheme="dark" if dark else "light",
        )  # fmt: skip
        self.browser_page: Page = context.new_page()
        self.browser_page.set_default_timeout(WAIT)
        self.browser_page.add_init_script(CLOSE_NOTICE_OF_SLOWNESS)
        self.faults: list[str] = []
        self.browser_page.on("pageerror", lambda error: self.faults.append(f"page: {error}"))
        self.browser_page.on("console", self._hear)
        self.browser_page.on("request", self._watch)
        self._own = address.partition("?")[0].rstrip("/")
        separator = "&" if "?" in address else "?"
        self.browser_page.goto(f"{address}{separator}fixedDpr=1")
        self.wait_until_ready()

    def wait_until_ready(self) -> None:
        """Wait until the page has drawn what it was sent when it was loaded."""
        self.browser_page.wait_for_function(READY)

    def wait_for(self, condition: Callable[[], Any], what: str = "", longest: int = WAIT) -> None:
        """Wait until a condition of this process holds, while the page goes on; fail after the longest time [ms]."""
        for _ in range(longest // 20):
            if condition():
                return
            self.browser_page.wait_for_timeout(20)
        raise AssertionError(f"waited for {longest // 1000} s in vain: {what}")

    def close(self) -> None:
        """Close the page."""
        self.browser_page.context.close()

    def press(self, label: str, option: str | None = None) -> None:
        """Press a button, or one option of a row of buttons."""
        self.button(option or label).click()

    def button(self, name: str) -> Locator:
        """Return the button with exactly this name."""
        return self.browser_page.get_by_role("button", name=name, exact=True).first

    def page_button(self, name: str) -> None:
        """Open a page, or the section in which it stands, by the navigation."""
        self.browser_page.locator(f'button[data-value="{name}"]').first.click()

    def open_group(self, label: str) -> None:
        """Open or close a group of controls."""
        self.browser_page.get_by_text(label, exact=True).first.click()

    def row(self, label: str) -> Locator:
        """Return the row of an input, with its label."""
        named = self.browser_page.locator("label").get_by_text(label, exact=True)
        return named.locator("xpath=ancestor::div[contains(@class,'mantine-Flex-root')][1]")

    def type(self, label: str, value: object) -> None:
        """Type a value into a number, a slider or a text, and leave it."""
        field = self.row(label).locator("input, textarea").last
        field.click()
        field.fill(str(value))
        field.press("Tab")

    def tick(self, label: str, value: bool = True) -> None:
        """Tick a box, or remove the tick."""
        self.browser_page.get_by_label(label, exact=True).set_checked(value)

    def choose(self, label: str, option: str) -> None:
        """Choose an option of a list."""
        self.row(label).locator("input").first.click()
        self.browser_page.get_by_role("option", name=option, exact=True).click()

    def act(self, action: str, value: str = "") -> None:
        """Click an element of HTML by its action and its value."""
        self.browser_page.locator(f'[data-action="{action}"][data-value="{value}"]').first.click()

    def upload(self, path: Path, nth: int = 0) -> None:
        """Choose a file for an upload; ``nth`` counts the uploads of the panel."""
        self.browser_page.locator("input[type=file]").nth(nth).set_input_files(str(path))

    def downloaded(self, act: Callable[[], object]) -> tuple[str, bytes]:
        """Return the name and the content of the file that an action sends."""
        with self.browser_page.expect_download() as download:
            act()
        return download.value.suggested_filename, Path(download.value.path()).read_bytes()

    def key(self, key: str) -> None:
        """Press a key, such as ``Control+z``, with the focus on the scene."""
        self.browser_page.evaluate("() => document.activeElement && document.activeElement.blur()")
        self.browser_page.keyboard.press(key)

    def wait_for_text(self, text: str) -> None:
        """Wait until a text can be read in the page."""
        self.browser_page.get_by_text(text).first.wait_for()

    def notices(self) -> list[str]:
        """Return the texts of the notices that stand in the page."""
        return self.browser_page.locator(".mantine-Notification-root").all_inner_texts()

    def close_notices(self) -> None:
        """Close the notices that stand in the page."""

        def are_closed() -> bool:
            self.browser_page.evaluate(CLOSE_NOTICES)  # A notice that still slides in takes no click.
            return not self.notices()

        self.wait_for(are_closed, "notices close")

    def screenshot(self, path: Path | None = None) -> bytes:
        """Return a picture of the whole page as a PNG file, and write it if there is a path."""
        return self.browser_page.screenshot(path=path)

    def place(self, share: Sequence[float]) -> tuple[float, float]:
        """Return the place in the page of a place on the scene, (0, 0) its upper left corner and (1, 1) the other."""
        left, top, width, height = self.browser_page.evaluate(CANVAS)
        return left + share[0] * width, top + share[1] * height

    def _hear(self, message: ConsoleMessage) -> None:
        if message.type == "error" and not any(part in message.text for part in HARMLESS):
            self.faults.append(f"console: {message.text}")

    def _watch(self, request: Request) -> None:
        if not request.url.startswith((self._own, f"blob:{self._own}", "data:")):
            self.faults.append(f"request of another machine: {request.url}")


class Rig(BrowserWindow):
    """The application and a page that shows it, in one process."""

    def __init__(self, browser: Browser, opened: OpenServer, app: App, size: tuple[int, int], *, dark: bool) -> None:
        """Open a page of an application that runs."""
        self.app, self.opened, self._browser = app, opened, browser
        self._heard = 0
        app.front.bridge.receive("fence", self._hear_fence)
        self._fence = opened.server.gui.add_html(_fence_text(0))
        super().__init__(browser, opened.address, size, dark=dark)
        self.settle()

    def wait_for(self, condition: Callable[[], Any], what: str = "", longest: int = WAIT) -> None:
        """Wait as ``BrowserWindow`` does; there is no page while one takes the place of another."""
        super().wait_for(lambda: self.app.page is not None and condition(), what, longest)

    @property
    def client(self) -> Any:
        """The browser as viser knows it; the newest one."""
        return self.opened.server.get_clients()[max(self.opened.server.get_clients())]

    def another_window(self, size: tuple[int, int] = SIZE) -> BrowserWindow:
        """Open a second browser on the same application."""
        return BrowserWindow(self._browser, self.opened.address, size)

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a function in the thread of the events, and return its value."""
        found: list[Any] = []
        self.app.post(lambda: found.append(function(*arguments)))
        self.wait_for(lambda: found, "a call in the thread of the events")
        return found[0]

    def settle(self) -> None:
        """Wait until all that the page sent is handled, no task runs, and the page has drawn all that it was sent."""
        number, page = next(self._fences), self.browser_page
        page.evaluate(SEND_FENCE, number)
        self.wait_for(lambda: self._heard >= number, "the messages of the page arrive")
        self.app.queue.settle()
        self.wait_for(lambda: self.app.tasks.current is None, "the task ends", LONGEST_TASK)
        self.app.queue.settle()
        self._fence.content = _fence_text(number)
        page.wait_for_function(f"() => document.querySelector('[data-fence=\"{number}\"]') !== null")
        page.evaluate(TWO_FRAMES)
        page.wait_for_function("() => window.__viserMutable.messageQueue.length === 0")

    def _hear_fence(self, message: dict[str, Any], _client: int | None) -> None:
        self._heard = message["fence"]

    def on_page(self, point: Sequence[float]) -> tuple[float, float]:
        """Return the place in the page at which a point of the scene is drawn [cm].

        The page sends the first place of its camera some time after it has drawn the scene.
        """

        def share() -> FloatArray:
            return view_of(self.client).on_screen(np.asarray([point], dtype=np.float64))[0]

        self.wait_for(lambda: bool(((share() >= 0.0) & (share() <= 1.0)).all()), f"{point} is in view")
        return self.place(share())

    def click_at(self, point: Sequence[float], modifier: str | None = None) -> None:
        """Click where a point of the scene is drawn; ``modifier`` is ``Shift`` or ``Control``."""
        self.click_page(self.on_page(point), modifier)

    def click_page(self, place: Sequence[float], modifier: str | None = None) -> None:
        """Click at a place in the page, and wait until the click has been handled."""
        page = self.browser_page
        page.mouse.move(place[0], place[1])
        with self._held(modifier):
            page.mouse.click(place[0], place[1])
        page.wait_for_timeout(120)  # Viser joins clicks that follow each other within 50 ms.
        self.settle()

    def drag(self, points: Sequence[Sequence[float]], modifier: str | None = None) -> None:
        """Drag over points of the scene."""
        self.drag_page([self.on_page(point) for point in points], modifier)

    def drag_page(self, places: Sequence[Sequence[float]], modifier: str | None = None) -> None:
        """Drag over places in the page."""
        page = self.browser_page
        page.mouse.move(*places[0])
        with self._held(modifier):
            page.mouse.down()
            for place in places[1:]:
                page.mouse.move(*place, steps=8)
                page.wait_for_timeout(60)  # Viser sends the moves of a drag twenty times a second.
            page.mouse.up()
        page.wait_for_timeout(120)
        self.settle()

    @contextlib.contextmanager
    def _held(self, modifier: str | None) -> Iterator[None]:
        if modifier is not None:
            self.browser_page.keyboard.down(modifier)
        yield
        if modifier is not None:
            self.browser_page.keyboard.up(modifier)


@contextlib.contextmanager
def running_app(folder: Path) -> Iterator[tuple[OpenServer, App]]:
    """Run the application on the project of a folder, without a browser."""
    opened = open_server(port=0)
    app = App(Project.open_or_create(folder), ViserFront(opened.server))
    app.post(lambda: app.open_page(app.last_page()))
    app.queue.settle()
    try:
        yield opened, app
    finally:
        app.close()
        opened.stop()


@contextlib.contextmanager
def rig_on(
    browser: Browser, folder: Path, page: str | None = None, size: tuple[int, int] = SIZE, *, dark: bool = False
) -> Iterator[Rig]:
    """Run the application on a folder, with a page that shows it; see the text of this module."""
    errors = _ErrorLog()
    logging.getLogger("stitchmesh").addHandler(errors)
    try:
        with running_app(folder) as (opened, app):
            if page is not None:
                app.post(app.open_page, page)
                app.queue.settle()
            rig = Rig(browser, opened, app, size, dark=dark)
            errors.lines = rig.faults
            yield rig
            rig.settle()
            rig.close()
            if rig.faults:
                raise AssertionError("; ".join(rig.faults))
    finally:
        logging.getLogger("stitchmesh").removeHandler(errors)


class SharedRig:
    """A page that is loaded once, and shows the project of one test after another; to load a page takes seconds."""

    def __init__(self, browser: Browser, folder: Path) -> None:
        """Load nothing yet; ``folder`` is the place of an empty project, which the page shows between two tests."""
        self._browser, self._empty = browser, folder
        self._loaded = contextlib.ExitStack()
        self._rig: Rig | None = None

    @contextlib.contextmanager
    def on(self, folder: Path, page: str | None = None, size: tuple[int, int] = SIZE) -> Iterator[Rig]:
        """Open the project of a folder, and close it at the end; after an error the next test gets a page of its own.

        A test that sets a variable of a script in the page sets it back.
        """
        rig = self._rig or self._loaded.enter_context(rig_on(self._browser, self._empty))
        self._rig = None
        rig.browser_page.set_viewport_size({"width": size[0], "height": size[1]})
        rig.call(_open_folder, rig.app, folder, page)
        rig.settle()
        yield rig
        rig.settle()
        rig.call(_open_folder, rig.app, self._empty, None)
        rig.call(rig.app.front.set_dark, False)
        rig.close_notices()
        faults = "; ".join(rig.faults)
        rig.faults.clear()
        self._rig = rig
        if faults:
            raise AssertionError(faults)

    def close(self) -> None:
        """End the application, if a test has started it."""
        self._loaded.close()


ELSEWHERE = np.array([1e3, 0.0, 0.0]), np.array([1e3, 1.0, 1.0])
"""A box that no test shows, so that a page places the camera even where the test before has turned it."""


def _open_folder(app: App, folder: Path, page: str | None) -> None:
    """Take the project of a folder, on the page on which it was left or another one."""
    app.scene.look_at(*ELSEWHERE, "front")
    app.set_project(Project.open_or_create(folder))
    if page is not None and app.page is not None and app.page.name != page:
        app.open_page(page)


class _ErrorLog(logging.Handler):
    """Keeps what was logged as an error."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.lines.append(self.format(record))


def _fence_text(number: int) -> str:
    return f'<span data-fence="{number}" style="display:none"></span>'
