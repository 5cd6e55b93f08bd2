# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How arguments are written on the command line: read by tyro from the annotated fields of dataclasses.

A field is an option: its name the flag, its default the default, its docstring the help. What is added to tyro here is
one rule for numbers and lists of them, so that a refusal says what was found and what was expected, and one line where
tyro draws a box.
"""

from __future__ import annotations

import io
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

BAD_INPUT = 2
"""Exit status where input is refused."""
TERMINAL_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
CONFIG = (tyro.conf.OmitArgPrefixes, tyro.conf.OmitSubcommandPrefixes, tyro.conf.FlagCreatePairsOff)
"""Flags bear the names of their fields alone, whichever group they are in, and no flag has a negation."""
FREE = "free"
"""A size that is not given."""
KINDS: dict[Any, tuple[str, str]] = {int: ("whole number", "N"), float: ("number", "X")}
"""What words of a kind are called in a refusal and in the help."""

T = TypeVar("T")


class Command(Protocol):
    """What a command can do."""

    def run(self) -> None:
        """Do it."""


def shown(metavar: str, unset: str | None = None, *, help: str | None = None, short: str | None = None) -> object:
    """How an option stands in the help.

    Args:
        metavar: what stands for its value.
        unset: what holds where it is not given, if its default is None.
        help: its text, where the field's docstring cannot hold it.
        short: another flag for it.
    """
    hint = None if unset is None else f"(default: {unset})"
    return arg(metavar=metavar, help=help, help_behavior_hint=hint, aliases=None if short is None else [short])


def read_by(parse: Callable[[str], T], metavar: str, write: Callable[[T], str] = str) -> PrimitiveConstructorSpec[T]:
    """How one word becomes a value; ``parse`` raises ``ValueError`` with what it expected."""
    return PrimitiveConstructorSpec(
        nargs=1,
        metavar=metavar,
        instance_from_str=lambda words: parse(words[0]),
        is_instance=lambda value: True,
        str_from_instance=lambda value: [write(value)],
    )


Flag = Annotated[bool, arg(help_behavior_hint="")]
"""An option without a value."""


def _pair(text: str) -> tuple[int, int]:
    try:
        first, second = (int(word) for word in text.split(","))
    except ValueError as error:
        raise ValueError(f"got {text!r}; expected two whole numbers with a comma between them") from error
    return first, second


def _one_or_two(text: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(word) for word in text.split(","))
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
        return tuple(None if word == FREE else float(word) for word in words)
    except ValueError as error:
        raise ValueError(f"got {' '.join(words)!r}; expected two numbers of cm, or {FREE} for either") from error


Pair = Annotated[tuple[int, int], read_by(_pair, "V,W")]
"""Two whole numbers in one word."""
OneOrTwo = Annotated[tuple[float, ...] | None, read_by(_one_or_two, "A[,B]")]
"""One or two numbers in one word."""
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
"""Width and height, each a number or free, which is None."""


def parse(commands: Sequence[type[Command]], words: Sequence[str], *, program: str, description: str) -> Command:
    """The command that the words ask for.

    Args:
        commands: frozen dataclasses, one for each command.
        words: the words after the program's name.
        program: its name.
        description: what it does.

    Raises:
        SystemExit: help was asked for (status 0), or the words are no command (``BAD_INPUT``, one line said).
        StitchMeshError: options refuse themselves.
    """
    said = io.StringIO()
    try:
        with redirect_stderr(said):
            return tyro.cli(
                cast(type[Command], Union[tuple(commands)]),  # noqa: UP007 (the union is made while running)
                prog=program, description=description, args=words, config=CONFIG, registry=_registry(),
            )  # fmt: skip
    except SystemExit as stop:
        if stop.code:
            command = {_name(each) for each in commands} & set(words[:1])
            asked = " ".join([program, *command])
            print(f"{asked}: {one_line(said.getvalue())}; see {asked} --help", file=sys.stderr)
        raise


def _name(command: type) -> str:
    """What a command is called: its class's name with hyphens."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "-", command.__name__).lower()


def one_line(box: str) -> str:
    """The text in one of tyro's boxes as one line, without the help of arguments that stands below it.

    A box has lines around it, or, where standard output cannot draw these, a title with a rule below it and lines that
    are indented by two.
    """
    sections = [""]
    for line in TERMINAL_COLOUR.sub("", box).splitlines():
        found = re.fullmatch(r"(?:│ (.*?) *│|  (.*?) *)", line)
        text = (found[1] or found[2] or "") if found else ""
        if text and set(text) <= set("─-"):
            sections.append("")
        elif text and not text.startswith(" " * 8):  # indented twice: the help of an argument
            listed = text.startswith(" " * 4) and not sections[-1].endswith(":")
            sections[-1] += (", " if listed else " ") + text.strip()
    kept = [text.strip() for text in sections if text and not text.startswith((" Argument helptext", " For full help"))]
    return "; ".join(kept).removeprefix("Error parsing ").rstrip(".") or " ".join(TERMINAL_COLOUR.sub("", box).split())


def _registry() -> ConstructorRegistry:
    registry = ConstructorRegistry()
    registry.primitive_rule(_spec_of_type)
    return registry


def _spec_of_type(info: PrimitiveTypeInfo) -> PrimitiveConstructorSpec[Any] | None:
    """How a text, a choice, a number or a tuple of numbers of one kind is written; it is None where it is not given."""
    declared: Any = info.type
    if get_origin(declared) in (Union, UnionType):
        options = [option for option in get_args(declared) if option is not NoneType]
        declared = options[0] if len(options) == 1 else None
    if declared is str:
        return read_by(str, "NAME")
    if get_origin(declared) is Literal:
        return read_by(partial(_choice, get_args(declared)), "NAME")
    if declared in KINDS:
        return _numbers(declared, 1, lambda values: values[0])
    parts = get_args(declared) if get_origin(declared) is tuple else ()
    if not parts or parts[0] not in KINDS or tyro.conf.UseAppendAction in info.markers:
        return None
    return _numbers(parts[0], "*" if Ellipsis in parts else len(parts), tuple)


def _numbers(kind: Any, count: Any, together: Callable[[list[Any]], Any]) -> PrimitiveConstructorSpec[Any]:
    name, metavar = KINDS[kind]

    def parse_words(words: list[str]) -> Any:
        try:
            return together([kind(word) for word in words])
        except ValueError as error:
            expected = f"a {name}" if count == 1 else f"{name}s"
            raise ValueError(f"got {' '.join(words)!r}; expected {expected}") from error

    return PrimitiveConstructorSpec(
        nargs=count,
        metavar=metavar,
        instance_from_str=parse_words,
        is_instance=lambda value: True,
        str_from_instance=lambda value: [str(part) for part in (value if isinstance(value, tuple) else (value,))],
    )
