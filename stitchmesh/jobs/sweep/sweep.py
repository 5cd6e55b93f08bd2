# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A sweep as a value: the table of a job, the options that differ from job to job, and the results to keep.

The jobs are numbered. Each row of a list is combined with all random samples, and each of these with all combinations
of the grid, in which the last option changes fastest. The file of a sweep is TOML, and paths in it are relative to its
folder.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import fspath
from typing import Any, Literal

import numpy as np

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checked import check_table
from stitchmesh.io.contents import FilePath
from stitchmesh.io.toml_file import read_table
from stitchmesh.jobs.former_keys import renamed_keys, with_present_keys
from stitchmesh.jobs.sweep.axis import MOST_DRAWS, Axis, Choices, grid_axes, leaves, random_axes, with_option

MOST_JOBS = 10_000_000
"""Largest number of jobs of a sweep."""


@dataclass(frozen=True, kw_only=True)
class StretchMeasure:
    """A stretch test of each swatch (``stretch_test``), whose curve is kept with the results."""

    direction: Literal["course", "wale"]
    """Direction of the stretch."""
    strains: tuple[float, float] = (0.0, 0.3)
    """First and last strain."""
    steps: int = 5
    """Number of strains."""
    other: Literal["free", "held"] = "free"
    """Whether the size across the stretch direction is free or held."""


@dataclass(frozen=True, kw_only=True)
class Kept:
    """What a sweep keeps of each job besides its row."""

    write_yarns: bool = False
    """Whether relaxed yarns are kept, as HDF5 files."""
    picture: tuple[int, int] | None = (180, 135)
    """Width and height of a picture of each job [pixels]; None for no picture."""
    stretch: tuple[StretchMeasure, ...] = ()
    """Stretch tests of each swatch."""


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """Many jobs that differ in some options.

    Raises:
        ParameterError: a number is out of bounds, or two parts of the sweep set one option.
    """

    job: Mapping[str, Any]
    """Table of a job file with the options that all jobs share; paths are relative to the folder of ``name``."""
    name: str = "sweep.toml"
    """Path of the file, for messages and for relative paths."""
    grid: tuple[Axis, ...] = ()
    """Options whose values are combined in all ways."""
    rows: tuple[Mapping[str, Any], ...] = ()
    """A list of tables, each with the options of one job."""
    random: tuple[Axis, ...] = ()
    """Options that are drawn at random."""
    samples: int = 1
    """Number of random samples."""
    seed: int = 0
    """Seed of the random samples; each sample follows from the seed and its number."""
    swatches_per_task: int | None = None
    """Number of swatches that one worker gets at a time, and relaxes together on a GPU; None for the usual number of
    the device (``task``)."""
    allow_paths: tuple[str, ...] = ()
    """Additional folders for files that the jobs read, besides the folder of the sweep and the present folder."""
    kept: Kept = field(default_factory=Kept)
    """What is kept of each job besides its row."""

    def __post_init__(self) -> None:
        if not 1 <= self.samples <= MOST_DRAWS:
            raise ParameterError(f"random.samples: got {self.samples}; expected 1 to {MOST_DRAWS}")
        if self.seed < 0:
            raise ParameterError(f"random.seed: got {self.seed}; expected 0 or more")
        if self.swatches_per_task is not None and self.swatches_per_task < 1:
            raise ParameterError(f"swatches_per_task: got {self.swatches_per_task}; expected at least 1")
        if self.job_count > MOST_JOBS:
            raise ParameterError(f"the sweep has {self.job_count} jobs; expected at most {MOST_JOBS}")
        self._refuse_options_of_two_parts()

    @property
    def job_count(self) -> int:
        """Number of jobs."""
        return max(len(self.rows), 1) * self.samples * math.prod(self.shape)

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of values of the options of the grid."""
        return tuple(len(axis.values.values) for axis in self.grid if isinstance(axis.values, Choices))

    def changes(self, number: int) -> list[tuple[tuple[str, ...], Any]]:
        """Return the options of one job that differ from job to job, with their values."""
        rest, place = divmod(number, math.prod(self.shape))
        row, sample = divmod(rest, self.samples)
        listed = list(leaves(self.rows[row])) if self.rows else []
        generator = np.random.default_rng([self.seed, sample])
        drawn = [(axis.keys, axis.values.draw(generator)) for axis in self.random]
        places = np.unravel_index(place, self.shape) if self.grid else ()
        combined = [
            (axis.keys, axis.values.values[int(k)])
            for axis, k in zip(self.grid, places, strict=True)
            if isinstance(axis.values, Choices)
        ]
        return [*listed, *drawn, *combined]

    def table(self, number: int) -> dict[str, Any]:
        """Return the table of one job.

        Raises:
            ParameterError: the path of an option leads through a key that holds no table.
        """
        table = dict(self.job)
        for keys, value in self.changes(number):
            table = with_option(table, keys, value)
        return table

    def _refuse_options_of_two_parts(self) -> None:
        parts = {"grid": {axis.name for axis in self.grid}, "random": {axis.name for axis in self.random},
                 "list": {".".join(keys) for row in self.rows for keys, _value in leaves(row)}}  # fmt: skip
        for first, second in (("grid", "random"), ("grid", "list"), ("random", "list")):
            for name in sorted(parts[first] & parts[second]):
                raise ParameterError(f"{name}: is set by {first} and by {second}; keep one of them")


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
            folder (``check_job_paths``).

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
