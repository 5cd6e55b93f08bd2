# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A real scheduler of Dask and real workers on the loopback address, each a process that tests may kill."""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from tests.gallery import ROOT

DEATHS = "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES"
"""Setting of Dask: of how many workers that died of it a task is given up if one more dies."""
DEADLINE = 120.0
"""Time after which a wait is a failure [s]: far beyond what a process needs to start on a busy machine."""


class Cluster:
    """A scheduler and its workers."""

    def __init__(
        self, folder: Path, *, preload: Path | None = None, memory: str = "0", deaths: int = 3,
        settings: Mapping[str, str] | None = None,
    ) -> None:  # fmt: skip
        """Start a scheduler that gives a task up when more workers than ``deaths`` have died of it.

        Workers load the script ``preload`` first, and may use some memory. Settings of Dask with certificates
        (``certificates``) are those of all processes.
        """
        self._settings = {f"DASK_{name}": value for name, value in (settings or {}).items()}
        self._protocol = "tls" if settings else "tcp"
        self.folder, self._preload, self._memory, self._deaths = folder, preload, memory, deaths
        self._processes: list[subprocess.Popen[bytes]] = []
        self.workers: list[subprocess.Popen[bytes]] = []
        self.port = 0
        self.start_scheduler()

    @property
    def address(self) -> str:
        """Address of the scheduler."""
        return f"{self._protocol}://127.0.0.1:{self.port}"

    def start_scheduler(self) -> None:
        """Start the scheduler, at its former port if it had one."""
        file = self.folder / "scheduler.json"
        file.unlink(missing_ok=True)
        self.scheduler = self._start(
            "dask_scheduler", "--host", "127.0.0.1", "--port", str(self.port), "--no-dashboard",
            "--protocol", self._protocol, "--dashboard-address", "127.0.0.1:0", "--scheduler-file", str(file),
        )  # fmt: skip
        wait_until(lambda: file.exists() and file.read_text().endswith("}"))
        self.port = int(json.loads(file.read_text())["address"].rpartition(":")[2])

    def start_worker(self) -> subprocess.Popen[bytes]:
        """Start a worker with its nanny, which starts it again when it dies, and which is itself started again.

        A nanny ends if its worker dies while it starts.
        """
        preload = [] if self._preload is None else ["--preload", str(self._preload)]
        worker = self._start(
            "dask_worker", self.address, "--host", "127.0.0.1", "--nthreads", "1", "--no-dashboard",
            "--protocol", self._protocol, "--memory-limit", self._memory, "--local-directory", str(self.folder),
            "--death-timeout", "60", *preload, again=True,
        )  # fmt: skip
        self.workers.append(worker)
        return worker

    def kill(self, process: subprocess.Popen[bytes]) -> None:
        """Kill a scheduler, or a worker and its nanny, without a word; they have one group of processes."""
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()

    def close(self) -> None:
        """End all processes."""
        for process in self._processes:
            if process.poll() is None:
                self.kill(process)

    def _start(self, program: str, *words: str, again: bool = False) -> subprocess.Popen[bytes]:
        log = (self.folder / f"{program}.log").open("ab")
        own = {"STITCHMESH_THREADS": "1", "PYTHONPATH": str(ROOT), DEATHS: str(self._deaths)}
        command = [sys.executable, "-m", f"distributed.cli.{program}", *words]
        process = subprocess.Popen(
            ["sh", "-c", f"while :; do {shlex.join(command)}; done"] if again else command,
            stdout=log, stderr=log, env=os.environ | own | self._settings, start_new_session=True, cwd=self.folder,
        )  # fmt: skip
        log.close()
        self._processes.append(process)
        return process


def certificates(folder: Path) -> dict[str, str]:
    """Write a key and a certificate, and return the settings of Dask that name them, as ends of variables."""
    from distributed.security import Security

    made = Security.temporary()
    certificate, key = folder / "cert.pem", folder / "key.pem"
    certificate.write_text(made.tls_ca_file)
    key.write_text(made.tls_client_key)
    settings = {"REQUIRE_ENCRYPTION": "True", "TLS__CA_FILE": str(certificate)}
    for role in ("SCHEDULER", "WORKER", "CLIENT"):
        settings |= {f"TLS__{role}__CERT": str(certificate), f"TLS__{role}__KEY": str(key)}
    return {f"DISTRIBUTED__COMM__{name}": value for name, value in settings.items()}


def wait_until(holds: Callable[[], object]) -> None:
    """Wait until a condition holds."""
    last = time.monotonic() + DEADLINE
    while not holds():
        assert time.monotonic() < last, "the wait took too long"
        time.sleep(0.05)
