# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether budgets are kept: what was asked for, what was expected and what came, on swatches that no table has.

    python benchmarks/budget_kept.py --device cpu
    python benchmarks/budget_kept.py --device cpu --budgets 1s 4s 1%

Each budget is a time or an error. The true error is that of the two periods against the true rest, as in
``benchmarks/budget_tables.py``. Kernels are loaded first.
"""

from __future__ import annotations

import argparse
import time

from budget_tables import spacing_error, true_quality

import stitchmesh as sm
from stitchmesh.budget.budget import Budget, percent
from stitchmesh.errors import StitchMeshError
from stitchmesh.quality import PRESETS

PATTERNS = ("reverse-stockinette", "twill-2x1", "basket-2x2", "lice", "long-slip-textured", "seersucker")
"""Swatches that ``benchmarks/budget_tables.py`` does not measure."""


def main() -> None:
    """Relax the swatches with each budget, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patterns", nargs="+", default=PATTERNS)
    parser.add_argument("--budgets", nargs="+", default=["1s", "5s", "5%", "1%"])
    parser.add_argument("--device")
    given = parser.parse_args()
    sm.swatch("stockinette", relax_cell=True, device=given.device, progress=False)
    print("| swatch | budget | chosen | expected s | at most s | seconds | expected error | true error | kept |")
    print("|---|---|---|---:|---:|---:|---:|---:|---|")
    kept = [row for pattern in given.patterns for row in rows_of(pattern, given.budgets, given.device)]
    print(f"\n{sum(kept)} of {len(kept)} budgets kept")


def rows_of(pattern: str, budgets: list[str], device: str | None) -> list[bool]:
    """Print the rows of a pattern, and return whether each budget was kept."""
    shared = {"relax_cell": True, "device": device, "progress": False}
    try:
        truth = sm.swatch(pattern, quality=true_quality(PRESETS["reference"]), **shared)
    except StitchMeshError as error:
        print(f"| {pattern} | {error} |")
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
        cells = [pattern, text, plan["setting"], f"{plan['seconds']:.2g}", f"{plan['most_seconds']:.2g}",
                 f"{seconds:.2g}{ended}", percent(plan["error"]), percent(wrong), "yes" if good else "no"]  # fmt: skip
        print(f"| {' | '.join(cells)} |", flush=True)
        found.append(good)
    return found


if __name__ == "__main__":
    main()
