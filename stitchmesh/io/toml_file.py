# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Dataclasses as TOML files, for what users write by hand: recipes, scenes, panels and materials.

The fields of a dataclass are the keys of a table. Fields whose value is the default are left out of a written file.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Collection, Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from os import fspath
from typing import Any, TypeVar

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checked import TOO_DEEP, check_depth, check_table
from stitchmesh.io.contents import FilePath, read_bytes, suffix_of

SUFFIX = ".toml"
KEY_ENDS = re.compile(r"[,\[\]{}=\n]")
"""Characters that bound a key with dots."""
USUAL_PARTS, MOST_PARTS = 3, 1000
"""Largest number of parts of a key that counts as cheap, and number of parts of a single key whose cost all keys
together may have: the time and memory of ``tomllib`` for a key grow with the square of this number."""
T = TypeVar("T")


def read_table(path: FilePath) -> dict[str, Any]:
    """Read the table of a TOML file.

    Raises:
        FileError: the file cannot be read, has another suffix, is not TOML, or is nested more than ``DEEPEST`` times.
    """
    name = fspath(path)
    suffix_of(path, [SUFFIX])
    try:
        text = read_bytes(path).decode("utf-8")
        parts = (piece.count(".") for piece in KEY_ENDS.split(text))
        if sum(count**2 for count in parts if count > USUAL_PARTS) > MOST_PARTS**2:
            raise FileError(f"{name}: has keys of very many parts; expected at most {USUAL_PARTS} each")
        return check_depth(tomllib.loads(text))
    except ValueError as error:  # The syntax or the encoding is wrong, or a number has thousands of digits.
        raise FileError(f"{name}: is no TOML ({error})") from error
    except RecursionError as error:
        raise FileError(f"{name}: {TOO_DEEP}") from error
    except ParameterError as error:
        raise FileError(f"{name}: {error}") from error


def read_dataclass(path: FilePath, kind: type[T]) -> T:
    """Read a dataclass from a TOML file.

    Raises:
        FileError: as for ``read_table``, or the dataclass does not have a key or does not accept a value; the message
            names the key and, for an unknown key, the nearest known key.
    """
    table = read_table(path)
    try:
        return check_table(table, kind)
    except ParameterError as error:
        raise FileError(f"{fspath(path)}: {error}") from error


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


def table_lines(
    table: Mapping[str, Any], *, inline: Collection[str] = (), comments: Mapping[str, str] | None = None
) -> Iterator[str]:
    """Yield the lines of a table: its values first, then its tables.

    Args:
        table: the table.
        inline: keys whose tables are written within one line.
        comments: comments beside keys, by the path of the key with dots; each is written once, beside the first such
            key.
    """
    yield from _lines(table, "", inline, dict(comments or {}))


def _lines(table: Mapping[str, Any], name: str, inline: Collection[str], comments: dict[str, str]) -> Iterator[str]:
    """Yield the lines of a table within another one; a comment is used up by its first key."""
    nested = {key: value for key, value in table.items() if _is_nested(value) and key not in inline}
    for key, value in table.items():
        if key not in nested:
            comment = comments.pop(f"{name}{key}", "")
            yield f"{key} = {toml_text(value)}" + (f"  # {comment}" if comment else "")
    for key, value in nested.items():
        for one in value if isinstance(value, list) else [value]:
            yield ""
            yield f"[[{name}{key}]]" if isinstance(value, list) else f"[{name}{key}]"
            yield from _lines(one, f"{name}{key}.", inline, comments)


def _is_nested(value: object) -> bool:
    """Whether a value is a table, or a list of tables."""
    is_tables = isinstance(value, list) and bool(value) and all(isinstance(one, dict) for one in value)
    return is_tables or isinstance(value, dict)


def _check_text(value: str) -> None:
    """Refuse a text that UTF-8 cannot hold, such as the names of some files.

    Raises:
        ParameterError: UTF-8 cannot hold the text.
    """
    try:
        value.encode("utf-8")
    except UnicodeEncodeError as error:
        raise ParameterError(f"{value!r}: is no text in UTF-8, so that no file can name it; rename the file") from error


def toml_text(value: object) -> str:
    """Return a value as TOML: a text, a number, true or false, a list of these, or a table within one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml_text(part)}" for key, part in value.items()) + " }"
    if isinstance(value, list | tuple):
        return f"[{', '.join(toml_text(part) for part in value)}]"
    if isinstance(value, str):
        if not value.isascii():
            _check_text(value)
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return str(value).lower()
    return repr(float(value)) if isinstance(value, float) else repr(value)  # NumPy's numbers are floats too
