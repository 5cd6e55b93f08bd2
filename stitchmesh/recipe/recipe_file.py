# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Recipes as files: TOML with the fields of ``Recipe`` as keys.

Each table ``[[edits]]`` has the name of the edit as its key ``edit``, and the arguments of the edit as further keys.
Paths in the file are relative to the folder of the file.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from os import fspath
from pathlib import Path
from typing import Any

from stitchmesh.editing.edit import Edit, checked_arguments
from stitchmesh.editing.on_selection import ON
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.checked import check_table
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.io.path_kind import whole_path
from stitchmesh.io.toml_file import SUFFIX, changed_fields, read_table, table_lines
from stitchmesh.recipe.recipe import Recipe, RecipePattern
from stitchmesh.selection import parse_selection
from stitchmesh.selection.selection import with_paths
from stitchmesh.settings import setting_comments

HEADER = """\
# A recipe of a garment: stitchmesh knit RECIPE -o DIR knits it.
# docs/recipes.md explains every key. Paths are relative to this file.
"""

def read_recipe(path: FilePath) -> Recipe:
    """Read a recipe from a TOML file.

    Raises:
        FileError: the file cannot be read, is not TOML, or has a key or a value that no recipe has; the message names
            the key and, for an unknown key, the nearest known one.
    """
    table = read_table(path)
    try:
        return recipe_with_paths(_recipe(table), lambda inside: _joined(Path(path).parent, inside))
    except ParameterError as error:
        raise FileError(f"{fspath(path)}: {error}") from error


def write_recipe(path: FilePath, recipe: Recipe) -> None:
    """Write a recipe as a TOML file; the file is written atomically. Keys whose value is the default are left out.

    Raises:
        FileError: the file cannot be written, or its suffix is not ``.toml``.
    """
    suffix_of(path, [SUFFIX])
    folder = whole_path(path).parent
    moved = recipe_with_paths(recipe, lambda inside: Path(os.path.relpath(inside, folder)).as_posix())
    write_text(path, HEADER + "\n" + "\n".join(table_lines(_table_of(moved), comments=setting_comments(recipe))) + "\n")


def _recipe(table: dict[str, Any]) -> Recipe:
    """Return the recipe of a table without a change of its paths.

    Raises:
        ParameterError: a key or a value is not possible in a recipe.
    """
    edits = pop_edits(table, "edits")
    return replace(check_table(table, Recipe), edits=edits)


def pop_edits(table: dict[str, Any], key: str) -> tuple[Edit, ...]:
    """Remove the edits from a table and return them; each has its name under ``edit`` and its arguments as other keys.

    Raises:
        ParameterError: the edits are no list of tables, or an edit is unknown or has other arguments.
    """
    edits = table.pop(key, [])
    if not isinstance(edits, list) or not all(isinstance(edit, dict) for edit in edits):
        raise ParameterError(f'{key}: expected tables [[{key}]], each with a key edit = "NAME"')
    return tuple(_edit(edit, f"{key}[{number}]") for number, edit in enumerate(edits))


def _edit(table: dict[str, Any], place: str) -> Edit:
    name = table.get("edit")
    if not isinstance(name, str):
        raise ParameterError(f"{place} needs 'edit', the name of an edit; got {', '.join(table) or 'nothing'}")
    edit = Edit(name, {key: value for key, value in table.items() if key != "edit"})
    try:
        checked_arguments(edit)
        if ON in edit.arguments:
            parse_selection(str(edit.arguments[ON]))
    except ParameterError as error:
        raise ParameterError(f"{place}: {error}") from error
    return edit


def recipe_with_paths(recipe: Recipe, change: Callable[[str], str]) -> Recipe:
    """Return a recipe with all paths changed: paths of files, and paths in selections."""
    edges, body, yarn, material = recipe.stitches.edges, recipe.physics.body, recipe.yarn, recipe.material.name
    return replace(
        recipe,
        mesh=change(recipe.mesh),
        patterns=patterns_with_paths(recipe.patterns, change),
        edits=edits_with_paths(recipe.edits, change),
        colours=tuple(replace(part, on=_selection_with_paths(part.on, change)) for part in recipe.colours),
        stitches=replace(recipe.stitches, edges=None if edges is None else change(edges)),
        physics=replace(recipe.physics, body=None if body is None else change(body)),
        yarn=None if yarn is None else name_with_path(yarn, change),
        material=replace(recipe.material, name=None if material is None else name_with_path(material, change)),
    )


def patterns_with_paths(parts: Sequence[RecipePattern], change: Callable[[str], str]) -> tuple[RecipePattern, ...]:
    """Return patterns with all paths changed: paths of pattern files, and paths in selections."""
    return tuple(
        replace(
            part, pattern=name_with_path(part.pattern, change),
            on=None if part.on is None else _selection_with_paths(part.on, change),
        )
        for part in parts
    )  # fmt: skip


def edits_with_paths(edits: Sequence[Edit], change: Callable[[str], str]) -> tuple[Edit, ...]:
    """Return edits with all paths changed: paths of pattern files, and paths in selections."""
    return tuple(Edit(edit.name, _arguments_with_paths(edit, change)) for edit in edits)


def _arguments_with_paths(edit: Edit, change: Callable[[str], str]) -> dict[str, Any]:
    values = dict(edit.arguments)
    if ON in values:
        values[ON] = _selection_with_paths(str(values[ON]), change)
    if edit.name == "paste_pattern" and "\n" not in str(values["pattern"]):
        values["pattern"] = name_with_path(str(values["pattern"]), change)
    return values


def name_with_path(name: str, change: Callable[[str], str]) -> str:
    """Return a name of the library unchanged, and a path changed."""
    return change(name) if Path(name).suffix or Path(name).name != name else name


def _selection_with_paths(text: str, change: Callable[[str], str]) -> str:
    return str(with_paths(parse_selection(text), change)) if '"' in text else text


def _joined(folder: Path, path: str) -> str:
    """Return a path in a recipe, seen from the present folder."""
    return fspath(folder / path)


def _table_of(recipe: Recipe) -> dict[str, Any]:
    """Return the table of a recipe, whose edits have their arguments as keys, in the order of its fields."""
    table = changed_fields(replace(recipe, edits=()))
    if recipe.edits:
        table["edits"] = [{"edit": edit.name, **edit.arguments} for edit in recipe.edits]
    first = ("mesh", "quality", "device")
    names = (*first, *(part.name for part in fields(recipe) if part.name not in first))
    return {name: table[name] for name in names if name in table}
