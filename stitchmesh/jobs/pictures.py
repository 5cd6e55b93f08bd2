# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The pictures of a job: the convergence, and the relaxed yarns. They are kept like the results of stages."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from stitchmesh.errors import DisplayError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import read_bytes
from stitchmesh.io.history import HistoryEntry
from stitchmesh.jobs.kept_stages import KeptStage, stage_key
from stitchmesh.jobs.sections import RenderTable
from stitchmesh.jobs.stage_files import PICTURE
from stitchmesh.jobs.stage_run import JobRun
from stitchmesh.mesh import StitchMesh
from stitchmesh.pipeline.garment import Made
from stitchmesh.render import render
from stitchmesh.render.plots.convergence_plot import plot_convergence
from stitchmesh.yarn import YarnSet

PLOT = "convergence.png"
"""Name of the plot of the convergence in the folder of the job."""
logger = logging.getLogger(__name__)


def draw_convergence(run: JobRun, history: Sequence[HistoryEntry], tolerance: float) -> None:
    """Draw residual and energies of the relaxation against its iterations."""
    entries = [dict(entry) for entry in history]
    _draw(
        run, "plot_convergence", PLOT, lambda path: plot_convergence(history, path, tolerance=tolerance),
        entries, tolerance,
    )  # fmt: skip


def draw_yarns(run: JobRun, fabric: StitchMesh | None, yarns: YarnSet) -> str | None:
    """Draw the pictures that the job asks for; return why there are none, or None if they are drawn."""
    try:
        for table in run.job.render:
            _draw_one(run, table, fabric, yarns)
    except DisplayError as error:
        logger.warning("no picture: %s", error)
        return str(error)
    return None


def _draw_one(run: JobRun, table: RenderTable, fabric: StitchMesh | None, yarns: YarnSet) -> None:
    tiles = None if yarns.lattice is None else table.tiles
    options, inputs = table.options() | {"fabric": fabric}, (fabric, yarns, asdict(table))
    _draw(run, "render", table.path, lambda path: render(yarns, path, tiles=tiles, **options), *inputs)


def _draw(run: JobRun, name: str, output: str, draw: Callable[[Path], None], *inputs: Any) -> None:
    """Draw a picture in the folder of its stage, unless it exists there, and write it into the folder of the job."""
    stage = KeptStage(name, stage_key(name, *inputs), bytes)

    def make() -> Made[bytes]:
        path = run.kept.folder_of(stage) / PICTURE
        draw(path)
        return Made(read_bytes(path), {})

    write_bytes(run.folder / output, run.keep(stage, make).value)
