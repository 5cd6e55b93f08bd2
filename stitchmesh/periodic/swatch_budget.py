# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The figures by which a budget plans a swatch: its kind, its number of stitches and its name."""

from __future__ import annotations

from typing import Any

from stitchmesh.budget.budget import Budget
from stitchmesh.budget.plan import Plan, make_plan
from stitchmesh.budget.tables import BudgetScene
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.relaxation.off_needles import state_of_rest
from stitchmesh.periodic.resolve_pattern import Source, resolve_pattern
from stitchmesh.periodic.swatch_options import KnitState, SwatchOptions
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.quality import Quality

RELAXATIONS: dict[KnitState, int] = {"frictionless": 1, "dry": 14, "wet": 18, "full": 23}
"""Number of relaxations, one after another, on the needles and in the release to each state (``off_needles``)."""


def plan_swatch(
    pattern: str | Pattern | Weave, budget: Budget, quality: str | Quality, device: str | None, **options: Any
) -> Plan:
    """Return the plan of a swatch for a budget; arguments as for ``swatch``.

    Raises:
        StitchMeshError: an error of ``swatch``, or a quality beside an error.
    """
    chosen = SwatchOptions(**options)
    source = resolve_pattern(pattern)
    state = state_of_rest(chosen, woven=isinstance(source, Weave))
    scene = BudgetScene(
        kind="free cell" if chosen.has_free_size else "given cell",
        stitches=stitches_of(source) * chosen.columns * chosen.rows,
        name=source.name if (chosen.columns, chosen.rows) == (1, 1) else "",
        relaxations=RELAXATIONS[state],
    )  # fmt: skip
    return make_plan(budget, scene, quality, device)


def stitches_of(source: Source) -> int:
    """Return the number of stitches of a repeat, or the number of crossings of a weave."""
    if isinstance(source, Weave):
        return len(source.matrix) * len(source.matrix[0])
    return source.width * source.height
