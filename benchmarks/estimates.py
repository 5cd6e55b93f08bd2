# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Estimates of what garments cost, compared with garments that are made.

    python benchmarks/estimates.py
    python benchmarks/estimates.py --quality standard --device cpu hat.obj:0.8 poncho.obj:1.6

Each garment is a mesh of ``assets/meshes``, or a path, and a stitch width [cm]. Each line holds the truth and, in
brackets, the estimate divided by the truth. Peak memory is the largest resident memory of a stage; each garment is made
in a process of its own.
"""

from __future__ import annotations

import argparse
import multiprocessing
import tempfile
from pathlib import Path

from benchmarks.garments import STAGES, StageMemory
from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.pipeline.knit import knit_and_write
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.recipe.estimate import estimate_garment

MESHES = Path(__file__).resolve().parents[1] / "assets" / "meshes"
GARMENTS = (
    "swatch.obj:0.8", "tea_cozy.obj:0.8", "hat.obj:0.8", "hat.obj:0.5", "glove.obj:0.4", "sock.obj:0.5",
    "sweater.obj:1.6", "dress.obj:1.2", "poncho.obj:0.8",
)  # fmt: skip


def measure(name: str, width: float, quality: str, device: str) -> None:
    """Make one garment, and print its line."""
    path = Path(name) if Path(name).exists() else MESHES / name
    mesh = read_mesh(path)
    estimate = estimate_garment(label(mesh), stitch_width=width, quality=quality, device=device)
    memory = StageMemory()
    with tempfile.TemporaryDirectory() as folder:
        options = KnitOptions(stitch_width=width, quality=quality, device=device)
        report = knit_and_write(mesh, folder, options, progress=memory).report
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
    print(f"| {path.stem} {width:g} | {' | '.join(cells)} | {iterations} |", flush=True)


def main() -> None:
    """Measure the garments named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("garment", nargs="*", default=GARMENTS, help="MESH:WIDTH")
    parser.add_argument("--quality", default="draft")
    parser.add_argument("--device", default="cpu")
    arguments = parser.parse_args()
    names = "stitches, yarn m, control points, tessellate s, meshrelax s, yarngen s, yarnrelax s, all s, peak MB"
    print(f"| garment | {names.replace(', ', ' | ')} | iterations |\n|{'---|' * 11}")
    for word in arguments.garment:
        name, _, width = word.rpartition(":")
        work = (name, float(width), arguments.quality, arguments.device)
        process = multiprocessing.get_context("spawn").Process(target=measure, args=work)
        process.start()
        process.join()


if __name__ == "__main__":
    main()
