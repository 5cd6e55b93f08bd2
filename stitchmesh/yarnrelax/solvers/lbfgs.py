# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The quasistatic solver: limited-memory quasi-Newton steps (L-BFGS; Nocedal and Wright, algorithm 7.4).

With forces F, the last moves s_j and what the forces lost on them y_j = F_before - F_after, the next move is

    q = F - sum a_j y_j,   z = g C q,   x <- x + z + sum (a_j - b_j) s_j
    a_j = s_j . q / s_j . y_j   from the newest to the oldest,      b_j = y_j . z / s_j . y_j   from the oldest on,

where C is the compliance of this iteration (``preconditioner``) and g = s . y / y . C y of the newest pair.
A move is what a control point really did after its step limit and the constraints, so a pair tells the truth even where
moves were cut short. A pair with s . y not clearly positive is left out.

Cells have a memory each. Small cells that nothing but their own forces act on iterate many times in one launch
(``quasi_newton_burst``); else each step is a launch (``quasi_newton_launches``). The steps are the same
(``quasi_newton_steps``).

Quasi-Newton moves leave noise in the stiffest modes, of which the residual then tells more than of the distance to
rest. So each ``PERIOD`` iterations end with ``SMOOTHING`` plain ones, x <- x + 1.6 F / D with the row sums D of
``stiffness``, which leave the memory alone.

A control point that has used up most of its budget (``step_limit``) would be left behind by its neighbours. All wait
instead until there are new candidate lists.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.yarnrelax.energies.term import Launcher
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.solvers.lbfgs_fused import FusedLaunch, suits_fusing
from stitchmesh.yarnrelax.solvers.lbfgs_kernels import StepLaunches
from stitchmesh.yarnrelax.solvers.lbfgs_steps import PERIOD, make_memory
from stitchmesh.yarnrelax.solvers.preconditioner import bounds_struct, find_preconditioner
from stitchmesh.yarnrelax.solvers.solver import Solver, SolverInputs
from stitchmesh.yarnrelax.solvers.stiffness_bounds import bend_row_sums, stretch_row_sums

CAUTION, DONE, WAITING, WANTED = 4, 2, 6, 7
"""Columns of ``Memory.numbers``."""
FIRST_GRADIENT, LAST_GRADIENT, TENTH = 8, 9, 11
"""Columns of the norms of gradients, and of the iteration at which a tenth was first left."""
FRESH = (0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0)
"""The first numbers of a memory without pairs."""
PATIENCE = 5
"""Iterations for which cells wait for those that move before candidate lists are made for all."""


class LBFGS(Solver):
    """Limited-memory quasi-Newton steps."""

    needs_blocks = True
    allowed_rise = 1e-3

    def __init__(self, model: Model, further: NDArray[np.float64], strains: int = 0, *, alone: bool = True) -> None:
        """Room for the memory.

        Args:
            model: whose yarns are to come to rest.
            further: row sums of the stiffness of further terms, shape (N,).
            strains: how many cells relax, all or none.
            alone: whether nothing but the yarns' own forces act, and nothing holds control points.
        """
        self.bounds = bounds_struct(model.scalar)()
        self.bounds.along = model.upload(stretch_row_sums(model), 4)
        self.bounds.across = model.upload(bend_row_sums(model), 4)
        self.bounds.further = model.upload(np.maximum(further, np.finfo(np.float32).tiny))
        self.memory = make_memory(model, strains)
        self.steps = StepLaunches(model, self.memory)
        self.bursts = FusedLaunch(model, self.memory) if model.on_lattice and alone and suits_fusing(model) else None
        self.since = 0
        self.done = np.zeros(model.cell_count)
        self.restart(np.ones(model.cell_count))

    def launches(self, scene: SolverInputs, launcher: Launcher) -> list[Any]:
        """Find how control points give way, then the steps."""
        inputs = [scene.model.constants, self.bounds, scene.state.arrays]
        give = launcher(find_preconditioner, scene.model.point_count, inputs, [])
        return [give, *self.steps.launches(scene, launcher)]

    def burst(self, scene: SolverInputs, point_stiffness: wp.array[Any], launcher: Launcher) -> Any:
        """A launch of ``PERIOD`` iterations, forces included, of cells for which there is one."""
        if self.bursts is None:
            return None
        return self.bursts.launch(scene, self.bounds, point_stiffness, int(PERIOD), launcher)

    def restart(self, step_scale: NDArray[np.float64], cells: NDArray[np.bool_] | None = None) -> None:
        """Forget all pairs of some cells; the next force has none before it."""
        numbers = self.memory.numbers.numpy()
        chosen = slice(None) if cells is None else cells
        numbers[chosen, : len(FRESH)] = FRESH
        numbers[:, CAUTION] = step_scale
        self.memory.numbers.assign(numbers)

    def set_step_scale(self, step_scale: NDArray[np.float64]) -> None:
        """Scale moves."""
        numbers = self.memory.numbers.numpy()
        numbers[:, CAUTION] = step_scale
        self.memory.numbers.assign(numbers)

    def begin(self, count: NDArray[np.int64]) -> None:
        """Start a new period, and stand still at its end."""
        self.left = int(count.max())
        self.since, self.done = 0, np.zeros(len(count))
        numbers = self.memory.numbers.numpy()
        numbers[:, DONE], numbers[:, WANTED] = 0.0, count
        self.memory.numbers.assign(numbers)

    def needs_new_lists(self, scene: SolverInputs, launched: int) -> bool:
        """Read how many iterations were done, and whether it is time for new candidate lists."""
        numbers = self.memory.numbers.numpy()
        done, behind = numbers[:, DONE], numbers[:, WANTED] - numbers[:, DONE]
        self.advanced = int((done - self.done).max())
        self.left, self.done = int(behind.max()), done
        self.since += launched
        waiting = (behind > 0.0) & (numbers[:, WAITING] > 0.0)
        moving = (behind > 0.0) & ~waiting
        needs_new_lists = bool(waiting.any()) and (self.since >= PATIENCE or not moving.any())
        if needs_new_lists:
            self.since = 0
        return needs_new_lists

    def gradients(self) -> tuple[list[int | None], list[float]]:
        """Of each cell, its strains left out: iterations to a tenth of the first gradient; the last over the first."""
        numbers = self.memory.numbers.numpy()
        first, last, tenth = (numbers[:, column] for column in (FIRST_GRADIENT, LAST_GRADIENT, TENTH))
        part = np.divide(last, first, out=np.zeros_like(last), where=first > 0.0)
        return [count or None for count in tenth.astype(int).tolist()], part.tolist()

    def go_on_from(self, other: LBFGS, cells: NDArray[np.bool_]) -> None:
        """Note gradients as the next iterations of some cells of another, of which these are the only ones left."""
        numbers = self.memory.numbers.numpy()
        numbers[:, FIRST_GRADIENT:] = other.memory.numbers.numpy()[cells, FIRST_GRADIENT:]
        self.memory.numbers.assign(numbers)

    def arrays(self) -> dict[str, wp.array[Any]]:
        """The memory."""
        names = ("moves", "gradient_change", "last_force", "numbers", "curvature")
        return {name: getattr(self.memory, name) for name in names}
