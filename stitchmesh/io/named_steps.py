# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Steps as data: the name of a function, and arguments that JSON can hold. Edits and labeling steps are such steps.

The parameters of the function, without the value that the step changes, give the names and the types of the arguments.
"""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Mapping, Sequence
from functools import cache, reduce
from operator import or_
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import msgspec

from stitchmesh.errors import ParameterError, described
from stitchmesh.io.checked import check_value, plain_value

LARGEST_NUMBER = 2**31 - 1
"""Largest absolute value of a whole number in the arguments of a step, which arrays of whole numbers can hold."""
WholeNumber = Annotated[int, msgspec.Meta(ge=-LARGEST_NUMBER, le=LARGEST_NUMBER)]
"""Type of a whole number in the arguments of a step."""


def plain_arguments(step: str, arguments: object, example: str) -> dict[str, object]:
    """Return the arguments of a step as JSON can hold them (``plain_value``).

    Args:
        step: kind and name of the step, for the message.
        arguments: the arguments by name.
        example: arguments by name, for the message.

    Raises:
        ParameterError: the arguments are not given by name.
    """
    if not isinstance(arguments, Mapping) or not all(isinstance(name, str) for name in arguments):
        raise ParameterError(f"{step}: got {described(arguments)}; expected arguments by name, such as {example}")
    return {name: plain_value(value) for name, value in arguments.items()}


def check_step_name(kind: str, name: str, known: Mapping[str, object]) -> None:
    """Check that a step is known.

    Raises:
        ParameterError: the step is unknown; the message gives the most similar name.
    """
    if name not in known:
        near = difflib.get_close_matches(str(name), known, n=1) or [", ".join(known)]
        raise ParameterError(f"{kind} {name!r}: is unknown; expected {near[0]}")


def checked_arguments_of(
    function: Callable[..., object], arguments: Mapping[str, object], replaced: str | None = None, by: str | None = None
) -> dict[str, Any]:
    """Check the names and the types of arguments, and return all arguments, defaults included.

    Args:
        function: the function of the step.
        arguments: the arguments by name.
        replaced: a parameter whose place a text takes.
        by: name of that text.

    Raises:
        ParameterError: an argument is missing, unknown or of another type.
    """
    return msgspec.structs.asdict(check_value(dict(arguments), _arguments_type(function, replaced, by)))


@cache
def _arguments_type(function: Callable[..., object], replaced: str | None, by: str | None) -> type[msgspec.Struct]:
    """Return a class whose fields are the parameters of a function after the first one."""
    hints = get_type_hints(function)
    fields: list[Any] = [] if by is None else [(by, str)]
    for parameter in list(inspect.signature(function).parameters.values())[1:]:
        if parameter.name != replaced:
            optional = () if parameter.default is parameter.empty else (parameter.default,)
            fields.append((parameter.name, _bounded(hints[parameter.name]), *optional))
    return msgspec.defstruct(function.__name__, fields, forbid_unknown_fields=True, kw_only=True)


def _bounded(hint: Any) -> Any:
    """Return the type of an argument with ``int`` replaced by whole numbers that arrays can hold.

    A number or a tuple stays as it is, because msgspec 0.22 ends the program on a bounded number or a tuple.
    """
    if hint is int:
        return WholeNumber
    if get_origin(hint) is Sequence:
        return list[WholeNumber]
    options = get_args(hint)
    if get_origin(hint) in (Union, UnionType) and not any(get_origin(option) is tuple for option in options):
        return reduce(or_, map(_bounded, options))
    return hint
