# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A relaxation loop that can pause within an assessment interval, for a user who makes single steps.

A launch does several iterations, and old candidate lists are renewed after a launch (``RelaxationLoop.iterate``). Parts
of an interval therefore count the iterations that a launch would still do, and renew lists after the same iterations as
a whole interval. The state at the end of an interval has the same bits for any division into parts.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL

INTERVAL = int(ASSESSMENT_INTERVAL)
"""Iterations between two assessments."""


class StepwiseLoop(RelaxationLoop):
    """The relaxation of one piece, or of one cell, in parts of assessment intervals."""

    def __init__(self, simulation: YarnSimulation, tolerance: float) -> None:
        """Arguments as for ``RelaxationLoop``."""
        super().__init__(simulation, tolerance)
        self.left_of_launch = 0
        """Iterations that the present launch of a whole interval would still do; 0 if the next one starts."""

    @property
    def is_between_intervals(self) -> bool:
        """Whether an assessment interval has ended and the next one has not begun."""
        return self.iteration % INTERVAL == 0

    def current_yarns(self) -> YarnSet:
        """The yarns in the current state, which is not assessed yet within an interval."""
        simulation = self.simulation
        return simulation.cells_at(simulation.state.points, simulation.model.constants.images.periods)[0]

    def advance_partly(self, most: int) -> int:
        """Iterate for a part of an assessment interval; at its end, accept the new state or step back.

        Args:
            most: number of iterations; there are fewer if the interval ends before. A solver that cannot stop within a
                launch (``Dynamics`` on a GPU) completes the launch.

        Returns:
            The number of iterations.

        Raises:
            SolverError: the piece cannot continue.
        """
        before = self.iteration % INTERVAL
        done, end = before, min(before + most, INTERVAL)
        while done < end:
            done = self._continue_launch(done, end)
        self.iteration += done - before
        if done == INTERVAL:
            self.left_of_launch = 0
            self.judge(np.ones(1, dtype=bool))
        return done - before

    def _continue_launch(self, done: int, end: int) -> int:
        """Iterate until the present launch of a whole interval ends, or until ``end``; return what is done then."""
        simulation, solver = self.simulation, self.simulation.solver
        launches = simulation.iterations  # captured here, so that the number of their iterations is known
        left = self.left_of_launch or simulation.graph_iterations
        solver.begin(np.array([min(end, done + left)]), done)
        launches.launch()
        progress = solver.progress(simulation.inputs, simulation.graph_iterations)
        made = int(progress.done[0]) - done
        self.lists_age += made
        waits = bool(progress.waiting[0])
        self.left_of_launch = 0 if waits else max(left - made, 0)
        if self.left_of_launch == 0 or done + made == INTERVAL:
            self.renew_lists(waits)
        return done + made
