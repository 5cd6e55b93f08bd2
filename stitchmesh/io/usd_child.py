# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading of USD stages in a process of its own.

The library of USD can end its process at a damaged file, ask for any memory, or not come to an end. A child process
therefore opens the stage, within limits of memory and processor time that grow with the file, and hands over what it
reads in a file with a checksum (``stitchmesh.io.checkpoint_file``). The end of the child is an error as any other one.

    python -m MODULE STAGE ANSWER
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable
from os import fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from stitchmesh.child_interpreter import clean_environment, python_command
from stitchmesh.errors import FileError
from stitchmesh.io.checkpoint_file import CheckpointFile, read_checkpoint, write_checkpoint
from stitchmesh.io.contents import FilePath, read_bytes

if TYPE_CHECKING:
    from pxr import Usd

T = TypeVar("T")

METRES_PER_UNIT = 0.01
"""Unit of the coordinates in files that are written [m]."""
Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rotation of points with z up, as rows, to points with y up."""
MEMORY = 2**30, 1000
"""Memory that the child may add to what its libraries take: a constant [bytes], and bytes for each byte of the file."""
SECONDS = 60, 2e-5
"""Processor time that the child may take: a constant [s], and seconds for each byte of the file."""


def answer_of_child(module: str, path: FilePath) -> CheckpointFile:
    """Return what a module hands over that reads a stage in a process of its own (``answer_parent``).

    Raises:
        FileError: the file cannot be read or is malformed, or the process ends.
    """
    name = fspath(path)
    read_bytes(path)
    with tempfile.TemporaryDirectory() as folder:
        answer = Path(folder) / "answer.smc"
        ended = subprocess.run(
            python_command("-m", module, name, str(answer)), env=clean_environment(),
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False,
        )  # fmt: skip
        if ended.returncode or not answer.exists():
            found = f"USD could not read it and ended with status {ended.returncode}"
            raise FileError(f"{name}: is not a valid USD file ({found}); write it again")
        content = read_checkpoint(answer)
    if content.header["error"]:
        raise FileError(content.header["error"])
    return content


def answer_parent(read: Callable[[str], CheckpointFile]) -> None:
    """Read the stage that the first argument of this process names, and write its content or the error to the second.

    The work of the child process.
    """
    stage, answer = sys.argv[1:]
    _limit(Path(stage).stat().st_size)
    try:
        content = read(stage)
        content = CheckpointFile({"error": "", **content.header}, content.arrays)
    except FileError as refused:
        content = CheckpointFile({"error": str(refused)}, {})
    write_checkpoint(answer, content)


def read_stage(path: FilePath, read: Callable[[str, Usd.Stage], T]) -> T:
    """Open a stage in this process, and read from it.

    Args:
        path: the file.
        read: reads from the stage; its first argument is the name of the file.

    Raises:
        FileError: the file is malformed or names files outside of its folder, or ``read`` refuses it.
    """
    from pxr import Tf, Usd

    name = fspath(path)
    try:
        stage = Usd.Stage.Open(name)
        _check_layers(name, stage)
        with np.errstate(all="ignore"):  # Numbers that overflow are not finite, which is checked.
            return read(name, stage)
    except FileError:
        raise
    except Exception as error:  # USD raises exceptions of many types for malformed files.
        reason = reason_of(error) if isinstance(error, Tf.ErrorException) else " ".join(str(error).split())[:100]
        raise FileError(f"{name}: is not a valid USD file ({reason}); write it again") from error


def to_centimetres(stage: Usd.Stage, world: Any) -> tuple[Any, Any, float]:
    """Return the transform of the points of a prim, as rows, to centimetres with y up.

    Returns:
        Matrix, shape (3, 3), translation [cm], shape (3,), and the mean factor of lengths.
    """
    from pxr import UsdGeom

    matrix = np.array(world, dtype=np.float64) * (UsdGeom.GetStageMetersPerUnit(stage) / METRES_PER_UNIT)
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z:
        matrix[:, :3] = matrix[:, :3] @ Z_UP
    return matrix[:3, :3], matrix[3, :3], float(np.cbrt(abs(np.linalg.det(matrix[:3, :3]))))


def reason_of(error: Any) -> str:
    """Return the first of USD's error messages in one line."""
    try:
        return " ".join(str(error.args[0].commentary).split())[:160]
    except UnicodeDecodeError:  # The message quotes the file.
        return "it holds characters that are not UTF-8"


def _check_layers(name: str, stage: Usd.Stage) -> None:
    """Refuse a stage that is composed of files outside of the folder of its own file."""
    folder = Path(name).resolve().parent
    for layer in stage.GetUsedLayers():
        if layer.realPath and not Path(layer.realPath).resolve().is_relative_to(folder):
            raise FileError(f"{name}: names the file {layer.realPath[:80]}; expected files in its own folder only")


def _limit(size: int) -> None:
    """Limit the memory and the processor time of this process, for a file of a size [bytes]."""
    import resource

    from pxr import Usd, UsdGeom  # noqa: F401  What the libraries take is not counted.

    pages = int(Path("/proc/self/statm").read_text().split()[0]) if Path("/proc/self/statm").exists() else 0
    memory = pages * resource.getpagesize() + MEMORY[0] + MEMORY[1] * size
    seconds = int(SECONDS[0] + SECONDS[1] * size)
    for kind, value in ((resource.RLIMIT_AS, memory), (resource.RLIMIT_CPU, seconds), (resource.RLIMIT_CORE, 0)):
        hard = resource.getrlimit(kind)[1]
        resource.setrlimit(kind, (value if hard == resource.RLIM_INFINITY else min(value, hard), hard))
