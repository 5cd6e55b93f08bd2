# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Memory that jobs estimate before they start, compared with the largest resident memory of their process.

Each job runs in a process of its own, as ``stitchmesh run`` does. The estimate is that of its ``report.json``. On a GPU
it is compared with the largest use of Warp's pool of memory.
"""

from __future__ import annotations

import json
import resource
import tempfile
from pathlib import Path

import warp as wp

from benchmarks.own_process import results_of
from benchmarks.places import MESHES
from benchmarks.table import Rows
from stitchmesh.compute.device import device_named
from stitchmesh.jobs.job_file import job_of_table
from stitchmesh.jobs.run_job import run_job


def garment(mesh: str, width: float, quality: str, iterations: int = 20_000, **more: object) -> dict[str, object]:
    """Return the table of a job that makes a garment."""
    relax = {"max_iterations": iterations}
    return {"mesh": str(MESHES / mesh), "quality": quality, "tessellate": {"stitch_width": width}, "relax_yarns": relax,
            "render": [], **more}  # fmt: skip


def repeats(pattern: str, count: int, quality: str, iterations: int) -> dict[str, object]:
    """Return the table of a job that relaxes several repeats of a pattern together."""
    swatch = {"pattern": pattern, "columns": count, "rows": count, "max_iterations": iterations}
    return {"quality": quality, "swatch": swatch, "render": []}


SCENES = {
    "hat 0.5": garment("hat.obj", 0.5, "draft"),
    "sweater 1.6, picture": garment("sweater.obj", 1.6, "draft", 100, render=[{}]),
    "sock 0.5, standard": garment("sock.obj", 0.5, "standard", 100),
    "hat 0.8, reference": garment("hat.obj", 0.8, "reference", 40),
    "rib2x2 16 x 16, standard": repeats("rib2x2", 16, "standard", 100),
}
"""Jobs by name: garments at each quality, one with a picture, and many repeats of a pattern. The first one comes to
rest; the others are limited to a few iterations."""


def measured(case: tuple[str, str]) -> Rows:
    """Run a job, and yield its row: the largest memory of the process, or of the pool of a GPU, beside the estimate."""
    name, device_name = case
    job = job_of_table(dict(SCENES[name]) | {"device": device_name}, str(MESHES / "job.toml"))
    with tempfile.TemporaryDirectory() as folder:
        run_job(job, folder)
        report = json.loads((Path(folder) / "report.json").read_text())
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0
    device = device_named(job.device)
    if device.is_cuda:
        peak = float(wp.get_mempool_used_mem_high(device))
    truth, guess = peak / 1e9, report["memory"]["estimate_gb"]
    points = report.get("yarngen", report).get("control_points", "")
    yield name, points, f"{guess:.3f}", f"{truth:.3f}", f"{guess / truth:.2f}"


def job_memory(job: tuple[str, ...] = tuple(SCENES), /, *, device: str = "cpu") -> Rows:
    """Measure the jobs named on the command line.

    Args:
        device: Warp's name of the device that relaxes the yarns
    """
    yield "job", "control points", "estimate GB", "largest GB", "estimate / largest"
    for _case, rows, why in results_of(measured, [(name, device) for name in job]):
        yield from rows or [why]
