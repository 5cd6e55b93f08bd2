# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The relaxation of yarns under their load: at once, or in steps if they cannot take it (``load_position``).

Each step is a relaxation of its own, with its own inputs (``load_path``). Iterations are counted through all steps. An
interval in which a step is refused counts as a whole one, so that no two states have the same count.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

import numpy as np

from stitchmesh.errors import OverloadError
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.load_path import LoadPath
from stitchmesh.yarnrelax.load_position import AT_ONCE, TRIAL_ITERATIONS, LoadPosition
from stitchmesh.yarnrelax.newton import DESCENT
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.renewal import renew_at_rest
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL

logger = logging.getLogger(__name__)


class Loading:
    """A relaxation along a path of loads."""

    def __init__(self, path: LoadPath, position: LoadPosition = AT_ONCE, *, in_steps: bool = True) -> None:
        """Start the step ``position``, or the next step that the yarns can start.

        Args:
            path: the inputs of all steps.
            position: the step to try first.
            in_steps: whether a load that is too large is applied in steps.

        Raises:
            SolverError: the yarns are too close to each other at every step.
        """
        self.path, self.position, self.in_steps = path, position, in_steps
        self.loop = self._begin()

    @property
    def quality(self) -> Quality:
        """The quality that the caller asked for."""
        return self.path.asked.quality

    @property
    def at_rest(self) -> bool:
        """Whether the yarns are at rest under their whole load."""
        return self.position.is_whole and bool(self.loop.at_rest[0])

    def good_yarns(self) -> YarnSet:
        """Return the last accepted state of the yarns, with the rest lengths and radii that the caller asked for."""
        yarns = self.loop.simulation.good_yarns()
        return yarns if self.position.is_whole else self.path.with_asked_inputs(yarns)

    def run(self, note: Callable[[], None]) -> None:
        """Iterate through the steps until the yarns are at rest, or have done ``Quality.max_iterations``.

        Raises:
            SolverError: the yarns cannot take the load.
        """
        while True:
            try:
                _run_to_rest(self.loop, int(min(self.quality.max_iterations, self._step_end)), note)
                if not self._step_is_done:
                    if not self.position.is_first:
                        count, why = self.position.steps, self.position.why
                        logger.debug("the load was applied in %d steps, because at once: %s", count, why)
                    return
                if self.position.is_whole:
                    self.position = self.path.thick_start(self.loop.iteration)
                else:
                    self.position = self.position.after_step(self.loop.simulation.good_yarns(), self.loop.iteration)
            except OverloadError as error:
                after = self.loop.iteration + int(ASSESSMENT_INTERVAL)
                self._refuse(error, min(after, self.quality.max_iterations), began=True)
            self.loop = self._begin()

    @property
    def _is_trial(self) -> bool:
        """Whether the whole load acts on thin yarn as a trial; if that is slow, thicker yarn is relaxed first."""
        return self.in_steps and self.position.is_first and self.path.is_slender

    @property
    def _step_end(self) -> float:
        """Number of iterations after which another step follows the present one."""
        if self._is_trial and not self.loop.ending[0]:
            return TRIAL_ITERATIONS
        return np.inf if self.position.is_whole else self.position.iterations + self.position.most_iterations

    @property
    def _step_is_done(self) -> bool:
        """Whether another step follows."""
        ended = bool((self.loop.at_rest | self.loop.stalled)[0])
        return self.loop.iteration >= self._step_end or (not self.position.is_whole and ended)

    def _begin(self) -> RelaxationLoop:
        """Start the present step, or the next one that the yarns can start."""
        quality = self.quality
        while True:
            position = self.position
            try:
                simulation = self.path.inputs_at(position).start()
                tolerance = quality.tolerance if position.is_whole else DESCENT
                return RelaxationLoop(
                    simulation, tolerance, quality.largest_change, position.iterations, quality.max_iterations,
                    by_newton=position.is_whole or position.thin > 1.0,
                )  # fmt: skip
            except OverloadError as error:
                self._refuse(error, position.iterations, began=False)

    def _refuse(self, error: OverloadError, iterations: int, *, began: bool) -> None:
        """Go on to the next step after a refusal.

        Raises:
            SolverError: no step is left.
        """
        following = self.position.after_refusal(str(error), iterations, began=began) if self.in_steps else None
        if following is None:
            raise self.path.refusal(error, self.position) from error
        self.position = following


def _run_to_rest(loop: RelaxationLoop, most: int, note: Callable[[], None]) -> None:
    """Iterate until the yarns are at rest, and still are so after the renewal of terms that lag."""
    loop.run(most, note)
    while renew_at_rest(loop).any() and not loop.at_rest[0]:
        loop.run(most, note)
