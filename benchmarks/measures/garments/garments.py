# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whole garments: time and peak memory of each stage, and the convergence of the yarns.

Peak memory is the largest resident memory of the process in a stage; Linux can reset this value between stages. The
value contains the memory that results of earlier stages occupy.
"""

from __future__ import annotations

import platform
import tempfile
from pathlib import Path

from benchmarks.table import Rows
from stitchmesh.io import read_mesh
from stitchmesh.pipeline.knit import knit_and_write
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.run import Run

STAGES = ("label", "tessellate", "meshrelax", "yarngen", "yarnrelax")


class StageMemory:
    """Peak memory of each stage [MB], read when the next stage starts."""

    def __init__(self) -> None:
        self.peak: dict[str, float] = {}
        self._stage = ""

    def __call__(self, stage: str, done: float, note: str) -> None:
        if stage != self._stage:
            self.close()
            self._stage = stage

    def close(self) -> None:
        """Read the peak memory of the stage that has ended, and reset it."""
        if self._stage:
            self.peak[self._stage] = _high_water_mark()
        Path("/proc/self/clear_refs").write_text("5")


def _high_water_mark() -> float:
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(float(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM"))


def measure(path: str, unit: str, options: KnitOptions) -> Rows:
    """Knit one garment and print its table."""
    memory = StageMemory()
    with tempfile.TemporaryDirectory() as folder:
        made = knit_and_write(read_mesh(path, unit=unit), folder, options, run=Run(memory))
    memory.close()
    report = made.report
    yield f"{Path(path).stem}: stitch width {options.stitch_width} cm, quality {options.quality}, {report['device']}"
    yield "stage", "seconds", "peak MB", "what"
    for stage in STAGES:
        row = report[stage]
        said = ", ".join(f"{key} {_short(value)}" for key, value in row.items() if key not in ("seconds", "device"))
        yield stage, f"{row['seconds']:.2f}", f"{memory.peak[stage]:.0f}", said
    total = sum(report[stage]["seconds"] for stage in STAGES)
    yield "all", f"{total:.2f}", f"{max(memory.peak.values()):.0f}", ""


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def garments(
    mesh: tuple[str, ...],
    /,
    *,
    unit: str = "cm",
    stitch_width: float = 0.8,
    quality: str = "draft",
    device: str = "cpu",
) -> Rows:
    """Measure the garments named on the command line."""
    yield f"Python {platform.python_version()}, {platform.machine()}"
    options = KnitOptions(stitch_width=stitch_width, quality=quality, device=device)
    for path in mesh:
        yield from measure(path, unit, options)
