# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cells on their way to rest that go from one batch to another.

A batch ends when its first cells can go on to other work. Cells that are not at rest then continue in the next batch,
with cells that begin there. The solver starts anew with them, as it does after new candidate lists. The memory of
Newton's method, and of its alternation with the solver, goes with the cell.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.io.history import HistoryEntry
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.solvers.lbfgs import LBFGS


@dataclass(frozen=True, eq=False)
class BegunCell:
    """A cell between two batches."""

    yarns: YarnSet
    """The yarns in their last accepted state."""
    height: float | None
    """Height of the middle plane of the given yarns, between the planes [cm]; None without planes."""
    learned: Mapping[str, NDArray[Any]]
    """What the solvers have learned about the cell (``learned_by``)."""
    history: Sequence[HistoryEntry]
    """The figures of each assessment."""
    seconds: float
    """Time that the cell has spent in batches [s]."""


def learned_by(loop: RelaxationLoop) -> list[dict[str, NDArray[Any]]]:
    """Return what the solvers have learned about each cell of a batch, for ``teach``.

    This includes the counts and gradients of each cell, because a relaxation reports them.
    """
    newton = loop.newton
    solver = loop.simulation.solver
    assert newton is not None and isinstance(solver, LBFGS)
    columns = {
        "iterations": loop.iterations, "ending": loop.ending, "descent": loop.alternation.descent,
        "newton_fall": loop.alternation.newton_fall, "newton": newton.memory, "gradients": solver.recorded_gradients(),
    }  # fmt: skip
    return [{name: np.array(column[cell]) for name, column in columns.items()} for cell in range(len(loop.iterations))]


def teach(loop: RelaxationLoop, cells: Sequence[Mapping[str, NDArray[Any]] | None]) -> None:
    """Continue with what the solvers have learned about cells (``learned_by``); None for cells that begin."""
    known = [(number, own) for number, own in enumerate(cells) if own is not None]
    if not known:
        return
    newton = loop.newton
    solver = loop.simulation.solver
    assert newton is not None and isinstance(solver, LBFGS)
    numbers = np.array([number for number, _own in known])

    def column(name: str) -> NDArray[Any]:
        return np.array([learned[name] for _number, learned in known])

    memory = newton.memory
    memory[numbers] = column("newton")
    newton.memory = memory
    loop.iterations[numbers] = column("iterations")
    loop.ending[numbers] = column("ending")
    loop.alternation.descent[numbers] = column("descent")
    loop.alternation.newton_fall[numbers] = column("newton_fall")
    solver.record_gradients(numbers, column("gradients"))
