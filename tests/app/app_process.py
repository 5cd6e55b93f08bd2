# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The application as a process of its own, which tests can kill."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.gallery import ROOT


class AppProcess:
    """The command ``stitchmesh app`` on a project."""

    def __init__(self, folder: Path, *words: str, port: int = 0) -> None:
        """Start the program, and wait until it listens."""
        home = folder.parent
        self.process = subprocess.Popen(
            [sys.executable, "-m", "stitchmesh", "app", *words, "--project", str(folder), "--port", str(port),
             "--no-browser"],
            cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            env={**os.environ, "STITCHMESH_PROJECTS": str(home / "projects"), "XDG_STATE_HOME": str(home / "state"),
                 "PYTHONUNBUFFERED": "1"},
        )  # fmt: skip
        self.lines: list[str] = []
        self.address = self._read_address()

    @property
    def port(self) -> int:
        """The port on which it listens."""
        found = re.search(r":(\d+)/", self.address)
        assert found is not None
        return int(found[1])

    def kill(self) -> None:
        """End the process at once, as a power cut would."""
        self.process.kill()
        self.process.wait()

    def terminate(self) -> int:
        """Ask the process to end, and return its exit status."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(timeout=60)

    def output(self) -> str:
        """Return all that the process has printed; it must have ended."""
        assert self.process.stdout is not None
        return "".join([*self.lines, self.process.stdout.read()])

    def _read_address(self) -> str:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(line)
            if (found := re.search(r"open (http://\S+)", line)) is not None:
                return found[1]
        raise AssertionError("the program ended before it listened: " + "".join(self.lines))


@contextmanager
def app_process(folder: Path, *words: str, port: int = 0) -> Iterator[AppProcess]:
    """Run the program; it is killed at the end if it still runs."""
    running = AppProcess(folder, *words, port=port)
    try:
        yield running
    finally:
        if running.process.poll() is None:
            running.kill()
