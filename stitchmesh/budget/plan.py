# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The plan of a relaxation with a budget: quality, limits, and one line that says what was chosen and what to expect.

The table is that of the device. A device without a table is compared by ``calibration`` with a device of the same kind
that has one, or with any that has one; the line then says how fast it is.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from stitchmesh.budget.budget import Budget, percent
from stitchmesh.budget.calibration import calibrate, device_title
from stitchmesh.budget.choice import Choice, choose, duration
from stitchmesh.budget.expectation import BudgetScene, expectations
from stitchmesh.budget.settings import SETTINGS, tightened
from stitchmesh.budget.tables import Table, read_tables
from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.time_limit import TimeLimit, seconds_left

MEASURING, LONGEST_MEASURING = 0.15, 1.0
"""Part of a time that is kept for the assessment and the measures of the result, and the longest such time [s]."""
LARGE_SCENE = 50
"""Stitches from which the large scene of the calibration says how fast a device is."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class Plan:
    """How a scene is relaxed within a budget."""

    quality: Quality
    """The quality, with the stopping rule and the limit of iterations of the budget."""
    choice: Choice | None
    """The setting and what to expect; None if no table has the scene with a given quality."""
    source: str
    """Where the expectation is from."""
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
    """Return the limit of the time of a budget, without the time for what follows; None if there is none.

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
        budget: the budget; its time counts as it is limited in the block around the call.
        scene: what is to be relaxed.
        quality: the default preset lets the tables choose; any other quality is kept.
        device: Warp's name of the device; None for the preferred device.
        measure: function that measures how fast a device is.

    Raises:
        ParameterError: a quality beside an error.
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
    """Return the nearest table with measurements of a scene, the slowness of the device, and how the two compare."""
    title, processor = device_title(device), "cuda" if device_named(device).is_cuda else "cpu"
    tables = [table for table in read_tables() if table.of(scene.kind)]
    for table in tables:
        if table.device == title:
            return table, 1.0, f"by the table of {table.title}"
    table = next((table for table in tables if table.processor == processor), tables[0])
    which = 0 if scene.stitches < LARGE_SCENE else 1
    slowness = measure(device, table.processor)[which] / table.pace[which]
    return table, slowness, f"by the table of {table.title}, calibrated: {title} takes {slowness:.2g} times as long"
