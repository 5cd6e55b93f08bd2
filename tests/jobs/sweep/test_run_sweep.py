# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sweeps with real schedulers and workers, which are killed: each job is done once, with the results of one process."""

from __future__ import annotations

import json
import os
import signal
import socket
import ssl
import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path

import dask
import numpy as np
import psutil
import pytest
from distributed import Security

import stitchmesh as sm
from stitchmesh.cli.main import main
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.jobs.job_status import JobStopped, StopRequest
from stitchmesh.jobs.sweep.axis import Axis, Choices
from stitchmesh.jobs.sweep.result_table import TASKS, read_table
from stitchmesh.jobs.sweep.row import WORKER
from stitchmesh.jobs.sweep.run_sweep import run_sweep
from stitchmesh.jobs.sweep.sweep import Kept, Sweep, read_sweep
from stitchmesh.jobs.sweep.workers import local_workers, offers_gpu
from tests.gallery import tube
from tests.jobs.sweep.cluster import Cluster, certificates, wait_until
from tests.jobs.sweep.quick_worker import FILLS, KILLS, SWALLOWS

QUICK = Path(__file__).with_name("quick_worker.py")
SWEEP = """
write_yarns = true
picture = false
swatches_per_task = 1
[job]
device = "cpu"
quality = "draft"
[[list]]
swatch = { pattern = "stockinette", max_iterations = 20 }
[[list]]
swatch = { pattern = "seed", gamma = 1.1, max_iterations = 20 }
[[list]]
mesh = "tube.obj"
tessellate.stitch_width = 0.8
relax_yarns.checkpoint_every = 5
render = []
"""
"""Two swatches, and a garment with many checkpoints."""


@pytest.fixture(scope="module")
def serial(tmp_path_factory):
    """Return the folder of a real sweep that was done in one process; the file of the sweep is beside it."""
    folder = tmp_path_factory.mktemp("real")
    sm.write_mesh(folder / "tube.obj", tube(8, 3, radius=2.0, height=1.2))
    (folder / "sweep.toml").write_text(SWEEP)
    run_sweep(read_sweep(folder / "sweep.toml", allow_paths=[folder]), folder / "serial", workers=0)
    return folder / "serial"


@pytest.fixture
def cluster(tmp_path):
    """Return a scheduler without workers."""
    made = Cluster(tmp_path)
    yield made
    made.close()


@pytest.fixture
def quick(tmp_path):
    """Return a scheduler with two quick workers."""
    made = Cluster(tmp_path, preload=QUICK, memory="500MB", deaths=0)
    made.start_worker()
    made.start_worker()
    yield made
    made.close()


@contextmanager
def started(sweep, folder, scheduler):
    """Run a sweep in another thread, and provide its result to come; the sweep is stopped if the block fails."""
    stop = StopRequest()
    with ThreadPoolExecutor() as pool:
        try:
            yield pool.submit(run_sweep, sweep, folder, scheduler=scheduler, stop=stop)
        finally:
            stop.ask()


def quick_sweep(gammas, *, together=1):
    """Return a sweep of jobs whose tightness says what a quick worker does (``quick_worker``)."""
    return Sweep(
        job={"device": "cpu", "swatch": {"pattern": "stockinette"}}, swatches_per_task=together,
        grid=(Axis(("swatch", "gamma"), Choices(tuple(gammas))),), kept=Kept(picture=None),
    )  # fmt: skip


def harmless(count):
    """Return values of the tightness with which a quick worker does nothing special."""
    return [2.0 + number / count for number in range(count)]


def begun(folder):
    """Return how often each task was begun."""
    return Counter((folder / "begun.txt").read_text().split())


def is_of_the_run(column):
    """Return whether a column says how the work went, and so differs from run to run: times, and who worked."""
    return column == WORKER or column.endswith("seconds")


def assert_same_results(first, second):
    """Compare all that does not tell how the work went: rows, and yarns to the bit."""
    one, two = read_table(first), read_table(second)
    assert one.keys() == two.keys()
    assert [name for name in one if not is_of_the_run(name) and one[name] != two[name]] == []
    for name in one["yarns_file"]:
        assert np.array_equal(sm.read_yarns(first / name).points, sm.read_yarns(second / name).points)


@pytest.mark.nightly
def test_a_garment_goes_on_elsewhere_when_its_worker_is_killed_and_all_results_are_those_of_a_serial_run(
    serial, cluster, tmp_path
):
    groups = {worker.pid: worker for worker in (cluster.start_worker(), cluster.start_worker())}
    target, sweep = tmp_path / "sweep", read_sweep(serial.parent / "sweep.toml", allow_paths=[serial.parent])
    with started(sweep, target, cluster.address) as ended:
        wait_until(lambda: list(target.glob("jobs/*/stages/relax_yarns-*/checkpoint.smc")))
        (status,) = target.glob("jobs/*/status.json")
        group = os.getpgid(json.loads(status.read_text())["process"])
        cluster.kill(groups[group])
        assert ended.result().failed == 0
    assert json.loads(status.read_text())["process"] not in groups
    assert_same_results(serial, target)


@pytest.mark.nightly
def test_workers_of_this_machine_have_the_results_of_a_serial_run_and_a_second_run_does_nothing(serial, tmp_path):
    sweep = read_sweep(serial.parent / "sweep.toml", allow_paths=[serial.parent])
    assert run_sweep(sweep, tmp_path, workers=1).kept == 0
    assert_same_results(serial, tmp_path)
    before = {path: path.stat().st_mtime_ns for path in tmp_path.glob(f"{TASKS}/*")}
    assert run_sweep(sweep, tmp_path, workers=0).kept == 3
    assert {path: path.stat().st_mtime_ns for path in tmp_path.glob(f"{TASKS}/*")} == before


def listening(*, but: frozenset[tuple[str, int]] = frozenset()) -> set[tuple[str, int]]:
    """Return the addresses at which this process and its children listen."""
    own = psutil.Process()
    found = [one for process in (own, *own.children(recursive=True)) for one in process.net_connections("inet")]
    return {tuple(one.laddr) for one in found if one.status == psutil.CONN_LISTEN} - but


def answer_to_a_page(place: tuple[str, int], *, context: ssl.SSLContext | None = None) -> bytes:
    """Return what a server answers to one who asks for a page; nothing if it ends the connection."""
    with suppress(OSError), socket.create_connection(place, timeout=10) as plain:
        with nullcontext(plain) if context is None else context.wrap_socket(plain) as connection:
            connection.sendall(b"GET / HTTP/1.0\r\n\r\n")
            return connection.recv(9)
    return b""


def test_each_gpu_has_one_worker_that_sees_no_other_and_all_processes_listen_on_the_loopback_address_only():
    before = frozenset(listening())
    with local_workers(4, 2) as client:
        found = listening(but=before)
        seen = client.run(os.getenv, "CUDA_VISIBLE_DEVICES")
        threads = client.nthreads()
        assert offers_gpu(client)
    assert {ip for ip, _ in found} == {"127.0.0.1"}
    assert sorted(seen.values()) == ["0", "1"] and list(threads.values()) == [1, 1]


def test_the_processes_of_a_sweep_speak_to_nobody_without_its_certificate():
    stranger = Security.temporary().get_connection_args("client")["ssl_context"]
    trusting = ssl.create_default_context()
    trusting.check_hostname, trusting.verify_mode = False, ssl.CERT_NONE
    before = frozenset(listening())
    with local_workers(1, 0) as client:
        assert client.submit(os.getpid).result() != os.getpid()
        found = listening(but=before)
        clients = (None, trusting, stranger)
        answers = [answer_to_a_page(place, context=context) for place in found for context in clients]
        secrets = client.run(lambda: "PRIVATE KEY" in "".join([*sys.argv, *os.environ.values()]))
    assert len(found) == 3 and set(answers) == {b""}  # The scheduler, the worker and the process that watches it.
    assert set(secrets.values()) == {False}


@pytest.mark.nightly
def test_a_standing_scheduler_with_certificates_is_reached_by_those_of_the_configuration(tmp_path, caplog):
    settings = certificates(tmp_path)
    cluster = Cluster(tmp_path, preload=QUICK, settings=settings)
    try:
        with pytest.raises(ParameterError, match="holds no certificate; set certificates") as caught:
            run_sweep(quick_sweep([2.0]), tmp_path / "sweep", scheduler=cluster.address)
        assert "\n" not in str(caught.value)
        cluster.start_worker()
        with dask.config.set({name.lower().replace("__", "."): value for name, value in settings.items()}):
            assert run_sweep(quick_sweep([2.0]), tmp_path / "sweep", scheduler=cluster.address).failed == 0
            with pytest.raises(ParameterError, match="requires encryption; set certificates"):
                run_sweep(quick_sweep([2.0]), tmp_path / "sweep", scheduler=cluster.address.replace("tls", "tcp"))
    finally:
        cluster.close()
    (warning,) = caplog.messages
    assert warning.startswith("tcp://127.0.0.1") and "takes code from everyone who reaches it" in warning


@pytest.mark.nightly
def test_jobs_of_which_workers_die_are_rows_with_an_error_and_the_jobs_beside_them_are_done(quick, tmp_path):
    sweep = quick_sweep([2.0, KILLS, 2.5, SWALLOWS], together=2)
    target = tmp_path / "sweep"
    ended = run_sweep(sweep, target, scheduler=quick.address)
    table = read_table(target)
    assert (ended.jobs, ended.failed) == (4, 2)
    assert table["measure"] == [2.0, None, 2.5, None]
    assert [error is not None and "died" in error for error in table["error_text"]] == [False, True, False, True]
    assert run_sweep(sweep, target, workers=0).kept == 4


@pytest.mark.nightly
def test_a_killed_client_is_followed_by_one_that_does_what_is_left(quick, tmp_path):
    target, gammas = tmp_path / "sweep", harmless(40)
    target.mkdir()
    script = (
        "import sys\nfrom tests.jobs.sweep.test_run_sweep import *\n"
        "run_sweep(quick_sweep(harmless(40)), sys.argv[1], scheduler=sys.argv[2])\n"
    )
    client = subprocess.Popen([sys.executable, "-c", script, str(target), quick.address])
    wait_until(lambda: len(list(target.glob(f"{TASKS}/*.json"))) >= 3)
    client.send_signal(signal.SIGKILL)
    client.wait()
    (target / "hold").touch()  # What the killed client gave last is still at work when the next one comes.
    kept = len(list(target.glob(f"{TASKS}/*.json")))
    with started(quick_sweep(gammas), target, quick.address) as ended:
        (target / "hold").unlink()
        assert ended.result().kept >= kept
    assert read_table(target)["measure"] == gammas
    assert set(begun(target).values()) == {1}


@pytest.mark.nightly
def test_a_scheduler_that_is_killed_and_started_again_gets_what_is_left(quick, tmp_path):
    target, gammas = tmp_path / "sweep", harmless(60)
    with started(quick_sweep(gammas), target, quick.address) as ended:
        wait_until(lambda: list(target.glob(f"{TASKS}/*.json")))
        (target / "hold").touch()
        quick.kill(quick.scheduler)
        for worker in quick.workers:
            quick.kill(worker)
        (target / "hold").unlink()
        quick.start_scheduler()
        quick.start_worker()
        assert ended.result().failed == 0
    assert read_table(target)["measure"] == gammas
    assert begun(target).total() <= len(gammas) + 2  # Only what the two workers held was begun twice.


@pytest.mark.nightly
def test_a_sweep_without_workers_says_so_until_it_is_stopped(cluster, tmp_path):
    stop, notes = StopRequest(), []

    def listen(status):
        notes.append(status.note)
        if "no worker" in status.note:
            stop.ask()

    with pytest.raises(JobStopped):
        run_sweep(quick_sweep([2.0]), tmp_path / "sweep", scheduler=cluster.address, stop=stop, listener=listen)
    assert "0 of 1 jobs; no worker yet" in notes


@pytest.mark.nightly
def test_a_full_disk_ends_a_sweep_in_one_line_and_the_next_run_does_what_is_left(quick, tmp_path):
    target, sweep = tmp_path / "sweep", quick_sweep([2.0, 2.5, FILLS, 3.0])
    target.mkdir()
    (target / "full").touch()
    with pytest.raises(FileError, match="cannot be written"):
        run_sweep(sweep, target, scheduler=quick.address)
    assert json.loads((target / "status.json").read_text())["state"] == "failed"
    (target / "full").unlink()
    assert run_sweep(sweep, target, scheduler=quick.address).failed == 0
    assert read_table(target)["measure"] == [2.0, 2.5, FILLS, 3.0]


def test_a_job_with_an_impossible_value_is_a_row_with_its_error(tmp_path):
    ended = run_sweep(quick_sweep([20.0, 30.0], together=2), tmp_path, workers=0)
    assert (ended.jobs, ended.failed) == (2, 2)
    first, second = read_table(tmp_path)["error_text"]
    assert ended.all_failed and ended.first_error == first
    assert first == "ParameterError: gamma: got 20.0; expected 0.1 to 10" and "30.0" in second


@pytest.mark.parametrize(("gammas", "status"), [("[20.0, 30.0]", 1), ("[1.0, 30.0]", 0)])
def test_a_sweep_of_which_every_job_failed_has_the_status_of_no_result(tmp_path, capsys, gammas, status):
    job = 'picture = false\n[job]\ndevice = "cpu"\nquality = "draft"\nswatch = { pattern = "stockinette" }'
    (tmp_path / "sweep.toml").write_text(f"{job}\n[grid]\nswatch.gamma = {gammas}\n")
    assert main(["batch", str(tmp_path / "sweep.toml"), "--workers", "0"]) == status
    last = capsys.readouterr().err.splitlines()[-1]
    error = "No job has a result; the first error: ParameterError: gamma: got 20.0; expected 0.1 to 10"
    assert (last == error) is (status == 1)


def test_a_sweep_that_is_refused_leaves_nothing(tmp_path):
    sweep = Sweep(job={"swatch": {"patern": "seed"}})
    with pytest.raises(FileError, match="job 0: swatch has no key 'patern'; did you mean 'pattern'"):
        run_sweep(sweep, tmp_path / "sweep", workers=0)
    assert not (tmp_path / "sweep").exists()


def test_a_wish_to_stop_ends_a_sweep_between_two_tasks(tmp_path):
    stop = StopRequest()
    stop.ask()
    with pytest.raises(JobStopped):
        run_sweep(quick_sweep([20.0]), tmp_path, workers=0, stop=stop)
    assert json.loads((tmp_path / "status.json").read_text())["state"] == "stopped"


@pytest.mark.nightly
def test_a_wish_to_stop_ends_a_sweep_whose_tasks_end_all_the_time(quick, tmp_path):
    stop = StopRequest()

    def listen(status):
        if status.done > 0.0:
            stop.ask()

    with pytest.raises(JobStopped):
        run_sweep(quick_sweep(harmless(40)), tmp_path / "sweep", scheduler=quick.address, stop=stop, listener=listen)
    # What two workers held when the first task had ended may have ended too.
    assert len(list((tmp_path / "sweep").glob(f"{TASKS}/*.json"))) < 20


def test_a_scheduler_that_does_not_answer_and_a_wrong_number_of_workers_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("stitchmesh.jobs.sweep.workers.CONNECT_SECONDS", 1)
    with pytest.raises(FileError, match="no scheduler answers"):
        run_sweep(quick_sweep([1.0]), tmp_path, scheduler="tcp://127.0.0.1:9")
    with pytest.raises(ParameterError, match="workers: got -1; expected 0 or more"):
        run_sweep(quick_sweep([1.0]), tmp_path, workers=-1)
    with pytest.raises(ParameterError, match="no number with a scheduler"):
        run_sweep(quick_sweep([1.0]), tmp_path, workers=1, scheduler="tcp://127.0.0.1:9")
