# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The choice of a setting for a budget.

With a time, the setting with the smallest expected error whose time fits; with an error only, the cheapest setting
whose expected error is small enough. More time therefore never gives a larger expected error, and a smaller error never
a cheaper setting. Where nothing fits, the nearest setting is taken and the choice says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stitchmesh.budget.budget import Budget, percent
from stitchmesh.budget.expectation import Expectation

LOAD = 0.8
"""Part of the time for which a setting is chosen; a machine is not always equally fast."""


@dataclass(frozen=True, kw_only=True)
class Choice:
    """A setting for a budget."""

    expected: Expectation
    """The setting, and what to expect of it."""
    doubt: str = ""
    """Why the budget cannot be met, as a clause; empty if it is expected to be."""


def choose(options: Sequence[Expectation], budget: Budget, seconds: float) -> Choice:
    """Return the setting for a budget.

    Args:
        options: what to expect of each setting; not empty.
        budget: the budget.
        seconds: time that is left for the relaxation [s]; infinite without a limit.
    """
    in_time = [one for one in options if one.most_seconds <= LOAD * seconds]
    cheapest = min(options, key=lambda one: (one.most_seconds, one.error))
    if budget.within is None:
        return _for_error(options, budget)
    if not in_time:
        return Choice(expected=cheapest, doubt=_too_short(cheapest, seconds))
    best = min(in_time, key=lambda one: (one.error, one.most_seconds))
    doubt = "" if budget.error is None or best.error <= budget.error else _too_little_time(options, budget, best)
    return Choice(expected=best, doubt=doubt)


def _for_error(options: Sequence[Expectation], budget: Budget) -> Choice:
    assert budget.error is not None
    good = [one for one in options if one.error <= budget.error]
    if good:
        return Choice(expected=min(good, key=lambda one: (one.most_seconds, one.error)))
    nearest = min(options, key=lambda one: (one.error, one.most_seconds))
    return Choice(expected=nearest, doubt=_too_small(budget.error, nearest))


def _too_small(error: float, nearest: Expectation) -> str:
    found = f"the nearest is {nearest.setting} with {percent(nearest.error)}"
    return f"no setting was measured with {percent(error)}; {found}"


def _too_short(cheapest: Expectation, seconds: float) -> str:
    need = f"{cheapest.setting} may need {duration(cheapest.most_seconds)}"
    return f"{need}, so the time may end it before rest" if seconds > 0.0 else f"{need}, and no time is left for it"


def _too_little_time(options: Sequence[Expectation], budget: Budget, best: Expectation) -> str:
    assert budget.error is not None
    enough = [one for one in options if one.error <= budget.error]
    if not enough:
        return _too_small(budget.error, min(options, key=lambda one: one.error))
    need = min(enough, key=lambda one: one.most_seconds)
    cost = f"{need.setting} may need {duration(need.most_seconds)} for it"
    return f"{percent(budget.error)} cannot be had in the time: {cost}, so {best.setting} is the nearest"


def duration(seconds: float) -> str:
    """Return a time with two digits or more, in the unit of which it has a few."""
    if seconds >= 7200.0:
        return f"{seconds / 3600.0:.2g} h"
    if seconds >= 120.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds:.0f} s" if seconds >= 10.0 else f"{seconds:.2g} s"
