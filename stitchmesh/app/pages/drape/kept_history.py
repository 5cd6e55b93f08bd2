# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The history of a scene on disk, so that undo goes on after the program was closed.

Each scene is a file that is named by its checksum, so that a change writes one small file and a list of names.
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from pathlib import Path

from stitchmesh.editing.undo_history import UndoHistory
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.atomic import write_json
from stitchmesh.io.checked import check_value, read_json
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.scene_file import read_scene, scene_text, write_scene

ORDER = "order.json"
"""Name of the list."""
DIGITS = 20
"""Digits of the checksum in the name of a scene."""
SCENE_NAME = re.compile(rf"[0-9a-f]{{{DIGITS}}}\.toml")
"""Form of the name of a scene; other files in the folder are the user's."""


@dataclass(frozen=True)
class _Order:
    """Names of the scenes of a history."""

    scene: str
    before: tuple[str, ...]
    """Earlier scenes, the newest last."""
    after: tuple[str, ...]
    """Scenes that were undone, the one to come back next last."""


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
    """Return the history of a scene that a folder holds; one without changes if there is none, or if it is damaged.

    A scene that was changed otherwise since, for example by hand, can be undone, and what was undone is forgotten.
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
