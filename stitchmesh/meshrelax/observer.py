# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Hands the states of a running mesh relaxation to its caller, who may watch, pause and stop it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic

from stitchmesh.compute.device import others_may_launch
from stitchmesh.mesh import StitchMesh
from stitchmesh.meshrelax.dynamics import MeshState, Progress
from stitchmesh.meshrelax.placement import P
from stitchmesh.run_control import RunControl, Snapshot
from stitchmesh.time_limit import check_time


@dataclass(frozen=True, eq=False)
class MeshObserver(Generic[P]):
    """Hands out the states of a running relaxation."""

    made: Callable[[P], StitchMesh]
    """Makes the fabric, with the stretch of its edges, from a placement."""
    tolerance: float
    """Residual at which the relaxation has converged."""
    began: float
    """Time of the start [s]."""
    progress: Progress | None
    """Called after each iteration."""
    control: RunControl[StitchMesh] | None
    """Watches, pauses and stops the relaxation."""

    def note(self, iteration: int, state: MeshState[P]) -> None:
        """Report an iteration, and let the user watch, pause and stop.

        Raises:
            RunStopped: the user has stopped the relaxation, or its time has run out.
        """
        check_time()
        if self.progress is not None and iteration > 0:
            self.progress(iteration, state.residual)
        if self.control is not None:
            self.control.after_step(lambda: self._snapshot(iteration, state), aside=others_may_launch)

    def seconds(self) -> float:
        """Return the time since the start, without pauses [s]."""
        waited = 0.0 if self.control is None else self.control.seconds_waited
        return time.perf_counter() - self.began - waited

    def _snapshot(self, iteration: int, state: MeshState[P]) -> Snapshot[StitchMesh]:
        return Snapshot(self.made(state.placement), iteration, state.residual, self.tolerance, self.seconds())
