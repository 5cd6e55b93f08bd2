# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checks of values that users write, in JSON or in Python, against a type.

The library msgspec finds the first error and its path in the value. This module converts msgspec's message into one
line that names the key, shows what was found and says in words what is expected. For an unknown key the line also names
the most similar known key. A damaged JSON file also gives an error of one line.
"""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import cache
from os import fspath
from types import UnionType
from typing import Any, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import msgspec
import numpy as np
from msgspec import inspect

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.contents import FilePath, read_bytes

KIND_NAMES = {
    "int": "a whole number",
    "float": "a number",
    "str": "a text",
    "bool": "true or false",
    "array": "a list",
    "object": "an object",
    "null": "null",
}
"""Words for msgspec's names of types."""
MAX_CHARACTERS = 60
"""Number of characters of a value that a message shows."""

DEEPEST = 50
"""Largest number of lists and objects within one another. Functions that walk through a value call themselves a few
times for each level, and Python permits 1,000 calls in all; no file of this program has more than ten levels."""
TOO_DEEP = f"is nested too deeply; expected at most {DEEPEST} lists and objects within one another"

T = TypeVar("T")


def parse_json(text: str) -> object:
    """Return the value of a JSON text.

    Raises:
        ParameterError: the text is not valid JSON, or is nested more than ``DEEPEST`` times.
    """
    try:
        return check_depth(msgspec.json.decode(text))
    except msgspec.DecodeError as error:
        raise ParameterError(f"is no JSON ({str(error).removeprefix('JSON is malformed: ')})") from error
    except RecursionError as error:
        raise ParameterError(TOO_DEEP) from error


def check_depth(value: T) -> T:
    """Check that lists and objects do not lie too deep within one another, and return the value.

    Raises:
        ParameterError: lists and objects are nested more than ``DEEPEST`` times.
    """
    level: list[Any] = [value]
    for _ in range(DEEPEST + 1):
        level = [one for one in level if isinstance(one, dict | list)]
        if not level:
            return value
        level = [part for one in level for part in (one.values() if isinstance(one, dict) else one)]
    raise ParameterError(TOO_DEEP)


def plain_value(value: object) -> object:
    """Return a value as JSON can hold it, where that is possible.

    NumPy numbers become numbers. NumPy arrays, tuples, ranges and all other collections become lists; a set of numbers
    becomes a sorted list. Keys of mappings and all other values stay as they are.
    """
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: plain_value(part) for key, part in value.items()}
    if isinstance(value, str | bytes) or not isinstance(value, Iterable):
        return value
    parts = [plain_value(part) for part in value]
    numbers = [part for part in parts if isinstance(part, int | float)]
    return sorted(numbers) if isinstance(value, Set) and len(numbers) == len(parts) else parts


def check_value(value: object, kind: type[T]) -> T:
    """Check a value against a type, and return it as an instance of the type.

    Only objects become instances of classes, and lists and tuples become each other. No other value is converted; for
    example, a text does not become a number.

    Args:
        value: a value from a JSON or TOML file, or an equal value made in Python.
        kind: a ``msgspec.Struct``, a dataclass, or any annotation that msgspec accepts.

    Raises:
        ParameterError: the value is not of the type; the message begins with the key, if the value has keys.
    """
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        raise ParameterError(_error_message(str(error), value, kind)) from error


def check_table(value: object, kind: type[T]) -> T:
    """Check a table with named keys against a dataclass, and return it as an instance of the dataclass.

    The fields may be dataclasses, tuples of dataclasses, and dataclasses or None. A key that is not a field is an
    error.

    Args:
        value: a table of a JSON or TOML file.
        kind: the dataclass.

    Raises:
        ParameterError: as for ``check_value``, or the constructor of a dataclass does not accept its values.
    """
    return cast(T, _instance(check_value(value, _strict(cast(Any, kind))), kind))


@cache
def _strict(kind: Any) -> Any:
    """Return a type that has the fields of a dataclass and accepts no others; other types stay as they are."""
    if is_dataclass(kind) and isinstance(kind, type):
        hints = _type_hints(kind)
        described = [(part.name, _strict(hints[part.name]), *_default_of(part)) for part in fields(kind)]
        return msgspec.defstruct(kind.__name__, described, forbid_unknown_fields=True, kw_only=True)
    if get_origin(kind) is tuple:
        parts = tuple(part if part is Ellipsis else _strict(part) for part in get_args(kind))
        return tuple[parts]  # type: ignore[valid-type]
    if get_origin(kind) in (Union, UnionType):
        return Union[tuple(_strict(part) for part in get_args(kind))]  # noqa: UP007 (the union is made at run time)
    return kind


@cache
def _type_hints(kind: type) -> dict[str, Any]:
    """Return the types of the fields of a dataclass; the evaluation of their texts takes half a millisecond."""
    return get_type_hints(kind)


def _default_of(part: Field[Any]) -> tuple[Any, ...]:
    """Return the default of a field as one element, an empty tuple for a field without a default.

    The default is never used, because only the keys that are given become arguments of the dataclass.
    """
    required = part.default is MISSING and part.default_factory is MISSING
    return () if required else (msgspec.UNSET,)


def _instance(value: Any, kind: Any, name: str = "") -> Any:
    """Return a checked value as an instance of the dataclass, or of the types of a tuple or of a union.

    Args:
        value: the checked value.
        kind: its type.
        name: its key.

    Raises:
        ParameterError: a constructor does not accept its values; the message has the place in a tuple.
    """
    if get_origin(kind) in (Union, UnionType) and isinstance(value, msgspec.Struct):
        return _instance(value, next(part for part in get_args(kind) if is_dataclass(part)))
    if is_dataclass(kind) and isinstance(kind, type):
        hints = _type_hints(kind)
        given = {part.name: getattr(value, part.name) for part in fields(kind)}
        return kind(**{key: _instance(one, hints[key], key) for key, one in given.items() if one is not msgspec.UNSET})
    if get_origin(kind) is tuple and Ellipsis in get_args(kind):
        return tuple(_instance_at(f"{name}[{place}]", one, get_args(kind)[0]) for place, one in enumerate(value))
    return value


def _instance_at(place: str, value: Any, kind: Any) -> Any:
    try:
        return _instance(value, kind)
    except ParameterError as error:
        raise ParameterError(f"{place}: {error}") from error


def _error_message(msgspec_message: str, value: object, kind: Any) -> str:
    """Return the error message for the user, made from msgspec's message ``EXPECTATION - at `$PATH```."""
    what, _, path = msgspec_message.partition(" - at `$")
    path = path.removesuffix("`")
    steps = [int(number) if number else key for key, number in re.findall(r"\.(\w+)|\[(\d+)\]", path)]
    found, place = _found_at(value, steps), path.removeprefix(".")
    if unknown := re.fullmatch(r"Object contains unknown field `(.*)`", what):
        return unknown_key(place, unknown[1], _keys_at(kind, steps))
    if missing := re.fullmatch(r"Object missing required field `(.*)`", what):
        given = ", ".join(found) if isinstance(found, dict) and found else "nothing"
        return f"{place} needs {missing[1]!r}; got {given}".lstrip()
    if what.startswith("Invalid enum value"):
        choices = ", ".join(str(choice) for choice in _choices_at(kind, steps))
        return f"{place} is {_abbreviated(found)}; expected one of {choices}".lstrip()
    expected = re.sub(r", got `.*", "", what).removeprefix("Expected ")
    for name in re.findall(r"\w+", (re.findall(r"`(.*?)`", expected) or [""])[0]):
        expected = expected.replace(name, KIND_NAMES.get(name, name), 1)
    return f"{place} is {_abbreviated(found)}; expected {expected.replace('`', '').replace(' | ', ' or ')}".lstrip()


def unknown_key(place: str, key: str, known: Sequence[str]) -> str:
    """Return the error message for a key that a table does not have, with the most similar known key."""
    near = difflib.get_close_matches(key, known, n=1)
    remedy = f"did you mean {near[0]!r}? the keys are" if near else "the keys are"
    return f"{place} has no key {key!r}; {remedy} {', '.join(known) or 'none'}".lstrip()


def _found_at(value: Any, steps: list[int | str]) -> Any:
    """Return the part of a value at a path of keys and indices."""
    for step in steps:
        value = value[step]
    return value


def _abbreviated(value: object) -> str:
    """Return the start of a value as JSON text; a value that JSON cannot hold is replaced by the name of its type."""
    text = json.dumps(value, default=lambda other: f"{type(other).__module__}.{type(other).__qualname__}")
    return text if len(text) <= MAX_CHARACTERS else f"{text[:MAX_CHARACTERS]} ..."


def _keys_at(kind: Any, steps: list[int | str]) -> list[str]:
    """Return the keys that the type allows for the object at a path."""
    for option in _options_at(kind, steps):
        if isinstance(option, inspect.StructType | inspect.DataclassType):
            return [field.encode_name for field in option.fields]
    return []


def _choices_at(kind: Any, steps: list[int | str]) -> list[object]:
    """Return the values that the type permits at a path."""
    options = _options_at(kind, steps)
    return [value for option in options if isinstance(option, inspect.LiteralType) for value in option.values]


def _options_at(kind: Any, steps: list[int | str]) -> list[Any]:
    """Return descriptions of the types that are allowed at a path."""
    options = _alternatives(inspect.type_info(kind))
    for step in steps:
        options = [part for option in options for part in _parts_at(option, step)]
    return options


def _parts_at(option: Any, step: int | str) -> list[Any]:
    """Return descriptions of the types that a type allows at a key or an index."""
    if isinstance(option, inspect.StructType | inspect.DataclassType):
        return [part for field in option.fields if field.encode_name == step for part in _alternatives(field.type)]
    if isinstance(option, inspect.ListType | inspect.VarTupleType):
        return _alternatives(option.item_type)
    return []


def _alternatives(info: Any) -> list[Any]:
    """Return the types of a union, or the type itself."""
    return list(info.types) if isinstance(info, inspect.UnionType) else [info]


def read_json(path: FilePath) -> object:
    """Read the value of a JSON file.

    Raises:
        FileError: the file cannot be read, is no text in UTF-8 or no JSON, or is nested more than
            ``checked.DEEPEST`` times.
    """
    content = read_bytes(path)
    try:
        return parse_json(content.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise FileError(f"{fspath(path)}: is no text in UTF-8 ({error.reason} at byte {error.start})") from error
    except ParameterError as error:
        raise FileError(f"{fspath(path)}: {error}") from error
