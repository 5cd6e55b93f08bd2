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

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.compute.cudss import factors_on
from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.assembled_hessian import HessianAssembly
from stitchmesh.yarnrelax.assessment import RemainingChanges
from stitchmesh.yarnrelax.collision.step_limit import STRAIN_UNIT
from stitchmesh.yarnrelax.energies.term import Coupling
from stitchmesh.yarnrelax.hessian.cell_matrices import Owners
from stitchmesh.yarnrelax.model.cell_entries import CellEntries
from stitchmesh.yarnrelax.newton_moves import NewtonMoves
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.mixture_shares import MixtureShares
from stitchmesh.yarnrelax.solvers.newton_system import NewtonSteps, NewtonSystems
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
        self.steps = self.moves.last.steps
        """The step of each cell from its current state, if it is known."""
        self._kept: list[tuple[NewtonSystems, NDArray[np.bool_]]] = []
        """The systems of the last steps, with the cells whose steps came from them, shape (C,)."""

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
        self.steps, left, saddles = self.steps.forgotten(cells), cells, np.zeros_like(cells)
        exact = systems = self._systems(cells)
        while True:
            found = self._steps(systems, left, exact, saddles)
            self._take(found, size)
            self._kept.append((systems, found.known & ~saddles))
            left = left & ~found.known
            if not left.any():
                return
            saddles |= left & balanced & self.shares.is_exact
            self._grow_shares(systems, left)
            systems = self._systems(left)

    def _take(self, found: NewtonSteps, size: NDArray[np.float64]) -> None:
        """Take the steps that were found, and choose the shares of the next steps of their cells."""
        own = self.moves.entries_of(found.known)
        self.steps = self.steps.replaced(own, found)
        self.leaving = np.where(found.known, found.leaves_balance, self.leaving)
        is_tiny = np.zeros_like(found.known)
        is_tiny[own.cells] = _farthest(found, own) < SMALLEST_MOVE
        gains_nothing = found.exact & (np.abs(found.work) <= self._rounding(size)) & is_tiny
        self.gains_nothing = np.where(found.known, gains_nothing, self.gains_nothing)
        self.shares.clear(found.known & found.leaves_balance)
        self.shares.shrink(found.known & ~found.leaves_balance)

    def _grow_shares(self, systems: NewtonSystems, cells: NDArray[np.bool_]) -> None:
        """Take larger shares of the Gauss-Newton matrix in some cells, whose matrices have negative eigenvalues."""
        if self.shares.local:
            points = self.simulation.state.points.numpy()[: self.model.point_count].astype(np.float64)
            self.shares.grow_near(systems.factors.negative_pivots, points)
        else:
            self.shares.grow(cells)

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
    ) -> NewtonSteps:
        """Return the steps of those of some cells whose matrices have no negative eigenvalues.

        Args:
            systems: the systems with the present shares.
            cells: the cells, shape (C,).
            exact: the systems with the exact Hessians.
            saddles: whether the exact Hessian of each balanced cell has negative eigenvalues, shape (C,).
        """
        solved = cells & ((systems.negative_count == 0) | (self.shares.least >= 1.0))
        found = systems.steps(solved, self.shares.part <= FEW)
        own = self.moves.entries_of(solved & saddles)
        balanced = own.cells[_farthest(found, own) < BALANCED]
        if not len(balanced):
            return found
        return self._steps_at_balance(exact, np.isin(np.arange(len(cells)), balanced), found)

    def _steps_at_balance(
        self, exact: NewtonSystems, cells: NDArray[np.bool_], steps: NewtonSteps
    ) -> NewtonSteps:  # fmt: skip
        """Return the steps of cells that balance at a saddle, from the exact Hessians and the steps by forces."""
        is_minimum = cells & (self.away < SMALLEST_MOVE)
        leaving = cells & ~is_minimum
        down = replace(steps, motion=exact.ways_down(leaving, self.away), leaves_balance=leaving)
        found = steps.replaced(self.moves.entries_of(leaving), down)
        if is_minimum.any():
            last = exact.without_negative_eigenvalues(is_minimum).steps(is_minimum, is_minimum)
            found = found.replaced(self.moves.entries_of(is_minimum), last)
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
        part = self.moves.begin(cells, self.steps, step_scale)
        shortened = cells & ((part < 1.0) | (self.is_late & ~self.steps.exact))
        self.steps = self.steps.forgotten(cells)
        self.moves.displace(cells)
        return shortened

    def find_steps_by_kept_factors(self, cells: NDArray[np.bool_]) -> None:
        """Find the next steps of some cells by their last factors; there are none after a step away from a balance."""
        self._find_forces(cells)
        for systems, served in self._kept:
            if (chosen := cells & served).any():
                found = systems.steps_by(self._forces(systems.matrices.owners), chosen, self.moves.last.steps.exact)
                self.steps = self.steps.replaced(self.moves.entries_of(chosen), found)

    def forget_steps(self) -> None:
        """Forget the steps that were found but not taken, and the factors of the last ones."""
        self.steps, self._kept = self.steps.forgotten(self.steps.known), []

    def factors_hold(self, cells: NDArray[np.bool_], fall: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether the factors of the last steps of some cells serve for the next ones, shape (C,).

        Args:
            cells: the cells, whose next steps were found by these factors.
            fall: decrease of their energies in the last moves [erg], shape (C,).
        """
        found, own = np.zeros_like(cells), self.moves.entries_of(cells)
        found[own.cells] = self.moves.last.lead_on(own, self.steps, fall)
        return found

    def remaining_changes(self, cells: NDArray[np.bool_], size: NDArray[np.float64]) -> RemainingChanges:
        """Return the estimates of the remaining changes of some cells; unknown where the step is not exact.

        Args:
            cells: the cells, shape (C,).
            size: sum of the magnitudes of the energies of each cell [erg], shape (C,).
        """
        judged = cells & self.steps.known & self.steps.exact
        found, own = RemainingChanges.unknown(len(cells)), self.moves.entries_of(judged)
        motion, counts = self.steps.motion[own.number], own.points
        squares = np.where(own.is_point[:, None], motion**2, 0.0).sum(axis=1)
        found.rms_radii[judged] = np.sqrt(own.sums(squares) / counts)
        work = 0.5 * self.steps.work[judged]
        found.energy[judged] = np.divide(work, size[judged], out=np.zeros_like(work), where=size[judged] > 0.0)
        if self.simulation.strain is not None:
            strains = np.abs(self.steps.motion[own.strains])
            found.spacing[judged] = strains.max(axis=1) / float(STRAIN_UNIT)
            return found
        for cell in own.cells.tolist():
            place = slice(*self.model.point_start[cell : cell + 2])
            if cell not in self._spacing:
                self._spacing[cell] = SpacingChange(self.model.cells[cell].yarns, self.model.device)
            points, moved = self.simulation.state.points[place], self.steps.motion[place]
            found.spacing[cell] = self._spacing[cell].of(points, moved)
        return found

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


def _farthest(steps: NewtonSteps, own: CellEntries) -> FloatArray:
    """Return the largest move of an entry of some cells in their steps [units], shape (K,)."""
    return own.largest(np.linalg.norm(steps.motion[own.number], axis=1))


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
