# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The way of a free repeat to rest: from one sampling to the next, and to the lowest of its states."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Literal

from stitchmesh.io.history import HistoryEntry
from stitchmesh.periodic.relaxation.lowest_rest import lowest_rest
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch
from stitchmesh.periodic.sampling.even_sampling import sample_evenly
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.relaxation_result import Relaxation
from stitchmesh.yarnrelax.saddle import continued, relax_to_minimum


def relax_along(
    prepared: PreparedSwatch, yarns: YarnSet, progress: Callable[[HistoryEntry], None] | Literal[False] | None
) -> Relaxation:
    """Relax yarns through the samplings of their path; the iterations are those of all relaxations, one after another.

    The first sampling goes to the lowest state (``lowest_rest``), from which the others continue. The history is that
    of the way to the result. A limit of iterations that is that of a preset holds for each relaxation, any other one
    for all of them together.

    Raises:
        SolverError: the yarns cannot be relaxed, or a yarn passed through another one.
    """
    most, found = iterations_of(prepared.path), None
    for step in prepared.path:
        relax = partial(_relax, prepared, step, most, progress)
        if found is None:
            found = lowest_rest(prepared, yarns, relax)
        else:
            yarns = sample_evenly(found.yarns, prepared.smallest.part_of(prepared.drawn_with(step)))
            found = continued(relax(yarns, found.report["iterations"]), found)
    assert found is not None
    return found


def iterations_of(path: Sequence[Quality]) -> float:
    """Return the largest number of iterations of all relaxations together; infinite with the limit of a preset."""
    limit = path[-1].max_iterations
    return math.inf if limit in {preset.max_iterations for preset in PRESETS.values()} else limit


def _relax(
    prepared: PreparedSwatch, step: Quality, most: float,
    progress: Callable[[HistoryEntry], None] | Literal[False] | None, yarns: YarnSet, done: int,
) -> Relaxation:  # fmt: skip
    """Relax yarns with a sampling, after a number of iterations that count for the limit of all together."""
    relax = relax_yarns if prepared.cell is None else relax_to_minimum
    quality = replace(step, max_iterations=int(min(step.max_iterations, max(most - done, 0))))
    return relax(
        yarns, material=prepared.similar, quality=quality, device=prepared.device, cell=prepared.cell,
        terms=prepared.terms, progress=progress,
    )  # fmt: skip
