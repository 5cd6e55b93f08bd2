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
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.yarnrelax.assessment import Assessments, RemainingChanges
from stitchmesh.yarnrelax.loop_state import carried_arrays
from stitchmesh.yarnrelax.model.cell_entries import CellEntries
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop

OF_PERIODS = {"periods", "good_periods", "searched_periods"}
"""Arrays with a row for each period of a cell."""
OF_CELLS = {"solver.record", "solver.curvature"}
"""Arrays with a row for each cell."""
OF_SLOTS = {"solver.moves", "solver.gradient_change"}
"""Arrays with a column for each control point and strain; all others have a row for each."""
ENERGY = "energy of "
"""Begin of the names of the columns with the energies of the last assessment."""


@dataclass(frozen=True, eq=False)
class CarriedCell:
    """Everything that decides how a cell continues."""

    arrays: Mapping[str, NDArray[Any]]
    """Its part of ``carried_arrays``, by name; of arrays with columns for each entry, the columns as rows."""
    columns: Mapping[str, Any]
    """What the loop and Newton's method remember of it."""

    @property
    def iterations(self) -> int:
        """Number of its iterations."""
        return int(self.columns["iterations"])


def taken_out(loop: RelaxationLoop, cells: NDArray[np.bool_]) -> list[CarriedCell]:
    """Return some cells of a batch, shape (C,), between two intervals."""
    if not cells.any():
        return []
    places = _Places.of(loop, cells)
    arrays = {name: places.divided(name, array.numpy()) for name, array in carried_arrays(loop.simulation).items()}
    columns = {name: list(column[cells]) for name, column in _columns(loop).items()}
    return [
        CarriedCell(dict(zip(arrays, own, strict=True)), dict(zip(columns, values, strict=True)))
        for own, values in zip(zip(*arrays.values(), strict=True), zip(*columns.values(), strict=True), strict=True)
    ]


def put_into(loop: RelaxationLoop, cells: NDArray[np.bool_], carried: Sequence[CarriedCell]) -> None:
    """Continue with some cells, shape (C,), in a loop that has started with all of them."""
    if not cells.any():
        return
    simulation, newton, places = loop.simulation, loop.newton, _Places.of(loop, cells)
    assert newton is not None
    own = carried_arrays(simulation)
    arrays = {name: array.numpy().copy() for name, array in own.items()}
    columns = {name: column.copy() for name, column in _columns(loop).items()}
    for name, array in arrays.items():
        places.put(name, array, [each.arrays[name] for each in carried])
    for name, column in columns.items():
        column[cells] = [each.columns[name] for each in carried]
    simulation.candidates.set_margins(columns["margin"])
    searched = arrays.get("searched_points", arrays["listed_points"])
    simulation.search.run_again(searched, arrays.get("searched_periods"), cells)
    for name, array in arrays.items():
        own[name].assign(array)
    energies = {name.removeprefix(ENERGY): each for name, each in columns.items() if name.startswith(ENERGY)}
    loop.last = Assessments(columns["residual"], energies, columns["rounding"], columns["hidden"])
    loop.remaining = RemainingChanges(*(columns[each.name] for each in fields(RemainingChanges)))
    loop.iterations, loop.lists_age, loop.step_scale = (columns[name] for name in ("iterations", "age", "scale"))
    loop.energy_fall, loop.ending, loop.stalled = (columns[name] for name in ("fall", "ending", "stalled"))
    loop.alternation.descent, loop.alternation.newton_fall = columns["descent"], columns["newton_fall"]
    newton.memory = columns["newton"]
    for number in np.flatnonzero(cells).tolist():
        loop.errors.pop(number, None)


def _columns(loop: RelaxationLoop) -> dict[str, NDArray[Any]]:
    """Return what a loop remembers, each with a row for each cell."""
    assert loop.newton is not None
    last = loop.last
    return {
        "iterations": loop.iterations, "age": loop.lists_age, "margin": loop.simulation.candidates.margins,
        "scale": loop.step_scale, "fall": loop.energy_fall, "ending": loop.ending, "stalled": loop.stalled,
        "descent": loop.alternation.descent, "newton_fall": loop.alternation.newton_fall,
        "newton": loop.newton.memory, "residual": last.residual, "rounding": last.rounding, "hidden": last.hidden,
        **{f"{ENERGY}{name}": values for name, values in last.energies.items()},
        **{each.name: getattr(loop.remaining, each.name) for each in fields(loop.remaining)},
    }  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Places:
    """Where the parts of some cells stand in the arrays of a simulation, one cell after another."""

    cells: NDArray[np.int64]
    """Numbers of the cells, shape (K,)."""
    entries: CellEntries
    """Their control points and strains."""

    @classmethod
    def of(cls, loop: RelaxationLoop, cells: NDArray[np.bool_]) -> _Places:
        assert loop.newton is not None
        return cls(np.flatnonzero(cells), loop.newton.moves.entries_of(cells))

    def divided(self, name: str, array: NDArray[Any]) -> list[NDArray[Any]]:
        """Return a copy of the part of each cell in an array."""
        rows = array.swapaxes(0, 1) if name in OF_SLOTS else array
        return np.split(rows[self._rows(name)], self._starts(name)[1:])

    def put(self, name: str, array: NDArray[Any], parts: Sequence[NDArray[Any]]) -> None:
        """Write the part of each cell into an array."""
        rows = array.swapaxes(0, 1) if name in OF_SLOTS else array
        rows[self._rows(name)] = np.concatenate(parts)

    def _rows(self, name: str) -> NDArray[np.int64]:
        """Return the rows of the cells in an array."""
        if name in OF_PERIODS:
            return np.repeat(2 * self.cells, 2) + np.tile([0, 1], len(self.cells))
        return self.cells if name in OF_CELLS else self.entries.number

    def _starts(self, name: str) -> NDArray[np.int64]:
        """Return the place of the first row of each cell among these rows."""
        each = 2 if name in OF_PERIODS else 1
        return each * np.arange(len(self.cells)) if name in OF_PERIODS | OF_CELLS else self.entries.start
