# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Parsing of the command line: the library tyro reads the arguments from the annotated fields of dataclasses.

A field is an option: its name is the flag, its default the default value, and its docstring the help text. This module
adds two things to tyro: rules for texts, choices and numbers, so that error messages state what was found and what was
expected; and the conversion of tyro's error messages, which are drawn in a box, into one line.
"""

from __future__ import annotations

import io
import math
import re
import sys
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr
from functools import partial
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Protocol, TypeVar, Union, cast, get_args, get_origin

import tyro
from tyro.conf import arg
from tyro.constructors import ConstructorRegistry, PrimitiveConstructorSpec, PrimitiveTypeInfo

from stitchmesh.cli.say import say

BAD_INPUT = 2
"""Exit status after an error in the input."""
TERMINAL_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
"""Escape sequence that sets a colour on a terminal."""
CONFIG = (tyro.conf.OmitArgPrefixes, tyro.conf.OmitSubcommandPrefixes, tyro.conf.FlagCreatePairsOff)
"""Options of tyro: a flag is the name of its field without the name of its group, and no flag has a negation."""
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


class Command(Protocol):
    """A command of the program; its fields are the arguments."""

    def run(self) -> int | None:
        """Run the command; return its exit status where it is not 0."""


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


def _one_or_two(text: str) -> tuple[float, ...]:
    try:
        numbers = tuple(finite_number(word) for word in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) not in (1, 2):
        raise ValueError(f"got {text!r}; expected one number, or two with a comma between them")
    return numbers


def _choice(known: tuple[str, ...], word: str) -> str:
    if word not in known:
        raise ValueError(f"got {word!r}; expected one of {', '.join(known)}")
    return word


def _sizes(words: list[str]) -> tuple[float | None, ...]:
    try:
        return tuple(None if word == FREE else finite_number(word) for word in words)
    except ValueError as error:
        raise ValueError(f"got {' '.join(words)!r}; expected two numbers of cm, or {FREE} for either") from error


def panel_direction(text: str) -> tuple[int | str, tuple[float, float]]:
    """Convert the name of a panel and its direction, ``PANEL=U,V``."""
    name, _, words = text.rpartition("=")
    try:
        u, v = (finite_number(word) for word in words.split(","))
    except ValueError as error:
        raise ValueError(f"got {text!r}; expected a panel and its direction in the texture, PANEL=U,V") from error
    return _panel(name, text), (u, v)


def panel_pair(text: str) -> tuple[int | str, int | str]:
    """Convert the names of two panels with a comma between them."""
    first, _, second = text.partition(",")
    return _panel(first, text), _panel(second, text)


def _panel(name: str, text: str) -> int | str:
    """Return the number of a panel, or its name."""
    if not name.strip():
        raise ValueError(f"got {text!r}; expected the number or the name of a panel")
    return whole_number(name) if name.isdecimal() else name.strip()


Pair = Annotated[tuple[int, int], parsed_by(pair, "V,W")]
"""Two whole numbers in one word, with a comma between them."""
PanelPair = Annotated[tuple[int | str, int | str], parsed_by(panel_pair, "PANEL,PANEL")]
"""Two panels in one word, each a number or a name, with a comma between them."""
PanelDirection = Annotated[tuple[int | str, tuple[float, float]], parsed_by(panel_direction, "PANEL=U,V")]
"""A panel and its direction of knitting in one word."""
Direction = Annotated[tuple[float, float, float] | None, parsed_by(direction, "AXIS|X,Y,Z", _direction_text)]
"""A direction in one word: the name of an axis, or three numbers with commas between them."""
OneOrTwo = Annotated[tuple[float, ...] | None, parsed_by(_one_or_two, "A[,B]")]
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


def parse(commands: Sequence[type[Command]], words: Sequence[str], *, program: str, description: str) -> Command:
    """Return the command that the words of a command line describe.

    Args:
        commands: frozen dataclasses, one for each command.
        words: the words after the name of the program.
        program: name of the program.
        description: description of the program in the help.

    Raises:
        SystemExit: the help was printed (status 0), or the words do not describe a command (status ``BAD_INPUT``, after
            one line on standard error).
        StitchMeshError: the constructor of a group of options does not accept a value.
    """
    messages = io.StringIO()
    try:
        with redirect_stderr(messages):
            return tyro.cli(
                cast(type[Command], Union[tuple(commands)]),  # noqa: UP007 (the union is made at run time)
                prog=program, description=description, args=words, config=CONFIG, registry=_registry(),
            )  # fmt: skip
    except SystemExit as stop:
        if stop.code:
            command = {_command_name(each) for each in commands} & set(words[:1])
            called = " ".join([program, *command])
            say(f"{called}: {one_line(messages.getvalue())}; see {called} --help", file=sys.stderr)
        raise


def _command_name(command: type) -> str:
    """Return the name of a command: the name of its class in lower case with hyphens."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "-", command.__name__).lower()


def one_line(box: str) -> str:
    """Return the text of one of tyro's error messages as one line, without the help of arguments at its end.

    An error message is drawn as a box. If standard output cannot show the characters of a box, the message has a title,
    a horizontal line below it, and text lines that are indented by two spaces.
    """
    sections = [""]
    for line in TERMINAL_COLOUR.sub("", box).splitlines():
        found = re.fullmatch(r"(?:│ (.*?) *│|  (.*?) *)", line)
        text = (found[1] or found[2] or "") if found else ""
        if text and set(text) <= set("─-"):
            sections.append("")
        elif text and not text.startswith(" " * 8):  # A line that is indented by more is the help of an argument.
            listed = text.startswith(" " * 4) and not sections[-1].endswith(":")
            sections[-1] += (", " if listed else " ") + text.strip()
    kept = [text.strip() for text in sections if text and not text.startswith((" Argument helptext", " For full help"))]
    return "; ".join(kept).removeprefix("Error parsing ").rstrip(".") or " ".join(TERMINAL_COLOUR.sub("", box).split())


def _registry() -> ConstructorRegistry:
    """Return tyro's rules of conversion, with the rules of this module added."""
    registry = ConstructorRegistry()
    registry.primitive_rule(_spec_of_type)
    return registry


def _spec_of_type(info: PrimitiveTypeInfo) -> PrimitiveConstructorSpec[Any] | None:
    """Return the rule of conversion for a text, a choice, a number or a tuple of numbers; None for other types.

    The rule for an optional type is that of the type itself, because the default is None.
    """
    declared: Any = info.type
    if get_origin(declared) in (Union, UnionType):
        options = [option for option in get_args(declared) if option is not NoneType]
        declared = options[0] if len(options) == 1 else None
    if declared is str:
        return parsed_by(str, "NAME")
    if get_origin(declared) is Literal:
        return parsed_by(partial(_choice, get_args(declared)), "NAME")
    if declared in NUMBER_NAMES:
        return _numbers(declared, 1, lambda values: values[0])
    parts = get_args(declared) if get_origin(declared) is tuple else ()
    if not parts or parts[0] not in NUMBER_NAMES or tyro.conf.UseAppendAction in info.markers:
        return None
    return _numbers(parts[0], "*" if Ellipsis in parts else len(parts), tuple)


def _numbers(kind: Any, count: Any, combine: Callable[[list[Any]], Any]) -> PrimitiveConstructorSpec[Any]:
    """Return the rule of conversion for numbers.

    Args:
        kind: type of the numbers, a key of ``NUMBER_NAMES``.
        count: number of words, or ``*`` for any number.
        combine: function that makes the value from the list of numbers.
    """
    name, metavar, bound = NUMBER_NAMES[kind]

    def parse_words(words: list[str]) -> Any:
        try:
            return combine([PARSERS[kind](word) for word in words])
        except ValueError as error:
            expected = f"a {name}" if count == 1 else f"{name}s"
            raise ValueError(f"got {' '.join(words)!r}; expected {expected} ({bound})") from error

    return PrimitiveConstructorSpec(
        nargs=count,
        metavar=metavar,
        instance_from_str=parse_words,
        is_instance=lambda value: True,
        str_from_instance=lambda value: [str(part) for part in (value if isinstance(value, tuple) else (value,))],
    )
