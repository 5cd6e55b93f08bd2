# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checkpoints: what it takes for a relaxation that was stopped to end in the same bits as one that was not.

A relaxation is written down between two iterations, right after an assessment. From there on all depends on

    the control points, where they were listed, where they were last good, and what the solver and the terms carry;
    the margin and the age of the candidate lists, the scale of steps, and the last assessment.

Candidate lists and budgets follow from the listed points and the margin, so they are made again and not stored.
Everything else follows from what the relaxation was given, so a checkpoint keeps a fingerprint of that: yarns,
material, quality, kind of device, terms and constraints have to be the same. Only tolerance and max_iterations may
differ. They decide where a relaxation ends and not how it goes, so one that stopped at its limit can go on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from os import fspath
from pathlib import Path
from typing import Any

import numpy as np
import warp as wp

from stitchmesh import __version__
from stitchmesh.errors import ParameterError
from stitchmesh.io.checkpoint_file import CheckpointFile, read_checkpoint, write_checkpoint
from stitchmesh.io.contents import FilePath
from stitchmesh.io.history import HistoryEntry
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.convergence import Assessment
from stitchmesh.yarnrelax.energies.term import ConstraintChoice, TermChoice
from stitchmesh.yarnrelax.fingerprint import fingerprint
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell

NAME = "checkpoint.smc"
"""Name of the newest checkpoint in its folder."""


@dataclass(frozen=True)
class Checkpoints:
    """Where and how often a relaxation is written down.

    Raises:
        ParameterError: ``every`` is below 1.
    """

    folder: FilePath
    """Folder of ``checkpoint.smc`` and of the one before it, ``checkpoint.previous.smc``; made where missing."""
    every: int
    """Iterations between two checkpoints, rounded up to whole assessments (``solver.ASSESSMENT_INTERVAL``)."""

    def __post_init__(self) -> None:
        if self.every < 1:
            raise ParameterError(f"checkpoint: got one every {self.every} iterations; expected at least 1")

    @property
    def path(self) -> Path:
        """The newest checkpoint."""
        return Path(self.folder) / NAME


@dataclass(frozen=True, eq=False)
class CheckpointState:
    """A relaxation between two iterations: all that decides how it goes on."""

    iteration: int
    """Iterations done."""
    seconds: float
    """Time spent [s]."""
    last: Assessment
    """What is known of the last good state."""
    history: Sequence[HistoryEntry]
    """What each assessment found."""
    margin: float
    """Margin of the candidate lists, in units."""
    age: int
    """Iterations since they were made."""
    step_scale: float
    """Scale of steps."""
    energy_fall: float
    """Part of itself by which the energy fell in the last burst (``descent``)."""
    arrays: Mapping[str, Any]
    """``YarnSimulation.arrays`` by name: copies on the device, or as read from a file."""


def origin(
    yarns: YarnSet,
    material: YarnMaterial,
    quality: Quality,
    device: wp.Device,
    terms: Sequence[TermChoice],
    constraints: Sequence[ConstraintChoice],
    cell: RelaxCell | None,
    arrays: Mapping[str, wp.array[Any]],
) -> dict[str, str]:
    """What a relaxation is given, and what it carries, in short words.

    Raises:
        ParameterError: a term or a constraint holds what cannot be compared.
    """
    told = {"stitchmesh": __version__, "device": "cuda" if device.is_cuda else "cpu"}
    told |= fingerprint("yarns", yarns) | fingerprint("material", material)
    told |= fingerprint("quality", quality, without=("tolerance", "max_iterations"))
    told |= {"cell": "kept"} if cell is None else fingerprint("cell", cell)
    for kind, choices in (("term", terms), ("constraint", constraints)):
        for number, choice in enumerate(choices):
            name = f"{kind} {number}"
            told |= {name: type(choice).__name__} | fingerprint(f"{name} ({type(choice).__name__})", choice)
    return told | {f"array {name}": array.dtype.__name__ for name, array in arrays.items()}


def write_state(path: FilePath, given: Mapping[str, str], moment: CheckpointState) -> None:
    """Write a moment down; the checkpoint before it is kept.

    Raises:
        FileError: the file cannot be written.
    """
    header = {
        "given": given,
        "iteration": moment.iteration,
        "seconds": moment.seconds,
        "last": asdict(moment.last),
        "history": list(moment.history),
        "margin": moment.margin,
        "age": moment.age,
        "step_scale": moment.step_scale,
        "energy_fall": moment.energy_fall if np.isfinite(moment.energy_fall) else None,
    }
    write_checkpoint(path, CheckpointFile(header, {name: array.numpy() for name, array in moment.arrays.items()}))


def read_state(path: FilePath, given: Mapping[str, str]) -> CheckpointState:
    """The moment that a checkpoint holds.

    Raises:
        FileError: the checkpoint is missing or damaged; the message names the one before it if that one is sound.
        ParameterError: the checkpoint is of a relaxation that was given something else; the message says what.
    """
    content = read_checkpoint(path)
    header: dict[str, Any] = dict(content.header)
    _refuse_other(fspath(path), header.pop("given"), given)
    energy_fall = np.inf if header["energy_fall"] is None else header["energy_fall"]
    last = Assessment(**header["last"])
    return CheckpointState(**header | {"last": last, "energy_fall": energy_fall, "arrays": content.arrays})


def _refuse_other(name: str, written: Mapping[str, str], given: Mapping[str, str]) -> None:
    differing = [key for key in {**written, **given} if written.get(key) != given.get(key)]
    if differing:
        key, more = differing[0], f", and {len(differing) - 1} more" if len(differing) > 1 else ""
        found = f"{key} is {given.get(key, 'absent')} and was {written.get(key, 'absent')}{more}"
        raise ParameterError(f"{name}: is of a relaxation that was given something else: {found}; give it the same")
