# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checkpoints: everything that a stopped relaxation needs to end with the same bits as one that was never stopped.

A checkpoint is written between two iterations or two Newton steps, right after an assessment. From there on everything
depends on

    the control points and the periods, the same at the last search for contacts and in the last accepted state, and
    what the solver, Newton's method and the terms carry; the margin and the age of the candidate lists, the scale of
    steps, whether Newton's method ends the relaxation, the estimate of the change that is left, the marks from which it
    is made (``settling``), the last assessment, the step of the load with its start, and the load steps that have ended
    (``load_steps``).

Candidate lists and budgets follow from the place of the last search and the margin, so they are made again and not
stored. Everything else follows from the inputs of the relaxation, so a checkpoint contains a fingerprint of the inputs:
yarns, material, quality, kind of device, terms and constraints have to be the same. Only tolerance, largest_change and
max_iterations may differ. They decide where a relaxation ends and not how it proceeds, so a relaxation that stopped at
its limit can continue.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from os import fspath
from typing import Any, TypedDict

import numpy as np
import warp as wp

from stitchmesh import __version__
from stitchmesh.io.checkpoint_file import CheckpointFile, checked_header, read_checkpoint, write_checkpoint
from stitchmesh.io.contents import FilePath
from stitchmesh.io.history import HistoryEntry
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.assessment import Assessment, RemainingChange
from stitchmesh.yarnrelax.ended_step import EndedStep, StepFigures, ended_steps, step_arrays, step_figures
from stitchmesh.yarnrelax.energies.term import ConstraintChoice, TermChoice
from stitchmesh.yarnrelax.fingerprint import fingerprint, refuse_other_inputs, yarn_fingerprint
from stitchmesh.yarnrelax.load_position import AT_ONCE, LoadPosition
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell

LOAD, START = "load.", ("points", "periods")
"""Beginning of the names of arrays at which a step of the load starts, and their names in ``LoadPosition``."""
MASSES = ("yarns.mass_per_length", "material.mass_per_length")
"""Inputs that older checkpoints hold even where nothing reads the mass."""


@dataclass(frozen=True, eq=False)
class CheckpointState:
    """A relaxation between two iterations: everything that decides how it continues."""

    iteration: int
    """Iterations done."""
    seconds: float
    """Time spent [s]."""
    last: Assessment
    """Assessment of the last accepted state."""
    history: Sequence[HistoryEntry]
    """The result of each assessment."""
    margin: float
    """Margin of the candidate lists [units]."""
    lists_age: int
    """Iterations since the candidate lists were made."""
    step_scale: float
    """Scale of steps."""
    energy_fall: float
    """Relative decrease of the energy over the last assessment interval."""
    arrays: Mapping[str, Any]
    """``carried_arrays`` and the marks by name: copies on the device, or as read from a file."""
    ending: bool = False
    """Whether Newton's method ends the relaxation."""
    descent: int = 0
    """Iterations of the solver before the next Newton step."""
    newton_fall: float = 0.0
    """Relative decrease of the energy in the last shortened Newton step, for each of the iterations it counts as."""
    stalled: bool = False
    """Whether no Newton step lowers the energy any more."""
    remaining: RemainingChange | None = None
    """Estimate of the change that is left; None where it is unknown."""
    position: LoadPosition = AT_ONCE
    """The step of the load."""
    ended: Sequence[EndedStep] = ()
    """The load steps before the present one (``load_steps``)."""


class _Position(TypedDict):
    """The fields of ``LoadPosition`` without its arrays."""

    share: float
    reached: float | None
    thin: float
    finer: int
    steps: int
    refusals: int
    reason: str
    iterations: int


class _Header(TypedDict):
    """The header of a checkpoint: the inputs, and the fields of ``CheckpointState`` without its arrays."""

    inputs: dict[str, str]
    iteration: int
    seconds: float
    last: Assessment
    history: list[HistoryEntry]
    margin: float
    lists_age: int
    step_scale: float
    energy_fall: float | None
    ending: bool
    descent: int
    newton_fall: float
    stalled: bool
    remaining: RemainingChange | None
    position: _Position
    ended: list[StepFigures]


def input_fingerprint(
    yarns: YarnSet,
    material: YarnMaterial,
    quality: Quality,
    device: wp.Device,
    terms: Sequence[TermChoice],
    constraints: Sequence[ConstraintChoice],
    cell: RelaxCell | None,
) -> dict[str, str]:
    """The inputs of a relaxation as short strings, without masses that nothing reads.

    Raises:
        ParameterError: a term or a constraint has a value that cannot be compared.
    """
    found = {"stitchmesh": __version__, "device": "cuda" if device.is_cuda else "cpu"}
    yarn = yarn_fingerprint(yarns) | fingerprint("material", material)
    found |= {key: value for key, value in yarn.items() if key not in MASSES}
    found |= fingerprint("quality", quality, without=("tolerance", "largest_change", "max_iterations"))
    found |= {"cell": "kept"} if cell is None else fingerprint("cell", cell)
    for kind, choices in (("term", terms), ("constraint", constraints)):
        for number, choice in enumerate(choices):
            name = f"{kind} {number}"
            found |= {name: type(choice).__name__} | fingerprint(f"{name} ({type(choice).__name__})", choice)
    if quality.solver == "dynamics" or any(term.reads_mass for term in terms):
        found |= {key: yarn[key] for key in MASSES if key in yarn}
    return found


def write_state(path: FilePath, inputs: Mapping[str, str], state: CheckpointState) -> None:
    """Write a checkpoint; the one before it is kept.

    Raises:
        FileError: the file cannot be written.
    """
    header = {
        "inputs": inputs,
        "iteration": state.iteration,
        "seconds": state.seconds,
        "last": asdict(state.last),
        "history": list(state.history),
        "margin": state.margin,
        "lists_age": state.lists_age,
        "step_scale": state.step_scale,
        "energy_fall": state.energy_fall if np.isfinite(state.energy_fall) else None,
        "ending": state.ending,
        "descent": state.descent,
        "newton_fall": state.newton_fall,
        "stalled": state.stalled,
        "remaining": None if state.remaining is None else asdict(state.remaining),
        "position": {name: value for name, value in vars(state.position).items() if name not in START},
        "ended": step_figures(state.ended),
    }
    arrays = {name: array.numpy() for name, array in state.arrays.items()}
    starts = {f"{LOAD}{name}": getattr(state.position, name) for name in START}
    arrays |= {name: array for name, array in starts.items() if array is not None}
    write_checkpoint(path, CheckpointFile(header, arrays | step_arrays(state.ended)))


def read_state(path: FilePath, inputs: Mapping[str, str]) -> CheckpointState:
    """The state that a checkpoint contains.

    Raises:
        FileError: the checkpoint is missing or damaged; the message names the one before it if that file is undamaged.
        ParameterError: the checkpoint is of a relaxation with other inputs; the message says which.
    """
    content = read_checkpoint(path)
    header: dict[str, Any] = {**checked_header(path, content, _Header)}
    written = {key: value for key, value in header.pop("inputs").items() if key in inputs or key not in MASSES}
    refuse_other_inputs(fspath(path), written, inputs)
    starts: dict[str, Any] = {name: content.arrays.get(f"{LOAD}{name}") for name in START}
    arrays = {name: array for name, array in content.arrays.items() if not name.startswith(LOAD)}
    position = replace(AT_ONCE, **header["position"], **starts)
    energy_fall = np.inf if header["energy_fall"] is None else header["energy_fall"]
    own = {"arrays": arrays, "position": position, "energy_fall": energy_fall}
    return CheckpointState(**header | own | {"ended": ended_steps(path, header["ended"], arrays)})


def seconds_of(path: FilePath) -> float:
    """Return the time that a relaxation had taken until it wrote a checkpoint [s].

    Raises:
        FileError: as for ``read_state``.
    """
    return checked_header(path, read_checkpoint(path), _Header)["seconds"]
