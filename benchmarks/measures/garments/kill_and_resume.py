# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A relaxation that is killed at random moments and resumed each time; its result must have the same bits.

Each part of the relaxation is a process that SIGKILL ends. The time between the first assessment of a process and its
end is random, with a mean of a twelfth of the time of an uninterrupted relaxation. The times of uninterrupted
relaxations with and without checkpoints show the cost of checkpoints.
"""

from __future__ import annotations

import json
import logging
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Generator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from tyro.conf import Positional

from benchmarks.scenes import stockinette_tube
from benchmarks.table import Rows
from stitchmesh.errors import FileError
from stitchmesh.io import read_yarns
from stitchmesh.io.checkpoint_file import read_checkpoint
from stitchmesh.quality import quality_named
from stitchmesh.run import Checkpoints, Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import relax_yarns


def scene(arguments: Options) -> YarnSet:
    """The yarns given on the command line."""
    if arguments.yarns is not None:
        return read_yarns(arguments.yarns)
    rows, stitches = arguments.tube
    return stockinette_tube(rows, stitches, 12)


def relax(arguments: Options) -> None:
    """Run one part: relax from the newest checkpoint, print each assessment, and save the result."""
    logging.disable()  # each part would log the same messages
    quality = quality_named(arguments.quality)
    if arguments.iterations is not None:
        quality = replace(quality, max_iterations=arguments.iterations, tolerance=0.0)
    folder, checkpoint = Path(arguments.part), None
    if arguments.every:
        checkpoint = Checkpoints(folder, arguments.every)
    resume = checkpoint.path if checkpoint is not None and checkpoint.path.exists() else None

    def print_iteration(_stage: str, _done: float, note: str) -> None:
        print(note.split()[1].rstrip(","), flush=True)

    run = Run(print_iteration, checkpoints=checkpoint, resume=resume)
    result = relax_yarns(scene(arguments), quality=quality, device=arguments.device, run=run)
    np.save(folder / "points.npy", result.yarns.points)
    (folder / "report.json").write_text(json.dumps(result.report))


def run_part(folder: Path, every: int, lifetime: float = np.inf) -> bool:
    """Run one part and kill it ``lifetime`` seconds after its first assessment.

    Returns:
        Whether the part was killed; False if it ended before.
    """
    command = [sys.executable, *sys.argv, "--part", str(folder), "--every", str(every)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        process.stdout.readline()
        if np.isfinite(lifetime):
            time.sleep(lifetime)
            process.send_signal(signal.SIGKILL)
        process.communicate()
    if process.returncode not in (0, -signal.SIGKILL):
        raise SystemExit(f"a part ended with status {process.returncode}")
    return process.returncode == -signal.SIGKILL


def read_result(folder: Path) -> tuple[np.ndarray, dict[str, Any]]:
    """Control points and report of a part that was not killed."""
    return np.load(folder / "points.npy"), json.loads((folder / "report.json").read_text())


def uninterrupted(name: str, scratch: Path, every: int) -> Generator[str, None, tuple[np.ndarray, dict[str, Any]]]:
    """Run an uninterrupted relaxation twice, and yield and return the second; the first compiles the kernels."""
    folder = scratch / name
    for _ in range(2):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        run_part(folder, every)
        points, report = read_result(folder)
    run = f"{report['iterations']} iterations in {report['seconds']:.2f} s"
    yield f"{name}: {run}, residual {report['residual']:.3g}, {report['device']}"
    return points, report


def describe_checkpoint(folder: Path) -> str:
    """Iteration and file size of the newest checkpoint, or the error that reading it raised."""
    path = folder / "checkpoint.smc"
    try:
        return f"iteration {read_checkpoint(path).header['iteration']}, {path.stat().st_size / 1e6:.1f} MB"
    except FileError as error:
        return str(error)


@dataclass(frozen=True)
class Options:
    """What is measured."""

    yarns: Positional[str | None] = None
    """yarn file; default: a tube of plain knit"""
    tube: tuple[int, int] = (20, 60)
    quality: str = "draft"
    iterations: int | None = None
    """number of iterations, in place of the quality's tolerance"""
    device: str = "cpu"
    every: int = 20
    """iterations between checkpoints"""
    kills: int = 10
    seed: int = 0
    part: Path | None = None
    """folder of a part, which this program starts itself"""


def kill_and_resume(arguments: Options) -> Rows:
    """Kill, resume, compare."""
    if arguments.part is not None:
        relax(arguments)
        return
    yarns = scene(arguments)
    yield f"{len(yarns.points)} control points, checkpoints every {arguments.every} iterations"
    with tempfile.TemporaryDirectory() as name:
        scratch = Path(name)
        expected, report = yield from uninterrupted("without checkpoints", scratch, 0)
        yield from uninterrupted("with checkpoints", scratch, arguments.every)
        folder, kills = scratch / "killed", 0
        folder.mkdir()
        lifetimes = np.random.default_rng(arguments.seed).uniform(0.0, report["seconds"] / 6, arguments.kills)
        for lifetime in lifetimes:
            kills += run_part(folder, arguments.every, float(lifetime))
            yield f"killed {lifetime:.2f} s after its first assessment: {describe_checkpoint(folder)}"
        run_part(folder, arguments.every)
        points, last = read_result(folder)
    same = np.array_equal(points, expected) and last["energies"] == report["energies"]
    yield f"{kills} kills: {'the same bits' if same else 'DIFFERENT BITS'}"
