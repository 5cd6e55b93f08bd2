# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checkpoints: everything that a stopped relaxation needs to end with the same bits as one that was never stopped.

A checkpoint is written between two iterations or two Newton steps, right after an assessment. From there on everything
depends on

    the control points and the periods: now, at the last search for contacts, and in the last accepted state, and
    the values that the solver, Newton's method and the terms keep; the margin and the age of the candidate lists, the
    scale of steps, whether Newton's method ends the relaxation, the estimate of the remaining change, the marks from
    which the estimate is made (``settling``), the last assessment, the step of the load with its start, and the load
    steps that have ended (``load_steps``).

Candidate lists and step budgets follow from the place of the last search and from the margin, so a checkpoint does not
store them; they are made again. Everything else follows from the inputs of the relaxation, so a checkpoint contains a
fingerprint of the inputs: yarns, material, quality, kind of device, terms and constraints have to be the same. Only
tolerance, largest_change and max_iterations may differ. They decide where a relaxation ends and not how it proceeds, so
a relaxation that stopped at its limit can continue.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from os import fspath
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.checkpoint_file import CheckpointFile, checked_header, read_checkpoint, write_checkpoint
from stitchmesh.io.contents import FilePath
from stitchmesh.io.history import HistoryEntry
from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.assessment import Assessment, RemainingChange
from stitchmesh.yarnrelax.fingerprint import refuse_other_inputs
from stitchmesh.yarnrelax.load_position import AT_ONCE, LoadPosition
from stitchmesh.yarnrelax.loop_state import LoopState
from stitchmesh.yarnrelax.relaxation_inputs import MASSES

PLACES = ("points", "periods")
"""Fields of ``EndedStep`` and of ``LoadPosition`` that are arrays."""
LOAD = "load."
"""Beginning of the names of the arrays at the start of a load step."""


@dataclass(frozen=True, eq=False)
class EndedStep:
    """The state in which a load step has ended (``load_steps``); the checkpoints of later steps hold it."""

    points: FloatArray
    """Control points [cm], shape (N, 3)."""
    periods: FloatArray
    """Periods of the cell [cm], shape (2, 3)."""
    energies: dict[str, float]
    """Energy of each term [erg]."""
    residual: float
    """Relative force residual."""
    converged: bool
    """Whether the yarns are at rest."""
    iterations: int
    """Iterations of this step."""
    nearest: float
    """Smallest distance of yarns over their radius, at most 2."""
    course: float
    """Force on the borders along the courses [dyn]."""
    wale: float
    """Force on the borders along the wales [dyn]."""
    seconds: float
    """Time from the start of the load steps to the end of this one [s]."""
    remaining: RemainingChange | None = None
    """Estimate of the remaining change; None if it is unknown."""


class StepFigures(TypedDict):
    """The fields of ``EndedStep`` without its arrays."""

    energies: dict[str, float]
    residual: float
    converged: bool
    iterations: int
    nearest: float
    course: float
    wale: float
    seconds: float
    remaining: RemainingChange | None


def step_figures(steps: Sequence[EndedStep]) -> list[dict[str, Any]]:
    """Return the figures of steps for the header of a checkpoint."""
    names = [field.name for field in fields(EndedStep) if field.name not in PLACES]
    figures = [{name: getattr(step, name) for name in names} for step in steps]
    for own in figures:
        own["remaining"] = None if own["remaining"] is None else asdict(own["remaining"])
    return figures


def step_arrays(steps: Sequence[EndedStep]) -> dict[str, FloatArray]:
    """Return the arrays of steps by their names in a checkpoint."""
    return {_step_array(number, field): getattr(step, field) for number, step in enumerate(steps) for field in PLACES}


def ended_steps(
    path: FilePath, figures: Sequence[StepFigures], arrays: Mapping[str, NDArray[Any]]
) -> list[EndedStep]:  # fmt: skip
    """Return the steps of a checkpoint.

    Raises:
        FileError: an array is missing.
    """
    wanted = [_step_array(number, field) for number in range(len(figures)) for field in PLACES]
    missing = [name for name in wanted if name not in arrays]
    if missing:
        raise FileError(f"{fspath(path)}: array {missing[0]!r} of the checkpoint is missing; begin without it")
    return [
        EndedStep(**{field: arrays[_step_array(number, field)] for field in PLACES}, **own)
        for number, own in enumerate(figures)
    ]


def _step_array(number: int, field: str) -> str:
    return f"ended {number}.{field}"


@dataclass(frozen=True, eq=False)
class CheckpointState:
    """A relaxation between two iterations: everything that decides how it continues, and its history for the report."""

    loop: LoopState
    """The state of the loop."""
    seconds: float
    """Time spent [s]."""
    history: Sequence[HistoryEntry]
    """The figures of each assessment."""
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
    """The header of a checkpoint: the inputs, and the fields of ``CheckpointState`` and of its loop without arrays."""

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


def write_state(path: FilePath, inputs: Mapping[str, str], state: CheckpointState) -> None:
    """Write a checkpoint, and keep the one before it.

    Raises:
        FileError: the file cannot be written.
    """
    loop = state.loop
    figures = {name: value for name, value in vars(loop).items() if name != "arrays"}
    figures["last"] = asdict(loop.last)
    figures["energy_fall"] = loop.energy_fall if np.isfinite(loop.energy_fall) else None
    figures["remaining"] = None if loop.remaining is None else asdict(loop.remaining)
    header = {
        "inputs": inputs,
        **figures,
        "seconds": state.seconds,
        "history": list(state.history),
        "position": {name: value for name, value in vars(state.position).items() if name not in PLACES},
        "ended": step_figures(state.ended),
    }
    arrays = {name: array.numpy() for name, array in loop.arrays.items()}
    starts = {f"{LOAD}{name}": getattr(state.position, name) for name in PLACES}
    arrays |= {name: array for name, array in starts.items() if array is not None}
    write_checkpoint(path, CheckpointFile(header, arrays | step_arrays(state.ended)))


def read_state(path: FilePath, inputs: Mapping[str, str]) -> CheckpointState:
    """Return the state that a checkpoint contains.

    Raises:
        FileError: the checkpoint is missing or damaged; the message names the one before it if that is undamaged.
        ParameterError: the checkpoint belongs to a relaxation with other inputs; the message names them.
    """
    content = read_checkpoint(path)
    header = checked_header(path, content, _Header)
    written = {key: value for key, value in header["inputs"].items() if key in inputs or key not in MASSES}
    refuse_other_inputs(fspath(path), written, inputs)
    arrays = {name: array for name, array in content.arrays.items() if not name.startswith(LOAD)}
    starts: dict[str, Any] = {name: content.arrays.get(f"{LOAD}{name}") for name in PLACES}
    return CheckpointState(
        loop=LoopState(
            iteration=header["iteration"],
            last=header["last"],
            margin=header["margin"],
            lists_age=header["lists_age"],
            step_scale=header["step_scale"],
            energy_fall=np.inf if header["energy_fall"] is None else header["energy_fall"],
            arrays=arrays,
            ending=header["ending"],
            descent=header["descent"],
            newton_fall=header["newton_fall"],
            stalled=header["stalled"],
            remaining=header["remaining"],
        ),
        seconds=header["seconds"],
        history=header["history"],
        position=replace(AT_ONCE, **header["position"], **starts),
        ended=ended_steps(path, header["ended"], arrays),
    )


def seconds_of(path: FilePath) -> float:
    """Return the time that a relaxation had taken until it wrote a checkpoint [s].

    Raises:
        FileError: the checkpoint is missing or damaged.
    """
    return checked_header(path, read_checkpoint(path), _Header)["seconds"]
