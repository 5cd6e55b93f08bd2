# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far the noise of a real yarn changes the size of free swatches, and how many shaken starts show it.

Each knit of the library relaxes from its prepared yarns and from ``--starts`` shaken starts, whose control points have
noise of ``NOISE`` radii, at each loop length. ``--together`` is how many cases are made in one call; all their starts
are relaxed together. The file has a line with the sizes of each case.

The spread of a case is the largest relative difference of its widths or heights. The first table says, for a number of
shaken starts as ``sm.swatch`` makes them, in how many cases the other starts differ from the size by at most the spread
that these starts show. The second table has the cases whose spread is more than the quality promises; repeats above
``SMALL_CELL`` stitches, which without friction come to rest from one start, are marked with a star.
"""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import stitchmesh as sm
from benchmarks.json_lines import append
from benchmarks.measures.rest.true_rest import PROMISE
from benchmarks.table import Rows
from stitchmesh.compute.work_together import done_together
from stitchmesh.periodic.relaxation import lowest_rest
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch, prepare_swatch
from stitchmesh.periodic.swatch import relax_prepared, shaken_yarns
from stitchmesh.periodic.swatch_options import COMPACT_LOOP, YARN_RADIUS, KnitState
from stitchmesh.yarnrelax.together.relax_together import ways_together

SHOWN = (1, 2, 3, 4, 6)
"""Numbers of shaken starts of the first table."""


@dataclass(frozen=True)
class Options:
    """What is measured."""

    patterns: tuple[str, ...] = tuple(sm.pattern_names())
    loops: tuple[float, ...] = (COMPACT_LOOP,)
    """loop lengths [yarn diameters]"""
    starts: int = 8
    """shaken starts"""
    search: int = lowest_rest.STARTS
    """displaced starts of each search"""
    quality: str = "draft"
    relaxation: KnitState | None = None
    """by default as knits come off the needles"""
    device: str | None = None
    together: int = 1
    """cases in one call"""
    out: Path = Path("out/shaken.jsonl")


def shaken_starts(given: Options) -> Rows:
    """Run the cases, and print what noise changes."""
    logging.getLogger("stitchmesh").setLevel(logging.ERROR)
    lowest_rest.STARTS = given.search
    cases = [(pattern, loop) for pattern in given.patterns for loop in given.loops]
    found, began = list[dict[str, Any]](), time.perf_counter()
    for first in range(0, len(cases), given.together):
        rows = measured(cases[first : first + given.together], given)
        append(given.out, rows)
        found += rows
    yield f"{time.perf_counter() - began:.0f} s"
    yield from tables(found, PROMISE[given.quality])


def measured(cases: list[tuple[str, float]], given: Options) -> list[dict[str, Any]]:
    """The sizes of all starts of some cases; None for one that does not come to rest."""
    prepared = [preparation(pattern, loop, given) for pattern, loop in cases]
    computations = [
        partial(relax_prepared, each, each.yarns if number < 0 else shaken_yarns(each.yarns, number))
        for each in prepared for number in range(-1, given.starts)
    ]  # fmt: skip
    made = iter(done_together(computations, ways_together()))
    rows = []
    for (pattern, loop), own in zip(cases, prepared, strict=True):
        swatches = [next(made) for _start in range(given.starts + 1)]
        sizes = [size_of(each.lattice) if isinstance(each, sm.Swatch) and each.report["converged"] else None
                 for each in swatches]  # fmt: skip
        rows.append({"pattern": pattern, "loop": loop, "small": own.has_states, "sizes": sizes})
    return rows


def preparation(pattern: str, loop: float, given: Options) -> PreparedSwatch:
    """A case that is ready to be relaxed."""
    return prepare_swatch(
        pattern, material=None, quality=given.quality, device=given.device, relax_cell=True,
        relaxation=given.relaxation, loop_length=2.0 * loop * YARN_RADIUS,
    )  # fmt: skip


def tables(cases: list[dict[str, Any]], promise: float) -> Rows:
    """Yield how well shaken starts show what noise does, and the cases in which it does much."""
    rested = [case for case in cases if case["sizes"][0] is not None]
    starts = sum(len(case["sizes"]) for case in cases)
    resting = sum(size is not None for case in cases for size in case["sizes"])
    kept = sum(spread(case["sizes"]) <= promise for case in rested)
    yield f"{resting} of {starts} starts at rest; {kept} of {len(rested)} cases within {100 * promise:g} %"
    yield ""
    yield "shaken starts", "cases", "others within the spread", "median spread %", "95th percentile %"
    for count in SHOWN:
        tried = [(case["sizes"][: count + 1], [size for size in case["sizes"][count + 1 :] if size is not None])
                 for case in rested]  # fmt: skip
        within = [apart(shown[0], size) <= spread(shown) for shown, others in tried for size in others]
        if within:
            spreads = 100.0 * np.array([spread(shown) for shown, _others in tried])
            yield (
                count, len(tried), f"{100 * np.mean(within):.1f} %", f"{np.median(spreads):.2g}",
                f"{np.percentile(spreads, 95):.2g}",
            )  # fmt: skip
    yield ""
    yield "pattern", "loop", "spread %"
    for case in sorted(rested, key=lambda case: -spread(case["sizes"])):
        if spread(case["sizes"]) > promise:
            star = "" if case["small"] else "*"
            yield f"{case['pattern']}{star}", f"{case['loop']:g}", f"{100 * spread(case['sizes']):.1f}"


def spread(sizes: list[tuple[float, float] | None]) -> float:
    """Largest relative difference of a width or a height among starts at rest."""
    rested = np.array([size for size in sizes if size is not None])
    return float((np.ptp(rested, axis=0) / rested.mean(axis=0)).max())


def apart(size: tuple[float, float], other: tuple[float, float]) -> float:
    """Largest relative difference of two sizes."""
    return float(np.abs(np.array(other) / np.array(size) - 1.0).max())
