# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sweeps as files: TOML. Paths in a file are relative to its folder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from os import fspath
from typing import Any

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checked import check_table
from stitchmesh.io.contents import FilePath
from stitchmesh.io.toml_file import read_table
from stitchmesh.jobs.former_keys import renamed_keys, with_present_keys
from stitchmesh.jobs.sweep.axis import grid_axes, random_axes
from stitchmesh.jobs.sweep.sweep import Kept, StretchMeasure, Sweep


@dataclass(frozen=True, kw_only=True)
class _Random:
    """How many random samples there are."""

    samples: int = 1
    seed: int = 0


@dataclass(frozen=True, kw_only=True)
class _SweepTable:
    """The keys of a sweep file, except for the tables of options."""

    write_yarns: bool = False
    picture: tuple[int, int] | bool = True
    stretch: tuple[StretchMeasure, ...] = ()
    swatches_per_task: int | None = None
    job: dict[str, Any] = field(default_factory=dict)
    grid: dict[str, Any] = field(default_factory=dict)
    random: dict[str, Any] = field(default_factory=dict)
    list: tuple[dict[str, Any], ...] = ()

    def kept(self) -> Kept:
        """Return what is kept of each job."""
        size = self.picture if not isinstance(self.picture, bool) else Kept.picture if self.picture else None
        return Kept(write_yarns=self.write_yarns, picture=size, stretch=self.stretch)


def read_sweep(path: FilePath, *, allow_paths: Sequence[FilePath] = ()) -> Sweep:
    """Read a sweep from a TOML file. Its jobs are checked when they are made (``jobs_of``).

    Args:
        path: the file.
        allow_paths: additional folders for files that the jobs read, besides the folder of the file and the present
            folder (``job_paths``).

    Raises:
        FileError: the file cannot be read, is not TOML, or has a key or a value that no sweep has; the message names
            the key and, for an unknown key, the nearest known key.
    """
    name = fspath(path)
    try:
        sweep = _sweep(check_table(read_table(path), _SweepTable), name)
        return replace(sweep, allow_paths=tuple(fspath(folder) for folder in allow_paths))
    except ParameterError as error:
        raise FileError(f"{name}: {error}") from error


def _sweep(table: _SweepTable, name: str) -> Sweep:
    own = {"samples", "seed"}
    numbers = check_table({key: value for key, value in table.random.items() if key in own}, _Random)
    drawn = renamed_keys({key: value for key, value in table.random.items() if key not in own})
    return Sweep(
        job=with_present_keys(table.job), name=name, grid=grid_axes(renamed_keys(table.grid)),
        rows=tuple(map(renamed_keys, table.list)), random=random_axes(drawn),
        samples=numbers.samples, seed=numbers.seed, swatches_per_task=table.swatches_per_task, kept=table.kept(),
    )  # fmt: skip
