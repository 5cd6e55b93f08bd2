# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far from true rest free swatches are that say they are at rest.

Each pattern of the library is relaxed in a free cell with each preset, at each loop length; weaves at their default
spacing. The result of the finest of these presets is then sampled with ``TRUE``, about a third more control points than
``reference`` has, and relaxed in float64 to a residual and a remaining change of 1e-4 by Newton's method: the true rest
of the fabric, with the error of the sampling. A second solver, L-BFGS alone, relaxes the same start to the same
residual; where both differ by more than ``AGREE``, the true rest is not known. The error of a preset is the largest
relative error of the two periods.

Each case, a pattern with a loop length, is a process of its own with one thread. A case that takes longer than the
limit is ended, and so are all after ``--seconds``; the small ones come first. Lines of several files can be merged.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from tyro.conf import Positional

import stitchmesh as sm
from benchmarks.json_lines import append, read
from benchmarks.own_process import results_of
from benchmarks.table import Rows, note
from stitchmesh.errors import StitchMeshError
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch, prepare_swatch
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.sampling.even_sampling import sample_evenly
from stitchmesh.periodic.sampling.sampling import close_contacts, refined
from stitchmesh.periodic.swatch import relax_prepared
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.periodic.weave.library import weave_names
from stitchmesh.quality import PRESETS
from stitchmesh.run import QUIET
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.relax import relax_partly

PROMISE = {"draft": 0.05, "standard": 0.01, "reference": 0.001}
"""Largest relative error of the spacings that each preset promises."""
TRUE = replace(
    refined(PRESETS["reference"]), control_points_per_stitch=64, contact_samples=5, quadrature_points=5,
    tolerance=1e-4, largest_change=1e-4, max_iterations=200_000, step_fraction=0.2,
)  # fmt: skip
"""Sampling and accuracy of the true rest."""
OTHER_ITERATIONS = 30_000
"""Iterations of the second solver."""
AGREE = 0.002
"""Largest relative difference of periods at which two solvers agree."""
LOOPS = (14.0, 16.67, 20.0, 24.0)
"""Loop lengths in yarn diameters."""
RADIUS = 0.125
"""Yarn radius [cm]."""


@dataclass(frozen=True)
class Options:
    """The cases, and how many of them run at a time."""

    out: Positional[Path]
    """file of lines to which results are added"""
    quality: tuple[Literal["draft", "standard", "reference"], ...] = ("draft", "standard")
    patterns: tuple[str, ...] = (*sm.pattern_names(), *weave_names())
    loops: tuple[float, ...] = LOOPS
    """loop lengths in yarn diameters"""
    most_points: int = 2500
    """leave out repeats with more points at draft"""
    processes: int = 1
    limit: float = 600.0
    """seconds for a case"""
    seconds: float = 1e9
    """seconds for all cases"""
    device: str | None = None


def run(given: Options) -> Rows:
    """Run each case in a process of its own, some at a time; add a line for each to the file."""
    waiting = list(cases(given))
    began = time.perf_counter()
    yield f"{len(waiting)} cases"
    ends = results_of(
        measure, waiting, processes=given.processes, limit=given.limit, seconds=given.seconds
    )
    for case, parts, why in ends:
        found = parts[-1] if parts else case
        append(given.out, [found if {"other", "failed"} & found.keys() else found | {"failed": why}])
    yield f"{time.perf_counter() - began:.0f} s"


def cases(given: Options) -> Iterator[dict[str, Any]]:
    """Return the cases in ascending order of their size."""
    sized = []
    for pattern in given.patterns:
        try:
            yarns = draw_swatch(resolve_pattern(pattern), SwatchOptions(), PRESETS["draft"])[1]
        except StitchMeshError as error:
            note(f"{pattern}: {error}")
            continue
        if len(yarns.points) <= given.most_points:
            sized.append((len(yarns.points), pattern))
    for _, pattern in sorted(sized):
        for loop in [None] if pattern in weave_names() else given.loops:
            yield {"pattern": pattern, "loop": loop, "quality": given.quality, "device": given.device}


def measure(case: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the results of a case after each part: its presets, its true rest, and that of a second solver."""
    logging.disable(logging.WARNING)
    options: dict[str, Any] = {"yarn_radius": RADIUS}
    if case["loop"] is not None:
        options["loop_length"] = 2 * case["loop"] * RADIUS
    found: dict[str, Any] = case | {"presets": {}}
    try:
        for quality in case["quality"]:
            began = time.perf_counter()
            start = prepare_swatch(
                case["pattern"], material=None, quality=quality, device=case["device"], relax_cell=True,
                relaxation="frictionless", **options
            )
            relaxed = relax_prepared(start, start.yarns)
            found["presets"][quality] = result_of(relaxed.yarns, relaxed.report, time.perf_counter() - began)
            yield found
        for name, solve in (("true", by_newton), ("other", by_lbfgs)):
            yield found
            found[name] = solve(start, relaxed.yarns, case["device"])
        yield found
    except StitchMeshError as error:
        yield found | {"failed": str(error)}


def by_newton(start: PreparedSwatch, yarns: YarnSet, device: str | None) -> dict[str, Any]:
    """Return the true rest near a relaxed swatch, as Newton's method finds it."""
    fine, shared = start_of_truth(start, yarns, device)
    began = time.perf_counter()
    relaxed = relax_yarns(fine, run=QUIET, **shared)
    return result_of(relaxed.yarns, relaxed.report, time.perf_counter() - began, start.smallest.copies)


def by_lbfgs(start: PreparedSwatch, yarns: YarnSet, device: str | None) -> dict[str, Any]:
    """Return the true rest near a relaxed swatch, as L-BFGS alone finds it."""
    fine, shared = start_of_truth(start, yarns, device)
    began = time.perf_counter()
    yarns = relax_partly(fine, iterations=OTHER_ITERATIONS, **shared)
    return result_of(yarns, {}, time.perf_counter() - began, start.smallest.copies)


def start_of_truth(start: PreparedSwatch, yarns: YarnSet, device: str | None) -> tuple[YarnSet, dict[str, Any]]:
    """Return the smallest cell of a relaxed swatch, sampled with ``TRUE``, and the arguments with which it relaxes."""
    fine = sample_evenly(start.smallest.part_of(yarns), start.smallest.part_of(start.drawn_with(TRUE)))
    return fine, {
        "material": start.similar, "device": device, "cell": start.cell, "terms": start.terms,
        "quality": close_contacts(TRUE, start.options),
    }  # fmt: skip


def result_of(yarns: YarnSet, report: dict[str, Any], seconds: float, copies: int = 1) -> dict[str, Any]:
    """Return the sizes of a relaxed repeat of ``copies`` smallest cells, and what its report says."""
    assert yarns.lattice is not None
    names = ("iterations", "converged", "remaining_change", "energy", "residual", "shape")
    width, height = size_of(yarns.lattice)
    found = {"size": [width, copies * height], "seconds": seconds, "points": copies * len(yarns.points)}
    found |= {name: report[name] for name in names if name in report}
    return found if copies == 1 or "energy" not in found else found | {"energy": copies * found["energy"]}


def error_of(found: dict[str, Any], true: dict[str, Any]) -> float:
    """Return the largest relative error of the periods."""
    return float(np.abs(np.array(found["size"]) / np.array(true["size"]) - 1.0).max())


def table(files: tuple[Path, ...], /) -> Rows:
    """Yield a table of each preset, and how many cases keep its promise."""
    found = read(*files)
    for quality in [name for name in PROMISE if any(name in case.get("presets", {}) for case in found)]:
        yield ""
        yield (
            f"{quality}: pattern", "loop", "points", "seconds", "iterations", "at rest", "error %", "estimate %",
            "true in s", "two solvers %",
        )  # fmt: skip
        for case in found:
            if quality in case.get("presets", {}):
                yield row_of(case, quality)
    yield from counts(found)
    failed = [case for case in found if "failed" in case]
    yield f"{len(failed)} of {len(found)} cases without an end:"
    for case in failed:
        yield f"- {case['pattern']}, {case['loop']}: {case['failed']}"


def row_of(case: dict[str, Any], quality: str) -> tuple[object, ...]:
    """Return the row of a case in the table of a preset."""
    own, true, other = case["presets"][quality], case.get("true"), case.get("other")
    left = own["remaining_change"]
    estimate = "" if left is None else f"{100 * left['spacing']:.2g}"
    loop = "" if case["loop"] is None else f"{case['loop']:g}"
    at_rest = "yes" if own["converged"] else "no"
    row = case["pattern"], loop, own["points"], f"{own['seconds']:.2g}", own["iterations"], at_rest
    if true is None:
        return *row, "", estimate, "", ""
    rest = "" if true["converged"] else ", not at rest"
    differ = "" if other is None else f"{100 * error_of(other, true):.2g}"
    return *row, f"{100 * error_of(own, true):.2g}", estimate, f"{true['seconds']:.2g}{rest}", differ


def counts(found: list[dict[str, Any]]) -> Rows:
    """Yield how many cases come to rest and keep the promise, for each preset and each loop length."""
    yield ""
    yield (
        "preset", "loop", "cases", "at rest", "true rest known", "of which two solvers agree", "promise kept",
        "off by more than twice", "worst %",
    )  # fmt: skip
    loops = sorted({case["loop"] for case in found if case["loop"] is not None})
    for quality in PROMISE:
        made = [case for case in found if quality in case.get("presets", {})]
        groups = [(f"{loop:g}", [case for case in made if case["loop"] == loop]) for loop in loops]
        groups += [("weaves", [case for case in made if case["loop"] is None]), ("all", made)]
        for name, cases in groups:
            if cases:
                yield quality, name, *counts_of(cases, quality)


def counts_of(cases: list[dict[str, Any]], quality: str) -> tuple[object, ...]:
    """Return the counts of a row of ``counts``."""
    at_rest = [case for case in cases if case["presets"][quality]["converged"]]
    known, promise = [case for case in at_rest if is_known(case)], PROMISE[quality]
    errors = np.array([error_of(case["presets"][quality], case["true"]) for case in known])
    agreed = sum(case.get("other") is not None for case in known)
    kept, far = (errors <= promise).sum(), (errors > 2.0 * promise).sum()
    return len(cases), len(at_rest), len(known), agreed, kept, far, f"{100 * errors.max(initial=0.0):.2g}"


def is_known(case: dict[str, Any]) -> bool:
    """Whether the true rest of a case was found, and the second solver, where it ended, agrees with it."""
    if "true" not in case or not case["true"]["converged"]:
        return False
    return case.get("other") is None or error_of(case["other"], case["true"]) <= AGREE


ACTIONS = (run, table)
