# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether budgets are kept: what was asked for, what was expected and what came, on swatches that no table has.

Each budget is a time or an error. The true error is that of the two periods against the true rest, as in
``budget_tables.py``. Kernels are loaded first.
"""

from __future__ import annotations

import time
from collections.abc import Generator, Sequence

import stitchmesh as sm
from benchmarks.measures.swatches.budget_tables import spacing_error, true_quality
from benchmarks.table import Rows
from stitchmesh.budget.budget import Budget, percent
from stitchmesh.errors import StitchMeshError
from stitchmesh.quality import PRESETS

PATTERNS = ("reverse-stockinette", "twill-2x1", "basket-2x2", "lice", "long-slip-textured", "seersucker")
"""Swatches that ``budget_tables.py`` does not measure."""


def budget_kept(*, patterns: tuple[str, ...] = PATTERNS, device: str | None = None) -> Rows:
    """Relax the swatches with each budget, and print the table."""
    sm.swatch("stockinette", relax_cell=True, device=device, progress=False)
    yield "swatch", "budget", "chosen", "expected s", "at most s", "seconds", "expected error", "true error", "kept"
    kept: list[bool] = []
    for pattern in patterns:
        kept += yield from rows_of(pattern, ("1s", "5s", "5%", "1%"), device)
    yield f"{sum(kept)} of {len(kept)} budgets kept"


def rows_of(
    pattern: str, budgets: Sequence[str], device: str | None
) -> Generator[tuple[object, ...], None, list[bool]]:
    """Yield the rows of a pattern, and return whether each budget was kept."""
    shared = {"relax_cell": True, "device": device, "progress": False}
    try:
        truth = sm.swatch(pattern, quality=true_quality(PRESETS["reference"]), **shared)
    except StitchMeshError as error:
        yield pattern, error
        return []
    found = []
    for text in budgets:
        budget = Budget.of(None, text) if text.endswith("%") else Budget.of(text)
        assert budget is not None
        began = time.perf_counter()
        made = sm.swatch(pattern, budget=budget, **shared)
        seconds, wrong = time.perf_counter() - began, spacing_error(made.yarns, truth.yarns)
        plan, report = made.report["budget"]["expected"], made.report
        in_time = budget.within is None or seconds <= budget.within
        good = in_time and (budget.error is None or wrong <= budget.error)
        ended = ", time over" if report["out_of_time"] else "" if report["converged"] else ", not at rest"
        yield (
            pattern, text, plan["setting"], f"{plan['seconds']:.2g}", f"{plan['most_seconds']:.2g}",
            f"{seconds:.2g}{ended}", percent(plan["error"]), percent(wrong), "yes" if good else "no",
        )  # fmt: skip
        found.append(good)
    return found
