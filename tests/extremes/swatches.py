# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Swatches with extreme values of gamma, take-up, size and number of stitches.

Each relaxation must converge, stop with a warning, or raise an error with a message of one line. Memory is the largest
memory of the process so far. ``--large`` adds the repeat of 50 by 50 stitches.
"""

from __future__ import annotations

import logging
import resource
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import stitchmesh as sm
from benchmarks.table import Rows
from stitchmesh.patterns import parse_pattern
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarn.rest_length import RestLengths
from tests.extremes.outcome import AT_REST, FAILED, NOT_AT_REST, Outcome, ended, table

PATTERNS = ("stockinette", "rib1x1", "slip-stitch-honeycomb", "plain")
FREE = {"relax_cell": True, "relaxation": "frictionless"}
MEGABYTE = 2**20 if sys.platform == "darwin" else 2**10
"""Bytes in the unit of the operating system for the largest resident memory."""


@dataclass(frozen=True)
class Case:
    """A swatch with its extreme values."""

    name: str
    pattern: Any
    options: dict[str, Any] = field(default_factory=dict)
    shares: tuple[float, float] | None = None
    """Width and height relative to those of the free repeat."""


def cases(large: bool) -> list[Case]:
    """Return all cases."""
    found = []
    for pattern in PATTERNS:
        for gamma in (0.1, 0.2, 5.0, 10.0):
            found.append(Case(f"{pattern}, gamma {gamma:g}", pattern, {"gamma": gamma}))
        for factor in (0.1, 2.0):
            rest_lengths = {"rest_lengths": RestLengths(factor=factor)}
            found.append(Case(f"{pattern}, all yarn x {factor:g}, held", pattern, rest_lengths))
            found.append(Case(f"{pattern}, all yarn x {factor:g}, free", pattern, rest_lengths | FREE))
        for shares in ((0.5, 1.0), (1.0, 0.5), (0.5, 0.5), (2.0, 1.0), (1.0, 2.0), (2.0, 2.0)):
            found.append(Case(f"{pattern}, {shares[0]:g} x as wide, {shares[1]:g} x as high", pattern, {}, shares))
    for part in ("floats", "held"):
        for factor in (0.1, 2.0):
            options = {"rest_lengths": RestLengths(**{part: factor}), **FREE}
            found.append(Case(f"{part} of a honeycomb x {factor:g}", "slip-stitch-honeycomb", options))
    for part in ("warp", "weft"):
        for factor in (0.1, 2.0):
            options = {"rest_lengths": RestLengths(**{part: factor}), **FREE}
            found.append(Case(f"{part} of a plain weave x {factor:g}", "plain", options))
    found.append(Case("one loop", parse_pattern("chart leaf:\nK\n"), {**FREE}))
    found.append(Case("yarn of 10 um", "stockinette", {"yarn_radius": 5e-4, **FREE}))
    found.append(Case("yarn of 20 m", "stockinette", {"yarn_radius": 1e3, **FREE}))
    found.append(Case("10 x 10 stitches", "stockinette", {"columns": 10, "rows": 5}))
    if large:
        found.append(Case("50 x 50 stitches", "stockinette", {"columns": 50, "rows": 25}))
    return found


def made(case: Case, quality: Quality, device: str | None) -> Outcome:
    """Make the swatch of a case."""
    options = dict(case.options)
    if case.shares is not None:
        own = sm.swatch(case.pattern, quality=quality, device=device, **FREE).report
        options["period"] = (case.shares[0] * own["width"], case.shares[1] * own["height"])
    swatch = sm.swatch(case.pattern, quality=quality, device=device, **options)
    report = swatch.report
    numbers = [report[name] for name in ("energy", "max_strain", "min_distance_over_radius", "width", "height")]
    sound = np.isfinite(swatch.yarns.points).all() and np.isfinite(numbers).all() and numbers[2] > 0.0
    return Outcome(FAILED if not sound else AT_REST if report["converged"] else NOT_AT_REST, report=report)


def row_of(case: Case, found: Outcome) -> tuple[object, ...]:
    """Return the row of a case."""
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / MEGABYTE
    own = case.name, f"{found.seconds:.1f}", f"{memory:.0f}", found.kind
    if not found.report:
        return *own, found.words
    report = found.report
    near = f"{report['min_distance_over_radius']:.2f}"
    sizes = (f"{report[name]:.3g}" for name in ("width", "height"))
    return *own, report["iterations"], f"{report['max_strain']:.3g}", near, *sizes


def swatches(*, device: str | None = None, quality: str = "draft", only: str = "", large: bool = False) -> Rows:
    """Make extreme swatches.

    Args:
        device: cpu, cuda:0 ...; the first GPU, else the CPU
        only: cases whose name contains this
        large: the repeat of 50 by 50 stitches too
    """
    logging.getLogger("stitchmesh").setLevel(logging.ERROR)

    def found() -> Iterator[tuple[Outcome, tuple[object, ...]]]:
        for case in cases(large):
            if only in case.name:
                end = ended(lambda case=case: made(case, quality_named(quality), device))  # type: ignore[misc]
                yield end, row_of(case, end)

    titles = "extreme", "s", "MB", "outcome", "iter.", "strain", "near", "width", "height"
    return (yield from table(titles, found()))
