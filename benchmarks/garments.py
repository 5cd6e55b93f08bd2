# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whole garments: time and peak memory of each stage, and the convergence of the yarns.

    python benchmarks/garments.py assets/meshes/hat.obj --stitch-width 0.8
    python benchmarks/garments.py skirt.obj --unit dm --stitch-width 0.8 --quality draft --device cpu

Peak memory is the largest resident memory of the process in a stage; Linux can reset this value between stages. The
value contains the memory that results of earlier stages occupy.
"""

from __future__ import annotations

import argparse
import platform
import tempfile
from pathlib import Path

from stitchmesh.io import read_mesh
from stitchmesh.pipeline.knit import knit_and_write
from stitchmesh.pipeline.options import KnitOptions

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


def measure(path: str, unit: str, options: KnitOptions) -> None:
    """Knit one garment and print its table."""
    memory = StageMemory()
    with tempfile.TemporaryDirectory() as folder:
        made = knit_and_write(read_mesh(path, unit=unit), folder, options, progress=memory)
    memory.close()
    report = made.report
    print(f"\n{Path(path).stem}: stitch width {options.stitch_width} cm, quality {options.quality}, {report['device']}")
    print(f"{'stage':<12}{'seconds':>10}{'peak MB':>10}  what")
    for stage in STAGES:
        row = report[stage]
        said = ", ".join(f"{key} {_short(value)}" for key, value in row.items() if key not in ("seconds", "device"))
        print(f"{stage:<12}{row['seconds']:>10.2f}{memory.peak[stage]:>10.0f}  {said}")
    total = sum(report[stage]["seconds"] for stage in STAGES)
    print(f"{'all':<12}{total:>10.2f}{max(memory.peak.values()):>10.0f}")


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def main() -> None:
    """Measure the garments named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mesh", nargs="+")
    parser.add_argument("--unit", default="cm")
    parser.add_argument("--stitch-width", type=float, default=0.8)
    parser.add_argument("--quality", default="draft")
    parser.add_argument("--device", default="cpu")
    arguments = parser.parse_args()
    print(f"Python {platform.python_version()}, {platform.machine()}")
    options = KnitOptions(
        stitch_width=arguments.stitch_width, quality=arguments.quality, device=arguments.device
    )
    for path in arguments.mesh:
        measure(path, arguments.unit, options)


if __name__ == "__main__":
    main()
