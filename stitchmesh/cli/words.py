# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conversion of words of the command line to values: numbers, pairs, directions, panels and sizes.

The error messages state what was found and what was expected.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any, TypeVar

from tyro.conf import arg
from tyro.constructors import PrimitiveConstructorSpec

from stitchmesh.shaping.panels.options import PanelDirection

AXES = {
    sign + name: tuple(float(f"{sign}1") if place == axis else 0.0 for place in range(3))
    for sign in ("", "-")
    for axis, name in enumerate("xyz")
}
"""Directions by the names of their axes, such as ``-x``."""
FREE = "free"
"""Word for a size that the relaxation determines."""
MOST_COUNTED = 10**15
"""Largest whole number of an option, up to its sign; any of them is exact in double precision."""
NUMBER_NAMES: dict[Any, tuple[str, str, str]] = {
    int: ("whole number", "N", f"at most {MOST_COUNTED:.0e}"), float: ("number", "X", "finite"),
}  # fmt: skip
"""Names of each type of number in error messages and in the help, and its bound."""

T = TypeVar("T")


def help_entry(
    metavar: str,
    unset: str | None = None,
    *,
    help: str | None = None,
    short: str | None = None,
    also: str | None = None,
) -> object:
    """Return an annotation that describes an option in the help.

    Args:
        metavar: placeholder of the value.
        unset: description of the default, for an option whose default is None or an empty tuple.
        help: help text, if it contains values and cannot be the docstring of the field.
        short: second flag, for example ``-o``.
        also: former name of the option, which is still accepted.
    """
    hint = None if unset is None else f"(default: {unset})"
    aliases = [flag for flag in (short, also) if flag is not None]
    return arg(metavar=metavar, help=help, help_behavior_hint=hint, aliases=aliases or None)


def parsed_by(parse: Callable[[str], T], metavar: str, write: Callable[[T], str] = str) -> PrimitiveConstructorSpec[T]:
    """Return an annotation of an option whose value is one word.

    Args:
        parse: function that converts the word into the value; it raises ``ValueError`` with the error message.
        metavar: placeholder of the value in the help.
        write: function that converts a default value into a word for the help.
    """
    return PrimitiveConstructorSpec(
        nargs=1,
        metavar=metavar,
        instance_from_str=lambda words: parse(words[0]),
        is_instance=lambda value: True,
        str_from_instance=lambda value: [write(value)],
    )


def whole_number(word: str) -> int:
    """Convert a word into a whole number.

    Raises:
        ValueError: the word is no whole number, or is larger than ``MOST_COUNTED``.
    """
    number = int(word)
    if abs(number) > MOST_COUNTED:
        raise ValueError(f"{word} is larger than {MOST_COUNTED}")
    return number


def finite_number(word: str) -> float:
    """Convert a word into a number.

    Raises:
        ValueError: the word is no number, or one that is not finite.
    """
    number = float(word)
    if not math.isfinite(number):
        raise ValueError(f"{word} is not finite")
    return number


PARSERS: dict[Any, Callable[[str], Any]] = {int: whole_number, float: finite_number}
"""Function that reads a number of each type."""
Flag = Annotated[bool, arg(help_behavior_hint="")]
"""An option without a value, which is false if it is not given."""


def pair(text: str) -> tuple[int, int]:
    """Convert two whole numbers with a comma between them."""
    try:
        first, second = (whole_number(word) for word in text.split(","))
    except ValueError as error:
        raise ValueError(f"got {text!r}; expected two whole numbers with a comma between them") from error
    return first, second


def direction(text: str) -> tuple[float, float, float]:
    """Convert the name of an axis, or three numbers with commas between them, into a direction."""
    try:
        x, y, z = AXES.get(text.strip().lower()) or (finite_number(word) for word in text.split(","))
    except ValueError as error:
        raise ValueError(f"got {text!r}; expected an axis such as y or -x, or three numbers with commas") from error
    return x, y, z


def _direction_text(given: tuple[float, ...] | None) -> str:
    """Return the name of an axis, or numbers with commas between them."""
    if given is None:
        return ""
    return next((name for name, axis in AXES.items() if axis == given), ",".join(f"{part:g}" for part in given))


def _number_or_pair(text: str) -> float | tuple[float, float]:
    first, comma, second = text.partition(",")
    try:
        return (finite_number(first), finite_number(second)) if comma else finite_number(first)
    except ValueError as error:
        raise ValueError(f"got {text!r}; expected one number, or two with a comma between them") from error


def _sizes(words: list[str]) -> tuple[float | None, ...]:
    try:
        return tuple(None if word == FREE else finite_number(word) for word in words)
    except ValueError as error:
        raise ValueError(f"got {' '.join(words)!r}; expected two numbers of cm, or {FREE} for either") from error


def _one_or_two_sizes(words: list[str]) -> float | tuple[float, float]:
    try:
        first, *others = (finite_number(word) for word in words)
        if not others:
            return first
        (second,) = others
    except ValueError as error:
        raise ValueError(f"got {' '.join(words)!r}; expected one number of cm, or two") from error
    return first, second


def panel_direction(text: str) -> PanelDirection:
    """Convert the name of a panel and its direction, ``PANEL=U,V``."""
    name, _, words = text.rpartition("=")
    try:
        u, v = (finite_number(word) for word in words.split(","))
    except ValueError as error:
        raise ValueError(f"got {text!r}; expected a panel and its direction in the texture, PANEL=U,V") from error
    return PanelDirection(panel=_panel(name, text), direction=(u, v))


def panel_pair(text: str) -> tuple[int | str, int | str]:
    """Convert the names of two panels with a comma between them."""
    first, _, second = text.partition(",")
    return _panel(first, text), _panel(second, text)


def _panel(name: str, text: str) -> int | str:
    if not name.strip():
        raise ValueError(f"got {text!r}; expected the number or the name of a panel")
    return whole_number(name) if name.isdecimal() else name.strip()


Pair = Annotated[tuple[int, int], parsed_by(pair, "V,W")]
"""Two whole numbers in one word, with a comma between them."""
PanelPair = Annotated[tuple[int | str, int | str], parsed_by(panel_pair, "PANEL,PANEL")]
"""Two panels in one word, each a number or a name, with a comma between them."""
DirectionWord = Annotated[tuple[float, float, float] | None, parsed_by(direction, "AXIS|X,Y,Z", _direction_text)]
"""A direction in one word: the name of an axis, or three numbers with commas between them."""
OneOrTwoSizes = Annotated[
    float | tuple[float, float] | None,
    PrimitiveConstructorSpec(
        nargs="*",
        metavar="CM [CM]",
        instance_from_str=_one_or_two_sizes,
        is_instance=lambda value: True,
        str_from_instance=lambda value: [str(value)],
    ),
]
"""One size, or two sizes in two words [cm]."""
NumberOrPair = Annotated[float | tuple[float, float] | None, parsed_by(_number_or_pair, "A[,B]")]
"""One number, or two numbers in one word with a comma between them."""
Period = Annotated[
    tuple[float | None, float | None],
    PrimitiveConstructorSpec(
        nargs=2,
        metavar="CM CM",
        instance_from_str=_sizes,
        is_instance=lambda value: True,
        str_from_instance=lambda sizes: [FREE if size is None else str(size) for size in sizes],
    ),
]
"""Width and height: two words, each a number [cm] or ``free``, which is None."""
