# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Measures how fast a device is: the times of a few iterations on two known scenes.

The time of a small scene is the time of the launches; the time of a large one is the time of the arithmetic and of the
memory. The scenes are cells of stockinette by a formula (Crane 2023: a loop is (t + 1.5 sin 2t, 4 cos t, cos 2t),
courses are 4.5 apart), so that no other stage takes part. By these times, a device without a table is compared with a
device that has one.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from stitchmesh.compute.device import device_named
from stitchmesh.compute.threads import thread_count
from stitchmesh.lattice import Lattice
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet, segment_lengths, segment_points
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.relax import relax_partly

FORMULA_RADIUS, STITCH_WIDTH, ROW_HEIGHT = 0.78, 2.0 * math.pi, 4.5
"""Radius, width and height of a stitch in units of the formula."""
RADIUS = 0.125
"""Yarn radius [cm]."""
POINTS = 12
"""Control points of a stitch."""
SMALL, LARGE = 2, {"cpu": 16, "cuda": 96}
"""Number of rows of each scene, and of stitches in each row."""
ITERATIONS = 100, 20
"""Iterations of the small and of the large scene."""
CPU_INFO = Path("/proc/cpuinfo")
"""On Linux: the names of the processors."""


def calibrate(
    device: str | None, processor: str | None = None, clock: Callable[[], float] = time.perf_counter
) -> tuple[float, float]:
    """Return the times of the small and of the large scene [s], with loaded kernels; this takes less than a second.

    Args:
        device: Warp's name of the device; None for the preferred device.
        processor: kind of device, ``cpu`` or ``cuda``, whose large scene is measured; the kind of ``device`` if None.
        clock: the clock.
    """
    sizes = SMALL, LARGE[processor or ("cuda" if device_named(device).is_cuda else "cpu")]
    return _time_of(sizes[0], ITERATIONS[0], device, clock), _time_of(sizes[1], ITERATIONS[1], device, clock)


def _time_of(size: int, iterations: int, device: str | None, clock: Callable[[], float]) -> float:
    yarns, material = stockinette_cell(size), YarnMaterial.named()
    quality = replace(PRESETS["draft"], tolerance=0.0)
    for count in (1, iterations):
        began = clock()
        relax_partly(yarns, material=material, quality=quality, iterations=count, device=device)
    return clock() - began


def stockinette_cell(size: int) -> YarnSet:
    """Return a periodic cell of ``size`` rows of ``size`` plain stitches."""
    scale, count = RADIUS / FORMULA_RADIUS, size * POINTS
    t = STITCH_WIDTH * np.arange(count) / POINTS
    row = np.stack([t + 1.5 * np.sin(2 * t), 4.0 * np.cos(t), np.cos(2 * t)], axis=1)
    points = scale * np.concatenate([row + np.array([0.0, ROW_HEIGHT * number, 0.0]) for number in range(size)])
    periods = scale * np.array([[size * STITCH_WIDTH, 0.0, 0.0], [0.0, size * ROW_HEIGHT, 0.0]])
    start, closed = np.arange(size + 1) * count, np.ones(size, dtype=bool)
    yarns = YarnSet(
        points=points, start=start, closed=closed, radius=np.full(size, RADIUS),
        rest_length=segment_lengths(points, segment_points(start, closed)), row=np.arange(size).repeat(count),
        face=np.arange(size * count) // POINTS, part=np.zeros(size * count, dtype=np.int64), lattice=Lattice(periods),
        lattice_step=np.tile([1, 0], (size, 1)),
    )  # fmt: skip
    return replace(yarns, rest_length=yarns.lengths)


def device_title(device: str | None) -> str:
    """Return the name of a device for the tables; for a CPU with its number of threads."""
    found = device_named(device)
    if found.is_cuda:
        return str(found.name)
    threads = thread_count()
    return f"{_processor_name()}, {threads} thread{'s' if threads > 1 else ''}"


def _processor_name() -> str:
    try:
        lines = CPU_INFO.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else "CPU"
