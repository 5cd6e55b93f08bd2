# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The fields of a value as short strings, to compare the inputs of two runs."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.yarn import YarnSet

DIGITS = 16
"""Number of hexadecimal digits of a checksum; two different values have the same digits once in 2^64 cases."""


def fingerprint(name: str, value: Any, *, without: tuple[str, ...] = ()) -> dict[str, str]:
    """Return the fields of a dataclass by ``name.field``: plain values as text, others as a checksum.

    Args:
        name: name of the value.
        value: a dataclass.
        without: fields to leave out.

    Raises:
        ParameterError: a field has a value whose bytes cannot be compared, such as a function.
    """
    names = [field.name for field in fields(value) if field.name not in without]
    return {f"{name}.{field}": _text_of(f"{name}.{field}", getattr(value, field)) for field in names}


def yarn_fingerprint(yarns: YarnSet) -> dict[str, str]:
    """Return the fields of yarns that decide a run; a mass that no yarn states is left out, like a missing field."""
    unstated = ("mass_per_length",) if np.isnan(yarns.mass_per_length).all() else ()
    return fingerprint("yarns", yarns, without=("palette", "drawn_radius", "made_of", *unstated))


def refuse_other_inputs(name: str, written: Mapping[str, str], inputs: Mapping[str, str]) -> None:
    """Check that a checkpoint has the inputs of the present run; ``name`` is the name of its file.

    Raises:
        ParameterError: an input differs; the message names it.
    """
    differing = [key for key in {**written, **inputs} if written.get(key) != inputs.get(key)]
    if differing:
        key, more = differing[0], f", and {len(differing) - 1} more" if len(differing) > 1 else ""
        found = f"{key} is {inputs.get(key, 'absent')} and was {written.get(key, 'absent')}{more}"
        raise ParameterError(f"{name}: is of a relaxation that was given something else: {found}; give it the same")


def _text_of(name: str, value: Any) -> str:
    if value is None or isinstance(value, str | bool | int | float | np.generic):
        return str(value)
    return f"SHA-256 {checksum(name, value)}"


def checksum(name: str, value: Any) -> str:
    """Return the checksum of a value, in hexadecimal digits; different values have different ones (``DIGITS``).

    Args:
        name: name of the value.
        value: a plain value, an array, a dataclass, or a mapping, list or tuple of these.

    Raises:
        ParameterError: the value has no bytes to compare (``fingerprint``).
    """
    digest = hashlib.sha256()
    for part in _parts(name, value):
        digest.update(part)
    return digest.hexdigest()[:DIGITS]


def _parts(name: str, value: Any) -> Iterator[bytes]:
    """Yield the bytes of a value; different values have different bytes."""
    if value is None or isinstance(value, str | bool | int | float | np.generic):
        yield f"{value!s};".encode()
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype.str}{value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif isinstance(value, Mapping):
        yield f"{len(value)} pairs".encode()
        for item in value.items():
            yield from _parts(name, item)
    elif isinstance(value, list | tuple):
        yield f"{len(value)} of".encode()
        for item in value:
            yield from _parts(name, item)
    elif is_dataclass(value):
        yield type(value).__name__.encode()
        for field in fields(value):
            yield from _parts(name, getattr(value, field.name))
    else:
        found = type(value).__name__
        raise ParameterError(f"{name}: got a {found}, which a checkpoint cannot tell from another; relax without one")
