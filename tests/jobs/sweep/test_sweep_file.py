# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sweeps as files: how jobs are numbered, that random samples are repeatable, and what is refused."""

from __future__ import annotations

import pytest

from stitchmesh.errors import FileError
from stitchmesh.jobs.sweep.sweep import read_sweep
from stitchmesh.jobs.sweep.task import jobs_of, tasks_of

JOB = '[job.swatch]\npattern = "stockinette"\n'


def written(path, text):
    file = path / "study.toml"
    file.write_text(text)
    return file


def test_all_combinations_of_a_grid_and_the_last_option_changes_fastest(tmp_path):
    file = written(tmp_path, JOB + '[grid]\nquality = ["draft", "standard"]\nswatch.gamma = [0.9, 1.0, 1.1]\n')
    sweep = read_sweep(file)
    jobs = [one.job for one in jobs_of(sweep, "cpu")]
    assert [(job.quality, job.swatch.gamma) for job in jobs] == [
        (quality, gamma) for quality in ("draft", "standard") for gamma in (0.9, 1.0, 1.1)
    ]


def test_rows_of_a_list_change_several_options_together(tmp_path):
    rows = "[[list]]\nswatch.gamma = 0.9\nquality = 'draft'\n[[list]]\nswatch.yarn_radius = 0.1\n"
    first, second = (one.job for one in jobs_of(read_sweep(written(tmp_path, JOB + rows)), "cpu"))
    assert (first.swatch.gamma, first.quality, first.swatch.yarn_radius) == (0.9, "draft", 0.125)
    assert (second.swatch.gamma, second.quality, second.swatch.yarn_radius) == (1.0, None, 0.1)


def test_random_samples_follow_from_the_seed_and_lie_within_their_bounds(tmp_path):
    text = (
        JOB + "[random]\nsamples = 20\nseed = 3\nswatch.gamma = { low = 0.5, high = 2, spread = 'log' }\n"
        "swatch.columns = { low = 1, high = 4, whole = true }\nswatch.pattern = ['seed', 'rib1x1']\n"
    )
    jobs = [one.job.swatch for one in jobs_of(read_sweep(written(tmp_path, text)), "cpu")]
    again = [one.job.swatch for one in jobs_of(read_sweep(written(tmp_path, text)), "cpu")]
    other = [one.job.swatch for one in jobs_of(read_sweep(written(tmp_path, text.replace("= 3", "= 4"))), "cpu")]
    longer = [one.job.swatch for one in jobs_of(read_sweep(written(tmp_path, text.replace("= 20", "= 30"))), "cpu")]
    assert jobs == again == longer[:20] and jobs != other
    assert all(0.5 <= job.gamma <= 2.0 and job.columns in (1, 2, 3, 4) for job in jobs)
    assert {job.pattern for job in jobs} == {"seed", "rib1x1"}
    # Half of the logarithms lie below 1; with 20 samples, fewer than 3 or more than 17 come up once in 2,500 seeds.
    assert 3 <= sum(job.gamma < 1.0 for job in jobs) <= 17


def test_keys_follow_the_inputs_the_files_and_the_kind_of_device(tmp_path):
    chart = tmp_path / "own.knit"
    chart.write_text("row: knit\n")
    file = written(tmp_path, '[job.swatch]\npattern = "own.knit"\n')

    def key(device="cpu"):
        return jobs_of(read_sweep(file), device)[0].key

    first = key()
    assert key() == first != key("cuda:0") == key("cuda:1")
    chart.write_text("row: purl\n")
    assert key() != first
    chart.write_text("row: knit\n")
    assert key() == first
    file.write_text(file.read_text() + "columns = 2\n")
    assert key() != first


def test_small_swatches_share_tasks_and_equal_jobs_are_done_once(tmp_path):
    text = "swatches_per_task = 2\n" + JOB + "[grid]\nswatch.gamma = [1.0, 1.1, 1.0, 1.2, 1.3, 1.4]\n"
    sweep = read_sweep(written(tmp_path, text))
    jobs = jobs_of(sweep, "cpu")
    tasks = tasks_of(jobs, sweep)
    assert [len(task.jobs) for task in tasks] == [2, 2, 1]
    assert {one.key for task in tasks for one in task.jobs} == {one.key for one in jobs}
    timed = read_sweep(written(tmp_path, text.replace("[job.swatch]", "[job]\nwithin = '1h'\n[job.swatch]")))
    assert [len(task.jobs) for task in tasks_of(jobs_of(timed, "cpu"), timed)] == [1] * 5


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[jobs]\n", "has no key 'jobs'; did you mean 'job'?"),
        (JOB + "[grid]\nswatch.gamma = 1.0\n", "grid.swatch.gamma: got 1.0; expected a list of values"),
        (JOB + "[random]\nswatch.gamma = { low = 2, high = 1 }\n", "random.swatch.gamma: got low 2 and high 1"),
        (JOB + "[random]\nswatch.rows = { low = 0, high = 1e30, whole = true }\n", "in this order, at most 1e+15"),
        (JOB + "[random]\nswatch.gamma = { low = 0, high = 1, spread = 'log' }\n", "expected a positive number"),
        (JOB + "[random]\nswatch.rows = { low = 1.2, high = 1.8, whole = true }\n", "no whole number between"),
        (JOB + "[grid]\nswatch.gamma = [1]\n[[list]]\nswatch.gamma = 2\n", "is set by grid and by list; keep one"),
        (JOB + "swatches_per_task = 1\n", "has no key 'swatches_per_task'"),
        ("swatches_per_task = 0\n" + JOB, "swatches_per_task: got 0; expected at least 1"),
        (JOB + "[grid]\nswatch.gama = [1.0]\n", "job 0 (swatch.gama = 1.0): swatch has no key 'gama'; did you mean"),
    ],
)
def test_what_no_sweep_has_is_refused_in_one_line(tmp_path, text, message):
    with pytest.raises(FileError) as error:
        jobs_of(read_sweep(written(tmp_path, text)), "cpu")
    assert message in str(error.value) and "\n" not in str(error.value)


def test_files_of_jobs_are_in_the_project(tmp_path):
    (tmp_path / "own").mkdir()
    (tmp_path / "chart.knit").write_text("row: knit\n")
    file = written(tmp_path / "own", '[job.swatch]\npattern = "../chart.knit"\n')
    with pytest.raises(FileError, match="outside the project"):
        jobs_of(read_sweep(file), "cpu")
    assert len(jobs_of(read_sweep(file, allow_paths=[tmp_path]), "cpu")) == 1
