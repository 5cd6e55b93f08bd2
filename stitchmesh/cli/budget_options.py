# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The options of a budget, with which measured tables choose the quality, and the time that a command needs besides."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from contextvars import ContextVar
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from stitchmesh.budget.budget import FILES, Budget
from stitchmesh.cli.words import help_entry
from stitchmesh.quality import DEFAULT_QUALITY, PRESETS

OUT_OF_TIME = 3
"""Exit status of a command whose relaxation was ended by its time, before rest; all files are written."""
QUICK_START, MOST_LOAD = 0.5, 5.0
"""Time in which a machine that has nothing else to do reads the options [s], and the largest factor by which a shared
machine is slower: where the start takes longer, files and pictures do too."""
WITHIN_HELP = f"time for the whole command: 60s, 2min, 0.5h; it ends with what is reached (exit status {OUT_OF_TIME})"
ChosenQuality = Annotated[
    str | None,
    help_entry(
        "NAME", f"{DEFAULT_QUALITY}, or as tables choose for --within and --error",
        help=f"preset of accuracy and cost: {', '.join(PRESETS)}",
    ),
]  # fmt: skip

_start: ContextVar[float] = ContextVar("start of the command")


def mark_start(*, fresh: bool) -> None:
    """Note the start of the command that runs now: that of the process, if the process is ``fresh``, or this moment."""
    _start.set(time.perf_counter() - (_age_of_process() if fresh else 0.0))


def _age_of_process() -> float:
    """Return the time since the start of the process [s]; 0 where it is not known."""
    try:
        since_boot = float(Path("/proc/uptime").read_text().split()[0])
        ticks = int(Path("/proc/self/stat").read_text().rpartition(")")[2].split()[19])  # when the process was started
        return since_boot - ticks / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError, IndexError):
        return 0.0


@dataclass(frozen=True)
class TimeOption:
    """A limit on the time."""

    within: Annotated[str | None, help_entry("TIME", "no limit", help=WITHIN_HELP)] = None

    def limit(self, after: float = FILES) -> Budget | None:
        """Return the budget of the time; None without a limit.

        Args:
            after: time that the command needs after the relaxation [s].

        Raises:
            ParameterError: the time is malformed or too short.
        """
        given = Budget.of(self.within)
        return None if given is None else _from_start(given, after)


@dataclass(frozen=True)
class BudgetOptions:
    """Limits on the time and on the error, for which measured tables choose the quality."""

    within: Annotated[str | None, help_entry("TIME", "no limit", help=WITHIN_HELP)] = None
    error: Annotated[str | None, help_entry("ERROR", "that of the quality")] = None
    """largest relative error of the stitch spacing: 1% or 0.01; tables then choose the quality"""

    def budget(self, after: float = FILES, *, chooses: bool = True) -> Budget | None:
        """Return the budget; None if neither option is given.

        Args:
            after: time that the command needs after the relaxation [s].
            chooses: whether tables choose the quality, because no other option asks for one.

        Raises:
            ParameterError: an amount is malformed or out of bounds, or an error is given beside a quality.
        """
        given = Budget.of(self.within, self.error)
        return None if given is None else replace(_from_start(given, after), chooses=chooses)


def _from_start(given: Budget, after: float) -> Budget:
    return replace(given, after=after * load_of_machine(), began=start_of_command())


def start_of_command() -> float:
    """Return the reading of ``time.perf_counter`` at the start of the command [s]."""
    return _start.get(time.perf_counter())


def load_of_machine() -> float:
    """Return how much slower this machine has been up to now than one that has nothing else to do."""
    now = time.perf_counter()
    return min(max((now - _start.get(now)) / QUICK_START, 1.0), MOST_LOAD)


def time_after(picture: float | None, within: str | None) -> tuple[float, bool]:
    """Return the time that a command needs after the relaxation [s], and whether it draws its picture.

    The time is that of a machine that has nothing else to do. A picture for which less than half of the budget would be
    left for the relaxation is left out.

    Args:
        picture: estimated time of the picture [s]; None without one.
        within: the option of that name.

    Raises:
        ParameterError: the time is malformed or too short.
    """
    if picture is None:
        return FILES, False
    budget, after = Budget.of(within), FILES + picture
    if budget is None or budget.within is None or budget.within >= 2.0 * load_of_machine() * after:
        return after, True
    return FILES, False


def chosen_setting(report: Mapping[str, Any]) -> str | None:
    """Return the name of the preset that a budget chose; None without one."""
    chosen = report.get("budget", {}).get("quality")
    return None if chosen is None else str(chosen)


def exit_status(report: Any) -> int | None:
    """Return the exit status of a command: ``OUT_OF_TIME`` if the time ended its relaxation, otherwise None."""
    return OUT_OF_TIME if report.get("out_of_time") else None
