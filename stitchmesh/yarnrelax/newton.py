# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Newton's method, which ends a relaxation and judges its end: each step comes from the factors of the exact Hessian.

L-BFGS brings yarns near to rest in cheap iterations, and then creeps along the soft directions of a fabric. The Hessian
H of control points and free strains (``assembled_hessian``) knows these directions. With the forces F, the step is
H^-1 F, from the factors of H (``newton_system``). If H has no negative eigenvalue, the yarns are near a minimum. The
step is then the remaining motion to this minimum, up to its square, and ``convergence`` reads the remaining change of
the spacing from it.

If H has negative eigenvalues, its mixture with the Gauss-Newton matrix replaces it, in all of a cell or in parts of a
garment (``mixture_shares``). A mixture in at most the part ``FEW`` of the segments counts as exact, because so few
segments hardly change the mean of a garment's spacing.

A symmetric fabric can balance at a saddle, from which no force leads away. If a step of the mixture moves no control
point by more than ``BALANCED``, the yarns move along negative directions v_k of H instead (``negative_directions``).
They move by the part of a random vector y that lies in these directions, sum over k of v_k (v_k . y), scaled to
``MOVE`` at the point that moves farthest. If a move does not lower the energy, the next one is shorter, by
``SHORTER``. Below ``SMALLEST_MOVE`` the balance counts as a minimum: the sampled contacts along yarn that slides
through itself cause negative directions without any other effect.

The factors of a step serve for the next ones too, as long as they hold (``newton_moves``): with the forces at its end
they give a step that costs no factorization. If a term lags (``YarnTerm.lags``), a state of rest is renewed and judged
again. The factors of a whole exact step then say well enough whether its end is such a state, because the factors at
its end would differ by a part as small as the step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.compute.cudss import factors_on
from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.assembled_hessian import HessianAssembly
from stitchmesh.yarnrelax.assessment import RemainingChange
from stitchmesh.yarnrelax.collision.step_limit import STRAIN_UNIT
from stitchmesh.yarnrelax.energies.term import Coupling
from stitchmesh.yarnrelax.hessian.cell_matrices import Owners
from stitchmesh.yarnrelax.newton_moves import NewtonMoves, entries_of
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.mixture_shares import MixtureShares
from stitchmesh.yarnrelax.solvers.newton_system import NewtonStep, NewtonSystems
from stitchmesh.yarnrelax.solvers.spacing_change import SpacingChange

BALANCED = 0.01
"""Largest move of a control point by forces at which the cell counts as balanced [radii]."""
MOVE, SMALLEST_MOVE = 0.05, 1e-3
"""First and smallest length of a move away from a balance, at the control point that moves farthest [radii]."""
SHORTER, AGAIN = 0.25, 0.8
"""Factors of that length after a move that has not lowered the energy, and after one that has."""
FEW = 0.01
"""A mixture in at most this part of the segments counts as the exact Hessian."""
NEWTON_RISE = 32.0
"""Rounding explains a rise of the energy in a step up to this, over the precision and the size of the energy."""
SMALLEST_NEWTON_SCALE, MOST_IDLE = 1e-6, 3
"""Below this scale of steps nothing lowers the energy any more; and this number of steps in a row may gain nothing."""
LARGE = 1024
"""A piece without a lattice is large if it has more control points."""
DESCENT, LATE = 0.01, 5e-5
"""Newton's method ends a relaxation below these residuals: in general, and for large pieces. Above the second, dozens
of stitches of a large piece slide (docs/accuracy.md, Garments at rest), and the solver moves them in less time."""
LARGEST_ON_HOST, LARGEST_ON_GPU = 20_000, 1_000_000
"""Control points of the largest pieces whose matrices are factored on the host, and on a GPU."""


class Newton:
    """Newton's method for the cells of a model, or for the only piece."""

    def __init__(self, simulation: YarnSimulation) -> None:
        """Begin without a step or a memory of any cell."""
        self.simulation, model = simulation, simulation.model
        self.model = model
        self.steps: list[NewtonStep | None] = [None] * model.cell_count
        """The step of each cell from its current state; None if it is not known."""
        self.is_late = not model.on_lattice and model.point_count > LARGE
        """Whether the only piece is large, so that the method begins late."""
        self.shares = MixtureShares(model, local=self.is_late)
        """Shares of the Gauss-Newton matrix in the next step."""
        self.away = np.full(model.cell_count, MOVE)
        """Length of the next move away from a balance of each cell [units], shape (C,)."""
        self.leaving = np.zeros(model.cell_count, dtype=bool)
        """Whether the present step of each cell leaves a balance, shape (C,)."""
        self.idle = np.zeros(model.cell_count)
        """Number of steps in a row that gained nothing, for each cell, shape (C,)."""
        self.gains_nothing = np.zeros(model.cell_count, dtype=bool)
        """Whether the present step of each cell is exact and tiny, and its work is less than rounding, shape (C,)."""
        self._assembly = HessianAssembly(simulation)
        self._spacing: dict[int, SpacingChange] = {}
        self.judges_twice = any(term.lags for term in simulation.yarn_terms)
        """Whether states of rest are renewed and judged again."""
        self.moves = NewtonMoves(simulation)
        """The present move of each cell along its step."""
        self._kept: list[NewtonSystems | None] = [None] * model.cell_count
        """The systems of the last step of each cell."""

    @property
    def descent(self) -> float:
        """The residual below which the method ends a relaxation."""
        return LATE if self.is_late else DESCENT

    @property
    def memory(self) -> NDArray[np.float64]:
        """The values of each cell that persist between steps: its shares, ``away`` and ``idle``, shape (C, 4)."""
        return np.column_stack([self.shares.largest, self.shares.sufficient, self.away, self.idle])

    @memory.setter
    def memory(self, table: NDArray[np.float64]) -> None:
        largest, self.shares.sufficient, self.away, self.idle = table.T.copy()
        self.shares.set_largest(largest)

    def find_steps(self, cells: NDArray[np.bool_], balanced: NDArray[np.bool_], size: NDArray[np.float64]) -> None:
        """Find the steps of some cells; their candidate lists must be up to date.

        Args:
            cells: the cells, shape (C,).
            balanced: whether the forces on each cell balance as well as they must at rest, shape (C,).
            size: sum of the magnitudes of the energies of each cell [erg], shape (C,).
        """
        if not cells.any():
            return
        self._find_forces(cells)
        left, saddles, systems = cells.copy(), np.zeros_like(cells), self._systems(cells)
        exact = systems
        while True:
            for cell, step in self._steps(systems, left, exact, saddles).items():
                self._kept[cell] = None if saddles[cell] else systems
                self.steps[cell], left[cell] = step, step is None
                self.leaving[cell] = step is not None and step.leaves_balance
                gains_nothing = step is not None and step.exact and abs(step.work) <= self._rounding(size[cell])
                is_tiny = step is not None and np.linalg.norm(step.motion, axis=1).max() < SMALLEST_MOVE
                self.gains_nothing[cell] = gains_nothing and is_tiny
                if step is not None and step.leaves_balance:
                    self.shares.clear(cell)
                elif step is not None:
                    self.shares.shrink(cell)
                else:
                    saddles[cell] |= balanced[cell] and self.shares.is_exact(cell)
                    self._grow_shares(systems, cell)
            if not left.any():
                return
            systems = self._systems(left)

    def _grow_shares(self, systems: NewtonSystems, cell: int) -> None:
        """Take a larger share of the Gauss-Newton matrix in a cell whose matrix has negative eigenvalues."""
        if not self.shares.local:  # The shares of a batch do not need the places of thousands of cells.
            self.shares.grow(cell)
            return
        points = self.simulation.state.points.numpy()[: self.model.point_count].astype(np.float64)
        self.shares.grow(cell, systems.factors.negative_pivots, points)

    def _find_forces(self, cells: NDArray[np.bool_]) -> None:
        """Find the forces on the control points and the strains of some cells."""
        simulation, strain = self.simulation, self.simulation.strain

        def launches() -> list[Any]:
            """Return the launches of the forces on the points, and then on the strains."""
            further = [] if strain is None else strain.force_launches(
                simulation.state, simulation.candidates, self.model.prepare
            )  # fmt: skip
            return simulation.balance_launches() + further

        with self.model.only_in(cells):
            simulation.captured("forces", launches).launch()

    def _steps(
        self, systems: NewtonSystems, cells: NDArray[np.bool_], exact: NewtonSystems, saddles: NDArray[np.bool_]
    ) -> dict[int, NewtonStep | None]:
        """Return the steps of some cells with their present shares; None if the matrix has negative eigenvalues.

        Args:
            systems: the systems with the present shares.
            cells: the cells, shape (C,).
            exact: the systems with the exact Hessians.
            saddles: whether the exact Hessian of each balanced cell has negative eigenvalues, shape (C,).
        """
        solved = cells & ((systems.negative_count == 0) | (self.shares.least >= 1.0))
        is_exact = self.shares.part <= FEW
        found = systems.steps(solved, is_exact)
        steps: dict[int, NewtonStep | None] = dict.fromkeys(np.flatnonzero(cells).tolist())
        balanced = np.zeros_like(cells)
        for cell in np.flatnonzero(solved).tolist():
            steps[cell] = step = found.of(cell, entries_of(self.simulation, cell), exact=bool(is_exact[cell]))
            balanced[cell] = saddles[cell] and np.linalg.norm(step.motion, axis=1).max() < BALANCED
        if balanced.any():
            steps |= self._steps_at_balance(exact, balanced, steps)
        return steps

    def _steps_at_balance(
        self, exact: NewtonSystems, cells: NDArray[np.bool_], steps: Mapping[int, NewtonStep | None]
    ) -> dict[int, NewtonStep]:
        """Return the steps of cells that balance at a saddle, from the exact Hessians and the steps by forces."""
        is_minimum, found = cells & (self.away < SMALLEST_MOVE), dict[int, NewtonStep]()
        leaving = np.flatnonzero(cells & ~is_minimum).tolist()
        for cell, motion in exact.ways_down({cell: float(self.away[cell]) for cell in leaving}).items():
            step = steps[cell]
            assert step is not None
            found[cell] = replace(step, motion=motion[entries_of(self.simulation, cell)], leaves_balance=True)
        if is_minimum.any():
            last = exact.without_negative_eigenvalues(is_minimum).steps(is_minimum, is_minimum)
            for cell in np.flatnonzero(is_minimum).tolist():
                found[cell] = last.of(cell, entries_of(self.simulation, cell), exact=True)
        return found

    def _systems(self, cells: NDArray[np.bool_]) -> NewtonSystems:
        """Return the systems of some cells with their present shares."""
        with self.model.only_in(cells):
            matrices = self._assembly.cell_matrices(
                1.0 - self.shares.of_segments, self._owners(cells), self._couplings(), forces_are_found=True
            )
        return NewtonSystems(matrices, self._forces(matrices.owners))

    def _forces(self, owners: Owners) -> FloatArray:
        """Return the forces on the coordinates of some cells [erg / unit], zero at all others, shape (n,)."""
        force = self.simulation.state.force.numpy().astype(np.float64).ravel()[: len(owners.cell)]
        return np.where(owners.cell >= 0, force, 0.0)

    def forget(self, cells: NDArray[np.bool_]) -> None:
        """Begin anew with some cells, shape (C,), because their loads have changed."""
        self.shares.set_largest(np.where(cells, 0.0, self.shares.largest))
        self.away[cells], self.idle[cells] = MOVE, 0

    def count_idle(self, cells: NDArray[np.bool_], at_rest: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Count the steps that gain nothing in some cells not at rest; return which cells have made too many."""
        self.idle[cells] = np.where(self.gains_nothing & ~at_rest, self.idle + 1, 0)[cells]
        return cells & (self.idle >= MOST_IDLE)

    def note_moves(self, lowered: NDArray[np.bool_]) -> None:
        """Shorten the next moves of cells that have left a balance; ``lowered`` says whose energy fell, shape (C,)."""
        self.away[self.leaving] *= np.where(lowered, AGAIN, SHORTER)[self.leaving]
        self.leaving[:], self.gains_nothing[:] = False, False

    def allowed_rise(self, size: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how much the energy of each cell may rise in its step [erg], shape (C,).

        A move away from a balance must lower the energy. ``size`` is the sum of the magnitudes of the energies [erg].
        """
        return np.where(self.leaving, 0.0, self._rounding(size))

    def _rounding(self, size: Any) -> Any:
        """Return the rounding of energies whose magnitudes have the sum ``size`` [erg]."""
        return NEWTON_RISE * self.simulation.precision * size

    def distrust(self, cells: NDArray[np.bool_]) -> None:
        """Take a larger share of the Gauss-Newton matrix next in some cells, because their last steps were refused."""
        self.shares.distrust(cells & ~self.leaving)

    def move(self, cells: NDArray[np.bool_], step_scale: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Move some cells along their steps, no further than the limits of moves times a scale, shape (C,).

        Returns:
            Whether the step of each cell was shortened, or is the step of a mixture in a large piece, shape (C,).
        """
        shortened, budget = np.zeros(len(cells), dtype=bool), self.simulation.state.budget.numpy().astype(np.float64)
        for cell in np.flatnonzero(cells).tolist():
            step, self.steps[cell] = self.steps[cell], None
            assert step is not None
            part = self.moves.begin(cell, step, float(step_scale[cell]), budget)
            shortened[cell] = part < 1.0 or (self.is_late and not step.exact)
        self.moves.displace(cells)
        return shortened

    def find_steps_by_kept_factors(self, cells: NDArray[np.bool_]) -> None:
        """Find the next steps of some cells by their last factors; there are none after a step away from a balance."""
        self._find_forces(cells)
        left = cells & np.array([kept is not None for kept in self._kept])
        while left.any():
            systems = self._kept[int(np.flatnonzero(left)[0])]
            assert systems is not None
            own = left & np.array([kept is systems for kept in self._kept])
            found = systems.steps_by(self._forces(systems.matrices.owners), own)
            for cell in np.flatnonzero(own).tolist():
                last = self.moves.of[cell]
                assert last is not None
                self.steps[cell] = found.of(cell, entries_of(self.simulation, cell), exact=last.step.exact)
            left &= ~own

    def made_whole_steps(self) -> NDArray[np.bool_]:
        """Whether the last move of each cell was its whole step, shape (C,)."""
        return np.array([move is not None and move.part == 1.0 for move in self.moves.of])

    def forget_steps(self) -> None:
        """Forget the steps that were found but not taken, and the factors of the last ones."""
        count = self.model.cell_count
        self.steps, self._kept = [None] * count, [None] * count

    def factors_hold(self, cells: NDArray[np.bool_], fall: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether the factors of the last steps of some cells serve for the next ones, shape (C,).

        Args:
            cells: the cells, whose next steps were found by these factors.
            fall: decrease of their energies in the last moves [erg], shape (C,).
        """
        found = cells.copy()
        for cell in np.flatnonzero(cells).tolist():
            last, step = self.moves.of[cell], self.steps[cell]
            found[cell] = last is not None and step is not None and last.leads_on(step, float(fall[cell]))
        return found

    def remaining_change(self, cell: int, size: float) -> RemainingChange | None:
        """Return the estimate of the remaining change of a cell; None if its last step was not exact.

        Args:
            cell: the cell.
            size: sum of the magnitudes of its energies [erg].
        """
        step = self.steps[cell]
        if step is None or not step.exact:
            return None
        count = int(self.model.point_start[cell + 1] - self.model.point_start[cell])
        moved = step.motion[:count]
        rms = float(np.sqrt((moved**2).sum() / count))
        energy = 0.5 * step.work / size if size > 0.0 else 0.0
        if self.simulation.strain is not None:
            spacing = float(np.abs(step.motion[-1]).max() / float(STRAIN_UNIT))
        else:
            own = slice(*self.model.point_start[cell : cell + 2])
            if cell not in self._spacing:
                self._spacing[cell] = SpacingChange(self.model.cells[cell].yarns, self.model.device)
            spacing = self._spacing[cell].of(self.simulation.state.points[own], moved)
        return RemainingChange(spacing, energy, rms)

    def _couplings(self) -> list[Coupling]:
        """Return the couplings of many coordinates of the only piece."""
        found = [term.coupling(self.simulation.state) for term in self.simulation.yarn_terms]
        return [own for own in found if own is not None] + [each.coupling() for each in self.simulation.constraints]

    def _owners(self, cells: NDArray[np.bool_]) -> Owners:
        """Return the coordinates of some cells that may change: of their control points, and then of their strains."""
        numbers = np.where(cells, np.arange(len(cells)), -1).astype(np.int32)
        owner = np.repeat(numbers, 3 * np.diff(self.model.point_start))
        if self.simulation.strain is not None:
            free = self.simulation.strain.host_free > 0.0
            owner = np.append(owner, np.where(free, numbers[:, None], np.int32(-1)))
        return Owners(owner, len(cells))


def newton_of(simulation: YarnSimulation) -> Newton | None:
    """Return Newton's method if it can end the relaxation of these yarns; all terms must give their Hessians.

    It cannot end the relaxation of open yarns if no term keeps the stitches in their places: only friction holds their
    ends, and at rest such a piece has unravelled. It also cannot end it for a large piece in which friction moves the
    state of rest, or for a piece that is too large to be factored.
    """
    model, terms = simulation.model, simulation.yarn_terms
    if not simulation.is_quasistatic or not all(term.gives_hessian for term in simulation.terms):
        return None
    held = bool(model.yarns.closed.all()) or any(term.keeps_stitches for term in terms)
    largest = LARGEST_ON_GPU if factors_on(model.device) else LARGEST_ON_HOST
    suits = held and (model.point_count <= LARGE or not any(term.lags for term in terms))
    return Newton(simulation) if model.on_lattice or (suits and model.point_count <= largest) else None
