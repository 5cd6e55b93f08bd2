# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenes as files: TOML with the fields of ``Scene`` as keys. Paths in a file are relative to its folder."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.io.path_kind import whole_path
from stitchmesh.io.toml_file import SUFFIX, changed_fields, read_dataclass, table_lines
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.yarns_section import is_file

HEADER = """\
# A scene of mixed yarns and triangles: stitchmesh drape SCENE -o DIR runs it.
# docs/settings.md lists every key. Lengths are in cm, times in s; y points up. Paths are relative to this file.
"""
INLINE = ("position", "first", "second", "low", "high")
"""Keys whose tables are written within one line."""


def read_scene(path: FilePath) -> Scene:
    """Read a scene from a TOML file.

    Raises:
        FileError: the file cannot be read, is not TOML, or has an unknown key or an impossible value; the message names
            the key and, for an unknown key, the nearest known one.
    """
    scene = read_dataclass(path, Scene)
    return _with_paths(scene, lambda inside: os.path.normpath(Path(path).parent / inside))


def write_scene(path: FilePath, scene: Scene) -> None:
    """Write a scene as a TOML file; the file is written atomically. Keys whose value is the default are left out.

    Raises:
        FileError: the file cannot be written, or its suffix is not ``.toml``.
    """
    suffix_of(path, [SUFFIX])
    write_text(path, scene_text(scene, whole_path(path).parent))


def scene_text(scene: Scene, folder: Path | None = None) -> str:
    """Return a scene as the text of a TOML file in a folder; without a folder, the paths in it are absolute."""

    def relative(inside: str) -> str:
        return (Path(inside).absolute() if folder is None else Path(os.path.relpath(inside, folder))).as_posix()

    moved = _with_paths(scene, relative)
    return HEADER + "\n" + "\n".join(table_lines(changed_fields(moved), inline=INLINE)) + "\n"


def example_scene() -> str:
    """Return the text of an example scene, with comments."""
    return Path(__file__).with_name("example.toml").read_text(encoding="utf-8")


def _with_paths(scene: Scene, change: Callable[[str], str]) -> Scene:
    """Return a scene with all paths of files changed."""

    def file(name: str | None) -> str | None:
        return None if name is None else change(name)

    def library(name: Any) -> Any:
        return change(name) if isinstance(name, str) and is_file(name) else name

    cloth, yarns = scene.cloth, scene.yarns
    return replace(
        scene,
        cloth=replace(cloth, file=file(cloth.file), material=library(cloth.material)),
        yarns=replace(
            yarns,
            weave=library(yarns.weave),
            knit=library(yarns.knit),
            material_file=file(yarns.material_file),
        ),
        bodies=tuple(replace(body, file=file(body.file)) for body in scene.bodies),
    )
