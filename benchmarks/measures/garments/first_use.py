# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Times of the first commands on a machine: without compiled kernels, and after ``stitchmesh warm-up``.

Each command runs in a process of its own, without compiled kernels each time in an empty folder of its own. The first
relaxation of the application is measured as the application computes it: from the call on its project until the first
frame that it could draw, and until the end of the relaxation; the time that the process takes to import and to
generate the yarns is not in it. CUDA keeps results of its own in ``~/.nv/ComputeCache``; the processes do not use it.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.table import Rows

FIRST_RELAXATION = """
import sys, time
import stitchmesh as sm
import stitchmesh.app.application
from stitchmesh.pipeline.options import RelaxOptions
from stitchmesh.pipeline.yarn_relaxation import relax_with_options
from stitchmesh.run import Run
from stitchmesh.run_control import RunControl
fabric = sm.tessellate(sm.label(sm.read_mesh("hat")), stitch_width=1.2)
yarns = sm.generate_yarns(fabric, yarn_radius=0.15)
device = sys.argv[1] or None
frames, began = [], time.perf_counter()
control = RunControl(lambda _snapshot: frames.append(time.perf_counter() - began))
relax_with_options(yarns, RelaxOptions(), quality="draft", fabric=fabric, device=device, run=Run(control=control))
print(f"frame {frames[0]:.1f} end {time.perf_counter() - began:.1f}")
"""
"""Relaxes a hat; prints when the first frame came, and the end."""


def first_use(*, device: str = "", workers: int = 0) -> Rows:
    """Yield the table.

    Args:
        device: the device; the first GPU or else the CPU if it is empty.
        workers: number of processes of the warm-up; as many as it takes by itself if 0.
    """
    on_device = ["--device", device] if device else []
    hat = ["knit", "hat", "--stitch-width", "1.2", "--quality", "draft", "--no-picture", *on_device]
    rib = ["swatch", "rib2x2", "--relax-cell", "--no-picture", *on_device]
    commands = {
        "knit hat": ["-m", "stitchmesh", *hat, "-o", "hat"],
        "swatch rib2x2": ["-m", "stitchmesh", *rib, "-o", "rib"],
        "first relaxation of the application": ["-c", FIRST_RELAXATION, device],
    }
    yield "command", "kernels", "seconds", "kernels compiled"
    for name, words in commands.items():
        with tempfile.TemporaryDirectory() as cache:
            yield name, "none", *_run(words, Path(cache))
    with tempfile.TemporaryDirectory() as cache:
        warm_up = ["-m", "stitchmesh", "warm-up", *on_device, *(["--workers", str(workers)] if workers else [])]
        yield "warm-up", "none", *_run(warm_up, Path(cache))
        yield "warm-up", "warm", *_run(warm_up, Path(cache))
        for name, words in commands.items():
            yield name, "warm", *_run(words, Path(cache))


def _run(words: list[str], cache: Path) -> tuple[str, str]:
    """Run a command; return its time [s], and the number of kernels that it has compiled."""
    before = len(list(cache.glob("*/wp_*/*.meta")))
    environment = {**os.environ, "WARP_CACHE_PATH": str(cache), "CUDA_CACHE_DISABLE": "1"}
    environment["PYTHONPATH"] = str(Path(__file__).parents[3])
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        ran = subprocess.run(
            [sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True, check=True
        )  # fmt: skip
        seconds = f"{time.perf_counter() - began:.1f}"
    frame = re.search(r"frame ([\d.]+) end ([\d.]+)", ran.stdout)
    if frame is not None:
        seconds = f"{frame[1]} to the first frame, {frame[2]} to the end"
    return seconds, str(len(list(cache.glob("*/wp_*/*.meta"))) - before)
