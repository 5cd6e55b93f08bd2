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

from dataclasses import dataclass

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.collision.step_limit import STRAIN_UNIT
from stitchmesh.yarnrelax.model.cell_entries import CellEntries
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.newton_system import NewtonSteps

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
class Moves:
    """The last moves of the cells along parts of their steps."""

    steps: NewtonSteps
    """The steps; those of cells that have not moved are not known."""
    motion: FloatArray
    """Motion of the control points, and then of the strains [units], shape (E, 3)."""
    part: FloatArray
    """The part of its step that the move of each cell takes, shape (C,)."""

    @property
    def said(self) -> FloatArray:
        """Fall of each energy by the quadratic model [erg], shape (C,).

        It is 0 for a move away from a balance, of which it is unknown.
        """
        fall = self.steps.work * self.part * (1.0 - 0.5 * self.part)
        return np.where(self.steps.leaves_balance, 0.0, fall)

    @property
    def are_whole(self) -> NDArray[np.bool_]:
        """Whether the last move of each cell was its whole step, shape (C,)."""
        return self.steps.known & (self.part == 1.0)

    def replaced(self, own: CellEntries, steps: NewtonSteps, motion: FloatArray, part: FloatArray) -> Moves:
        """Return these moves, with others of the cells of some entries: their motion (M, 3) and parts (K,)."""
        moved, parts = self.motion.copy(), self.part.copy()
        moved[own.number], parts[own.cells] = motion, part
        return Moves(self.steps.replaced(own, steps), moved, parts)

    def less(self, own: CellEntries, rise: FloatArray) -> Moves:
        """Return the parts of moves to try next if energies rise, or do not fall enough.

        Args:
            own: the entries of the cells that move less.
            rise: rise of the energy of each cell [erg], shape (C,).
        """
        work = (self.part * self.steps.work)[own.cells]
        bent = work + rise[own.cells]
        best = np.divide(0.5 * work, bent, out=np.full(len(work), LESS[0]), where=bent > 0.0)
        factor = np.clip(best, *LESS)
        motion = factor[own.cell, None] * self.motion[own.number]
        return self.replaced(own, self.steps, motion, factor * self.part[own.cells])

    def lead_on(self, own: CellEntries, steps: NewtonSteps, fall: FloatArray) -> NDArray[np.bool_]:
        """Whether the factors of the moves of some cells serve for their next steps, shape (K,).

        Args:
            own: the entries of the cells.
            steps: the next steps.
            fall: fall of each energy in the last moves [erg], shape (C,).
        """
        longest, last = (own.largest(np.abs(motion[own.number]).max(axis=1)) for motion in (steps.motion, self.motion))
        as_said = (self.part < 1.0) & (fall > AS_SAID * self.said)
        are_known = self.steps.known & steps.known
        return are_known[own.cells] & ((longest < CONTRACTION * last) | as_said[own.cells])


class NewtonMoves:
    """The present moves of the cells of a simulation."""

    def __init__(self, simulation: YarnSimulation) -> None:
        """Begin without a move of any cell."""
        self.simulation = simulation
        cells, entries = simulation.model.cell_count, simulation.model.point_count
        entries += 0 if simulation.strain is None else cells
        self.last = Moves(NewtonSteps.unknown(entries, cells), np.zeros((entries, 3)), np.zeros(cells))
        """The last move of each cell."""

    def entries_of(self, cells: NDArray[np.bool_]) -> CellEntries:
        """Return the entries of some cells, shape (C,)."""
        return CellEntries.of(self.simulation.model, cells, relaxes=self.simulation.strain is not None)

    def begin(self, cells: NDArray[np.bool_], steps: NewtonSteps, scale: FloatArray) -> FloatArray:
        """Plan the moves of some cells along their steps; return the part of its step that each move takes, shape (C,).

        Args:
            cells: the cells, shape (C,).
            steps: their steps.
            scale: factor of the largest move of each cell, shape (C,).
        """
        own, budget = self.entries_of(cells), self.simulation.state.budget.numpy().astype(np.float64)
        scales = scale[own.cells]
        limit = np.minimum((self.simulation.step_fraction * scales)[own.cell], budget[own.number])
        motion, part = shortened_motions(steps.motion[own.number], limit, SHORTEST_LIMIT * scales, own)
        self.last = self.last.replaced(own, steps, motion, part)
        return self.last.part

    def begin_less(self, cells: NDArray[np.bool_], rise: FloatArray) -> None:
        """Plan shorter moves of some cells, whose energies have risen in the last ones [erg], both of shape (C,)."""
        self.last = self.last.less(self.entries_of(cells), rise)

    def enough(self, cells: NDArray[np.bool_]) -> FloatArray:
        """Return how much the energies of some cells must fall in their moves, up to rounding [erg], shape (C,)."""
        return np.where(cells & self.last.steps.known, np.maximum(ENOUGH * self.last.said, 0.0), 0.0)

    def displace(self, cells: NDArray[np.bool_]) -> None:
        """Displace some cells by their moves."""
        simulation, strain, own = self.simulation, self.simulation.strain, self.entries_of(cells)
        points = simulation.state.points.numpy().astype(np.float64)
        moved = points[own.number] + self._constrained(own)
        if strain is not None:
            changes = self.last.motion[own.strains] / float(STRAIN_UNIT)
            matrices = deformations(strain.host_frame[own.cells], changes)
            places, by = moved[own.is_point], matrices[own.cell[own.is_point]]
            moved[own.is_point] = sum(places[:, axis, None] * by[:, axis] for axis in range(3))
            periods = strain.periods.numpy().astype(np.float64).reshape(-1, 2, 3)
            periods[own.cells] = periods[own.cells] @ matrices
            strain.periods.assign(periods.reshape(-1, 3))
            simulation.candidates.near.invalidate(cells)
        points[own.number] = moved
        simulation.state.points.assign(points)

    def _constrained(self, own: CellEntries) -> FloatArray:
        """Return the moves of some entries after the constraints have changed them, shape (M, 3)."""
        simulation, model, motion = self.simulation, self.simulation.model, self.last.motion[own.number]
        if not simulation.constraints:
            return motion
        moves = np.zeros((len(simulation.state.points), 3))
        moves[own.number] = motion
        step, limit = model.upload(moves, 3), wp.clone(simulation.state.budget)
        launches = []
        for constraint in simulation.constraints:
            launches += constraint.filter_steps(simulation.state, step, limit, model.prepare)
        CapturedLaunches(launches, model.device).launch()
        return np.asarray(step.numpy().astype(np.float64)[own.number])


def shortened_motions(
    motion: FloatArray, limit: FloatArray, shortest: FloatArray, own: CellEntries
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Return the motions of cells, each shortened by one factor to the limits of its moves, and these factors.

    Args:
        motion: the motions, shape (M, 3).
        limit: largest move of each entry, shape (M,).
        shortest: an entry of a cell with a limit below this is shortened by itself, shape (K,).
        own: the entries.
    """
    length = np.linalg.norm(motion, axis=1)
    ratio = own.largest(length / np.maximum(limit, shortest[own.cell]))
    factor = np.minimum(1.0, 1.0 / np.maximum(ratio, 1e-30))
    each = factor[own.cell]
    by_itself = np.minimum(1.0, limit / np.maximum(each * length, 1e-30))
    return motion * (each * by_itself)[:, None], factor


def deformations(frames: FloatArray, strains: FloatArray) -> FloatArray:
    """Return the matrices by which strains (a, b, c) deform row vectors, shape (K, 3, 3).

    Args:
        frames: directions of each cell, shape (K, 2, 3).
        strains: the strains in these frames, shape (K, 3).
    """
    e1, e2 = frames[:, 0], frames[:, 1]
    outer = e1[:, :, None] * e1[:, None], e2[:, :, None] * e2[:, None], e2[:, :, None] * e1[:, None]
    found = np.eye(3)
    for number, own in enumerate(outer):
        found = found + strains[:, number, None, None] * own
    return np.asarray(found)
