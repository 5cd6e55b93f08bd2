# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The way to rest: bursts of iterations, each judged, and each cell by itself (``convergence``)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.yarnrelax.convergence import Assessment, has_converged
from stitchmesh.yarnrelax.simulation import PART_THEM, Iteration

CHECK = 20
"""Iterations between two assessments."""


@dataclass(eq=False)
class Descent:
    """Cells, or one piece, on their way to rest."""

    solver: Iteration
    tolerance: float
    """``Quality.tolerance``."""
    last: list[Assessment]
    """What is known of the last good state of each cell."""
    fall: NDArray[np.float64]
    """Part of itself by which the energy of each fell in its last burst; infinite before one and after a step back,
    shape (C,)."""
    moving: float = 0.0
    """Kinetic energy at the last assessment [erg]; cells that are several have none."""

    @classmethod
    def start(cls, solver: Iteration, tolerance: float) -> Descent:
        """Assess yarns as they were given; cells whose energy is not finite are stuck.

        Raises:
            SolverError: that of the only one is not.
        """
        last = solver.assess_cells()
        for cell, now in enumerate(last):
            if not now.finite:
                solver.stuck[cell] = f"{solver.blame(cell)}: not finite at the start; {PART_THEM}"
        solver.raise_if_alone()
        return cls(solver, tolerance, last, np.full(len(last), np.inf))

    @property
    def at_rest(self) -> NDArray[np.bool_]:
        """Whether both conditions of ``convergence`` hold in each cell, shape (C,)."""
        pairs = zip(self.last, self.fall.tolist(), strict=True)
        return np.array([has_converged(now.residual, fall, self.tolerance) for now, fall in pairs])

    @property
    def stuck(self) -> NDArray[np.bool_]:
        """Whether each cell cannot go on, shape (C,)."""
        return np.isin(np.arange(len(self.last)), list(self.solver.stuck))

    def advance(self, cells: NDArray[np.bool_] | None = None) -> None:
        """One burst of some cells, or of all; back to the state before where the energy is not finite or rose too far.

        Raises:
            SolverError: the only one cannot go on.
        """
        solver = self.solver
        chosen = np.ones(len(self.last), dtype=bool) if cells is None else cells
        solver.run(CHECK, chosen)
        found, moving = solver.assess_cells(chosen), solver.method.kinetic_energy()
        good = chosen & [self._is_good(cell, now, moving) for cell, now in enumerate(found)]
        for cell in np.flatnonzero(good).tolist():
            self._take(cell, found[cell])
        self.moving = moving if good.all() else 0.0
        # others that are at rest stand still, and all cells are quicker to copy than some
        solver.keep(good | (self.at_rest & ~chosen))
        bad = chosen & ~good
        if bad.any():
            self.fall[bad] = np.inf
            solver.back_off(bad)

    def _is_good(self, cell: int, now: Assessment, moving: float) -> bool:
        """Whether a cell's energy is finite and has not risen too far."""
        last = self.last[cell]
        allowed = self.solver.method.allowed_rise * (last.size + self.moving) + float(self.solver.noise[cell])
        return now.finite and now.energy + moving <= last.energy + self.moving + allowed

    def _take(self, cell: int, now: Assessment) -> None:
        """Note how a cell fared."""
        self.fall[cell] = (self.last[cell].energy - now.energy) / now.size if now.size > 0.0 else 0.0
        self.last[cell] = now
