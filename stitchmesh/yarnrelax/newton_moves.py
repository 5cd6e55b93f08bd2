# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Moves of cells along their Newton steps: as far as no yarn passes through another, and as far as the energy falls.

All moves of a cell are shortened by one factor, so that no control point moves farther than ``Quality.step_fraction``,
and the step limit holds at each point. Points with less room than ``SHORTEST_LIMIT`` are shortened alone.
Longer moves would find other states of rest. For example, the floats of a chart of three colours have two states of
rest; a cell with such floats ends in the one nearest to the state in which it was knitted.

A move is a part p of its step. If w is the work of the forces at its beginning in the whole step, the quadratic model
of the energy falls by w p (1 - p / 2). If the energy does not fall by ``ENOUGH`` of that, but rises by r, the parabola
with the slope -w p and the end r has its minimum at the part

    w p / (2 (w p + r))        within ``LESS``

of the move, which is tried next. Otherwise contacts that open and close would let whole steps go back and forth.

The factors of a step serve for the next one too in two cases. First, if the next step is at most ``CONTRACTION`` times
as long as the last move, so that the steps converge. Second, if the last move was a part of its step, and the energy
fell by ``AS_SAID`` of the fall of the model: then the model holds, and only the limits ended the move.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.collision.step_limit import STRAIN_UNIT
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.newton_system import NewtonStep

SHORTEST_LIMIT = 0.05
"""If the limit of a control point is below this, in mean radii times the scale of the limits, its move is shortened by
itself and does not shorten the whole step."""
ENOUGH = 0.2
"""The energy must fall by this part of the fall of the model, up to rounding."""
LESS = 0.1, 0.5
"""Least and largest part of a move that is tried next if the energy does not fall enough."""
CONTRACTION, AS_SAID = 0.5, 0.5
"""Conditions for factors to serve again: the length of the next step over the length of the last move, and the fall of
the energy over the fall of the model."""


@dataclass(frozen=True, eq=False)
class Move:
    """The move of a cell along a part of its step."""

    step: NewtonStep
    motion: FloatArray
    """Motion of the control points, and then of the strains [units], shape (n, 3)."""
    part: float
    """The part of the step that the move takes."""

    @property
    def said(self) -> float:
        """Fall of the energy by the quadratic model [erg]; 0 for a move away from a balance, of which it is unknown."""
        return 0.0 if self.step.leaves_balance else self.step.work * self.part * (1.0 - 0.5 * self.part)

    def less(self, rise: float) -> Move:
        """Return the part of this move to try next if the energy rises by ``rise`` [erg], or does not fall enough."""
        work = self.part * self.step.work
        factor = float(np.clip(0.5 * work / (work + rise), *LESS)) if work + rise > 0.0 else LESS[0]
        return replace(self, motion=factor * self.motion, part=factor * self.part)

    def leads_on(self, step: NewtonStep, fall: float) -> bool:
        """Whether the factors of this move serve for the next step, if the energy fell in it by ``fall`` [erg]."""
        is_short = bool(np.abs(step.motion).max() < CONTRACTION * np.abs(self.motion).max())
        return is_short or (self.part < 1.0 and fall > AS_SAID * self.said)


class NewtonMoves:
    """The present moves of the cells of a simulation."""

    def __init__(self, simulation: YarnSimulation) -> None:
        """Begin without a move of any cell."""
        self.simulation = simulation
        self.of: list[Move | None] = [None] * simulation.model.cell_count
        """The last move of each cell."""

    def begin(self, cell: int, step: NewtonStep, scale: float, budget: FloatArray) -> float:
        """Plan the move of a cell along its step; return the part of the step that the move takes.

        Args:
            cell: the cell.
            step: its step.
            scale: factor of the largest move.
            budget: the step budgets of all entries [units], shape (E,).
        """
        limit = np.minimum(self.simulation.step_fraction * scale, budget[entries_of(self.simulation, cell)])
        motion, part = shortened_motion(step.motion, limit, SHORTEST_LIMIT * scale)
        self.of[cell] = Move(step, motion, part)
        return part

    def begin_less(self, cell: int, rise: float) -> None:
        """Plan a shorter move of a cell, whose energy has risen in the last one [erg]."""
        last = self.of[cell]
        assert last is not None
        self.of[cell] = last.less(rise)

    def enough(self, cells: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Return how much the energies of some cells must fall in their moves, up to rounding [erg], shape (C,)."""
        found = np.zeros(len(cells))
        for cell in np.flatnonzero(cells).tolist():
            move = self.of[cell]
            found[cell] = 0.0 if move is None else max(ENOUGH * move.said, 0.0)
        return found

    def displace(self, cells: NDArray[np.bool_]) -> None:
        """Displace some cells by their moves."""
        simulation, strain = self.simulation, self.simulation.strain
        points = simulation.state.points.numpy().astype(np.float64)
        moves = np.zeros_like(points)
        for cell in np.flatnonzero(cells).tolist():
            move = self.of[cell]
            assert move is not None
            moves[entries_of(simulation, cell)] = move.motion
        points += self._constrained(moves)
        if strain is not None:
            periods, model = strain.periods.numpy().astype(np.float64).reshape(-1, 2, 3), simulation.model
            for cell in np.flatnonzero(cells).tolist():
                own = slice(*model.point_start[cell : cell + 2])
                matrix = deformation(strain.host_frame[cell], moves[model.point_count + cell] / float(STRAIN_UNIT))
                points[own], periods[cell] = points[own] @ matrix, periods[cell] @ matrix
            strain.periods.assign(periods.reshape(-1, 3))
            simulation.candidates.near.invalidate(cells)
        simulation.state.points.assign(points)

    def _constrained(self, moves: FloatArray) -> FloatArray:
        """Return the moves of all entries after the constraints have changed them."""
        simulation = self.simulation
        if not simulation.constraints:
            return moves
        model = simulation.model
        step, limit = model.upload(moves, 3), wp.clone(simulation.state.budget)
        launches = []
        for constraint in simulation.constraints:
            launches += constraint.filter_steps(simulation.state, step, limit, model.prepare)
        CapturedLaunches(launches, model.device).launch()
        return np.asarray(step.numpy().astype(np.float64))


def entries_of(simulation: YarnSimulation, cell: int) -> NDArray[np.int64]:
    """Return the numbers of the control points of a cell, and of its strain if cells relax."""
    own = np.arange(*simulation.model.point_start[cell : cell + 2])
    return own if simulation.strain is None else np.append(own, simulation.model.point_count + cell)


def shortened_motion(motion: FloatArray, limit: FloatArray, shortest: float) -> tuple[FloatArray, float]:
    """Return the motion of a cell, shortened by one factor to the limits of its moves, and this factor.

    Args:
        motion: the motion, shape (n, 3).
        limit: largest move of each entry, shape (n,).
        shortest: an entry with a limit below this is shortened by itself.
    """
    length = np.linalg.norm(motion, axis=1)
    factor = min(1.0, 1.0 / max(float((length / np.maximum(limit, shortest)).max()), 1e-30))
    own = np.minimum(1.0, limit / np.maximum(factor * length, 1e-30))
    return motion * (factor * own)[:, None], factor


def deformation(frame: FloatArray, strain: FloatArray) -> FloatArray:
    """Return the matrix (3, 3) by which a strain (a, b, c), in a frame of directions (2, 3), deforms row vectors."""
    e1, e2 = frame
    return np.asarray(
        np.eye(3) + strain[0] * np.outer(e1, e1) + strain[1] * np.outer(e2, e2) + strain[2] * np.outer(e2, e1)
    )
