# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What ``kills.py`` and ``refusals.py`` interrupt: small runs that replace old files by new ones."""

from __future__ import annotations

import csv
import json
import sys
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from pathlib import Path

import numpy as np
from PIL import Image

from stitchmesh.app.project.project import Project
from stitchmesh.cli.main import main
from stitchmesh.errors import StitchMeshError
from stitchmesh.io import write_mesh, write_yarns
from stitchmesh.io.any_file import read_any
from stitchmesh.io.checkpoint_file import read_checkpoint
from stitchmesh.io.history import read_history
from stitchmesh.jobs.sweep.result_table import read_table
from stitchmesh.mixed.scene.scene import write_scene
from tests.app.project.projects import HISTORY, REPORT, YARNS, relaxed_project
from tests.gallery import tube
from tests.mixed.small_scene import SWINGING

JOB = """mesh = "tube.obj"
quality = "draft"
device = "cpu"
[tessellate]
stitch_width = {width}
[relax_yarns]
checkpoint_every = 10
max_iterations = 40
[[render]]
path = "preview.png"
size = [120, 90]
"""
"""A job with checkpoints and a small picture."""
SWEEP = """write_yarns = true
[job]
quality = "draft"
device = "cpu"
[job.swatch]
pattern = "stockinette"
max_iterations = 20
[grid]
swatch.gamma = {gammas}
"""
"""A sweep of two swatches with pictures and yarns."""
USED = (
    "stitchmesh.cli.progress", "stitchmesh.jobs.run_job", "stitchmesh.jobs.sweep.run_sweep", "stitchmesh.mixed.drape",
    "stitchmesh.periodic.swatch", "stitchmesh.recipe.knit_recipe", "stitchmesh.render", "h5py", "matplotlib.pyplot",
    "pxr.Usd", "pyarrow.parquet", "pyvista",
)  # fmt: skip
"""Modules that the runs load when they need them."""
LIMITED = ["--quality", "draft", "--device", "cpu", "--max-iterations", "20", "--no-picture"]


@dataclass(frozen=True)
class Work:
    """A run that replaces the old files of a folder by new ones, and may be repeated."""

    name: str
    """Name of the command."""
    old: Callable[[Path], int]
    """Writes the old files into a folder, and returns the exit status."""
    new: Callable[[Path], int]
    """Writes the new files into the folder, and returns the exit status."""
    share: float
    """Part of the kills that this run gets."""
    may_go: tuple[str, ...] = ()
    """Patterns of names of old files that the run may remove."""
    is_project: bool = False
    """Whether the folder is a project: the next run gives its files other numbers."""
    remakes: bool = False
    """Whether the run may make a removed folder again: autosave writes all files again, and USD makes its folder."""


def load_modules() -> None:
    """Load the modules that the runs use, so that each process that is made by a fork has them."""
    for name in USED:
        import_module(name)


def works(inputs: Path) -> list[Work]:
    """Write the inputs of all runs into a folder, and return the runs."""
    _write_inputs(inputs)
    mesh = str(inputs / "tube.obj")
    return [
        Work("knit", *(partial(_command, "knit", mesh, "--stitch-width", width, *LIMITED) for width in ("0.8", "0.5")),
             share=0.125),
        Work("run", *(partial(_command, "run", str(inputs / f"{version}-job.toml"), "--resume")
                      for version in ("old", "new")), share=0.075, may_go=("stages/*/checkpoint*.smc",)),
        Work("swatch", *(partial(_command, "swatch", "stockinette", "--gamma", gamma, *LIMITED)
                         for gamma in ("1", "1.1")), share=0.1),
        Work("drape", *(partial(_command, "drape", str(inputs / name), "--checkpoint-every", "1")
                        for name in ("old-scene.toml", "new-scene.toml")), share=0.1, may_go=("frames/*", "*.smc")),
        Work("convert", *(partial(_convert, inputs / name) for name in ("old.h5", "new.h5")), share=0.3,
             remakes=True),
        Work("autosave", *(partial(_autosave, iterations) for iterations in (1, 2)), share=0.25, may_go=("files/*",),
             is_project=True, remakes=True),
        Work("batch", *(partial(_command, "batch", str(inputs / f"{version}-sweep.toml"), "--workers", "0")
                        for version in ("old", "new")), share=0.05),
    ]  # fmt: skip


def _write_inputs(folder: Path) -> None:
    write_mesh(folder / "tube.obj", tube(8, 1, radius=2.0, height=0.8))
    for name, gammas in (("old", [1.0, 1.1]), ("new", [1.1, 1.2])):
        (folder / f"{name}-sweep.toml").write_text(SWEEP.format(gammas=gammas))
    for name, width, picks, radius in (("old", 0.8, 3.0, 0.05), ("new", 0.5, 4.0, 0.06)):
        (folder / f"{name}-job.toml").write_text(JOB.format(width=width))
        write_scene(folder / f"{name}-scene.toml", replace(SWINGING, yarns=replace(SWINGING.yarns, picks=picks)))
        write_yarns(folder / f"{name}.h5", replace(YARNS, radius=np.full(2, radius)))


def _command(*words: object) -> int:
    """Run a command whose last word is its output folder."""
    *others, folder = words
    return main([*map(str, others), "-o", str(folder)])


def _convert(source: Path, folder: Path) -> int:
    """Convert yarns to every format, up to the first one that is refused."""
    suffixes = ("h5", "bcc", "obj", "vtp", "usda", "usdc", "glb")
    statuses = (main(["convert", str(source), str(folder / f"yarns.{suffix}")]) for suffix in suffixes)
    return next(filter(None, statuses), 0)


def _autosave(iterations: int, folder: Path) -> int:
    """Change a project, as the application does, and wait until autosave has written it."""
    there = (folder / "project.json").exists()
    try:
        project = Project.open(folder) if there else relaxed_project(folder)
        if there and project.notes:
            return 1
        project.set_relaxed(YARNS, {**REPORT, "iterations": iterations}, HISTORY)
        project.close()
    except StitchMeshError as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return 2
    return 0


def _read_picture(path: Path) -> None:
    with Image.open(path) as picture:
        picture.load()


def _read_glb(path: Path) -> None:
    content = path.read_bytes()
    if content[:4] != b"glTF" or int.from_bytes(content[8:12], "little") != len(content):
        raise ValueError("is not a whole GLB file")


def _read_rows(path: Path) -> None:
    """Read the table of a sweep as text; each row has a value for each column."""
    with path.open(newline="") as file:
        rows = list(csv.reader(file, strict=True))
    if not rows or any(len(row) != len(rows[0]) for row in rows):
        raise ValueError("has rows of different lengths")


READERS: Mapping[str, Callable[[Path], object]] = {
    ".json": lambda path: json.loads(path.read_text()),
    ".toml": lambda path: tomllib.loads(path.read_text()),
    ".csv": read_history,
    "rows.csv": _read_rows,
    ".parquet": lambda path: read_table(path.parent),
    ".png": _read_picture,
    ".smc": read_checkpoint,
    ".glb": _read_glb,
}
"""How a file is read, by its name or its suffix; other files hold meshes, stitches or yarns."""


def read_file(path: Path) -> None:
    """Read a file.

    Raises:
        Exception: the file is damaged.
    """
    if path.name != "maps.h5":  # The maps of a drape have no reader of their own: they are compared by bytes.
        READERS.get(path.name, READERS.get(path.suffix, read_any))(path)
