# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Plans a relaxation with a budget: the quality, the limits, and one line that says what was chosen and what to expect.

The expectations come from the table of the device. If the device has no table, ``calibration`` compares it with a
device that has one, of the same kind if there is one. The line then says how fast the device is in comparison.

A budget chooses between settings: qualities with their solvers. For an error it also chooses the stopping rule.

With a time, the choice is the setting with the smallest expected error whose time fits. With an error only, it is the
cheapest setting whose expected error is small enough. More time therefore never gives a larger expected error, and a
larger error never needs a more expensive setting. If no setting fits, the nearest one is taken, and the choice says so.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from stitchmesh.budget.budget import Budget, percent
from stitchmesh.budget.calibration import calibrate, device_title
from stitchmesh.budget.tables import BudgetScene, Expectation, Table, expectations, read_tables
from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.quality import DEFAULT_QUALITY, PRESETS, Quality, quality_named
from stitchmesh.time_limit import TimeLimit, seconds_left

SETTINGS: Mapping[str, Quality] = PRESETS | {"standard by dynamics": replace(PRESETS["standard"], solver="dynamics")}
"""The settings by name."""
LEFT = 0.5
"""Part of the error that may remain when a relaxation stops; the rest of the error is for the sampling."""
SMALLEST_CHANGE = {"float32": 1e-4, "float64": 1e-6}
"""Smallest estimate of the remaining change that each precision resolves."""
MORE_ITERATIONS = 50
"""The limit of iterations is raised by this factor if a budget ends the relaxation instead."""
LOAD = 0.8
"""Part of the time for which a setting is chosen, because a machine is not always equally fast."""
MEASURING, LONGEST_MEASURING = 0.15, 1.0
"""Part of the time that is kept for the assessment and the measures of the result, and the longest such time [s]."""

logger = logging.getLogger(__name__)


def tightened(quality: Quality, error: float | None) -> Quality:
    """Return a quality that stops no earlier than an error allows, with a limit of iterations that does not end it.

    Args:
        quality: the quality of a setting.
        error: largest relative error of the spacing; None keeps the rule of the quality.
    """
    limit = MORE_ITERATIONS * quality.max_iterations
    if error is None:
        return replace(quality, max_iterations=limit)
    change = max(LEFT * error, SMALLEST_CHANGE[quality.precision])
    return replace(quality, max_iterations=limit, largest_change=min(quality.largest_change, change))


@dataclass(frozen=True, kw_only=True)
class Choice:
    """A setting for a budget."""

    expected: Expectation
    """The setting, and what to expect from it."""
    doubt: str = ""
    """Why the budget cannot be met, as a clause; empty if it is expected to be."""


def choose(options: Sequence[Expectation], budget: Budget, seconds: float) -> Choice:
    """Return the setting for a budget.

    Args:
        options: what to expect from each setting; not empty.
        budget: the budget.
        seconds: remaining time for the relaxation [s]; infinite without a limit.
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
    """Return a time with two digits or more, in a unit of which it has a few."""
    if seconds >= 7200.0:
        return f"{seconds / 3600.0:.2g} h"
    if seconds >= 120.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds:.0f} s" if seconds >= 10.0 else f"{seconds:.2g} s"


@dataclass(frozen=True, kw_only=True)
class Plan:
    """How a scene is relaxed within a budget."""

    quality: Quality
    """The quality, with the stopping rule and the limit of iterations of the budget."""
    choice: Choice | None
    """The setting and what to expect; None if no table knows the scene with the given quality."""
    source: str
    """Where the expectation comes from."""
    budget: Budget
    """The budget."""

    @property
    def line(self) -> str:
        """Return what was chosen and what to expect, in one line."""
        limit = "" if self.budget.within is None else f"; all of it is limited to {duration(self.budget.within)}"
        if self.choice is None:
            return f"budget: the quality as given, of which no table says what to expect{limit}"
        expected = self.choice.expected
        time = f"about {duration(expected.seconds)} (at most {duration(expected.most_seconds)})"
        figures = f"{expected.setting}: {time}, spacing within {percent(expected.error)}"
        doubt = f"; {self.choice.doubt}" if self.choice.doubt else ""
        return f"budget: {figures}, {self.source}{doubt}{limit}"

    def report(self) -> dict[str, Any]:
        """Return the entry of the report."""
        expected = None if self.choice is None else asdict(self.choice.expected)
        preset = None if self.choice is None else self.choice.expected.setting.split()[0]
        return {
            "within": self.budget.within, "error": self.budget.error, "expected": expected, "quality": preset,
            "solver": self.quality.solver, "largest_change": self.quality.largest_change, "source": self.source,
            "line": self.line,
        }  # fmt: skip


def limit_of(budget: Budget | None) -> TimeLimit | None:
    """Return the limit of a budget on the time, without the time for later work; None if the budget has no time.

    Raises:
        ParameterError: the time is already over.
    """
    if budget is None or budget.within is None:
        return None
    measuring = min(MEASURING * budget.within, LONGEST_MEASURING)
    limit = TimeLimit(budget.within, reserved=budget.after + measuring, began=budget.began)
    if limit.left <= 0.0:
        needed = f"{limit.spent:.1f} s are spent on the start and {limit.reserved:.1f} s are needed for the files"
        least = math.ceil(limit.spent + limit.reserved + 1.0)
        raise ParameterError(f"within: got {duration(budget.within)}, but {needed}; give {least}s or more")
    return limit


def make_plan(
    budget: Budget, scene: BudgetScene, quality: str | Quality = DEFAULT_QUALITY, device: str | None = None,
    measure: Callable[[str | None, str], tuple[float, float]] = calibrate,
) -> Plan:  # fmt: skip
    """Choose the quality of a scene for a budget, and log what was chosen.

    Args:
        budget: the budget; the limit of the block around the call says how much time is left.
        scene: the scene to relax.
        quality: the default preset lets the tables choose; any other quality is kept.
        device: Warp's name of the device; None for the preferred device.
        measure: function that measures how fast a device is.

    Raises:
        ParameterError: the budget has an error, and the quality is kept.
    """
    given = quality_named(quality)
    kept = not budget.chooses or given != quality_named(DEFAULT_QUALITY)
    budget.refuse_kept_quality(kept=kept)
    table, slowness, source = _table_for(device, scene, measure)
    options = expectations(table, scene, slowness)
    if kept:
        options = [one for one in options if SETTINGS[one.setting] == given]
    choice = choose(options, budget, seconds_left()) if options else None
    if not (kept or choice is None):
        given = tightened(SETTINGS[choice.expected.setting], budget.error)
    made = Plan(quality=given, choice=choice, source=source, budget=budget)
    logger.info(made.line)
    return made


def _table_for(
    device: str | None, scene: BudgetScene, measure: Callable[[str | None, str], tuple[float, float]]
) -> tuple[Table, float, str]:
    """Return the nearest table with measurements of a scene, the slowness of the device, and the source in words."""
    title, processor = device_title(device), "cuda" if device_named(device).is_cuda else "cpu"
    tables = [table for table in read_tables() if table.of(scene.kind)]
    for table in tables:
        if table.device == title:
            return table, 1.0, f"by the table of {table.title}"
    table = next((table for table in tables if table.processor == processor), tables[0])
    # From 50 stitches on, the large scene of the calibration says how fast a device is.
    which = 0 if scene.stitches < 50 else 1
    slowness = measure(device, table.processor)[which] / table.pace[which]
    return table, slowness, f"by the table of {table.title}, calibrated: {title} takes {slowness:.2g} times as long"
