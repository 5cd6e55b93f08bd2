# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Estimates of what garments cost, compared with garments that are made.

Each garment is a mesh of ``assets/meshes``, or a path, and a stitch width [cm]. Each line holds the truth and, in
brackets, the estimate divided by the truth. Peak memory is the largest resident memory of a stage; each garment is made
in a process of its own.
"""

from __future__ import annotations

import multiprocessing
import tempfile
from pathlib import Path

from benchmarks.measures.garments.garments import STAGES, StageMemory
from benchmarks.places import MESHES
from benchmarks.table import Rows
from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.pipeline.knit import knit_and_write
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.recipe.estimate import estimate_garment
from stitchmesh.run import Run

GARMENTS = (
    "swatch.obj:0.8", "tea_cozy.obj:0.8", "hat.obj:0.8", "hat.obj:0.5", "glove.obj:0.4", "sock.obj:0.5",
    "sweater.obj:1.6", "dress.obj:1.2", "poncho.obj:0.8",
)  # fmt: skip


def measured(name: str, width: float, quality: str, device: str) -> tuple[object, ...]:
    """Make one garment, and return its row."""
    path = Path(name) if Path(name).exists() else MESHES / name
    mesh = read_mesh(path)
    estimate = estimate_garment(label(mesh), stitch_width=width, quality=quality, device=device)
    memory = StageMemory()
    with tempfile.TemporaryDirectory() as folder:
        options = KnitOptions(stitch_width=width, quality=quality, device=device)
        report = knit_and_write(mesh, folder, options, run=Run(memory)).report
    memory.close()
    truth = {stage: report[stage] for stage in STAGES}
    figures = [
        (truth["tessellate"]["faces"], estimate.stitches),
        (truth["yarngen"]["length_cm"] / 100.0, estimate.yarn_length / 100.0),
        (truth["yarngen"]["control_points"], estimate.control_points),
    ]
    figures += [(truth[stage]["seconds"], estimate.stages[stage].seconds) for stage in STAGES[1:]]
    figures += [(sum(truth[stage]["seconds"] for stage in STAGES), estimate.seconds)]
    figures += [(max(memory.peak.values()), estimate.memory / 2**20)]
    cells = [f"{value:,.{0 if value > 100 else 2}f} ({guess / value:.2f})" for value, guess in figures]
    iterations = truth["yarnrelax"]["iterations"]
    return f"{path.stem} {width:g}", *cells, iterations


def estimates(garment: tuple[str, ...] = GARMENTS, /, *, quality: str = "draft", device: str = "cpu") -> Rows:
    """Measure the garments named on the command line.

    Args:
        garment: MESH:WIDTH
    """
    names = "stitches, yarn m, control points, tessellate s, meshrelax s, yarngen s, yarnrelax s, all s, peak MB"
    yield "garment", *names.split(", "), "iterations"
    for word in garment:
        name, _, width = word.rpartition(":")
        with multiprocessing.get_context("spawn").Pool(1) as process:  # Its memory is that of one garment.
            yield process.apply(measured, (name, float(width), quality, device))
