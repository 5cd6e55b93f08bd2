# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The linking certificate: time and number of crossings of a garment, of many copies of it, and of many open yarns.

Each run is repeated, because the first run compiles the kernels. The shortest time is printed, with the times of the
parts: making polylines, finding crossings, and the remainder, which closes open yarns and adds signs.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from tyro.conf import Positional

import stitchmesh as sm
from benchmarks.table import Rows
from stitchmesh.compute.device import device_named
from stitchmesh.linking.certificate import doubled_linking
from stitchmesh.linking.crossings import edge_crossings
from stitchmesh.linking.projection import project_yarns


def copies(yarns: sm.YarnSet, count: int) -> sm.YarnSet:
    """``count`` copies of the yarns, side by side in rows."""
    size = 1.05 * np.ptp(yarns.points, axis=0)
    across = int(np.ceil(np.sqrt(count)))
    places = [size * [k % across, k // across, 0] for k in range(count)]
    starts = [yarns.start[1:] + k * len(yarns.points) for k in range(count)]
    names = (
        "closed", "radius", "rest_length", "row", "face", "colour", "natural_curvature", "drawn_radius",
        "mass_per_length",
    )  # fmt: skip
    tiled = {name: np.tile(getattr(yarns, name), count) for name in names}
    return replace(
        yarns,
        points=np.concatenate([yarns.points + place for place in places]),
        start=np.concatenate([[0], *starts]),
        part=np.tile(yarns.part, count),
        **tiled,
    )


def open_rows(rows: int, stitches: int, points_per_stitch: int = 12) -> sm.YarnSet:
    """Open rows of plain knit, one above the other (Crane 2023)."""
    t = np.arange(stitches * points_per_stitch) / points_per_stitch * 2 * np.pi
    row = np.stack([t + 1.5 * np.sin(2 * t), 4 * np.cos(t), np.cos(2 * t)], axis=1)
    curves = [row + np.array([0.0, 4.5 * k, 0.0]) for k in range(rows)]
    return sm.YarnSet.from_curves(curves, closed=[False] * rows, radius=0.78)


def measure(name: str, yarns: sm.YarnSet, device: str, runs: int) -> Rows:
    """Yield the wall-clock time and the processor time of the shortest run, and the numbers of crossings and links."""
    best = (np.inf, np.inf, np.inf, np.inf)
    for _ in range(runs):
        clock, processor = time.perf_counter(), time.process_time()
        linking = doubled_linking(yarns, device=device)
        whole, used = time.perf_counter() - clock, time.process_time() - processor
        clock = time.perf_counter()
        projection = project_yarns([yarns], device_named(device))
        projected = time.perf_counter()
        crossings = len(edge_crossings(projection))
        best = min(best, (whole, used, projected - clock, time.perf_counter() - projected))
    whole, used, projecting, finding = best
    times = whole, used, projecting, finding, whole - projecting - finding
    sizes = len(yarns.points), yarns.yarn_count, projection.edge_yarn.shape[0], crossings, len(linking.doubled)
    yield name, *sizes, *(f"{time:.3f}" for time in times)


HEAD = (
    "scene", "points", "yarns", "edges", "crossings", "linked pairs", "s", "processor s", "projection s", "crossings s",
    "rest s",
)  # fmt: skip


@dataclass(frozen=True)
class Options:
    """What is measured."""

    garment: Positional[Path]
    """yarn file, for example glove.bcc"""
    device: str = "cpu"
    runs: int = 3


def linking(given: Options) -> Rows:
    """Measure three scenes."""
    garment = sm.read_yarns(given.garment)
    yield HEAD
    yield from measure(given.garment.name, garment, given.device, given.runs)
    yield from measure(f"21 times {given.garment.name}", copies(garment, 21), given.device, given.runs)
    yield from measure("10000 open rows", open_rows(10_000, stitches=10), given.device, given.runs)
