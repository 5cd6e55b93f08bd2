# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The way to rest: bursts of iterations, each judged, and each cell by itself (``convergence``)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.yarnrelax.convergence import Assessment, has_converged
from stitchmesh.yarnrelax.simulation import PART_THEM, YarnSimulation

ASSESSMENT_INTERVAL = 20
"""Iterations between two assessments."""


@dataclass(eq=False)
class RelaxationLoop:
    """Cells, or one piece, on their way to rest."""

    simulation: YarnSimulation
    tolerance: float
    """``Quality.tolerance``."""
    last: list[Assessment]
    """What is known of the last good state of each cell."""
    energy_fall: NDArray[np.float64]
    """Part of itself by which the energy of each fell in its last burst; infinite before one and after a step back,
    shape (C,)."""
    moving: float = 0.0
    """Kinetic energy at the last assessment [erg]; cells that are several have none."""

    @classmethod
    def start(cls, simulation: YarnSimulation, tolerance: float) -> RelaxationLoop:
        """Assess yarns as they were given; cells whose energy is not finite are stuck.

        Raises:
            SolverError: that of the only one is not.
        """
        last = simulation.assess_cells()
        for cell, now in enumerate(last):
            if not now.finite:
                simulation.failed[cell] = f"{simulation.blame(cell)}: not finite at the start; {PART_THEM}"
        simulation.raise_if_alone()
        return cls(simulation, tolerance, last, np.full(len(last), np.inf))

    @property
    def at_rest(self) -> NDArray[np.bool_]:
        """Whether both conditions of ``convergence`` hold in each cell, shape (C,)."""
        pairs = zip(self.last, self.energy_fall.tolist(), strict=True)
        return np.array([has_converged(now.residual, energy_fall, self.tolerance) for now, energy_fall in pairs])

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Whether each cell cannot go on, shape (C,)."""
        return np.isin(np.arange(len(self.last)), list(self.simulation.failed))

    def advance(self, cells: NDArray[np.bool_] | None = None) -> None:
        """One burst of some cells, or of all; back to the state before where the energy is not finite or rose too far.

        Raises:
            SolverError: the only one cannot go on.
        """
        simulation = self.simulation
        chosen = np.ones(len(self.last), dtype=bool) if cells is None else cells
        simulation.run(ASSESSMENT_INTERVAL, chosen)
        found, moving = simulation.assess_cells(chosen), simulation.solver.kinetic_energy()
        good = chosen & [self._is_good(cell, now, moving) for cell, now in enumerate(found)]
        for cell in np.flatnonzero(good).tolist():
            self._take(cell, found[cell])
        self.moving = moving if good.all() else 0.0
        # others that are at rest stand still, and all cells are quicker to copy than some
        simulation.keep(good | (self.at_rest & ~chosen))
        bad = chosen & ~good
        if bad.any():
            self.energy_fall[bad] = np.inf
            simulation.step_back(bad)

    def _is_good(self, cell: int, now: Assessment, moving: float) -> bool:
        """Whether a cell's energy is finite and has not risen too far."""
        last = self.last[cell]
        allowed = self.simulation.solver.allowed_rise * (last.size + self.moving) + float(self.simulation.noise[cell])
        return now.finite and now.energy + moving <= last.energy + self.moving + allowed

    def _take(self, cell: int, now: Assessment) -> None:
        """Note how a cell fared."""
        self.energy_fall[cell] = (self.last[cell].energy - now.energy) / now.size if now.size > 0.0 else 0.0
        self.last[cell] = now
