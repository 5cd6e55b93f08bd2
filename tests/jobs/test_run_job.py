# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs of jobs: finished stages are kept, a stopped run continues to the same bits, and folders are not shared."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.cli.main import main
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.folder_lock import FolderLock
from stitchmesh.io.own_files import RECORD, mark_folder
from stitchmesh.jobs.job import Job, recipe_of
from stitchmesh.jobs.job_memory import check_job_memory
from stitchmesh.jobs.job_status import JobLog, JobStopped, StopRequest, read_status
from stitchmesh.jobs.kept_stages import KeptStage, KeptStages, StageRecord
from stitchmesh.jobs.run_job import clean_job, end_reported, run_job
from stitchmesh.jobs.sections import SwatchTable
from stitchmesh.jobs.stage_run import JobRun
from stitchmesh.memory_need import relaxation_memory
from stitchmesh.periodic.swatch import Swatch
from stitchmesh.pipeline.garment import Made
from stitchmesh.pipeline.knit import knit_and_write
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.recipe.recipe import Recipe, recipe_options
from stitchmesh.recipe.recipe_file import write_recipe
from stitchmesh.recipe.sections import SolverSection
from tests.gallery import ROOT, tube
from tests.killing import leave_part

STAGES = ["label", "tessellate", "relax_mesh", "generate_yarns", "relax_yarns", "plot_convergence"]


@pytest.fixture(scope="module")
def job(tmp_path_factory):
    """Return a job of a small tube, without a picture."""
    path = tmp_path_factory.mktemp("mesh") / "tube.obj"
    sm.write_mesh(path, tube(8, 3, radius=2.0, height=1.2))
    return Job(
        garment=Recipe(mesh=str(path), stitch_width=0.8), quality="draft", device="cpu", render=(),
        checkpoint_every=20,
    )  # fmt: skip


SHORT = SolverSection(max_iterations=20)
"""A relaxation that need not come to rest."""


def with_garment(job, **settings):
    """Return a job with other settings of its garment."""
    return replace(job, garment=replace(job.garment, **settings))


def computed(made):
    return [stage["name"] for stage in made.report["job"]["stages"] if not stage["kept"]]


def stopped_at(job, folder, note):
    """Run a job until a report of the relaxation has a text."""
    stop = StopRequest()

    def listen(status):
        if status.stage == "relax_yarns" and note in status.note:
            stop.ask()

    with pytest.raises(JobStopped):
        run_job(job, folder, stop=stop, listener=listen)


def test_a_job_has_the_bits_of_knit(job, done, tmp_path):
    recipe = recipe_of(job)
    knit_and_write(recipe.read_mesh().mesh, tmp_path, recipe_options(recipe))
    assert (tmp_path / "yarns.h5").read_bytes() == (done / "yarns.h5").read_bytes()
    assert json.loads((done / "report.json").read_text())["yarnrelax"]["pull_throughs"] == 0


def test_a_second_run_computes_nothing_nor_does_the_recipe_of_the_job(job, copy, tmp_path):
    before = (copy / "yarns.h5").read_bytes()
    assert computed(run_job(job, copy)) == []
    assert (copy / "yarns.h5").read_bytes() == before
    assert read_status(copy).state == "finished"
    write_recipe(tmp_path / "garment.toml", recipe_of(job))
    assert computed(run_job(Job(recipe=str(tmp_path / "garment.toml"), render=()), copy)) == []


@pytest.mark.parametrize(
    "key, value, first",
    [
        ("checkpoint_every", 33, None),
        ("yarn_radius", 0.09, "generate_yarns"),
    ],
)
def test_a_changed_option_computes_its_stage_and_those_after_it(job, copy, key, value, first):
    changed = replace(job, **{key: value}) if key == "checkpoint_every" else with_garment(job, **{key: value})
    if first is not None:  # what follows need not come to rest
        changed = with_garment(changed, solver=SHORT)
    expected = [] if first is None else STAGES[STAGES.index(first) :]
    assert computed(run_job(changed, copy)) == expected
    assert computed(run_job(job, copy)) == []  # the results of the first options are still there


def test_a_damaged_result_or_report_is_computed_again(job, copy):
    path = next(copy.glob("stages/generate_yarns-*/yarns.h5"))
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    report = next(copy.glob("stages/label-*/stage.json"))
    record = json.loads(report.read_text())
    record["record"]["report"] |= {"one": 1}
    report.write_text(json.dumps(record))
    assert computed(run_job(job, copy)) == ["label", "generate_yarns"]
    assert sm.read_yarns(path).yarn_count == sm.read_yarns(copy / "yarns.h5").yarn_count


@pytest.mark.parametrize("content", [b"[" * 10_000, b"\xff", b"{}"])
def test_a_damaged_plan_is_chosen_again(tmp_path, content):
    kept, stage = KeptStages(tmp_path), KeptStage("budget", "1", Quality)
    record = StageRecord(seconds=0.1, report={})
    kept.keep(stage, PRESETS["draft"], record)
    made = kept.load(stage, record)
    assert made is not None and made.value == PRESETS["draft"]
    (kept.folder_of(stage) / "plan.json").write_bytes(content)
    assert kept.load(stage, record) is None


def test_a_stopped_job_continues_to_the_same_bits(job, done, tmp_path, monkeypatch):
    monkeypatch.setattr("stitchmesh.yarnrelax.observer.PROGRESS_SECONDS", 0.0)
    stopped_at(job, tmp_path, "iteration 60")
    assert read_status(tmp_path).state == "stopped"
    assert list(tmp_path.glob("stages/relax_yarns-*/checkpoint.smc"))
    with pytest.raises(ParameterError, match="give --resume to continue from its checkpoint"):
        run_job(job, tmp_path)
    made = run_job(job, tmp_path, resume=True)
    assert computed(made) == ["relax_yarns", "plot_convergence"]
    assert (tmp_path / "yarns.h5").read_bytes() == (done / "yarns.h5").read_bytes()
    assert not list(tmp_path.glob("stages/*/*.smc"))


def test_a_result_that_the_time_cut_short_is_one_of_that_time_only(job, tmp_path):
    stage, record = KeptStage("generate_yarns", "0", sm.YarnSet), StageRecord(seconds=1.0, report={}, within="1s")
    log = JobLog(tmp_path, FolderLock(tmp_path, "held"), lambda _: None)
    run = JobRun(replace(job, within="1s"), tmp_path, False, StopRequest(), log, KeptStages(tmp_path))
    run.kept.keep(stage, sm.YarnSet.from_curves([np.eye(4)[:, :3]], closed=[False], radius=0.1), record)
    assert run.finished(stage) is not None
    assert replace(run, job=replace(job, within="1h")).finished(stage) is None


def test_the_time_of_the_parts_before_counts(job, copy, monkeypatch):
    """A job that continues has the time of its budget less that of the earlier run."""
    monkeypatch.setattr("stitchmesh.yarnrelax.observer.PROGRESS_SECONDS", 0.0)
    limited = replace(job, within="10min", quality=None)
    other = with_garment(limited, solver=SolverSection(method="quasistatic"))
    stopped_at(other, copy, "iteration 40")
    checkpoint = next(copy.glob("stages/relax_yarns-*/checkpoint.smc"))
    found = {}

    def late(path):
        found["read"] = path
        return 601.0

    monkeypatch.setattr("stitchmesh.jobs.garment_stages.seconds_of", late)
    with pytest.raises(ParameterError, match=r"within: got 10 min, but 6\d\d"):
        run_job(other, copy, resume=True)
    assert found["read"] == checkpoint


@pytest.mark.parametrize("seconds, drawn", [(0.0, True), (19.0, False)])
def test_a_picture_is_drawn_if_the_renderer_can_start_within_the_time(tmp_path, monkeypatch, seconds, drawn):
    """Nothing else of a job takes time here; ``seconds`` of its 20 were spent before."""
    job = Job(swatch=SwatchTable(pattern="stockinette"), quality="draft", device="cpu", within="20s")
    now, yarns = 1e6, sm.YarnSet.from_curves([np.eye(4)[:, :3]], closed=[False], radius=0.1)
    swatch = Swatch(yarns, {}, None, [])
    monkeypatch.setattr("stitchmesh.jobs.run_job.time.perf_counter", lambda: now)
    monkeypatch.setattr("stitchmesh.jobs.run_job.relax_swatch", lambda run, table: Made(swatch, {}))
    monkeypatch.setattr("stitchmesh.jobs.run_job.limit_of", lambda budget: None)
    monkeypatch.setattr("stitchmesh.jobs.run_job.draw_convergence", lambda *given: None)
    monkeypatch.setattr("stitchmesh.jobs.run_job.draw_yarns", lambda *given: None)
    monkeypatch.setattr("stitchmesh.jobs.run_job._tolerance", lambda report: 1.0)
    report = run_job(job, tmp_path, began=now - seconds)
    assert report.drawn is drawn and ("no_picture" in report.report) is not drawn


def test_two_runs_in_one_folder_are_refused(job, copy):
    lock = FolderLock(copy, "held")
    try:
        with pytest.raises(FileError, match="another run works in this folder"):
            run_job(job, copy)
    finally:
        lock.release()


def test_a_job_that_ended_without_a_word_was_killed(tmp_path):
    lock = FolderLock(tmp_path, "held")
    JobLog(tmp_path, lock, lambda _: None).begin("label")
    assert read_status(tmp_path).state == "running"
    lock.release()
    assert read_status(tmp_path).state == "killed"
    (tmp_path / "status.json").write_bytes(b"[" * 10_000)
    with pytest.raises(FileError, match=r"is not the status of a job .*nested too deeply.*; run the job again"):
        read_status(tmp_path)


def test_what_killed_runs_leave_goes_at_the_next_run(job, copy):
    label, begun = next(copy.glob("stages/label-*")), copy / "stages/yarns-0123456789abcdef"
    mark_folder(begun)
    for folder in (copy, label, begun):
        leave_part(folder, "yarns.h5")
    (copy / ".mine").write_text("")
    run_job(job, copy)
    hidden = {path.name for path in copy.glob("**/.*")}
    assert hidden == {".lock", ".mine", RECORD} and not begun.exists()


def test_what_the_program_did_not_make_stays_in_the_folder_of_the_stages_and_is_said(job, copy, tmp_path, caplog):
    mine = [copy / "stages" / name for name in ("my_data", "yarns-0123456789abcdef")]
    for folder in mine:
        folder.mkdir()
        (folder / "a.txt").write_text("mine")
    (copy / "stages" / "yarns-fedcba9876543210").symlink_to(mine[0])
    mark_folder(mine[0])
    run_job(job, copy)
    clean_job(copy)
    assert all((folder / "a.txt").read_text() == "mine" for folder in mine)
    left = "left alone what StitchMesh did not make: my_data, yarns-0123456789abcdef, yarns-fedcba9876543210"
    assert [record.message.endswith(left) for record in caplog.records].count(True) == 2


def test_stages_that_are_a_link_are_refused(job, copy, tmp_path):
    (copy / "stages").rename(tmp_path / "victim")
    (copy / "stages").symlink_to(tmp_path / "victim")
    before = sorted(tmp_path.rglob("*"))
    for work in (lambda: run_job(job, copy), lambda: clean_job(copy)):
        with pytest.raises(FileError, match=r"stages: is a symbolic link; .* remove the link"):
            work()
    assert sorted(tmp_path.rglob("*")) == before


def test_a_job_replaces_neither_its_mesh_nor_a_file_of_the_users(job, tmp_path):
    shutil.copy(job.garment.mesh, tmp_path / "yarns.obj")
    own = replace(with_garment(job, mesh=str(tmp_path / "yarns.obj")), write_yarns=("yarns.obj",))
    for overwrite in (False, True):
        with pytest.raises(FileError, match=r"yarns\.obj: .*(was not written by StitchMesh|would replace it)"):
            run_job(own, tmp_path, overwrite=overwrite)
    assert (tmp_path / "yarns.obj").read_bytes() == Path(job.garment.mesh).read_bytes()


def test_clean_removes_the_stages_that_the_last_run_has_not_used(job, copy, capsys):
    used = {path.name for path in copy.glob("stages/*")}
    run_job(with_garment(job, solver=SHORT), copy)
    run_job(job, copy)
    other = {path.name for path in copy.glob("stages/*")} - used
    assert {name.partition("-")[0] for name in other} == {"relax_yarns", "plot_convergence"}
    size = sum(path.stat().st_size for name in other for path in (copy / "stages" / name).iterdir())
    assert main(["job", "clean", str(copy)]) == 0
    assert capsys.readouterr().out == f"Removed 2 stages ({size / 1e6:.1f} MB), kept the {len(used)} of the last run.\n"
    assert {path.name for path in copy.glob("stages/*")} == used
    assert computed(run_job(job, copy)) == []


def test_clean_refuses_a_folder_in_which_stages_may_be_needed(job, copy, tmp_path):
    before = sorted(copy.rglob("*"))
    lock = FolderLock(copy, "held")
    try:
        with pytest.raises(FileError, match="another run works in this folder"):
            clean_job(copy)
    finally:
        lock.release()
    lock = FolderLock(copy, "held")
    JobLog(copy, lock, lambda _: None).close("stopped")
    lock.release()
    with pytest.raises(FileError, match=r"the last run in it was stopped, .* run the job to its end first"):
        clean_job(copy)
    with pytest.raises(FileError, match=r"holds no status\.json"):
        clean_job(tmp_path)
    assert sorted(copy.rglob("*")) == before


def test_a_folder_that_is_removed_in_the_middle_is_one_line(job, copy):
    def remove(report):
        if report.stage == "generate_yarns":
            shutil.rmtree(copy, ignore_errors=True)

    other = with_garment(job, yarn_radius=0.09)
    with pytest.raises(FileError, match="was removed while it was in use, with files of it; begin again"):
        run_job(other, copy, listener=remove)
    assert not (copy / "status.json").exists(), "another run may be there by now"
    run_job(with_garment(job, solver=SHORT), copy)


def test_a_full_disk_is_one_line_and_keeps_what_is_whole(job, copy, monkeypatch):
    def full(path, yarns):
        raise FileError(f"{path}: cannot be written (No space left on device)")

    monkeypatch.setattr("stitchmesh.jobs.stage_files.write_yarns", full)
    before = (copy / "yarns.h5").read_bytes()
    with pytest.raises(FileError, match="No space left"):
        run_job(with_garment(job, yarn_radius=0.09), copy)
    status = read_status(copy)
    assert (status.state, status.stage) == ("failed", "generate_yarns") and "No space left" in status.note
    assert (copy / "yarns.h5").read_bytes() == before
    monkeypatch.undo()
    assert computed(run_job(job, copy)) == []


def test_a_swatch_is_a_job(tmp_path):
    job = Job(swatch=SwatchTable(pattern="stockinette", gamma=1.1), quality="draft", device="cpu", render=())
    made, same = run_job(job, tmp_path), sm.swatch("stockinette", gamma=1.1, quality="draft", device="cpu")
    np.testing.assert_array_equal(made.yarns.points, same.yarns.points)
    np.testing.assert_array_equal(sm.read_yarns(tmp_path / "yarns.h5").points, same.yarns.points)
    assert made.report["wale_spacing"] == same.report["wale_spacing"]
    assert computed(made) == ["swatch", "plot_convergence"] and computed(run_job(job, tmp_path)) == []


def test_what_does_not_fit_is_refused_with_the_quality_that_would():
    def memory_at(quality):
        return 1e8 * quality.control_points_per_stitch

    fits = check_job_memory(memory_at, PRESETS["standard"], "cpu", "wider stitches", available=2.1e9)
    assert fits == {"estimate_gb": 2.0, "available_gb": 2.1}
    with pytest.raises(ParameterError, match=r"needs about 2.4 GB, and cpu has 2.1 GB free; expected quality standard"):
        check_job_memory(memory_at, PRESETS["reference"], "cpu", "wider stitches", available=2.1e9)
    with pytest.raises(ParameterError, match="expected wider stitches"):
        check_job_memory(memory_at, PRESETS["draft"], "cpu", "wider stitches", available=1e9)


def test_a_job_that_does_not_fit_is_refused_before_the_stitches(job, tmp_path, monkeypatch):
    monkeypatch.setattr("stitchmesh.jobs.job_memory.available_memory", lambda device: 1e6)
    with pytest.raises(ParameterError, match="memory: the job needs about"):
        run_job(job, tmp_path)
    assert [stage.name for stage in read_status(tmp_path).stages] == ["label"]


def test_commands_report_lines_of_json_and_the_status(job, copy, tmp_path, capsys):
    path = tmp_path / "job.toml"
    path.write_text(
        f'mesh = "{job.garment.mesh}"\nstitch_width = 0.8\nquality = "draft"\ndevice = "cpu"\nrender = []\n'
    )
    assert main(["run", str(path), "-o", str(copy), "--allow-paths", str(Path(job.garment.mesh).parent)]) == 0
    output = capsys.readouterr()
    lines = [json.loads(line) for line in output.out.splitlines()]
    assert lines[-1]["state"] == "finished" and lines[-1]["stages"] == STAGES
    assert "Kept from earlier runs: label" in output.err
    assert main(["status", str(copy)]) == 0
    assert "finished after" in capsys.readouterr().out
    assert main(["status", str(tmp_path)]) == 2
    assert "holds no status.json" in capsys.readouterr().err


def test_sigterm_writes_a_checkpoint_and_ends_the_process(job, tmp_path):
    path = tmp_path / "job.toml"
    path.write_text(f'mesh = "{job.garment.mesh}"\nstitch_width = 0.8\nquality = "draft"\ndevice = "cpu"\n')
    words = [sys.executable, "-m", "stitchmesh", "run", str(path), "--allow-paths", str(Path(job.garment.mesh).parent)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT) as process:
        for line in process.stdout:
            if json.loads(line)["stage"] == "relax_yarns":
                process.send_signal(signal.SIGTERM)
                break
        rest, errors = process.communicate()
    assert process.returncode == 143, errors
    assert "--resume` continues the job" in errors
    assert json.loads(rest.splitlines()[-1])["state"] == "stopped"
    assert list((tmp_path / "job").glob("stages/relax_yarns-*/checkpoint.smc"))


def test_the_memory_on_a_gpu_is_that_of_the_measured_jobs():
    """The figures are those of ``benchmarks/run.py job-memory --device cuda:0``; 20 % is what the estimate promises."""
    for points, quality, measured in ((80_196, "draft", 0.174e9), (63_096, "reference", 0.866e9)):
        assert relaxation_memory(points, PRESETS[quality], on_gpu=True) == pytest.approx(measured, rel=0.2)


INTERRUPTED_IMPORT = ImportError("numpy failed to import")
INTERRUPTED_IMPORT.__cause__ = KeyboardInterrupt()


@pytest.mark.parametrize(
    ("error", "state"),
    [(KeyboardInterrupt(), "stopped"), (INTERRUPTED_IMPORT, "stopped"), (JobStopped(), "stopped"),
     (FileError("no space"), "failed"), (MemoryError(), "failed"), (SystemExit(1), "failed")],
)  # fmt: skip
def test_whatever_ends_a_job_its_status_says_so(tmp_path, error, state):
    log = JobLog(tmp_path, FolderLock(tmp_path, "busy"), lambda _: None)
    log.begin("label")
    with pytest.raises(type(error)), end_reported(log):
        raise error
    assert json.loads((tmp_path / "status.json").read_text())["state"] == state
