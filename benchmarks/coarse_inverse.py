# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time of the inverse of a cell's coarse matrix, and of the same elimination in NumPy.

    python benchmarks/coarse_inverse.py [--device cpu] [--cells 1]

The cells are patches of stockinette. Each time is the shortest of five; the matrices of all cells are inverted at once.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial

import numpy as np
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import PRESETS
from stitchmesh.yarn.tiling import tile_yarns
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.coarse_inverse import Inverses

SIDES = (2, 6, 12)
"""Stitches along the sides of the patches."""
REPEATS = 5
"""Measurements, of which the shortest is printed."""


def shortest(action: Callable[[], object], device: wp.Device) -> float:
    """The shortest time of an action [s]."""
    taken = []
    for _ in range(REPEATS):
        wp.synchronize_device(device)
        began = time.perf_counter()
        action()
        wp.synchronize_device(device)
        taken.append(time.perf_counter() - began)
    return min(taken)


def eliminated(matrix: np.ndarray) -> np.ndarray:
    """The inverse of a symmetric positive definite matrix by elimination, element by element."""
    inverse, part = matrix.copy(), np.empty_like(matrix)
    for k in range(len(inverse)):
        column = inverse[:, k].copy()
        inverse[k] /= column[k]
        inverse[:, k] = 0.0
        inverse[k, k] = 1.0 / column[k]
        column[k] = 0.0
        np.multiply(column[:, None], inverse[k], out=part)
        inverse -= part
    return inverse


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--device")
    parser.add_argument("--cells", type=int, default=1)
    given = parser.parse_args()
    device, quality = device_named(given.device), PRESETS["draft"]
    one = draw_swatch(resolve_pattern("stockinette"), SwatchOptions(), quality)[1]
    print("| rows | cells | on the device ms | NumPy ms |\n|---:|---:|---:|---:|")
    for side in SIDES:
        cells = [(tile_yarns(one, side, side, periodic=True), YarnMaterial.named())] * given.cells
        simulation = YarnSimulation(cells, quality, device, cells=[RelaxCell()] * given.cells)
        newton, every = simulation.newton, np.ones(given.cells, dtype=bool)
        assert newton is not None and newton.coarse is not None
        simulation.newton_step(every, np.ones(given.cells))
        space = newton.coarse
        rows = 6 * (space.count // given.cells)
        random = np.random.default_rng(side).normal(size=(rows, rows))
        matrix = random @ random.T + rows * np.eye(rows)
        space.matrix.assign(np.tile(matrix.ravel(), given.cells))
        inverses = Inverses(simulation.model, space.groups, space.matrix)
        inverses.invert(every)
        own = shortest(partial(inverses.invert, every), device)
        host = given.cells * shortest(partial(eliminated, matrix), device)
        print(f"| {rows} | {given.cells} | {1e3 * own:.2f} | {1e3 * host:.2f} |", flush=True)


if __name__ == "__main__":
    main()
