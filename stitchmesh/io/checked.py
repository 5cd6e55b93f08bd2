# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Values that users write, in JSON or in Python, checked against a type by msgspec; each refusal is one line.

msgspec says what is wrong and at which path. Here this becomes a line that names the key, shows what was found, says in
words what is expected, and names the known key that is nearest to an unknown one.
"""

from __future__ import annotations

import difflib
import json
import re
from typing import Any, TypeVar

import msgspec
from msgspec import inspect

from stitchmesh.errors import ParameterError

KINDS = {
    "int": "a whole number",
    "float": "a number",
    "str": "a text",
    "bool": "true or false",
    "array": "a list",
    "object": "an object",
    "null": "null",
}
"""msgspec's kinds of values in words."""
LONGEST = 60
"""Characters of a value that a message shows."""

T = TypeVar("T")


def parse_json(text: str) -> object:
    """The value of a JSON text.

    Raises:
        ParameterError: it is none, or nested too deeply.
    """
    try:
        return msgspec.json.decode(text)
    except msgspec.DecodeError as error:
        raise ParameterError(f"is no JSON ({str(error).removeprefix('JSON is malformed: ')})") from error
    except RecursionError as error:
        raise ParameterError("is no JSON that can be read; it is nested too deeply") from error


def checked(value: object, kind: type[T]) -> T:
    """The value as a type that msgspec knows; nothing is converted on the way but lists and tuples.

    Args:
        value: what JSON or TOML gave, or the same made in Python.
        kind: a ``msgspec.Struct``, a dataclass, or any annotation that msgspec takes.

    Raises:
        ParameterError: the value is not of the type; the message begins with the key, if the value has keys.
    """
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        raise ParameterError(_refusal(str(error), value, kind)) from error


def _refusal(said: str, value: object, kind: Any) -> str:
    """What msgspec said, in the words of a user."""
    what, _, path = said.partition(" - at `$")
    path = path.removesuffix("`")
    steps = [int(number) if number else key for key, number in re.findall(r"\.(\w+)|\[(\d+)\]", path)]
    found, place = _found_at(value, steps), path.removeprefix(".")
    if unknown := re.fullmatch(r"Object contains unknown field `(.*)`", what):
        known = _keys_at(kind, steps)
        near = difflib.get_close_matches(unknown[1], known, n=1)
        remedy = f"did you mean {near[0]!r}? the keys are" if near else "the keys are"
        return f"{place} has no key {unknown[1]!r}; {remedy} {', '.join(known) or 'none'}".lstrip()
    if missing := re.fullmatch(r"Object missing required field `(.*)`", what):
        given = ", ".join(found) if isinstance(found, dict) and found else "nothing"
        return f"{place} needs {missing[1]!r}; got {given}".lstrip()
    expected = re.sub(r", got `.*", "", what).removeprefix("Expected ")
    for name in re.findall(r"\w+", (re.findall(r"`(.*?)`", expected) or [""])[0]):
        expected = expected.replace(name, KINDS.get(name, name), 1)
    return f"{place} is {_shown(found)}; expected {expected.replace('`', '').replace(' | ', ' or ')}".lstrip()


def _found_at(value: Any, steps: list[int | str]) -> Any:
    for step in steps:
        value = value[step]
    return value


def _shown(value: object) -> str:
    """The value as JSON; what JSON does not know by the name of its type."""
    text = json.dumps(value, default=lambda other: f"{type(other).__module__}.{type(other).__qualname__}")
    return text if len(text) <= LONGEST else f"{text[:LONGEST]} ..."


def _keys_at(kind: Any, steps: list[int | str]) -> list[str]:
    """Keys that an object at a path may have."""
    info: Any = inspect.type_info(kind)
    for step in [*steps, None]:
        options = info.types if isinstance(info, inspect.UnionType) else [info]
        for option in options:
            if isinstance(option, inspect.StructType | inspect.DataclassType):
                fields = {field.encode_name: field.type for field in option.fields}
                if step is None:
                    return list(fields)
                info = fields[str(step)]
            elif isinstance(option, inspect.ListType | inspect.VarTupleType):
                info = option.item_type
    return []
