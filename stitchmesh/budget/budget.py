# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A budget: how long a relaxation may take, and how wrong its spacing may be. Texts are parsed into amounts here."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from stitchmesh.errors import ParameterError, described

UNITS = {"ms": 1e-3, "s": 1.0, "sec": 1.0, "min": 60.0, "h": 3600.0}
"""Seconds in each unit of time."""
SHORTEST = 0.1
"""Shortest time that can be kept [s]; to generate the smallest swatch and assess it once takes about as long."""
SMALLEST_ERROR, LARGEST_ERROR = 1e-5, 0.5
"""Smallest and largest relative error of the spacing. The tables compare with states of rest that are known to the
smallest error only."""
FILES = 1.5
"""Time to write the files and to plot the convergence after the relaxations, on a machine without other load [s]."""
START_OF_RENDERER, POINT_OF_PICTURE = 2.0, 6e-5
"""Time to start the renderer, and to draw one control point without a GPU [s]."""
NO_TIME_FOR_PICTURE = "no picture: the time leaves none for it; give more, or draw it with `stitchmesh render`"
"""Line in the place of a picture that is left out."""
AMOUNT = re.compile(r"\s*([-+]?(?:[\d.]+(?:e[-+]?\d+)?|nan|inf\w*))\s*([a-z%]*)\s*", re.IGNORECASE)
"""A number and a unit."""


@dataclass(frozen=True, kw_only=True)
class Budget:
    """Limits on the cost and on the error of a relaxation; at least one of them is given.

    Raises:
        ParameterError: neither is given, one is out of bounds, or an error is given and the quality is kept.
    """

    within: float | None = None
    """Time for everything, from the call to the result [s]."""
    error: float | None = None
    """Largest relative error of the spacing of stitches."""
    chooses: bool = True
    """Whether tables choose the quality, if it is the default; otherwise it is kept, and no error is allowed."""
    after: float = 0.0
    """Part of the time that the caller needs after the result, for example to draw it [s]."""
    began: float = math.nan
    """Reading of ``time.perf_counter`` from which the time counts [s]; by default the reading at the call."""

    def __post_init__(self) -> None:
        if self.within is None and self.error is None:
            raise ParameterError("budget: got neither a time nor an error; give one of them")
        if self.within is not None:
            _check_time(self.within)
        if self.error is not None:
            _check_error(self.error)
            self.refuse_kept_quality(kept=not self.chooses)

    def refuse_kept_quality(self, *, kept: bool) -> None:
        """Refuse an error together with a kept quality, because the error chooses the quality.

        Raises:
            ParameterError: an error is given, and the quality is kept.
        """
        if kept and self.error is not None:
            raise ParameterError("error: got a quality, a solver or a limit of iterations beside it; leave one out")

    @classmethod
    def of(cls, within: str | float | None = None, error: str | float | None = None) -> Budget | None:
        """Return the budget of a time and an error; None if neither is given.

        Args:
            within: seconds, or a text such as ``60s``, ``2min`` or ``0.5 h``.
            error: a fraction, or a text such as ``1%`` or ``0.01``.

        Raises:
            ParameterError: an amount is malformed or out of bounds.
        """
        if within is None and error is None:
            return None
        return cls(
            within=None if within is None else parse_time(within), error=None if error is None else parse_error(error)
        )


def parse_time(amount: str | float) -> float:
    """Return a time [s] that is given as a number of seconds, or as a text such as ``60s``, ``2min`` or ``0.5 h``.

    Raises:
        ParameterError: the text is malformed, or the time is too short.
    """
    number, unit = _number_and_unit(amount)
    if number is None or (unit or "s") not in UNITS:
        raise ParameterError(f"within: got {described(amount)}; expected a time such as 60s, 2min or 0.5h")
    return _check_time(number * UNITS[unit or "s"])


def parse_error(amount: str | float) -> float:
    """Return a relative error that is given as a number, or as a text such as ``1%`` or ``0.01``.

    Raises:
        ParameterError: the text is malformed, or the error is out of bounds.
    """
    number, unit = _number_and_unit(amount)
    if number is None or unit not in ("", "%"):
        raise ParameterError(f"error: got {described(amount)}; expected an error such as 1% or 0.01")
    if not unit and 1.0 <= number <= 100.0 * LARGEST_ERROR:
        raise ParameterError(f"error: got {number:g}, which is {percent(number)}; {number:g} % is written {number:g}%")
    return _check_error(number / 100.0 if unit else number)


def _number_and_unit(amount: str | float) -> tuple[float | None, str]:
    """Return a number and the unit after it; the number is None if the text is something else."""
    if isinstance(amount, int | float) and not isinstance(amount, bool):
        return float(amount), ""
    found = AMOUNT.fullmatch(amount) if isinstance(amount, str) else None
    try:
        return (None, "") if found is None else (float(found[1]), found[2].lower())
    except ValueError:
        return None, ""


def _check_time(seconds: float) -> float:
    if not math.isfinite(seconds):
        raise ParameterError(f"within: got {seconds:g}; expected a finite time such as 60s, or no limit")
    if not seconds > 0.0:
        raise ParameterError(f"within: got {seconds:g} s; expected a time above zero, such as 60s")
    if seconds < SHORTEST:
        raise ParameterError(f"within: got {seconds:g} s; the start alone takes longer; the shortest is {SHORTEST:g}s")
    return seconds


def _check_error(error: float) -> float:
    if not error > 0.0:
        raise ParameterError(f"error: got {error:g}; expected an error above zero, such as 1%")
    if error > LARGEST_ERROR:
        raise ParameterError(f"error: got {percent(error)}; expected at most {percent(LARGEST_ERROR)}")
    if error < SMALLEST_ERROR:
        least = f"the states that it is measured by are known to {percent(SMALLEST_ERROR)}; ask for that"
        raise ParameterError(f"error: got {percent(error)}; {least}")
    return error


def percent(part: float) -> str:
    """Return a fraction as a percentage, without a space as on the command line."""
    return f"{100.0 * part:.3g}%"
