# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Swatches with extreme values of gamma, take-up, size and number of stitches.

    python benchmarks/swatch_extremes.py [--device cpu] [--quality draft] [--only WORDS] [--large]

Each relaxation must converge, stop with a warning, or raise an error with a message of one line. Every other result is
a failure, and the exit status is 1. Memory is the largest memory of the process so far. ``--large`` adds the repeat of
200 by 200 stitches.
"""

from __future__ import annotations

import argparse
import logging
import resource
import sys
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import stitchmesh as sm
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.patterns import parse_pattern
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarn.rest_length import RestLengths

PATTERNS = ("stockinette", "rib1x1", "slip-stitch-honeycomb", "plain")
FREE = {"relax_cell": True, "relaxation": "frictionless"}
FAILED = "FAILED"
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
    found.append(Case("50 x 50 stitches", "stockinette", {"columns": 50, "rows": 25}))
    if large:
        found.append(Case("200 x 200 stitches", "stockinette", {"columns": 200, "rows": 100}))
    return found


def line(case: Case, quality: Quality, device: str | None) -> tuple[bool, str]:
    """Return whether the result of a case is allowed, and its line of the table."""
    began = time.perf_counter()
    sound, words = True, ""
    try:
        options = dict(case.options)
        if case.shares is not None:
            own = sm.swatch(case.pattern, quality=quality, device=device, **FREE).report
            options["period"] = (case.shares[0] * own["width"], case.shares[1] * own["height"])
        made = sm.swatch(case.pattern, quality=quality, device=device, **options)
        sound, words = judged(made)
    except (ParameterError, SolverError) as error:
        sound, words = "\n" not in str(error), f"{'refused':<13}{'':>38}  {error}"
    except Exception as error:
        sound, words = False, f"{FAILED:<13}{'':>38}  {type(error).__name__}: {error}"
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / MEGABYTE
    return sound, f"{case.name:<48}{time.perf_counter() - began:>7.1f}{memory:>7.0f}  {words}"


def judged(made: sm.Swatch) -> tuple[bool, str]:
    """Return whether a swatch is valid, and its figures."""
    report = made.report
    numbers = [report[name] for name in ("energy", "max_strain", "min_distance_over_radius", "width", "height")]
    sound = bool(np.isfinite(made.yarns.points).all() and np.isfinite(numbers).all() and numbers[2] > 0.0)
    kind = FAILED if not sound else "at rest" if report["converged"] else "not at rest"
    figures = f"{report['iterations']:>6}{report['max_strain']:>9.3g}{numbers[2]:>7.2f}"
    return sound, f"{kind:<13}{figures}{report['width']:>8.3g}{report['height']:>8.3g}"


def main() -> int:
    """Run the cases, and return 1 if a case failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--device", help="cpu, cuda:0 ...; the first GPU, else the CPU")
    parser.add_argument("--quality", default="draft")
    parser.add_argument("--only", default="", help="cases whose name contains this")
    parser.add_argument("--large", action="store_true", help="the repeat of 200 by 200 stitches too")
    arguments = parser.parse_args()
    logging.getLogger("stitchmesh").setLevel(logging.ERROR)
    figures = f"{'iter.':>6}{'strain':>9}{'near':>7}{'width':>8}{'height':>8}"
    print(f"{'extreme':<48}{'s':>7}{'MB':>7}  {'outcome':<13}{figures}")
    failed = 0
    for case in cases(arguments.large):
        if arguments.only in case.name:
            sound, words = line(case, quality_named(arguments.quality), arguments.device)
            failed += not sound
            print(words, flush=True)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
