# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Units of length in files. Inside StitchMesh every length is in centimetres."""

from __future__ import annotations

from os import fspath

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath

CENTIMETRES: dict[str, float] = {"mm": 0.1, "cm": 1.0, "dm": 10.0, "m": 100.0, "inch": 2.54}
"""Centimetres in each unit that a file may be written in."""
DEFAULT_UNIT = "cm"
"""Unit of a file that states none, where the caller names none."""


def centimetres(unit: str) -> float:
    """How many centimetres the unit has.

    Raises:
        ParameterError: there is no unit of that name.
    """
    if unit not in CENTIMETRES:
        raise ParameterError(f"unit: got {unit!r}; expected one of {', '.join(CENTIMETRES)}")
    return CENTIMETRES[unit]


def check_unit_left_out(path: FilePath, scale: float) -> None:
    """Check that no unit was named for a format that fixes or states its own.

    Args:
        path: the file, for the message.
        scale: centimetres in the unit that was named, 1 where none was.

    Raises:
        ParameterError: one was.
    """
    if scale != 1.0:
        raise ParameterError(f"unit: {fspath(path)} is of a format that fixes or states its unit; leave the unit out")
