# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cells that go on in another batch with the same bits.

Everything that decides how a cell continues is taken out of the loop of one batch and put into the loop of another:
its part of the arrays of the simulation (``loop_state.carried_arrays``), its margin, its last assessment, and what the
loop and Newton's method remember of it. Its candidate lists are made again at the place of its last search. The other
batch starts with the same given yarns, so that both have the same units, origins and constants.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.yarnrelax.assessment import Assessment, Assessments, RemainingChange
from stitchmesh.yarnrelax.loop_state import carried_arrays
from stitchmesh.yarnrelax.newton_moves import entries_of
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation

OF_PERIODS = {"periods", "good_periods", "searched_periods"}
"""Arrays with a row for each period of a cell."""
OF_CELLS = {"solver.record", "solver.curvature"}
"""Arrays with a row for each cell."""
OF_SLOTS = {"solver.moves", "solver.gradient_change"}
"""Arrays with a column for each control point and strain; all others have a row for each."""


@dataclass(frozen=True, eq=False)
class CarriedCell:
    """Everything that decides how a cell continues."""

    arrays: Mapping[str, NDArray[Any]]
    """Its part of ``carried_arrays``."""
    columns: Mapping[str, NDArray[Any]]
    """What the loop and Newton's method remember of it."""
    last: Assessment
    """Assessment of its last accepted state."""
    remaining: RemainingChange | None
    """Estimate of the remaining change."""

    @property
    def iterations(self) -> int:
        """Number of its iterations."""
        return int(self.columns["iterations"])


def taken_out(loop: RelaxationLoop, cells: Sequence[int]) -> list[CarriedCell]:
    """Return some cells of a batch between two intervals."""
    arrays = {name: array.numpy() for name, array in carried_arrays(loop.simulation).items()}
    columns = _columns(loop)
    return [
        CarriedCell(
            {name: array[_own(loop.simulation, name, cell)].copy() for name, array in arrays.items()},
            {name: np.array(column[cell]) for name, column in columns.items()}, loop.last[cell], loop.remaining[cell],
        )
        for cell in cells
    ]  # fmt: skip


def put_into(loop: RelaxationLoop, cells: Mapping[int, CarriedCell]) -> None:
    """Continue with some cells, by their numbers, in a loop that has started with all of them."""
    if not cells:
        return
    simulation, newton = loop.simulation, loop.newton
    assert newton is not None
    carried = carried_arrays(simulation)
    arrays = {name: array.numpy().copy() for name, array in carried.items()}
    columns = {name: column.copy() for name, column in _columns(loop).items()}
    chosen, others = np.zeros(len(loop.iterations), dtype=bool), list(loop.last)
    for number, own in cells.items():
        chosen[number], others[number], loop.remaining[number] = True, own.last, own.remaining
        for name, array in arrays.items():
            array[_own(simulation, name, number)] = own.arrays[name]
        for name, column in columns.items():
            column[number] = own.columns[name]
    simulation.candidates.set_margins(columns["margin"])
    places = arrays.get("searched_points", arrays["listed_points"])
    simulation.search.run_again(places, arrays.get("searched_periods"), chosen)
    for name, array in arrays.items():
        carried[name].assign(array)
    loop.last = Assessments.of(others)
    loop.iterations, loop.lists_age, loop.step_scale = (columns[name] for name in ("iterations", "age", "scale"))
    loop.energy_fall, loop.ending, loop.stalled = (columns[name] for name in ("fall", "ending", "stalled"))
    loop.alternation.descent, loop.alternation.newton_fall = columns["descent"], columns["newton_fall"]
    newton.memory = columns["newton"]
    for number in cells:
        loop.errors.pop(number, None)


def _columns(loop: RelaxationLoop) -> dict[str, NDArray[Any]]:
    """Return what a loop remembers, each with a row for each cell."""
    assert loop.newton is not None
    return {
        "iterations": loop.iterations, "age": loop.lists_age, "margin": loop.simulation.candidates.margins,
        "scale": loop.step_scale, "fall": loop.energy_fall, "ending": loop.ending, "stalled": loop.stalled,
        "descent": loop.alternation.descent, "newton_fall": loop.alternation.newton_fall,
        "newton": loop.newton.memory,
    }  # fmt: skip


def _own(simulation: YarnSimulation, name: str, cell: int) -> Any:
    """Return the index of the part of a cell in an array."""
    if name in OF_PERIODS:
        return slice(2 * cell, 2 * cell + 2)
    if name in OF_CELLS:
        return cell
    entries = entries_of(simulation, cell)
    return (slice(None), entries) if name in OF_SLOTS else entries
