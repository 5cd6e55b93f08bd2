# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether noise on the generated yarns changes the size of free swatches.

    python benchmarks/shaken_starts.py out/shaken.jsonl --patterns rib1x1 moss --loops 16.67 20
    python benchmarks/shaken_starts.py out/shaken.jsonl --processes 16 --seconds 400

Each knit of the library comes off the needles with ``draft``, at each loop length, from the prepared yarns and from
``--starts`` copies of them whose control points have noise of ``NOISE`` radii. The spread of a case is the largest
relative difference of its periods. Repeats above ``SMALL_CELL`` stitches, which come to rest from one start, are
marked with a star. A table of the cases whose spread is more than ``draft`` promises ends the output.
"""

from __future__ import annotations

import argparse
import json
import logging
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
from true_rest import PROMISE

import stitchmesh as sm
from stitchmesh.errors import StitchMeshError
from stitchmesh.periodic.relaxation import lowest_rest
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.lowest_rest import STARTS
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch, prepare_swatch
from stitchmesh.periodic.swatch import relax_prepared
from stitchmesh.periodic.swatch_options import KnitState

LOOPS = (14.0, 16.67, 20.0, 24.0)
"""Loop lengths in yarn diameters."""
RADIUS = 0.125
"""Yarn radius [cm]."""
NOISE = 0.01
"""Standard deviation of the displacements [radii]."""


def main() -> None:
    """Run the cases and print those that noise changes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path, help="file of lines to which results are added")
    parser.add_argument("--patterns", nargs="+", default=sm.pattern_names())
    parser.add_argument("--loops", nargs="+", type=float, default=LOOPS, help="loop lengths in yarn diameters")
    parser.add_argument("--starts", type=int, default=4, help="starts with noise")
    parser.add_argument("--search", type=int, default=STARTS, help="displaced starts of each search")
    parser.add_argument("--small", action="store_true", help="leave out repeats that come to rest from one start")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=1e9, help="seconds after which no further case begins")
    parser.add_argument("--quality", default="draft")
    parser.add_argument("--relaxation", choices=get_args(KnitState), help="by default as knits come off the needles")
    given = parser.parse_args()
    given.out.parent.mkdir(parents=True, exist_ok=True)
    until = time.time() + given.seconds
    cases = [(pattern, loop, given, until) for pattern in given.patterns for loop in given.loops]
    found = []
    with ProcessPoolExecutor(given.processes) as pool, given.out.open("a") as out:
        for done in as_completed(pool.submit(measure, *case) for case in cases):
            if done.result() is not None:
                out.write(json.dumps(done.result()) + "\n")
                out.flush()
                found.append(done.result())
    print_table(found)


def measure(pattern: str, loop: float, given: argparse.Namespace, until: float) -> dict[str, Any] | None:
    """Relax all starts of a case; return its sizes, energies and seconds, or None where it is left out."""
    if time.time() > until:
        return None
    logging.disable(logging.WARNING)
    lowest_rest.STARTS = given.search
    case: dict[str, Any] = {"pattern": pattern, "loop": loop}
    try:
        prepared = prepare_swatch(
            pattern, material=None, quality=given.quality, device="cpu", relax_cell=True, relaxation=given.relaxation,
            loop_length=2 * loop * RADIUS,
        )  # fmt: skip
        assert prepared.fabric is not None
        case |= {"stitches": prepared.fabric.face_count // prepared.smallest.copies, "small": prepared.has_states}
        if given.small and not prepared.has_states:
            return None
        return case | {"ways": [way(prepared, number) for number in range(given.starts + 1)]}
    except StitchMeshError as error:
        return case | {"error": str(error)}


def way(prepared: PreparedSwatch, number: int) -> dict[str, Any]:
    """Relax the prepared yarns, with noise unless the number is 0."""
    random, began = np.random.default_rng(number), time.perf_counter()
    noise = NOISE * RADIUS * random.normal(size=prepared.yarns.points.shape) if number else 0.0
    made = relax_prepared(prepared, replace(prepared.yarns, points=prepared.yarns.points + noise), False)
    return {
        "size": size_of(made.lattice), "energy": made.report["energy"], "converged": made.report["converged"],
        "shape": made.report["shape"], "seconds": time.perf_counter() - began,
    }  # fmt: skip


def print_table(cases: list[dict[str, Any]]) -> None:
    """Print how many cases keep their size, and those that do not."""
    whole = [case for case in cases if "ways" in case and all(each["converged"] for each in case["ways"])]
    for small in (True, False):
        group = [case for case in whole if case["small"] is small]
        kept = sum(spread(case) <= PROMISE["draft"] for case in group)
        print(f"{'small' if small else 'larger'} repeats: {kept} of {len(group)} within {100 * PROMISE['draft']:g} %")
    print(f"not at rest or refused: {len(cases) - len(whole)} of {len(cases)}")
    print(f"{sum(way['seconds'] for case in cases if 'ways' in case for way in case['ways']):.0f} s of one core")
    print("\n| pattern | loop | stitches | spread % | energies |\n|---|---:|---:|---:|---|")
    for case in sorted(whole, key=spread, reverse=True):
        if spread(case) > PROMISE["draft"]:
            energies = " ".join(f"{each['energy']:.1f}" for each in case["ways"])
            star = "" if case["small"] else "*"
            stitches, percent = f"{case['stitches']}{star}", f"{100 * spread(case):.1f}"
            print(f"| {case['pattern']} | {case['loop']:g} | {stitches} | {percent} | {energies} |")


def spread(case: dict[str, Any]) -> float:
    """Largest relative difference of a period among the starts of a case."""
    sizes = np.array([each["size"] for each in case["ways"]])
    return float((np.ptp(sizes, axis=0) / sizes.min(axis=0)).max())


if __name__ == "__main__":
    main()
