# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A relaxation loop that can pause within an assessment interval, for a user who makes single steps.

A launch does several iterations, and old candidate lists are renewed after a launch (``RelaxationLoop.iterate``). A
part of an interval therefore counts the iterations that a launch of the whole interval would still do, and renews
lists after the same iterations. The state at the end of an interval has the same bits for any division into parts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.yarnrelax.collision.narrow_phase import LONG_LIFE
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL, Progress

INTERVAL = int(ASSESSMENT_INTERVAL)
"""Number of iterations between two assessments."""


class StepwiseLoop(RelaxationLoop):
    """The relaxation of one cell of a lattice in parts of assessment intervals."""

    def __init__(self, simulation: YarnSimulation, tolerance: float, largest_change: float) -> None:
        """Make a loop with the arguments of ``RelaxationLoop``."""
        super().__init__(simulation, tolerance, largest_change)
        self.done = 0
        """Number of iterations of the present interval; ``iteration`` counts only the iterations of whole intervals."""
        self.left_of_launch = 0
        """Number of iterations that the present launch of a whole interval would still do; 0 if the next launch
        starts."""

    @property
    def is_between_intervals(self) -> bool:
        """Whether an assessment interval has ended and the next one has not begun."""
        return self.done == 0

    def advance_partly(self, most: int) -> int:
        """Iterate for a part of an assessment interval; at its end, accept the new state or step back.

        Args:
            most: number of iterations; there are fewer if the interval ends before. A Newton step, and a launch of a
                solver that cannot stop within it (``Dynamics`` on a GPU), are completed.

        Returns:
            The number of iterations.

        Raises:
            SolverError: the cell cannot continue.
        """
        before, count = self.done, self.iteration
        if self.ending[0]:
            self.advance()
            return self.iteration - count
        if before + most >= INTERVAL:
            self.advance()
            return INTERVAL - before
        self.iterate(before + most)
        return self.done - before

    def advance(self, cells: NDArray[np.bool_] | None = None) -> None:
        """Complete the present interval; accept the new state, or step back.

        Raises:
            SolverError: the cell cannot continue.
        """
        super().advance(cells)
        self.done = self.left_of_launch = 0

    def iterate(self, count: int | NDArray[np.int64]) -> None:
        """Iterate until ``count`` iterations of the present interval are done."""
        simulation, solver, stop, count = self.simulation, self.simulation.solver, 0, int(np.max(count))
        while self.done < count:
            left = self.left_of_launch
            wanted = min(count, self.done + left) if left else count
            if wanted != stop:
                stop = wanted
                solver.begin(np.array([stop]), self.done)
            launched = simulation.iterate()
            self._note_launch(left or launched, solver.progress(simulation.inputs, launched))

    def _note_launch(self, left: int, progress: Progress) -> None:
        """Count the iterations done, and renew candidate lists where a whole interval would renew them.

        Args:
            left: iterations that the launch of a whole interval would still have done.
            progress: progress after the launch.
        """
        made, waits = int(progress.done[0]) - self.done, bool(progress.waiting[0])
        self.done += made
        self.lists_age += made
        self.left_of_launch = 0 if waits else max(left - made, 0)
        margins = self._fitting_margins()
        is_old = bool(((self.lists_age > LONG_LIFE) & (margins != self.simulation.candidates.margins))[0])
        if waits or (is_old and (self.left_of_launch == 0 or self.done >= INTERVAL)):
            self.search_contacts(margins)
