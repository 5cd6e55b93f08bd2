# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far from rest free swatches are that say they are at rest.

    python benchmarks/true_rest.py --device cpu
    python benchmarks/true_rest.py --quality standard --loops 14 16.67 20 24 --patterns moss rib2x2

Each pattern is relaxed in a free cell with a preset. The result is then relaxed further with the same sampling in
float64, to a residual and a remaining change of ``TRUE``: this state is the true rest. The table shows the largest
relative error of the two spacings, and the change that the preset estimated. The last line counts the swatches at rest,
and of those the ones within what the preset promises.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace

import numpy as np

import stitchmesh as sm
from stitchmesh.errors import StitchMeshError
from stitchmesh.periodic.swatch import prepare_swatch
from stitchmesh.yarnrelax import Relaxation, relax_yarns

PROMISE = {"draft": 0.05, "standard": 0.01, "reference": 0.001}
"""Largest relative error of the spacings that each preset promises."""
TRUE = 1e-5
"""Residual, and estimate of the remaining change, of the true rest."""
RADIUS = 0.125
"""Yarn radius [cm]."""


def main() -> None:
    """Relax the patterns and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quality", nargs="+", default=["draft", "standard"], choices=PROMISE)
    parser.add_argument("--patterns", nargs="+", default=list(sm.pattern_names()))
    parser.add_argument("--loops", nargs="+", type=float, default=[16.67], help="loop lengths in yarn diameters")
    parser.add_argument("--most-points", type=int, default=1200, help="leave out larger repeats")
    parser.add_argument("--unsupported", action="store_true", help="without the planes of a swatch on a table")
    parser.add_argument("--device", default=None)
    given = parser.parse_args()
    for quality in given.quality:
        print(f"\n| {quality}: pattern | loop | seconds | iterations | at rest | error % | estimate % | true in s |")
        print("|---|---:|---:|---:|---|---:|---:|---:|")
        found = [
            measure(pattern, loop, quality, given) for pattern in given.patterns for loop in given.loops
        ]
        print_summary(quality, [row for row in found if row is not None])


def measure(
    pattern: str, loop: float, quality: str, given: argparse.Namespace
) -> tuple[bool, bool, float] | None:
    """Print one row; return whether the swatch and its true rest are at rest, and the error of the spacings."""
    options = {"yarn_radius": RADIUS, "loop_length": 2 * loop * RADIUS, "unsupported": given.unsupported}
    try:
        start = prepare_swatch(pattern, material=None, quality=quality, device=given.device, relax_cell=True, **options)
        if len(start.yarns.points) > given.most_points:
            return None
        shared = {"material": start.similar, "device": given.device, "cell": start.cell, "terms": start.terms}
        began = time.perf_counter()
        preset = relax_yarns(start.yarns, quality=start.quality, progress=False, **shared)
        seconds, began = time.perf_counter() - began, time.perf_counter()
        tight = replace(start.quality, precision="float64", tolerance=TRUE, largest_change=TRUE, max_iterations=200_000)
        true = relax_yarns(preset.yarns, quality=tight, progress=False, **shared)
    except StitchMeshError as error:
        print(f"| {pattern} | {loop:g} | {error} |")
        return None
    wrong = float(np.abs(sizes(preset) / sizes(true) - 1.0).max())
    left = preset.report["remaining_change"]
    estimate = "" if left is None else f"{100 * left['spacing']:.2g}"
    rest, truly = preset.report["converged"], true.report["converged"]
    print(
        f"| {pattern} | {loop:g} | {seconds:.2g} | {preset.report['iterations']} | {'yes' if rest else 'no'} "
        f"| {100 * wrong:.2g} | {estimate} | {time.perf_counter() - began:.2g}{'' if truly else ', not at rest'} |",
        flush=True,
    )
    return rest, truly, wrong


def sizes(relaxed: Relaxation) -> np.ndarray:
    """Width and height of the cell [cm]."""
    assert relaxed.yarns.lattice is not None
    return np.linalg.norm(relaxed.yarns.lattice.periods, axis=1)


def print_summary(quality: str, rows: list[tuple[bool, bool, float]]) -> None:
    """Print how many swatches keep the promise of a preset."""
    at_rest = [wrong for rest, truly, wrong in rows if rest and truly]
    kept = sum(wrong <= PROMISE[quality] for wrong in at_rest)
    worst = max(at_rest, default=0.0)
    rest = f"{sum(rest for rest, _, _ in rows)} of {len(rows)} at rest; true rest found for {len(at_rest)} of them"
    print(f"\n{quality}: {rest}: {kept} within {100 * PROMISE[quality]:g} %, worst {100 * worst:.2g} %")


if __name__ == "__main__":
    main()
