# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The way of a free repeat to rest: from one sampling to the next, and to the lowest of its states.

The yarn of a free repeat is distributed evenly over its segments, as it lies at rest, although some stitches are drawn
far longer than they end: beside a double yarn over, decreases lose four tenths of their length. Their yarn then slides
at once, and may wedge itself between other yarns, where it stays. If a repeat ends with axes nearer than ``WEDGED``
radii, it therefore begins again from yarns that have settled at their generated size, each stitch with its own yarn.
"""

from __future__ import annotations

import logging
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from stitchmesh.errors import SolverError
from stitchmesh.periodic.relaxation.continuation import change_period, change_radius, change_rest_length, size_of
from stitchmesh.periodic.relaxation.lowest_rest import lowest_rest
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch
from stitchmesh.periodic.sampling.even_sampling import sample_evenly
from stitchmesh.quality import Quality
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.relax import relax_partly
from stitchmesh.yarnrelax.relaxation_result import Relaxation, continued

WEDGED = 1.0
"""Yarns are wedged if their axes are nearer than this multiple of their radius; axes of touching yarns are 2 apart, and
of pressed yarns 1.4."""

logger = logging.getLogger(__name__)


def relax_along(prepared: PreparedSwatch, yarns: YarnSet, run: Run[YarnSet]) -> Relaxation:
    """Relax yarns through the samplings of their path; the iterations of all relaxations are numbered through.

    The first sampling goes to the lowest state (``lowest_rest``), and the others continue from it. The history follows
    the way to the result. The limit of iterations of a preset holds for each relaxation alone; any other limit holds
    for all of them together.

    Raises:
        SolverError: the yarns cannot be relaxed, or a yarn passed through another one.
    """
    found: Relaxation | None = None
    for step in prepared.path:
        relax = partial(_relax, prepared, step, run)
        if found is None:
            found = lowest_rest(prepared, yarns, relax)
            wedged = prepared.cell is not None and found.report["min_distance_over_radius"] < WEDGED
            if wedged and yarns is prepared.yarns:
                try:
                    start = _settled(prepared)
                except SolverError:  # They cannot be settled at that size, so the first state of rest stays.
                    continue
                found = continued(relax(start, found.report["iterations"]), found)
        else:
            yarns = sample_evenly(found.yarns, prepared.smallest.part_of(prepared.drawn_with(step)))
            found = continued(relax(yarns, found.report["iterations"]), found)
    assert found is not None
    return found


def _settled(prepared: PreparedSwatch) -> YarnSet:
    """Return the generated yarns, settled at the size of the prepared ones and sampled like them.

    Raises:
        SolverError: the yarns cannot be separated.
    """
    given: dict[str, Any] = {"material": prepared.similar, "quality": prepared.path[0], "device": prepared.device}
    wanted = prepared.yarns
    yarns = prepared.smallest.part_of(prepared.repeat)
    assert wanted.lattice is not None
    lengths, own = (np.add.reduceat(each.rest_length, each.segment_start[:-1]) for each in (wanted, yarns))
    yarns = change_radius(yarns, float(wanted.radius[0] / yarns.radius[0]), **given)
    rest_length = yarns.rest_length * (lengths / own)[yarns.segment_yarn]
    yarns = change_rest_length(yarns, rest_length, **given)
    yarns = change_period(yarns, size_of(wanted.lattice), **given)
    # Number of iterations in which generated yarns settle
    yarns = relax_partly(yarns, iterations=1000, cell=None, terms=(), **given)
    return sample_evenly(yarns, wanted)


def _relax(
    prepared: PreparedSwatch, step: Quality, run: Run[YarnSet],
    yarns: YarnSet, done: int,
) -> Relaxation:  # fmt: skip
    """Relax yarns with a sampling, after a number of iterations that count for the limit of all together."""
    left = int(min(step.max_iterations, max(prepared.most_iterations - done, 0)))
    return relax_with_digits(
        yarns, replace(step, max_iterations=left), material=prepared.similar, device=prepared.device,
        cell=prepared.cell, terms=prepared.terms, run=run,
    )  # fmt: skip


def relax_with_digits(yarns: YarnSet, quality: Quality, **given: Any) -> Relaxation:
    """Relax yarns with ``relax_yarns``, and continue in float64 where rounding hides whether they are at rest.

    This happens in satins, whose long floats carry small forces, and in fabrics whose yarns are stretched.

    Raises:
        SolverError: the yarns cannot be relaxed, or a yarn passed through another one.
    """
    found = relax_yarns(yarns, quality=quality, **given)
    if quality.precision == "float64" or not found.report["hidden_by_rounding"]:
        return found
    logger.warning("rounding hides rest in float32; the yarns relax on in float64")
    left = max(quality.max_iterations - found.report["iterations"], 0)
    finer = replace(quality, precision="float64", max_iterations=left)
    further = relax_yarns(found.yarns, quality=finer, **given)
    return continued(further, found)
