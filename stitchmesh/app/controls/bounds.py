# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bounds of a number or a slider."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.errors import ParameterError

ROUNDING = 1e-7
"""Distance by which a value may lie beyond its bounds; a browser rounds a slider's ends to seven decimals."""
LONGEST_SHOWN = 40
"""Number of characters of a wrong value that a message shows."""


@dataclass(frozen=True)
class Bounds:
    """The values that an input takes."""

    label: str
    """Label of the input."""
    least: float
    most: float

    def check(self, given: object) -> None:
        """Refuse what is no number, nan included, or beyond the bounds.

        Raises:
            ParameterError: the value is refused.
        """
        is_number = isinstance(given, int | float) and not isinstance(given, bool)
        if is_number and self.least - ROUNDING <= given <= self.most + ROUNDING:  # type: ignore[operator]
            return
        shown = f"{given:g}" if is_number else repr(given)[:LONGEST_SHOWN]
        raise ParameterError(f"{self.label}: got {shown}; expected {self.least:g} to {self.most:g}")
