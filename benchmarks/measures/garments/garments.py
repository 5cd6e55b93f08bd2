# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whole garments: time and peak memory of each stage, the convergence of the yarns, and what estimates say of them.

``stages`` prints a table for each garment. ``estimates`` prints a line for each: the truth and, in brackets, the
estimate divided by the truth; each garment is made in a process of its own. Peak memory is the largest resident memory
of the process in a stage, with the results of earlier stages; Linux can reset this value between stages.
"""

from __future__ import annotations

import platform
import tempfile
from pathlib import Path

from benchmarks.own_process import results_of
from benchmarks.scenes.garments import Garment
from benchmarks.table import Rows
from stitchmesh.labeling import label
from stitchmesh.pipeline.knit import knit_and_write
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.recipe.estimate import estimate_garment
from stitchmesh.run import Run

STAGES = ("label", "tessellate", "meshrelax", "yarngen", "yarnrelax")
ESTIMATED = (
    "swatch.obj:0.8", "tea_cozy.obj:0.8", "hat.obj:0.8", "hat.obj:0.5", "glove.obj:0.4", "sock.obj:0.5",
    "sweater.obj:1.6", "dress.obj:1.2", "poncho.obj:0.8",
)  # fmt: skip


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


def knitted(garment: Garment, quality: str, device: str) -> tuple[dict[str, dict[str, float]], StageMemory]:
    """Knit a garment, and return the report of its stages and their memory."""
    memory = StageMemory()
    options = KnitOptions(stitch_width=garment.width, quality=quality, device=device)
    with tempfile.TemporaryDirectory() as folder:
        report = knit_and_write(garment.mesh(), folder, options, run=Run(memory)).report
    memory.close()
    return {stage: report[stage] for stage in STAGES}, memory


def stages(
    mesh: tuple[str, ...],
    /,
    *,
    unit: str = "cm",
    stitch_width: float = 0.8,
    quality: str = "draft",
    device: str = "cpu",
) -> Rows:
    """Measure the stages of garments."""
    yield f"Python {platform.python_version()}, {platform.machine()}"
    for path in mesh:
        report, memory = knitted(Garment(path, stitch_width, unit), quality, device)
        yield f"{Path(path).stem}: stitch width {stitch_width} cm, quality {quality}, {device}"
        yield "stage", "seconds", "peak MB", "what"
        for stage, row in report.items():
            said = ", ".join(f"{key} {_short(value)}" for key, value in row.items() if key not in ("seconds", "device"))
            yield stage, f"{row['seconds']:.2f}", f"{memory.peak[stage]:.0f}", said
        total = sum(row["seconds"] for row in report.values())
        yield "all", f"{total:.2f}", f"{max(memory.peak.values()):.0f}", ""


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def estimates(garment: tuple[str, ...] = ESTIMATED, /, *, quality: str = "draft", device: str = "cpu") -> Rows:
    """Compare garments with their estimates.

    Args:
        garment: MESH:WIDTH
    """
    names = "stitches, yarn m, control points, tessellate s, meshrelax s, yarngen s, yarnrelax s, all s, peak MB"
    yield "garment", *names.split(", "), "iterations"
    cases = [(Garment.of(word), quality, device) for word in garment]
    for _case, rows, why in results_of(estimated, cases):
        yield from rows or [why]


def estimated(case: tuple[Garment, str, str]) -> Rows:
    """Yield the row of a garment."""
    garment, quality, device = case
    guess = estimate_garment(label(garment.mesh()), stitch_width=garment.width, quality=quality, device=device)
    truth, memory = knitted(garment, quality, device)
    figures = [
        (truth["tessellate"]["faces"], guess.stitches),
        (truth["yarngen"]["length_cm"] / 100.0, guess.yarn_length / 100.0),
        (truth["yarngen"]["control_points"], guess.control_points),
    ]
    figures += [(truth[stage]["seconds"], guess.stages[stage].seconds) for stage in STAGES[1:]]
    figures += [(sum(row["seconds"] for row in truth.values()), guess.seconds)]
    figures += [(max(memory.peak.values()), guess.memory / 2**20)]
    cells = [f"{value:,.{0 if value > 100 else 2}f} ({other / value:.2f})" for value, other in figures]
    yield f"{garment.name} {garment.width:g}", *cells, truth["yarnrelax"]["iterations"]


ACTIONS = (stages, estimates)
