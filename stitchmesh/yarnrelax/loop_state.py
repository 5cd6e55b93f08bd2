# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The state of the loop of one piece between two assessment intervals; from it the loop continues with the same bits.

Candidate lists and step budgets follow from the place of the last search and from the margin. They are made again,
and are no part of the state. Everything else follows from the inputs of the relaxation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import warp as wp
from numpy.typing import NDArray

from stitchmesh.simulation.term import check_arrays
from stitchmesh.yarnrelax.assessment import Assessment, RemainingChange
from stitchmesh.yarnrelax.simulation import YarnSimulation


@dataclass(frozen=True, eq=False)
class LoopState:
    """Everything that decides how the loop of one piece continues (``RelaxationLoop.state``)."""

    iteration: int
    """Number of iterations done."""
    last: Assessment
    """Assessment of the last accepted state."""
    margin: float
    """Margin of the candidate lists [units]."""
    lists_age: int
    """Iterations since the candidate lists were made."""
    step_scale: float
    """Scale of steps."""
    energy_fall: float
    """Relative decrease of the energy over the last assessment interval."""
    arrays: Mapping[str, Any]
    """``carried_arrays``, the memory of Newton's method and the marks of ``settling``, by name: copies on the device,
    or arrays read from a file."""
    ending: bool = False
    """Whether Newton's method ends the relaxation."""
    descent: int = 0
    """Number of iterations of the solver before the next Newton step."""
    newton_fall: float = 0.0
    """Relative decrease of the energy in the last shortened Newton step, over the iterations that the step counts
    as."""
    stalled: bool = False
    """Whether no Newton step lowers the energy any more."""
    remaining: RemainingChange | None = None
    """Estimate of the remaining change; None if it is unknown."""


def carried_arrays(simulation: YarnSimulation) -> dict[str, wp.array[Any]]:
    """Return all arrays that decide how the iterations continue, by name; candidate lists follow from them."""
    state = simulation.state
    own = {"points": state.points, "listed_points": state.listed_points, "good_points": simulation.good_points}
    if simulation.good_periods is not None:
        own |= {"periods": simulation.model.constants.images.periods, "good_periods": simulation.good_periods}
    if simulation.search.periods is not None:
        own |= {"searched_points": simulation.search.points, "searched_periods": simulation.search.periods}
    carried = {f"solver.{name}": array for name, array in simulation.solver.arrays().items()}
    for number, term in enumerate(simulation.terms):
        carried |= {f"{term.name} {number}.{name}": array for name, array in term.arrays().items()}
    return own | carried


def resume_from_arrays(simulation: YarnSimulation, arrays: Mapping[str, NDArray[Any]], margin: float) -> None:
    """Continue from the arrays of a simulation with the same inputs, with lists of the same margin [units].

    Raises:
        ParameterError: an array is missing or has another shape.
    """
    # arrays of terms may have any shape, because the numbers of contacts change
    shapes = {
        name: array.numpy().shape if "." not in name or name.startswith("solver.") else None
        for name, array in carried_arrays(simulation).items()
    }
    check_arrays(shapes, arrays)
    simulation.candidates.set_margins(margin)
    simulation.search.run_again(arrays.get("searched_points", arrays["listed_points"]), arrays.get("searched_periods"))
    for name, array in carried_arrays(simulation).items():
        if "." not in name or name.startswith("solver."):
            array.assign(arrays[name])
    for number, term in enumerate(simulation.terms):
        term.resume(_part_of(arrays, f"{term.name} {number}."))


def _part_of(arrays: Mapping[str, NDArray[Any]], start: str) -> dict[str, NDArray[Any]]:
    """Return the arrays whose names begin with ``start``, by the rest of their names."""
    return {name.removeprefix(start): array for name, array in arrays.items() if name.startswith(start)}
