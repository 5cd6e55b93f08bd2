# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The state that the parts of the page Drape share: the scene, its changes with undo, and the folders of both.

Each earlier scene is a file, named by its checksum, so that a change writes one small file and a list of names.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from stitchmesh.app.pages.drape.opened_scene import OpenedScene, open_scene, scene_of_file, with_region, with_scene
from stitchmesh.compute.device import alone
from stitchmesh.editing.undo_history import UndoHistory
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.atomic import write_json
from stitchmesh.io.checked import check_value, read_json
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.drape import SCENE_FILE
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import Scene, read_scene, scene_text, write_scene
from stitchmesh.progress import Progress

if TYPE_CHECKING:
    from stitchmesh.app.application import App

ORDER = "order.json"
"""Name of the list."""
DIGITS = 20
"""Number of digits of the checksum in the name of a scene."""
SCENE_NAME = re.compile(rf"[0-9a-f]{{{DIGITS}}}\.toml")
"""Pattern of the name of a scene; other files in the folder belong to the user."""


@dataclass(frozen=True)
class _Order:
    """Names of the scenes of a history."""

    scene: str
    before: tuple[str, ...]
    """Earlier scenes, the newest last."""
    after: tuple[str, ...]
    """Scenes that were undone; the next one to redo is the last."""


def write_history(folder: Path, history: UndoHistory[Scene]) -> None:
    """Write a history into a folder, and delete the scenes that it no longer has.

    Raises:
        FileError: a file cannot be written.
    """
    names = {name_of(scene): scene for scene in (*history.past, *history.future)}
    for name, scene in names.items():
        if not (folder / name).exists():
            write_scene(folder / name, scene)
    order = {
        "scene": name_of(history.present),
        "before": [name_of(scene) for scene in history.past],
        "after": [name_of(scene) for scene in reversed(history.future)],
    }
    write_json(folder / ORDER, order)
    for path in folder.glob("*.toml"):
        if SCENE_NAME.fullmatch(path.name) and path.name not in names:
            path.unlink(missing_ok=True)


def read_history(folder: Path, scene: Scene) -> UndoHistory[Scene]:
    """Return the history of a scene from a folder; without a valid history there, one without changes.

    A change of the scene from outside, for example by hand, can be undone; scenes to redo are then forgotten.
    """
    try:
        order = check_value(read_json(folder / ORDER), _Order)
        before = tuple(read_scene(folder / Path(name).name) for name in order.before)
        after = tuple(read_scene(folder / Path(name).name) for name in reversed(order.after))
    except (FileError, ParameterError, ValueError):
        return UndoHistory(scene)
    return UndoHistory(scene, before, after if order.scene == name_of(scene) else ())


def name_of(scene: Scene) -> str:
    """Return the name of the file of a scene."""
    return f"{hashlib.sha256(scene_text(scene).encode()).hexdigest()[:DIGITS]}.toml"


FOLDER, RUN, FILES, HISTORY = "drape", "run", "files", "history"
"""Folder in the project, and the folders in it: for the run, for uploaded files, and for earlier scenes."""


class DrapeSession:
    """The scene of the page. All methods belong to the event thread."""

    def __init__(self, app: App, shown: Callable[[], None]) -> None:
        """Start without a scene; ``shown`` is called after each change."""
        self.app, self.show = app, shown
        self.opened: OpenedScene | None = None
        self.history: UndoHistory[Scene] | None = None

    @property
    def scene(self) -> Scene | None:
        """The scene; None while none is open."""
        return None if self.opened is None else self.opened.scene

    @property
    def folder(self) -> Path:
        """Folder of the page in the project."""
        return self.app.project.folder / FOLDER

    @property
    def scene_path(self) -> Path:
        """File of the scene in the project."""
        return self.folder / SCENE_FILE

    @property
    def run_folder(self) -> Path:
        """Output folder of the run."""
        return self.folder / RUN

    @property
    def history_folder(self) -> Path:
        """Folder of the scenes to which undo and redo lead."""
        return self.folder / HISTORY

    def opened_for(self, what: str) -> OpenedScene:
        """Return the scene.

        Raises:
            ParameterError: no scene is open; the message begins with ``what``, which needs one.
        """
        if self.opened is None:
            raise ParameterError(f"{what}: there is no cloth yet; open a scene first")
        return self.opened

    def open_path(self, path: Path) -> None:
        """Open a scene, or a new scene for a cloth; it replaces the scene of the project.

        Raises:
            ParameterError: another task runs.
        """

        def done(opened: OpenedScene) -> None:
            self._take(opened, UndoHistory(opened.scene))

        folder = self.run_folder
        self._open(lambda progress: open_scene(scene_of_file(path), folder, progress), done)

    def open_kept(self) -> None:
        """Open the scene of the project, if it has one and no task runs."""
        if self.opened is None and self.scene_path.is_file() and not self.app.tasks.running:
            path, folder = self.scene_path, self.run_folder
            self._open(lambda progress: open_scene(read_scene(path), folder, progress), self._take_kept)

    def change(self, scene: Scene) -> None:
        """Change the scene.

        Raises:
            ParameterError: another task runs.
        """
        history = self._history()
        if scene != history.present:
            self._go_to(history.do(scene, most=100))

    def change_region(self, change: Callable[[RegionSection, Cloth], RegionSection]) -> None:
        """Change the region: the function takes the region and the cloth."""
        scene = self._history().present
        assert self.opened is not None
        self.change(replace(scene, region=change(scene.region, self.opened.cloth)))

    def undo(self) -> None:
        """Return to the scene before the last change; without a change, the scene stays."""
        history = self._history()
        self._go_to(history.undo("") if history.past else history)

    def redo(self) -> None:
        """Make the last undone change again; without one, the scene stays."""
        history = self._history()
        self._go_to(history.redo("") if history.future else history)

    def _go_to(self, history: UndoHistory[Scene]) -> None:
        """Show the present scene of a history; a change of the region alone appears at once."""
        self._check_idle()
        opened, scene = self.opened, history.present
        assert opened is not None
        if replace(scene, region=opened.scene.region) == opened.scene:
            self._take(with_region(opened, scene.region), history)
            return

        def done(found: OpenedScene) -> None:
            self._take(found, history)

        folder = self.run_folder
        self._open(lambda progress: with_scene(opened, scene, folder, progress), done)

    def _open(self, work: Callable[[Progress], OpenedScene], done: Callable[[OpenedScene], None]) -> None:
        """Build a scene in the worker thread; errors become notices, and the scene before stays."""
        project = self.app.project

        def make(progress: Progress) -> OpenedScene:
            with alone():
                return work(progress)

        def take(opened: OpenedScene) -> None:
            if self.app.project is project:
                done(opened)

        self.app.tasks.start("opening the scene", make, take, lambda error: self.show())

    def _take_kept(self, opened: OpenedScene) -> None:
        self.history, self.opened = read_history(self.history_folder, opened.scene), opened
        self.show()

    def _take(self, opened: OpenedScene, history: UndoHistory[Scene]) -> None:
        """Keep a scene and its history, in the project too, and show the scene."""
        self.opened, self.history = opened, history
        write_scene(self.scene_path, opened.scene)
        write_history(self.history_folder, history)
        self.show()

    def _history(self) -> UndoHistory[Scene]:
        if self.history is None or self.opened is None:
            raise ParameterError("scene: there is none yet; open one first")
        return self.history

    def _check_idle(self) -> None:
        """Check that nothing that uses the scene runs.

        Raises:
            ParameterError: something that uses the scene runs.
        """
        task = self.app.tasks.current
        if task is not None:
            raise ParameterError(f"scene: cannot change during {task.name}; stop that first, or wait")
