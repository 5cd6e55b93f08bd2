# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The program ``stitchmesh`` as child processes: the mesh for it, its words, its progress and its errors.

Nothing here needs Blender.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

PROGRAM = "stitchmesh"
"""Name of the program on the search path."""
MESH, FOLDER, YARNS, LOG = "garment.obj", "knit", "yarns.usdc", "log.txt"
"""Names in the temporary folder of a run: the mesh, the folder of `knit`, the yarns as curves, and the messages."""
STOP_SECONDS = 5.0
"""Time that a stopped program has to remove its own temporary files [s]; then it is killed."""
PROGRESS = re.compile(r"^(?P<stage>.+?): (?P<percent>\d+)%(?:, (?P<left>[^(]+? left))?")
"""A line of progress, such as ``relaxing yarns: 22%, 10 to 40 s left (iteration 60, residual 0.0225)``."""


class ProgramError(Exception):
    """The program cannot be started, or refused its input; the text is one line."""


@dataclass(frozen=True)
class KnitChoices:
    """What the user chooses in the panel."""

    stitch_width: float = 0.8
    """Wale spacing [cm]."""
    auto: bool = False
    """Whether rows and stitches are found on any mesh, instead of taken from the faces of a mesh of quads."""
    quality: str = "draft"
    """Quality of the relaxation: draft, standard or reference."""
    pattern: str = ""
    """Pattern of the library; empty for plain knitting."""


@dataclass(frozen=True)
class Step:
    """How far a program has come in its current stage."""

    text: str
    """The stage, and the remaining time if the program states one."""
    part: float
    """Completed part of the stage, 0 to 1."""


def find_program(chosen: str) -> str:
    """Return the path of the program: the chosen one, or the one on the search path if none is chosen.

    Raises:
        ProgramError: there is no such program.
    """
    found = shutil.which(chosen or PROGRAM)
    if found is None:
        where = f"{chosen}: is no program" if chosen else f"{PROGRAM}: is not on the search path"
        raise ProgramError(f"{where}; set its path in the preferences of the add-on")
    return found


def write_obj(path: Path, vertices: np.ndarray, corners: np.ndarray, sizes: np.ndarray) -> None:
    """Write a polygon mesh as OBJ.

    Args:
        path: the file.
        vertices: places, shape (n, 3).
        corners: vertices of the faces, one face after the other, shape (c,).
        sizes: number of corners of each face, shape (f,).

    Raises:
        ProgramError: the mesh has no faces.
    """
    if len(sizes) == 0:
        raise ProgramError("the active mesh has no faces; choose the mesh of a garment")
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices.tolist()]
    for face in np.split(corners + 1, np.cumsum(sizes)[:-1]):
        lines.append("f " + " ".join(map(str, face.tolist())))
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def commands(program: str, folder: Path, choices: KnitChoices) -> list[list[str]]:
    """Return the commands that make curves of the mesh in a folder; its lengths are metres, and z points up."""
    made = folder / FOLDER
    knit = [program, "knit", str(folder / MESH), "-o", str(made), "--unit", "m", "--up", "z", "--no-picture",
            "--stitch-width", f"{choices.stitch_width:.6g}", "--quality", choices.quality]  # fmt: skip
    knit += ["--auto"] if choices.auto else []
    knit += ["--pattern", choices.pattern] if choices.pattern else []
    return [knit, [program, "convert", str(made / "yarns.h5"), str(folder / YARNS)]]


def last_step(log: str) -> Step | None:
    """Return the last progress that messages report; None if they report none."""
    for line in reversed(log.splitlines()):
        found = PROGRESS.match(line)
        if found:
            left = f", {found['left']}" if found["left"] else ""
            return Step(found["stage"] + left, min(int(found["percent"]), 100) / 100)
    return None


def error_line(log: str, status: int) -> str:
    """Return the line that says why a program failed: the last one of its messages that is no progress."""
    lines = [line.strip() for line in log.splitlines() if line.strip() and not PROGRESS.match(line)]
    return lines[-1] if lines else f"{PROGRAM}: ended with status {status} and without a message"


class ProgramRun:
    """Commands that run one after the other, in a temporary folder that ``close`` removes."""

    def __init__(self) -> None:
        """Make the temporary folder."""
        self._temporary = tempfile.TemporaryDirectory(prefix="stitchmesh-", ignore_cleanup_errors=True)
        self.folder = Path(self._temporary.name)
        self.step = Step("starting", 0.0)
        self._waiting: list[Sequence[str]] = []
        self._process: subprocess.Popen | None = None

    def start(self, words: Sequence[Sequence[str]]) -> None:
        """Start the first command.

        Raises:
            ProgramError: the program cannot be started.
        """
        self._waiting = list(words)
        self._start_next()

    def poll(self) -> bool:
        """Read the progress, start the next command if one has ended, and return whether all have ended.

        Raises:
            ProgramError: a command has failed, or the next one cannot be started.
        """
        if self._process is None:
            return True
        log = self._log()
        self.step = last_step(log) or self.step
        status = self._process.poll()
        if status is None:
            return False
        self._process = None
        if status != 0:
            raise ProgramError(error_line(self._log(), status))
        if self._waiting:
            self._start_next()
        return self._process is None

    def close(self) -> None:
        """Stop the command that runs, and remove the folder."""
        if self._process is not None:
            self._process.terminate()
            try:
                self._process.wait(STOP_SECONDS)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
            self._process = None
        self._temporary.cleanup()

    def _start_next(self) -> None:
        words = self._waiting.pop(0)
        with (self.folder / LOG).open("wb") as log:
            try:
                self._process = subprocess.Popen(
                    words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log, cwd=self.folder
                )
            except OSError as error:
                raise ProgramError(f"{words[0]}: cannot be started ({error.strerror}); check its path") from error

    def _log(self) -> str:
        return (self.folder / LOG).read_text(encoding="utf-8", errors="replace")
