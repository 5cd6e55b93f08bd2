# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A load step that has ended (``load_steps``), as the checkpoints of later steps hold it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from os import fspath
from typing import Any, TypedDict

from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.assessment import RemainingChange

ARRAYS = ("points", "periods")
"""Fields of a step that are arrays."""


@dataclass(frozen=True, eq=False)
class EndedStep:
    """The state in which a load step has ended."""

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
    names = [field.name for field in fields(EndedStep) if field.name not in ARRAYS]
    figures = [{name: getattr(step, name) for name in names} for step in steps]
    for own in figures:
        own["remaining"] = None if own["remaining"] is None else asdict(own["remaining"])
    return figures


def step_arrays(steps: Sequence[EndedStep]) -> dict[str, FloatArray]:
    """Return the arrays of steps by their names in a checkpoint."""
    return {_name(number, field): getattr(step, field) for number, step in enumerate(steps) for field in ARRAYS}


def ended_steps(
    path: FilePath, figures: Sequence[StepFigures], arrays: Mapping[str, NDArray[Any]]
) -> list[EndedStep]:  # fmt: skip
    """Return the steps of a checkpoint.

    Raises:
        FileError: an array is missing.
    """
    wanted = [_name(number, field) for number in range(len(figures)) for field in ARRAYS]
    missing = [name for name in wanted if name not in arrays]
    if missing:
        raise FileError(f"{fspath(path)}: array {missing[0]!r} of the checkpoint is missing; begin without it")
    return [
        EndedStep(**{field: arrays[_name(number, field)] for field in ARRAYS}, **own)
        for number, own in enumerate(figures)
    ]


def _name(number: int, field: str) -> str:
    return f"ended {number}.{field}"
