# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Parsing of the command line: the library tyro reads the arguments from the annotated fields of dataclasses.

A field is an option: its name is the flag, its default the default value, and its docstring the help text. This module
adds three things to tyro: rules for texts, choices and numbers, so that error messages state what was found and what
was expected; a rule for declared settings (``setting_flags``); and the conversion of tyro's error messages, which are
drawn in a box, into one line.
"""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stderr
from functools import partial
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Protocol, Union, cast, get_args, get_origin

import tyro
from tyro.constructors import ConstructorRegistry, PrimitiveConstructorSpec, PrimitiveTypeInfo

from stitchmesh.cli.say import say
from stitchmesh.cli.setting_flags import settings_group
from stitchmesh.cli.words import NUMBER_NAMES, PARSERS, parsed_by

BAD_INPUT = 2
"""Exit status after an error in the input."""
TERMINAL_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
"""Escape sequence that sets a colour on a terminal."""
CONFIG = (tyro.conf.OmitArgPrefixes, tyro.conf.OmitSubcommandPrefixes, tyro.conf.FlagCreatePairsOff)
"""Options of tyro: a flag is the name of its field without the name of its group, and no flag has a negation."""


class Command(Protocol):
    """A command of the program; its fields are the arguments."""

    def run(self) -> int | None:
        """Run the command; return its exit status where it is not 0."""


def parse(commands: Mapping[str, type[Command]], words: Sequence[str], *, program: str, description: str) -> Command:
    """Return the command that the words of a command line describe.

    Args:
        commands: frozen dataclasses, one for each command, by the names of the commands.
        words: the words after the name of the program.
        program: name of the program.
        description: description of the program in the help.

    Raises:
        SystemExit: the help was printed (status 0), or the words do not describe a command (status ``BAD_INPUT``, after
            one line on standard error).
        StitchMeshError: the constructor of a group of options does not accept a value.
    """
    messages = io.StringIO()
    called, kind, given = program, _any_of(commands), list(words)
    if words and words[0] in commands:  # The rules of the other commands would take most of the time.
        called, kind, given = f"{program} {words[0]}", commands[words[0]], given[1:]
        description = kind.__doc__ or ""
    try:
        with redirect_stderr(messages):
            return tyro.cli(kind, prog=called, description=description, args=given, config=CONFIG, registry=_registry())
    except SystemExit as stop:
        if stop.code:
            say(f"{called}: {one_line(messages.getvalue())}; see {called} --help", file=sys.stderr)
        raise


def _any_of(commands: Mapping[str, type[Command]]) -> type[Command]:
    """Return the type of a value that is any of the commands, for the help of all of them."""
    named = tuple(Annotated[command, tyro.conf.subcommand(name)] for name, command in commands.items())
    return cast(type[Command], Union[named])  # noqa: UP007 (the union is made at run time)


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


def _choice(known: tuple[str, ...], word: str) -> str:
    if word not in known:
        raise ValueError(f"got {word!r}; expected one of {', '.join(known)}")
    return word


def _registry() -> ConstructorRegistry:
    """Return tyro's rules of conversion, with the rules of this module added."""
    registry = ConstructorRegistry()
    registry.primitive_rule(_spec_of_type)
    registry.struct_rule(settings_group)
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
