# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Jobs and sweeps of meshes whose rows are found: kept stages, and the memory that they need."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.jobs import job_memory
from stitchmesh.jobs.job import Job
from stitchmesh.jobs.job_memory import found_memory
from stitchmesh.jobs.job_status import JobStopped, StopRequest
from stitchmesh.jobs.run_job import run_job
from stitchmesh.jobs.stage_files import GIVEN
from stitchmesh.jobs.sweep.row import inputs_of, measures_of
from stitchmesh.quality import PRESETS
from stitchmesh.recipe.estimate import control_points, loops_in_chains
from stitchmesh.recipe.recipe import Recipe
from stitchmesh.recipe.sections import RowsSection, SolverSection
from tests.gallery import tube
from tests.labeling.test_partial_labeling import triangulated

STAGES = ["auto_stitches", "relax_mesh", "generate_yarns", "relax_yarns", "plot_convergence"]


@pytest.fixture(scope="module")
def job(tmp_path_factory) -> Job:
    """Return a job of a narrowing tube of triangles, whose yarns do not come to rest."""
    path = tmp_path_factory.mktemp("mesh") / "cone.obj"
    sm.write_mesh(path, triangulated(tube(8, 3, radius=2.0, height=1.5, top_radius=1.2)))
    return Job(
        garment=Recipe(
            mesh=str(path), stitch_width=1.0, rows=RowsSection(auto=True), solver=SolverSection(max_iterations=5)
        ),
        quality="draft", device="cpu", render=(),
    )  # fmt: skip


def computed(made) -> list[str]:
    return [stage["name"] for stage in made.report["job"]["stages"] if not stage["kept"]]


def test_the_row_of_a_sweep_has_the_options_and_the_figures(job, done):
    report = json.loads((done / "report.json").read_text())
    measures = measures_of(report)
    assert measures["shape.irregular"] > 0 and measures["shape.rms_stretch"] > 0.0
    assert report["repair"] == [] and inputs_of(job)["rows.multiple"] == 1


def test_an_option_of_found_rows_computes_all_stages(job, copy):
    changed = replace(job, garment=replace(job.garment, rows=RowsSection(auto=True, multiple=2)))
    assert computed(run_job(changed, copy)) == STAGES
    before = json.loads((copy / "report.json").read_text())["shape"]
    again = run_job(changed, copy)
    assert computed(again) == [] and again.report["shape"] == before


def test_a_damaged_surface_is_found_again_with_the_same_bits(job, copy):
    path = next(copy.glob(f"stages/auto_stitches-*/{GIVEN}"))
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    assert computed(run_job(job, copy)) == ["auto_stitches"]
    assert path.read_bytes() == content


def test_the_memory_follows_from_the_stitches_that_were_found(job, done):
    """The control points are within a few percent of those that are generated, and each of them needs memory."""
    fabric, yarns, draft = sm.read_stitches(done / "stitches.h5"), sm.read_yarns(done / "yarns.h5"), PRESETS["draft"]
    bind_off = loops_in_chains(fabric, np.ones(fabric.side_count, dtype=int))
    shaped = int(abs(fabric.n_top - fabric.n_bottom).sum())
    points = control_points(fabric.face_count, bind_off, shaped, draft)
    assert points == pytest.approx(len(yarns.points), rel=0.1)  # as for an estimate of a modelled mesh
    needed = [found_memory(fabric, quality, "cpu", ()) for quality in (draft, PRESETS["reference"])]
    assert needed[0] < needed[1]


def test_a_job_that_does_not_fit_is_refused_before_the_relaxation(job, tmp_path, monkeypatch):
    monkeypatch.setattr(job_memory, "available_memory", lambda device: 1e6)
    with pytest.raises(sm.StitchMeshError, match="memory: the job needs about"):
        run_job(job, tmp_path)
    assert [path.name.split("-")[0] for path in (tmp_path / "stages").iterdir()] == ["auto_stitches"]


def test_a_job_stops_while_it_finds_rows(job, tmp_path):
    stop, ended = StopRequest(), []

    def ask(status) -> None:
        """Ask when the first rows are made."""
        ended[:] = status.stages
        if status.note == "rows":
            stop.ask()

    with pytest.raises(JobStopped):
        run_job(job, tmp_path / "job", stop=stop, listener=ask)
    assert ended == []
