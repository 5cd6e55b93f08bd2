# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenes as files: TOML with the fields of ``Scene`` as keys. Paths in a file are relative to its folder."""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass, replace
from os import fspath
from pathlib import Path
from typing import Any

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.checked import check_table
from stitchmesh.io.contents import FilePath, read_bytes, suffix_of
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.yarns_section import is_file

SUFFIX = ".toml"
HEADER = """\
# A scene of mixed yarns and triangles: stitchmesh drape SCENE -o DIR runs it.
# docs/how-to/drape.md explains every key. Lengths are in cm, times in s; y points up. Paths are relative to this file.
"""
INLINE = ("position", "first", "second", "low", "high")
"""Keys whose tables are written within one line."""


def read_scene(path: FilePath) -> Scene:
    """Read a scene from a TOML file.

    Raises:
        FileError: the file cannot be read, is not TOML, or has a key or a value that no scene has; the message names
            the key and, for an unknown key, the nearest known one.
    """
    name = fspath(path)
    suffix_of(path, [SUFFIX])
    try:
        table = tomllib.loads(read_bytes(path).decode("utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FileError(f"{name}: is no TOML ({error})") from error
    except RecursionError as error:
        raise FileError(f"{name}: is no TOML that can be read; it is nested too deeply") from error
    try:
        scene = check_table(table, Scene)
    except ParameterError as error:
        raise FileError(f"{name}: {error}") from error
    return _with_paths(scene, lambda inside: fspath(Path(path).parent / inside))


def write_scene(path: FilePath, scene: Scene) -> None:
    """Write a scene as a TOML file; the file is written atomically. Keys whose value is the default are left out.

    Raises:
        FileError: the file cannot be written, or its suffix is not ``.toml``.
    """
    suffix_of(path, [SUFFIX])
    folder = Path(path).resolve().parent
    moved = _with_paths(scene, lambda inside: Path(os.path.relpath(inside, folder)).as_posix())
    write_text(path, HEADER + "\n" + "\n".join(_lines(changed_fields(moved), "")) + "\n")


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
        yarns=replace(yarns, knit=library(yarns.knit), material_file=file(yarns.material_file)),
        bodies=tuple(replace(body, file=file(body.file)) for body in scene.bodies),
    )


def changed_fields(value: Any) -> dict[str, Any]:
    """Return the fields of a dataclass that differ from their defaults, with nested dataclasses as tables."""
    table: dict[str, Any] = {}
    for part in fields(value):
        found = getattr(value, part.name)
        default = part.default_factory() if part.default_factory is not MISSING else part.default
        if found == default:
            continue
        if isinstance(found, tuple) and found and is_dataclass(found[0]):
            found = [changed_fields(one) for one in found]
        table[part.name] = changed_fields(found) if is_dataclass(found) else found
    return table


def _lines(table: Mapping[str, Any], name: str) -> Iterator[str]:
    """Yield the lines of a table: its values first, then its tables."""
    nested = {key: value for key, value in table.items() if _is_nested(key, value)}
    for key, value in table.items():
        if key not in nested:
            yield f"{key} = {_text(value)}"
    for key, value in nested.items():
        for one in value if isinstance(value, list) else [value]:
            yield ""
            yield f"[[{name}{key}]]" if isinstance(value, list) else f"[{name}{key}]"
            yield from _lines(one, f"{name}{key}.")


def _is_nested(key: str, value: object) -> bool:
    is_tables = isinstance(value, list) and bool(value) and all(isinstance(one, dict) for one in value)
    return is_tables or (isinstance(value, dict) and key not in INLINE)


def _text(value: object) -> str:
    """Return a value as TOML: a text, a number, true or false, a list of these, or a table within one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_text(part)}" for key, part in value.items()) + " }"
    if isinstance(value, list | tuple):
        return f"[{', '.join(_text(part) for part in value)}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return str(value).lower() if isinstance(value, bool) else repr(value)
