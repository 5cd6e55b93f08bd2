# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The loop of a relaxation: iterate, renew the candidate lists, assess, accept or step back, stop.

The loop serves one piece, or many cells, each of which comes to rest by itself (``convergence``). A cell descends with
the solver, in intervals of ``ASSESSMENT_INTERVAL`` iterations. If all terms give their Hessians, Newton steps end the
relaxation from a small residual on, and judge whether it has ended (``newton``). A Newton step counts as some
iterations (``newton_interval``). The last interval ends at the limit of iterations; a step that has begun is completed.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.errors import OverloadError
from stitchmesh.time_limit import check_time
from stitchmesh.yarnrelax.assessment import Assessments, RemainingChanges
from stitchmesh.yarnrelax.collision.narrow_phase import LONG_LIFE, fitting_margins
from stitchmesh.yarnrelax.convergence import has_converged, is_at_rest, is_level
from stitchmesh.yarnrelax.loop_state import LoopState, carried_arrays, resume_from_arrays
from stitchmesh.yarnrelax.newton import SMALLEST_NEWTON_SCALE, newton_of
from stitchmesh.yarnrelax.newton_interval import alternation_of, follow_steps, judge_and_move, move_less
from stitchmesh.yarnrelax.settling import settling_of
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL, UNLIMITED

SMALLEST_STEP_SCALE = 5e-5
"""The loop does not step back again below this scale of steps."""
REMEDY = "move the yarns apart, or control points that lie in one place"
"""Advice for yarns whose energy is too steep."""


class RelaxationLoop:
    """One piece, or many cells, on their way to rest."""

    def __init__(
        self, simulation: YarnSimulation, tolerance: float, largest_change: float = 0.004, before: int = 0,
        most: int | NDArray[np.int64] = UNLIMITED, *, by_newton: bool = True,
    ) -> None:  # fmt: skip
        """Make a loop before its first assessment (``start``).

        Args:
            simulation: the cells, or the piece.
            tolerance: ``Quality.tolerance``.
            largest_change: ``Quality.largest_change``.
            before: iterations that were done before, with another load; they count too.
            most: largest number of iterations of all cells, or of each cell, shape (C,).
            by_newton: whether Newton's method ends the relaxation if it can.
        """
        self.simulation, self.tolerance, self.largest_change = simulation, tolerance, largest_change
        cells = simulation.model.cell_count
        self.before, self.iterations = before, np.full(cells, before, dtype=np.int64)
        """Iterations of each cell, with the iterations that its Newton steps count as, shape (C,)."""
        self.most = np.full(cells, most, dtype=np.int64)
        """Number of iterations after which each cell begins nothing more, shape (C,)."""
        self.cut_short = False
        """Whether the last interval of a cell was shorter because of its limit of iterations."""
        self.lists_age = np.zeros(cells, dtype=np.int64)
        """Iterations of each cell since its candidate lists were made, shape (C,)."""
        self.step_scale = np.ones(cells)
        """Scale of the steps of each cell, shape (C,)."""
        self.last = Assessments.of([])
        """Assessments of the last accepted state of each cell; none before the first assessment."""
        self.energy_fall = np.full(cells, np.inf)
        """Decrease of the energy of each cell over the last assessment interval, relative to the energy, shape (C,);
        infinite before the first interval and after a step back."""
        self.ending = np.zeros(cells, dtype=bool)
        """Whether each cell takes Newton steps, shape (C,)."""
        self.alternation = alternation_of(simulation.model)
        """How Newton steps alternate with iterations of the solver."""
        self.stalled = np.zeros(cells, dtype=bool)
        """Whether no step lowers the energy of a cell that is not at rest, shape (C,)."""
        self.remaining = RemainingChanges.unknown(cells)
        """Estimate of the remaining change of each cell."""
        self.newton = newton_of(simulation) if by_newton else None
        """Newton's method, if it ends the relaxation."""
        self.settling = settling_of(simulation, self.newton, tolerance, largest_change)
        """How the only piece settles, if Newton's method does not end its relaxation or begins too late."""
        self.kinetic_energy = 0.0
        """Kinetic energy at the last assessment [erg]."""
        self.errors: dict[int, str] = dict(simulation.too_close)
        """Error messages of the cells that cannot continue."""

    def start(self) -> None:
        """Assess the given yarns.

        Raises:
            SolverError: the energy of the only piece is not finite.
        """
        self.last = self.simulation.assess_cells()
        for cell in np.flatnonzero(~self.last.finite).tolist():
            where = self.simulation.largest_force(cell)
            self._fail({cell: f"{where}: not finite at the start; {REMEDY}"})

    def run(self, iterations: int, note: Callable[[], None] = lambda: None) -> None:
        """Iterate until all cells are at rest, or have done ``iterations``; ``note`` is called after each assessment.

        Raises:
            SolverError: the only piece cannot continue.
        """
        if not len(self.last):
            self.start()
            note()
        while not (self.at_rest | self.stalled).all() and self.iteration < iterations:
            self.advance()
            note()

    def advance(self, cells: NDArray[np.bool_] | None = None) -> None:
        """Iterate some cells, or all, for one assessment interval; accept the new states, or step back.

        Raises:
            SolverError: the only piece cannot continue.
        """
        chosen = (np.ones(len(self.last), dtype=bool) if cells is None else cells) & ~self.stalled
        chosen = self.alternation.begin_interval(chosen, self.ending)
        stepping, self.cut_short = chosen & self.takes_newton_step, False
        shortened = judge_and_move(self, stepping)
        self.iterations += np.where(stepping, self.alternation.step_cost, self._descend(chosen & ~stepping))
        found, kinetic_energy = self.simulation.assess_cells(chosen), self.simulation.solver.kinetic_energy()
        allowed, energy = self._allowed_rise(stepping), self.last.energy
        found = move_less(self, stepping, found, allowed)
        good = chosen & self.is_acceptable(found, allowed, kinetic_energy)
        self.note(good, found)
        self.kinetic_energy = kinetic_energy if good.all() else 0.0
        # other cells at rest have not moved, and copying all cells is faster than copying some
        self.accept(good | (self.at_rest & ~chosen))
        if (chosen & ~good).any():
            self.step_back(chosen & ~good)
        if self.newton is not None:
            self.newton.note_moves(good & (self.energy_fall > 0.0))
            late = stepping & ~good & self.newton.is_late  # the same factors again would only say the same
            self.alternation.note_steps(stepping, (shortened & good) | late, np.where(late, 0.0, self.energy_fall))
            descended = chosen & self.ending & ~stepping
            self.alternation.note_iterations(descended & good, descended & ~good, self.energy_fall)
            follow_steps(self, stepping & good, energy)
            if (stepping & good).any():
                self.simulation.solver.restart(self.step_scale, stepping & good)

    def _descend(self, cells: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Iterate some cells with the solver for one assessment interval; return each cell's iterations, shape (C,)."""
        wanted = cells * np.minimum(np.int64(ASSESSMENT_INTERVAL), self.most - self.iterations)
        if cells.any():
            self.cut_short |= bool((wanted[cells] < int(ASSESSMENT_INTERVAL)).any())
            with self.simulation.model.only_in(cells):
                self.iterate(wanted)
        return wanted

    def iterate(self, count: int | NDArray[np.int64]) -> None:
        """Do ``count`` iterations of all cells, or of each cell, and make new lists of cells whose lists are old."""
        wanted = np.full(self.simulation.model.cell_count, count)
        self.simulation.solver.begin(wanted)
        done, since_search = np.zeros(len(wanted)), 0
        while (done < wanted).any():
            check_time()
            launched = self.simulation.iterate(int((wanted - done).max()) if self.cut_short else None)
            progress = self.simulation.solver.progress(self.simulation.inputs, launched)
            self.lists_age += (progress.done - done).astype(np.int64)
            done, since_search = progress.done, since_search + launched
            needed, margins = progress.needs_lists(since_search), self._fitting_margins()
            old = (self.lists_age > LONG_LIFE) & (margins != self.simulation.candidates.margins)
            if (renewed := needed | (old & (wanted > 0))).any():
                self.search_contacts(np.where(renewed, margins, self.simulation.candidates.margins), renewed)
                since_search = 0 if needed.any() else since_search

    def search_contacts(
        self, margins: NDArray[np.float64] | None = None, cells: NDArray[np.bool_] | None = None
    ) -> None:
        """Make new candidate lists of some cells, shape (C,), or of all, with new margins if they are given [units].

        Raises:
            SolverError: the yarns of the only piece are too close to each other.
        """
        self.lists_age[slice(None) if cells is None else cells] = 0
        self._fail(self.simulation.search_contacts(margins, cells))

    def accept(self, cells: NDArray[np.bool_]) -> None:
        """Accept the current states of some cells, and let their steps become longer again."""
        self.simulation.accept(cells)
        if (self.step_scale[cells] < 1.0).any():
            recovery = np.where(self.ending, 2.0, 1.2)[cells]  # twice after a Newton step
            self.step_scale[cells] = np.minimum(self.step_scale[cells] * recovery, 1.0)
            self.simulation.solver.set_step_scale(self.step_scale)

    def step_back(self, cells: NDArray[np.bool_]) -> None:
        """Return some cells to their last accepted state; they begin again with shorter steps and without velocity.

        Raises:
            SolverError: the steps of the only piece are as short as they may be.
        """
        stepping = self.takes_newton_step
        self.stalled |= cells & stepping & (self.step_scale < SMALLEST_NEWTON_SCALE)
        for cell in np.flatnonzero(cells & ~self.ending & (self.step_scale < SMALLEST_STEP_SCALE)).tolist():
            where = self.simulation.largest_force(cell)
            self._fail({cell: f"{where}: its energy grows at the smallest steps; {REMEDY}"})
        self.energy_fall[cells] = np.inf
        self.simulation.restore(cells)
        self.step_scale[cells] /= np.where(stepping, 4.0, 2.0)[cells]
        if self.newton is not None:
            self.newton.distrust(cells & stepping)
        self.simulation.solver.restart(self.step_scale, cells)
        self.search_contacts(cells=cells)

    @property
    def takes_newton_step(self) -> NDArray[np.bool_]:
        """Whether each cell takes a Newton step in the present interval, shape (C,)."""
        return self.ending & self.alternation.is_step_due

    @property
    def iteration(self) -> int:
        """Number of iterations of the cell that did the most."""
        return int(self.iterations.max())

    @property
    def at_rest(self) -> NDArray[np.bool_]:
        """Whether the conditions of ``convergence`` hold in each cell, shape (C,)."""
        if self.newton is None and self.settling is None:
            return self._is_near_rest(self.tolerance)
        at_rest = is_at_rest(self.last.residual, self.remaining.spacing, self.tolerance, self.largest_change)
        return at_rest | (self.stalled & self.last.is_noise & (self.last.residual < self.tolerance))

    def _is_near_rest(self, tolerance: float) -> NDArray[np.bool_]:
        """Whether the residual and the fall of the energy of each cell are small, shape (C,)."""
        return has_converged(self.last.residual, self.energy_fall, tolerance)

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Whether each cell cannot continue, shape (C,)."""
        return np.isin(np.arange(len(self.last)), list(self.errors))

    def _fitting_margins(self) -> NDArray[np.float64]:
        """Return the margins of the next candidate lists of each cell [units], shape (C,)."""
        return fitting_margins(self.simulation.candidates.margins, self.lists_age)

    def _allowed_rise(self, stepping: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Return how much each cell's energy may rise [erg], in a Newton step or in iterations, shape (C,)."""
        size, simulation = self.last.size, self.simulation
        iterated = simulation.solver.allowed_rise * (size + self.kinetic_energy) + simulation.noise
        return iterated if self.newton is None else np.where(stepping, self.newton.allowed_rise(size), iterated)

    def is_acceptable(
        self, now: Assessments, allowed: NDArray[np.float64], kinetic_energy: float = 0.0
    ) -> NDArray[np.bool_]:  # fmt: skip
        """Return whether the energy of each cell is finite and has not risen too far, shape (C,)."""
        before = self.last.energy + self.kinetic_energy
        return now.finite & (now.energy + kinetic_energy <= before + allowed)

    def note(self, cells: NDArray[np.bool_], now: Assessments) -> None:
        """Record the accepted assessments of some cells."""
        size = now.size
        with np.errstate(divide="ignore", invalid="ignore"):
            fall = np.where(size > 0.0, (self.last.energy - now.energy) / size, 0.0)
        self.energy_fall = np.where(cells, fall, self.energy_fall)
        self.last = self.last.replaced(cells, now)
        done, level = self.iteration - self.before, is_level(self.energy_fall, self.tolerance)
        if self.settling is not None and cells.any() and not self.ending[0] and self.settling.is_due(done):
            self.remaining = self.remaining.with_cell(0, self.settling.note_state(self.simulation, done, now[0]))
        if self.newton is not None:
            beginning = cells & ~self.ending & self._is_near_rest(self.newton.descent)
            self.ending, self.step_scale[beginning] = self.ending | beginning, 1.0
            level = np.where(self.ending, self.newton.gains_nothing, level)
        self.stalled |= cells & now.hides_rest(self.tolerance) & level

    def state(self) -> LoopState:
        """Return a copy of the state of the only piece, which has been assessed."""
        arrays = {name: wp.clone(array) for name, array in carried_arrays(self.simulation).items()}
        learned = {} if self.newton is None else {"newton": self.newton.memory}
        if self.settling is not None:
            learned |= {f"settling.{name}": values for name, values in self.settling.arrays().items()}
        arrays |= {name: wp.array(values, dtype=wp.float64, device="cpu") for name, values in learned.items()}
        return LoopState(
            iteration=self.iteration,
            last=self.last[0],
            margin=float(self.simulation.candidates.margins[0]),
            lists_age=int(self.lists_age[0]),
            step_scale=float(self.step_scale[0]),
            energy_fall=float(self.energy_fall[0]),
            arrays=arrays,
            ending=bool(self.ending[0]),
            descent=int(self.alternation.descent[0]),
            newton_fall=float(self.alternation.newton_fall[0]),
            stalled=bool(self.stalled[0]),
            remaining=self.remaining[0],
        )

    def resume(self, state: LoopState) -> None:
        """Continue the relaxation of the only piece, with the same inputs, from a state.

        Raises:
            ParameterError: an array is missing or has another shape.
        """
        resume_from_arrays(self.simulation, state.arrays, state.margin)
        self.iterations[0] = state.iteration
        self.last = Assessments.of([state.last])
        self.lists_age[0] = state.lists_age
        self.step_scale[0] = state.step_scale
        self.energy_fall[0] = state.energy_fall
        self.ending[0] = state.ending
        self.alternation.descent[0] = state.descent
        self.alternation.newton_fall[0] = state.newton_fall
        self.stalled[0] = state.stalled
        self.remaining = self.remaining.with_cell(0, state.remaining)
        self.kinetic_energy = self.simulation.solver.kinetic_energy()
        if self.newton is not None:
            self.newton.memory = np.array(state.arrays["newton"], dtype=np.float64)
        if self.settling is not None:
            self.settling.resume(state.arrays["settling.table"], state.arrays["settling.middles"])

    def _fail(self, errors: dict[int, str]) -> None:
        """Record the cells that cannot continue; raise the error if there is only one cell."""
        self.errors |= errors
        if self.errors and self.simulation.model.cell_count == 1:
            raise OverloadError(self.errors[0])
