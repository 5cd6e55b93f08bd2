# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far the noise of a real yarn changes the size of free swatches, and how many shaken starts show it.

    python benchmarks/shaken_starts.py --device cuda:0 --together 1000
    python benchmarks/shaken_starts.py --patterns rib1x1 moss --loops 16.67 20 --relaxation frictionless --search 8

Each knit of the library relaxes from its prepared yarns and from ``--starts`` shaken starts, whose control points have
noise of ``NOISE`` radii, at each loop length. ``--together`` is how many cases are made in one call; all their starts
are relaxed together. The file has a line with the sizes of each case.

The spread of a case is the largest relative difference of its widths or heights. The first table says, for a number of
shaken starts as ``sm.swatch`` makes them, in how many cases the other starts differ from the size by at most the spread
that these starts show. The second table has the cases whose spread is more than the quality promises; repeats above
``SMALL_CELL`` stitches, which without friction come to rest from one start, are marked with a star.
"""

from __future__ import annotations

import argparse
import json
import logging
import time
from pathlib import Path
from typing import Any, get_args

import numpy as np
from true_rest import PROMISE

import stitchmesh as sm
from stitchmesh.compute.asking_together import answer_together
from stitchmesh.periodic.relaxation import lowest_rest
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch, prepare_swatch
from stitchmesh.periodic.swatch import relax_prepared, shaken_yarns
from stitchmesh.periodic.swatch_options import COMPACT_LOOP, YARN_RADIUS, KnitState
from stitchmesh.yarnrelax.together.relax_together import ways_together

SHOWN = (1, 2, 3, 4, 6)
"""Numbers of shaken starts of the first table."""


def main() -> None:
    """Run the cases, and print what noise changes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patterns", nargs="+", default=sm.pattern_names())
    parser.add_argument("--loops", nargs="+", type=float, default=[COMPACT_LOOP], help="loop lengths [yarn diameters]")
    parser.add_argument("--starts", type=int, default=8, help="shaken starts")
    parser.add_argument("--search", type=int, default=lowest_rest.STARTS, help="displaced starts of each search")
    parser.add_argument("--quality", default="draft")
    parser.add_argument("--relaxation", choices=get_args(KnitState), help="by default as knits come off the needles")
    parser.add_argument("--device")
    parser.add_argument("--together", type=int, default=1, help="cases in one call")
    parser.add_argument("--out", type=Path, default=Path("out/shaken.jsonl"))
    given = parser.parse_args()
    logging.getLogger("stitchmesh").setLevel(logging.ERROR)
    given.out.parent.mkdir(parents=True, exist_ok=True)
    lowest_rest.STARTS = given.search
    cases = [(pattern, loop) for pattern in given.patterns for loop in given.loops]
    found, began = list[dict[str, Any]](), time.perf_counter()
    with given.out.open("a") as out:
        for first in range(0, len(cases), given.together):
            for row in measured(cases[first : first + given.together], given):
                out.write(json.dumps(row) + "\n")
                found.append(row)
            out.flush()
    print(f"{time.perf_counter() - began:.0f} s")
    print_tables(found, PROMISE[given.quality])


def measured(cases: list[tuple[str, float]], given: argparse.Namespace) -> list[dict[str, Any]]:
    """The sizes of all starts of some cases; None for one that does not come to rest."""
    prepared = [preparation(pattern, loop, given) for pattern, loop in cases]
    computations = [
        relax_prepared.asking(each, each.yarns if number < 0 else shaken_yarns(each.yarns, number), False)
        for each in prepared for number in range(-1, given.starts)
    ]  # fmt: skip
    made = iter(answer_together(computations, ways_together()))
    rows = []
    for (pattern, loop), own in zip(cases, prepared, strict=True):
        swatches = [next(made) for _start in range(given.starts + 1)]
        sizes = [size_of(each.lattice) if isinstance(each, sm.Swatch) and each.report["converged"] else None
                 for each in swatches]  # fmt: skip
        rows.append({"pattern": pattern, "loop": loop, "small": own.has_states, "sizes": sizes})
    return rows


def preparation(pattern: str, loop: float, given: argparse.Namespace) -> PreparedSwatch:
    """A case that is ready to be relaxed."""
    return prepare_swatch(
        pattern, material=None, quality=given.quality, device=given.device, relax_cell=True,
        relaxation=given.relaxation, loop_length=2.0 * loop * YARN_RADIUS,
    )  # fmt: skip


def print_tables(cases: list[dict[str, Any]], promise: float) -> None:
    """Print how well shaken starts show what noise does, and the cases in which it does much."""
    rested = [case for case in cases if case["sizes"][0] is not None]
    starts = sum(len(case["sizes"]) for case in cases)
    resting = sum(size is not None for case in cases for size in case["sizes"])
    kept = sum(spread(case["sizes"]) <= promise for case in rested)
    print(f"{resting} of {starts} starts at rest; {kept} of {len(rested)} cases within {100 * promise:g} %")
    print("\n| shaken starts | cases | others within the spread | median spread % | 95th percentile % |")
    print("|---:|---:|---:|---:|---:|")
    for count in SHOWN:
        tried = [(case["sizes"][: count + 1], [size for size in case["sizes"][count + 1 :] if size is not None])
                 for case in rested]  # fmt: skip
        within = [apart(shown[0], size) <= spread(shown) for shown, others in tried for size in others]
        if within:
            spreads = 100.0 * np.array([spread(shown) for shown, _others in tried])
            print(f"| {count} | {len(tried)} | {100 * np.mean(within):.1f} % | {np.median(spreads):.2g} | "
                  f"{np.percentile(spreads, 95):.2g} |")  # fmt: skip
    print("\n| pattern | loop | spread % |\n|---|---:|---:|")
    for case in sorted(rested, key=lambda case: -spread(case["sizes"])):
        if spread(case["sizes"]) > promise:
            star = "" if case["small"] else "*"
            print(f"| {case['pattern']}{star} | {case['loop']:g} | {100 * spread(case['sizes']):.1f} |")


def spread(sizes: list[tuple[float, float] | None]) -> float:
    """Largest relative difference of a width or a height among starts at rest."""
    rested = np.array([size for size in sizes if size is not None])
    return float((np.ptp(rested, axis=0) / rested.mean(axis=0)).max())


def apart(size: tuple[float, float], other: tuple[float, float]) -> float:
    """Largest relative difference of two sizes."""
    return float(np.abs(np.array(other) / np.array(size) - 1.0).max())


if __name__ == "__main__":
    main()
