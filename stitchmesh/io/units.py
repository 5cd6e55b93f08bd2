# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Units of length in files. Inside StitchMesh every length is in centimetres."""

from __future__ import annotations

from stitchmesh.errors import ParameterError

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
