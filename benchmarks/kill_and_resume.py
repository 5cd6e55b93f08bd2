# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A relaxation that is killed at random moments and resumed each time; its result must have the same bits.

    python benchmarks/kill_and_resume.py glove.bcc --device cuda:0 --every 100
    python benchmarks/kill_and_resume.py --tube 20 60 --device cpu --iterations 400

Each part of the relaxation is a process that SIGKILL ends. The time between the first assessment of a process and its
end is random, with a mean of a twelfth of the time of an uninterrupted relaxation. The times of uninterrupted
relaxations with and without checkpoints show the cost of checkpoints.
"""

from __future__ import annotations

import argparse
import json
import logging
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scenes import stockinette_tube

from stitchmesh.errors import FileError
from stitchmesh.io import read_yarns
from stitchmesh.io.checkpoint_file import read_checkpoint
from stitchmesh.quality import quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.checkpoint import Checkpoints


def scene(arguments: argparse.Namespace) -> YarnSet:
    """The yarns that the command line asks for."""
    if arguments.yarns is not None:
        return read_yarns(arguments.yarns)
    rows, stitches = arguments.tube
    return stockinette_tube(rows, stitches, 12)


def relax(arguments: argparse.Namespace) -> None:
    """One leg: relax from the newest checkpoint on, say when it has begun, and save where it ended."""
    logging.disable()  # each leg would say the same
    quality = quality_named(arguments.quality)
    if arguments.iterations is not None:
        quality = replace(quality, max_iterations=arguments.iterations, tolerance=0.0)
    folder, checkpoint = Path(arguments.leg), None
    if arguments.every:
        checkpoint = Checkpoints(folder, arguments.every)
    resume = checkpoint.path if checkpoint is not None and checkpoint.path.exists() else None
    result = relax_yarns(scene(arguments), quality=quality, device=arguments.device, checkpoint=checkpoint,
                         resume=resume, progress=lambda entry: print(entry["iteration"], flush=True))  # fmt: skip
    np.save(folder / "points.npy", result.yarns.points)
    (folder / "report.json").write_text(json.dumps(result.report))


def leg(folder: Path, every: int, life: float = np.inf) -> bool:
    """Run a leg and kill it when its life is over; whether that was needed."""
    command = [sys.executable, __file__, *sys.argv[1:], "--leg", str(folder), "--every", str(every)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        process.stdout.readline()
        if np.isfinite(life):
            time.sleep(life)
            process.send_signal(signal.SIGKILL)
        process.communicate()
    if process.returncode not in (0, -signal.SIGKILL):
        raise SystemExit(f"a leg ended with status {process.returncode}")
    return process.returncode == -signal.SIGKILL


def ended(folder: Path) -> tuple[np.ndarray, dict[str, Any]]:
    """Control points and report of a leg that came to its end."""
    return np.load(folder / "points.npy"), json.loads((folder / "report.json").read_text())


def whole(name: str, scratch: Path, every: int) -> tuple[np.ndarray, dict[str, Any]]:
    """An undisturbed relaxation, the second one: the first compiles."""
    folder = scratch / name
    for _ in range(2):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        leg(folder, every)
        points, report = ended(folder)
    print(f"{name}: {report['iterations']} iterations in {report['seconds']:.2f} s, "
          f"residual {report['residual']:.3g}, {report['device']}")  # fmt: skip
    return points, report


def reached(folder: Path) -> str:
    """What the newest checkpoint says, and what it weighs."""
    path = folder / "checkpoint.smc"
    try:
        return f"iteration {read_checkpoint(path).header['iteration']}, {path.stat().st_size / 1e6:.1f} MB"
    except FileError as error:
        return str(error)


def main() -> None:
    """Kill, resume, compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("yarns", nargs="?", help="file of yarns; a tube of plain knit where not given")
    parser.add_argument("--tube", nargs=2, type=int, default=(20, 60), metavar=("ROWS", "STITCHES"))
    parser.add_argument("--quality", default="draft")
    parser.add_argument("--iterations", type=int, help="do so many, instead of the quality's limit and tolerance")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--every", type=int, default=20, help="iterations between checkpoints")
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--leg", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.leg is not None:
        relax(arguments)
        return
    yarns = scene(arguments)
    print(f"{len(yarns.points)} control points, checkpoints every {arguments.every} iterations")
    with tempfile.TemporaryDirectory() as name:
        scratch = Path(name)
        expected, report = whole("without checkpoints", scratch, 0)
        whole("with checkpoints", scratch, arguments.every)
        folder, kills = scratch / "killed", 0
        folder.mkdir()
        lives = np.random.default_rng(arguments.seed).uniform(0.0, report["seconds"] / 6, arguments.kills)
        for life in lives:
            kills += leg(folder, arguments.every, float(life))
            print(f"killed {life:.2f} s after its first assessment: {reached(folder)}")
        leg(folder, arguments.every)
        points, last = ended(folder)
    same = np.array_equal(points, expected) and last["energies"] == report["energies"]
    print(f"{kills} kills: {'the same bits' if same else 'OTHER BITS'}")


if __name__ == "__main__":
    main()
