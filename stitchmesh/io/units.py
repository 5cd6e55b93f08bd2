# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Units of length in files. In the program every length is in centimetres."""

from __future__ import annotations

from os import fspath

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath

CENTIMETRES: dict[str, float] = {"mm": 0.1, "cm": 1.0, "dm": 10.0, "m": 100.0, "inch": 2.54}
"""Number of centimetres in each unit of length that a file may have."""
DEFAULT_UNIT = "cm"
"""Unit of a file if neither the file nor the caller states a unit."""


def centimetres(unit: str) -> float:
    """Return the number of centimetres in a unit.

    Raises:
        ParameterError: there is no unit of that name.
    """
    if unit not in CENTIMETRES:
        raise ParameterError(f"unit: got {unit!r}; expected one of {', '.join(CENTIMETRES)}")
    return CENTIMETRES[unit]


def check_unit_left_out(path: FilePath, scale: float) -> None:
    """Check that the caller gave no unit for a format that prescribes or states its unit.

    Args:
        path: the file, for the error message.
        scale: number of centimetres in the given unit; 1 if no unit was given.

    Raises:
        ParameterError: a unit was given.
    """
    if scale != 1.0:
        raise ParameterError(f"unit: {fspath(path)} is of a format that fixes or states its unit; leave the unit out")
