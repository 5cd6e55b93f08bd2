# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The application: one project, one front and one open page, joined by the event queue."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import TYPE_CHECKING

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.front import Front, Listener, NoticeKind
from stitchmesh.app.pages.all_pages import PAGES, show_not_yet
from stitchmesh.app.pages.navigation import Navigation
from stitchmesh.app.pages.page import Page
from stitchmesh.app.project.opening import keep_dark, prefers_dark
from stitchmesh.app.scene.scene import DrawingScene, Pick, ScreenBox, Stroke
from stitchmesh.app.task import TaskRunner
from stitchmesh.errors import ParameterError, StitchMeshError

if TYPE_CHECKING:
    from stitchmesh.app.project.project import Project

logger = logging.getLogger(__name__)

APP_SETTINGS = "application"
"""Name under which the project keeps the settings of the application itself."""
TITLES: dict[NoticeKind, str] = {"info": "StitchMesh", "warning": "Please note", "error": "Not possible"}


class App:
    """The object that every page gets. Its fields belong to the event thread."""

    def __init__(self, project: Project, front: Front) -> None:
        """Join a project and a front; ``open_page`` shows the first page."""
        self.project, self.front = project, front
        self.queue = front.queue
        self.queue.on_error = self.report
        self.tasks = TaskRunner(self.queue, self.report)
        self.page: Page | None = None
        self._is_built = False
        self._pages: dict[str, Page] = {}
        self._navigation = Navigation(front.navigation, self.open_page, self._set_dark)
        self._navigation.dark = prefers_dark()
        front.set_dark(self._navigation.dark)
        self._watch_project()
        front.listen(Listener(self._picked, self._stroked, self._boxed, self._camera_moved))

    @property
    def scene(self) -> DrawingScene:
        """The scene."""
        return self.front.scene

    @property
    def controls(self) -> Controls:
        """The controls of the open page."""
        return self.front.controls

    @property
    def left_controls(self) -> Controls:
        """The controls on the left, for example a chart."""
        return self.front.left_controls

    def post(self, function: Callable[..., object], *arguments: object) -> None:
        """Call a function in the event thread; any thread may call this."""
        self.queue.post(function, *arguments)

    def notice(self, text: str, kind: NoticeKind = "info", title: str | None = None) -> None:
        """Show a message to the user."""
        self.front.notice(title or TITLES[kind], text, kind)

    def download(self, name: str, content: bytes, client: int | None = None) -> None:
        """Send a file to the browser with a number, by default to the browser that asked for the present call.

        A task or a thread makes its file later than the user asks for it; it must keep ``front.acting_client`` until
        then.
        """
        self.front.download(name, content, client)

    def report(self, error: Exception) -> None:
        """Show an error as a notice; an error from outside the library is also logged with its origin."""
        if isinstance(error, StitchMeshError):
            self.notice(str(error), "error")
            return
        logger.error("the application met an error that it does not know", exc_info=error)
        self.notice(f"{type(error).__name__}: {error}; your work is saved, please go on", "error", "Internal error")

    def open_page(self, name: str) -> None:
        """Leave the open page, and open another one; an unavailable page says what the user must do first.

        Raises:
            ParameterError: there is no such page.
        """
        if name not in PAGES:
            raise ParameterError(f"page: got {name!r}; expected one of {', '.join(PAGES)}")
        self._close_page()
        page = self._pages.get(name) or PAGES[name](self)
        self._pages[name] = self.page = page
        self.project.set_settings(APP_SETTINGS, {**self.project.settings(APP_SETTINGS), "page": name})
        self.front.name_left_panel(page.left_title, page.left_width)
        reason = page.unavailable()
        self._navigation.show(name, reason or page.hint)
        self._is_built = reason is None
        if self._is_built:
            page.build()
        else:
            show_not_yet(self, page, PAGES)

    def refresh(self) -> None:
        """Show the project after a change; a page that becomes available or unavailable is built anew."""
        if self.page is None:
            return
        if self._is_built != (self.page.unavailable() is None):
            self.open_page(self.page.name)
        elif self._is_built:
            self.page.refresh()

    def set_project(self, project: Project) -> None:
        """Take another project, and open the page that was open when the user left it."""
        self.tasks.cancel()
        self._close_page()
        try:
            self.project.close()
        except StitchMeshError as error:
            self.report(error)
        self.project = project
        self._watch_project()
        self._pages.clear()
        self.open_page(self.last_page())

    def last_page(self) -> str:
        """Return the page that was open when the user left the project; for a new project the first page."""
        page = self.project.settings(APP_SETTINGS).get("page")
        return page if page in PAGES else next(iter(PAGES))

    def close(self) -> None:
        """End the task, save the project, and end all connections.

        Raises:
            FileError: the disk refuses the project.
        """
        refused: list[StitchMeshError] = []
        self.tasks.cancel()
        self.queue.post(self._close_page)
        self.queue.post(self._save_last, refused)
        self.queue.stop()
        self.front.close()
        if refused:
            raise refused[0]

    def _save_last(self, refused: list[StitchMeshError]) -> None:
        """Save and close the project; an error is kept for the end, because nobody sees a notice any more."""
        try:
            self.project.close()
        except StitchMeshError as error:
            refused.append(error)

    def _set_dark(self, dark: bool) -> None:
        """Show dark or light colours, now and at the next start."""
        self.front.set_dark(dark)
        keep_dark(dark)

    def _watch_project(self) -> None:
        """Show a notice when the project cannot be saved, and another when it can be saved again."""
        self.project.on_trouble = lambda message: self.post(self._say_trouble, message)

    def _say_trouble(self, message: str | None) -> None:
        if message is None:
            self.notice("The project is saved again.")
        else:
            self.notice(f"{message}. It is tried again every few seconds.", "error", "Not saved")
        self.refresh()

    def _close_page(self) -> None:
        if self.page is not None and self._is_built:
            self.page.leave()
        self.page, self._is_built = None, False
        self.controls.clear()
        self.left_controls.clear()
        self.scene.clear()

    def _picked(self, pick: Pick) -> None:
        if self.page is not None and self._is_built:
            self.page.picked(pick)

    def _stroked(self, stroke: Stroke) -> None:
        if self.page is not None and self._is_built:
            self.page.stroked(stroke)

    def _boxed(self, box: ScreenBox) -> None:
        if self.page is not None and self._is_built:
            self.page.boxed(box)

    def _camera_moved(self) -> None:
        if self.page is not None and self._is_built:
            self.page.camera_moved()
