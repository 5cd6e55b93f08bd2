# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The errors that StitchMesh raises on purpose.

A message is one line. It says what is wrong, where (an index), what was found, what was expected and how to correct
it. The command line prints the message unchanged and exits with status 2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T")

LEAST_NUMBER, LARGEST_NUMBER = 1e-6, 1e6
"""Bounds of a length [cm] or a ratio that a user gives: from 10 nm to 10 km. Every yarn, stitch and tool is far within
them, and fourth powers and their quotients stay far within the range of numbers in single precision."""

MAKERS = {
    "Mesh": "sm.read_mesh(path)",
    "StitchMesh": "sm.tessellate(labeled, stitch_width=0.8)",
    "YarnSet": "sm.generate_yarns(fabric)",
    "YarnMaterial": "sm.YarnMaterial.named(name)",
    "Pattern": "sm.read_pattern(name)",
    "Weave": "sm.read_weave(name)",
    "Edit": "sm.Edit(name, arguments)",
    "RestLengths": "sm.RestLengths(factor=1.1)",
    "ShapingOptions": "sm.ShapingOptions(multiple=4)",
}
"""Call that makes a value of each class, for the messages of ``check_kind``."""
LONGEST_MESSAGE = 2000
"""A longer message loses its middle."""
REPLACEMENT = "\N{REPLACEMENT CHARACTER}"
"""This character replaces each one that cannot be printed."""


class StitchMeshError(Exception):
    """Base class of all errors below; a handler of this class catches all of them."""

    def __init__(self, message: str = "") -> None:
        """Make an error; text that the message quotes from a damaged file cannot make it long or break its line."""
        super().__init__(_one_line(message))


class FileError(StitchMeshError):
    """A file cannot be read or written, or its content does not match its format."""


class ParameterError(StitchMeshError):
    """The user gave a number or a name that the operation does not accept."""


class MeshError(StitchMeshError):
    """A polygon mesh is not an oriented manifold surface with valid coordinates."""


class LabelError(StitchMeshError):
    """A mesh cannot be separated into knitting rows."""

    def __init__(self, message: str, *, labeling: object | None = None) -> None:
        """Make an error; ``labeling`` is the ``PartialLabeling`` that shows the faces at fault, if there is one."""
        super().__init__(message)
        self.labeling = labeling


class TessellationError(StitchMeshError):
    """A labeled mesh cannot be divided into legal stitch faces with the requested counts."""


class PatternError(StitchMeshError):
    """A knitting pattern or a weave cannot be read, or its stitches do not fit together."""

    def __init__(
        self, message: str, *, line: int | None = None, column: int | None = None, row: int | None = None
    ) -> None:
        """Make an error.

        Args:
            message: the message, with the place in words.
            line: line of the text at fault, from 1, if the fault has a place in a text.
            column: column of the text at fault, from 1.
            row: row of the matrix of a weave at fault, from 0, if one row is at fault.
        """
        super().__init__(message)
        self.line = line
        self.column = column
        self.row = row


class YarnError(StitchMeshError):
    """A set of yarns is malformed, or yarns cannot be generated from a stitch mesh."""

    def __init__(self, message: str, *, face: int | None = None, remedy: str = "") -> None:
        """Make an error; ``face`` is the stitch at fault, if one is; ``found`` holds the message without the remedy."""
        super().__init__(f"{message}; {remedy}" if remedy else message)
        self.face = face
        self.found = message


class SolverError(StitchMeshError):
    """A relaxation cannot continue; the last good state was kept."""


class OverloadError(SolverError):
    """The forces press yarns together or are too steep; the yarns may take a smaller load."""


class CompilationError(StitchMeshError):
    """A kernel cannot be compiled on this machine."""


class DisplayError(StitchMeshError):
    """Pictures cannot be drawn on this machine."""


def is_interrupt(error: BaseException) -> bool:
    """Return whether an interrupt from the keyboard is the cause of an exception.

    If an interrupt comes while a module is imported, Python may raise an ``ImportError`` or a ``SystemError``.
    """
    links: list[BaseException] = []
    found: BaseException | None = error
    while found is not None and found not in links:
        if isinstance(found, KeyboardInterrupt):
            return True
        links.append(found)
        found = found.__cause__ or found.__context__
    return False


def first_few(items: Sequence[object] | NDArray, limit: int = 3) -> str:
    """List the first items and count the others: ``4, 7, 9 (+12 more)``.

    Args:
        items: the items, for example the indices of all faces that failed a check.
        limit: number of items to list.
    """
    shown = ", ".join(str(item) for item in items[:limit])
    rest = len(items) - limit
    return f"{shown} (+{rest} more)" if rest > 0 else shown


def check_kind(place: str, value: object, kind: type[T], made_by: str | None = None) -> T:
    """Return a value that a user has given, if its class is the one that the operation works on.

    Args:
        place: name of the operation, and of the argument if the argument is not the first one.
        value: the value.
        kind: class of the values that the operation works on.
        made_by: call that makes such a value; by default the call in ``MAKERS``.

    Raises:
        ParameterError: the value is of another class. If the value has a field of the right class, the message names
            the field.
    """
    if isinstance(value, kind):
        return value
    fields = [name for name in getattr(value, "__dataclass_fields__", ()) if isinstance(getattr(value, name), kind)]
    remedy = f"give its field {fields[0]!r}" if fields else f"make one by {made_by or MAKERS[kind.__name__]}"
    raise ParameterError(f"{place}: got {described(value)}; expected {_with_article(kind.__name__)}: {remedy}")


def check_positive(name: str, value: float, unit: str = "") -> None:
    """Check a length or a ratio that a user has given.

    Args:
        name: name of the number, for the message.
        value: the number.
        unit: unit of the number, for the message.

    Raises:
        ParameterError: the number is not positive, or is outside the range from ``LEAST_NUMBER`` to ``LARGEST_NUMBER``.
    """
    unit = unit and f" {unit}"
    if not 0.0 < value < math.inf:
        raise ParameterError(f"{name}: got {value}{unit}; expected a positive number")
    if not LEAST_NUMBER <= value <= LARGEST_NUMBER:
        raise ParameterError(f"{name}: got {value:g}{unit}; expected {LEAST_NUMBER:g} to {LARGEST_NUMBER:g}{unit}")


def described(value: object) -> str:
    """Return a short description of a value for a message: a text or a number itself, or the class of another value."""
    if isinstance(value, str):
        return f"the text {value[:40]!r}"
    if value is None or isinstance(value, bool | int | float):
        return str(value)
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    return _with_article(type(value).__name__)


def _one_line(text: str) -> str:
    """Return a text in one line of printable characters, without the middle of a very long text."""
    line = " ".join(text.splitlines())
    if not line.isprintable():
        line = "".join(character if character.isprintable() else REPLACEMENT for character in line)
    if len(line) <= LONGEST_MESSAGE:
        return line
    return f"{line[: LONGEST_MESSAGE * 3 // 4]} ... {line[-LONGEST_MESSAGE // 8 :]}"


def _with_article(name: str) -> str:
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"
