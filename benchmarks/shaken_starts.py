# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How much the size of a free swatch depends on noise on its start.

    python benchmarks/shaken_starts.py stockinette:16.67 rib1x1:20 --device cpu

Each pattern, with its loop length in yarn diameters, is relaxed at ``draft`` from its prepared yarns, and from these
with normal noise on all control points. The last column is the largest relative difference of width and height.
"""

from __future__ import annotations

import argparse
import logging
from dataclasses import replace

import numpy as np

from stitchmesh.periodic.swatch import prepare_swatch, relax_prepared

RADIUS = 0.125
"""Yarn radius [cm]."""
NOISE = 0.01
"""Standard deviation of the noise [radii]."""


def main() -> None:
    """Print a row for each pattern."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="+", help="PATTERN:LOOP")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--device", default=None)
    given = parser.parse_args()
    logging.disable(logging.WARNING)
    print("| pattern | loop | size [cm] | largest change % |\n|---|---:|---:|---:|")
    for case in given.cases:
        pattern, loop = case.split(":")
        found = np.array([size_from(pattern, float(loop), seed, given.device) for seed in range(given.seeds + 1)])
        change = 100 * np.abs(found / found[0] - 1.0).max()
        print(f"| {pattern} | {loop} | {found[0, 0]:.3f} x {found[0, 1]:.3f} | {change:.2g} |", flush=True)


def size_from(pattern: str, loop: float, seed: int, device: str | None) -> tuple[float, float]:
    """Return width and height of a swatch [cm]; seed 0 stands for no noise."""
    prepared = prepare_swatch(
        pattern, material=None, quality="draft", device=device, relax_cell=True, loop_length=2 * loop * RADIUS
    )
    yarns = prepared.yarns
    if seed:
        noise = np.random.default_rng(seed).normal(size=yarns.points.shape) * NOISE * RADIUS
        yarns = replace(yarns, points=yarns.points + noise)
    report = relax_prepared(prepared, yarns, False).report
    return report["width"], report["height"]


if __name__ == "__main__":
    main()
