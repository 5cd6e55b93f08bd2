# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time from a change of a project until it is on disk, for results of different sizes.

The time holds the delay in which further changes join the first one. A project is then opened again.
"""

from __future__ import annotations

import os
import platform
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.places import MESHES
from benchmarks.table import Rows
from stitchmesh.app.project.division import Division
from stitchmesh.app.project.project import Project
from stitchmesh.editing.edit import Edit
from stitchmesh.labeling.steps import LabelStep
from stitchmesh.yarn import YarnSet

SWEATER = MESHES / "sweater.obj"
STITCH_WIDTH = 0.8
"""Width of a stitch [cm], for about 20,000 stitches."""
REPEATS = 5


def yarns_of(count: int) -> YarnSet:
    """Return yarns with a number of control points."""
    points = np.random.default_rng(1).normal(size=(count // 1000, 1000, 3))
    return YarnSet.from_curves(list(points), closed=[False] * len(points), radius=0.1)


def seconds_to_disk(project: Project, change: Callable[[], object]) -> float:
    """Return the time from a change until it is on disk [s]; the median of some changes."""
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        change()
        while project.autosave.pending:
            time.sleep(0.002)
        times.append(time.perf_counter() - began)
    return statistics.median(times)


def app_autosave() -> Rows:
    """Yield the table."""
    yield f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores"
    yield "change", "on disk after [ms]"
    with tempfile.TemporaryDirectory() as folder:
        project = Project.create(Path(folder) / "sweater")
        project.import_mesh(SWEATER.name, SWEATER.read_bytes())
        project.apply_label_step(LabelStep("label_all"))
        project.divide(Division(stitch_width=STITCH_WIDTH))
        assert project.fabric is not None
        stitches = f"{project.fabric.face_count:,} stitches"
        faces = np.flatnonzero(project.fabric.row == 20)
        edit = Edit("change_stitch", {"faces": faces[:1], "stitch": "p"})
        yield f"an edit of {stitches}", f"{1e3 * seconds_to_disk(project, lambda: project.apply_edit(edit)):.0f}"
        fabric = project.fabric
        made = seconds_to_disk(project, lambda: project.set_evened(fabric))
        yield f"{stitches}, evened out", f"{1e3 * made:.0f}"
        for count in (100_000, 1_000_000):
            yarns = [yarns_of(count) for _ in range(REPEATS)]
            made = seconds_to_disk(project, lambda: project.set_yarns(yarns.pop(), {}))  # noqa: B023
            yield f"yarns of {count:,} control points", f"{1e3 * made:.0f}"
        project.close()
        began = time.perf_counter()
        Project.open(project.folder).close()
        yield f"The project opens again in {time.perf_counter() - began:.2f} s."
