# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Logs of steps: text files with one JSON object in each line, ``{"edit": NAME, "arguments": {...}}``.

The first key says what kind of steps the log holds.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from os import fspath
from typing import Any, TypeVar

import msgspec

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.checked import check_value, parse_json
from stitchmesh.io.contents import FilePath, read_bytes

Step = TypeVar("Step")


def write_step_log(path: FilePath, kind: str, steps: Iterable[tuple[str, Mapping[str, object]]]) -> None:
    """Write a log of steps; the file is written atomically.

    Args:
        path: the file.
        kind: key of the names of the steps, such as ``edit``.
        steps: name and arguments of each step.

    Raises:
        FileError: the file cannot be written.
    """
    lines = [json.dumps({kind: name, "arguments": dict(arguments)}, default=list) for name, arguments in steps]
    write_text(path, "".join(line + "\n" for line in lines))


def read_step_log(path: FilePath, kind: str, make_step: Callable[[str, dict[str, Any]], Step]) -> list[Step]:
    """Read a log of steps.

    Args:
        path: the file.
        kind: key of the names of the steps, such as ``edit``.
        make_step: makes a step of its name and arguments; raises ``ParameterError`` for a step that is not valid.

    Raises:
        FileError: the file cannot be read, or a line is not a valid step; the message names the line.
    """
    try:
        text = read_bytes(path, may_be_empty=True).decode("utf-8")
    except UnicodeDecodeError as error:
        found = "cannot be read (it is not UTF-8 text)"
        raise FileError(f"{fspath(path)}: {found}; expected a log of {kind}s") from error
    steps = []
    for number, line in enumerate(text.splitlines(), start=1):
        try:
            steps.append(make_step(*_name_and_arguments(line, kind)))
        except ParameterError as error:
            raise FileError(f"{fspath(path)} line {number}: {error}") from error
    return steps


def _name_and_arguments(line: str, kind: str) -> tuple[str, dict[str, Any]]:
    """The name and the arguments in a line.

    Raises:
        ParameterError: the line is no JSON, or is not an object with these two keys.
    """
    try:
        content = parse_json(line)
    except ParameterError as error:
        raise ParameterError(f"{error}; expected one {kind} a line") from error
    keys: list[Any] = [(kind, str), ("arguments", dict[str, Any])]
    try:
        found = check_value(content, msgspec.defstruct("Line", keys, forbid_unknown_fields=True))
    except ParameterError as error:
        expected = f'expected {{"{kind}": NAME, "arguments": {{...}}}}'
        raise ParameterError(f"is no {kind}; {expected}: {error}") from error
    return getattr(found, kind), found.arguments  # type: ignore[attr-defined]
