# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The readers of what the program keeps for itself: jobs and their stages, runs of scenes, projects and settings."""

from __future__ import annotations

import json
import os
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from stitchmesh.errors import FileError, ParameterError, PatternError
from stitchmesh.io import write_mesh
from stitchmesh.io.atomic import write_json
from stitchmesh.io.checked import check_value, read_json
from stitchmesh.quality import Quality, quality_named
from tests.fuzz import mutations as damage
from tests.fuzz.geometry_readers import hdf5
from tests.fuzz.reader import ROOT, Reader, cube, files, joined, later, small_yarns, under_name, written
from tests.fuzz.structures import JSON, TOML

SWEEP = b"""[job]
quality = "draft"
[random]
samples = 3
seed = 1
swatch.pattern = ["seed", "rib1x1"]
swatch.gamma = { low = 0.9, high = 1.1, spread = "log" }
swatch.columns = { low = 1, high = 3, whole = true }
[[list]]
swatch.yarn_radius = 0.1
[[stretch]]
direction = "wale"
strains = [0.0, 0.2]
"""
"""A sweep of random samples."""
SCENE = "examples/mixed/pulled.toml"
REPORT = {"iterations": 1, "tolerance": 1e-3, "out_of_time": False}
"""Report of a relaxation."""
STAGE = "stages/relax_yarns-1/stage.json", "stages/budget-1/stage.json"
"""Records of two stages, whose other files lie beside them."""


def _jobs(folder: Path) -> list[bytes]:
    from stitchmesh.jobs.job_file import example_job

    return [example_job(source).encode() for source in ("hat.obj", "hat.toml", "rib2x2", "chart.png")]


def _status(folder: Path) -> list[bytes]:
    from stitchmesh.jobs.job_status import JobStatus, StageStatus

    stage = StageStatus(name="label", key="0123456789abcdef", kept=False, seconds=0.25)
    status = JobStatus(time="2026-01-01T00:00:00+00:00", state="running", stage="relax_yarns", done=0.5, seconds=2.5,
                       seconds_left=(1.5, 3.0), note="iteration 5", stages=(stage,), process=1, host="h")  # fmt: skip
    return written(write_json, asdict(status), suffix=".json")(folder)


def _read_status(folder: Path) -> object:
    from stitchmesh.cli.commands.jobs import status_lines
    from stitchmesh.jobs.job_status import read_status

    return status_lines(read_status(folder))


def _stages(folder: Path) -> tuple[Any, Any]:
    """Return the kept stages of a folder, and the stages of relaxed yarns and of a quality, which are complete."""
    from stitchmesh.jobs.kept_stages import KeptStage, KeptStages, StageRecord
    from stitchmesh.yarnrelax.relaxation_result import Relaxation

    kept, stages = KeptStages(folder), (KeptStage("relax_yarns", "1", Relaxation), KeptStage("budget", "1", Quality))
    if not kept.folder_of(stages[1]).is_dir():
        history = [{"iteration": 1, "seconds": 0.1, "residual": 0.5, "energies": {"stretch": 1.0}}]
        relaxed = Relaxation(small_yarns(), REPORT, history)
        kept.keep(stages[0], relaxed, StageRecord(seconds=1.0, report={"yarnrelax": relaxed.report}))
        kept.keep(stages[1], quality_named("draft"), StageRecord(seconds=0.5, report={"budget": {}}, within="8h"))
    return kept, stages


def _record(folder: Path) -> list[bytes]:
    _stages(folder)
    return [(folder / name).read_bytes() for name in STAGE]


def _read_stage(path: Path) -> object:
    """Read a stage whose record is damaged; it is computed again, or has the report that it had."""
    kept, stages = _stages(path.parent)
    for stage, name in zip(stages, STAGE, strict=True):
        (path.parent / name).write_bytes(path.read_bytes())
        record = kept.record(stage)
        if record is not None:
            if record.report not in ({"budget": {}}, {"yarnrelax": REPORT}):
                raise AssertionError("a damaged report was read")
            return kept.load(stage, record)
    raise FileError("the record is damaged")


def _plan(folder: Path) -> list[bytes]:
    return written(write_json, asdict(quality_named("draft")), suffix=".json")(folder)


def _run_checkpoint(folder: Path) -> list[bytes]:
    from stitchmesh.mixed.output.report import RunTotals
    from stitchmesh.mixed.run_checkpoint import RunCheckpoint, write_run

    arrays = {"vertices": np.arange(12.0).reshape(4, 3), "kind": np.arange(4, dtype=np.int32)}
    path = folder / "checkpoint.smc"
    write_run(path, {"scene": "1"}, RunCheckpoint(RunTotals(steps=3, seconds=0.5), 2, arrays))
    return [path.read_bytes()]


def _read_sweep(path: Path) -> object:
    """Read a sweep and its first job."""
    from stitchmesh.jobs.job_file import job_of_table
    from stitchmesh.jobs.sweep.sweep import read_sweep

    return job_of_table(read_sweep(path).table(0), str(path))


@cache
def _task() -> Any:
    from stitchmesh.jobs.job import Job
    from stitchmesh.jobs.sections import SwatchTable
    from stitchmesh.jobs.sweep.sweep import Kept
    from stitchmesh.jobs.sweep.task import SweepTask, SweptJob

    jobs = tuple(SweptJob(key, Job(swatch=SwatchTable(pattern="seed"))) for key in ("a", "b"))
    return SweepTask(jobs, Kept())


ROWS: dict[str, dict[str, Any]] = {
    "a": {"swatch.gamma": 1.0, "width": 0.5, "error_text": None}, "b": {"swatch.gamma": 1.2, "width": None},
}  # fmt: skip
"""Rows of a task."""


def _rows(folder: Path) -> list[bytes]:
    return written(write_json, ROWS, suffix=".json")(folder)


def _read_rows(path: Path) -> object:
    from stitchmesh.jobs.sweep.result_table import read_rows

    return under_name(f"tasks/{_task().key}.json", lambda folder: read_rows(folder, _task()))(path)


def _sweep_table(folder: Path) -> list[bytes]:
    from stitchmesh.jobs.sweep.result_table import TABLE, write_table

    write_table(folder, _task().jobs, ROWS)
    return [(folder / TABLE).read_bytes()]


def _read_sweep_table(folder: Path) -> object:
    """Do in this process what ``read_table`` does in a child, whose start takes longer than the reading."""
    from stitchmesh.jobs.sweep.parquet_columns import columns_of, packed_columns

    path = folder / "rows.parquet"
    return columns_of(packed_columns(str(path), path))


def _maps(folder: Path) -> list[bytes]:
    from stitchmesh.io.hdf5 import write_dataclass
    from stitchmesh.mixed.output.files import FORMAT, StateMaps

    places, whole = np.arange(12.0).reshape(4, 3), np.array([[0, 1, 2], [0, 2, 3]])
    maps = StateMaps(places, whole, np.ones(4), np.zeros(2, int), np.ones(2), places, np.array([0, 4]), np.arange(4),
                     np.ones(4))  # fmt: skip
    return written(write_dataclass, maps, suffix=".h5", format_name=FORMAT)(folder)


def _scene_history(folder: Path) -> list[bytes]:
    return [b'{"scene": "a.toml", "before": ["a.toml", "b.toml"], "after": ["c.toml"]}']


def _read_scene_history(folder: Path) -> object:
    from stitchmesh.app.pages.drape.drape_session import read_history

    if not (folder / "a.toml").exists():
        (folder / "a.toml").write_bytes(files(SCENE)(folder)[0])
    return read_history(folder, _scene())


@cache
def _scene() -> Any:
    from stitchmesh.mixed.scene.scene import read_scene

    return read_scene(ROOT / SCENE)


def _project(folder: Path) -> list[bytes]:
    """Write a project with a mesh, steps, edits, results and settings, and return its table."""
    from stitchmesh.app.pages.swatch.state import first_state, state_table
    from stitchmesh.app.project.division import Division
    from stitchmesh.app.project.project_folder import ProjectFolder
    from stitchmesh.app.project.source import Source
    from stitchmesh.app.project.state import ProjectState, Results
    from stitchmesh.editing.edit import Edit
    from stitchmesh.editing.undo_history import history_of_steps
    from stitchmesh.labeling.steps import LabelStep

    mesh = written(write_mesh, cube, suffix=".obj")(folder)[0]
    history = [{"iteration": 1, "seconds": 0.1, "residual": 0.5, "energies": {"stretch": 1.0}}]
    work: dict[str, Any] = {
        "source": Source("cube.obj", mesh), "label_steps": history_of_steps([LabelStep("flip_row", {"face": 1})]),
        "division": Division(stitch_width=0.5, counts={(0, 1): 4}, marked=((1, 3),)),
        "edits": history_of_steps([Edit("insert_row", {"face": 3})]),
        "results": Results(yarns=small_yarns(), yarn_settings={"radius": 0.1}, report={"a": 1}, history=history),
    }  # fmt: skip
    state = ProjectState(name="cube", kept=(ProjectState(name="cube", **work),), **work,
                         settings={"Swatch": state_table(first_state()), "View": {"show": "Mesh"}})  # fmt: skip
    ProjectFolder(folder).write(state)
    return [(folder / "project.json").read_bytes()]


def _read_project(folder: Path) -> object:
    from stitchmesh.app.project.project_folder import ProjectFolder

    if not (folder / "files").is_dir():
        table = (folder / "project.json").read_bytes()
        _project(folder)
        (folder / "project.json").write_bytes(table)
    return ProjectFolder(folder).read()


def _swatch_settings(folder: Path) -> list[bytes]:
    from stitchmesh.app.pages.swatch.state import first_state, state_table

    return [json.dumps(state_table(first_state())).encode()]


def _read_swatch_settings(path: Path) -> object:
    from stitchmesh.app.pages.swatch.state import read_state

    return read_state(check_value(read_json(path), dict[str, Any]))


def _read_recent(folder: Path) -> object:
    from stitchmesh.app.project.opening import recent_projects

    os.environ["XDG_STATE_HOME"] = str(folder)
    return recent_projects()


READ_VALUE = later("stitchmesh.jobs.stage_files.read_value")
READ_RUN = later("stitchmesh.mixed.run_checkpoint.read_run")

KEPT_READERS: dict[str, Reader] = {
    "job": Reader(".toml", later("stitchmesh.jobs.job_file.read_job"),
                  joined(_jobs, files("examples/jobs/sweater.toml")), TOML),
    "status": Reader(".json", under_name("status.json", _read_status), _status, JSON),
    "stage": Reader(".json", _read_stage, _record, JSON),
    "plan": Reader(".json", under_name("plan.json", lambda folder: READ_VALUE(folder, Quality, {})), _plan, JSON,
                   (FileError, ParameterError)),
    "run of a scene": Reader(".smc", lambda path: READ_RUN(path, {"scene": "1"}), _run_checkpoint,
                             (*damage.BINARY, *[damage.inside_checkpoint] * 20),
                             (FileError, ParameterError)),
    "sweep": Reader(".toml", _read_sweep, joined(files("examples/sweeps/tightness.toml"), lambda folder: [SWEEP]),
                    TOML, (FileError, ParameterError)),
    "rows of a task": Reader(".json", _read_rows, _rows, JSON),
    "table of a sweep": Reader(".parquet", under_name("rows.parquet", _read_sweep_table), _sweep_table, damage.BINARY,
                               has_own_process=True),
    "maps": hdf5(later("stitchmesh.mixed.output.files.read_maps"), _maps),
    "history of a scene": Reader(".json", under_name("order.json", _read_scene_history), _scene_history, JSON),
    "project": Reader(".json", under_name("project.json", _read_project), _project, JSON),
    "settings of swatches": Reader(".json", _read_swatch_settings, _swatch_settings, JSON,
                                   (FileError, ParameterError, PatternError)),
    "recent projects": Reader(".json", under_name("stitchmesh/projects.json", _read_recent), lambda folder: [
        b'[{"folder": "/tmp/a", "name": "a"}, {"folder": "/tmp/b", "name": "b"}]'], JSON, ()),
}  # fmt: skip
"""Readers by name."""
