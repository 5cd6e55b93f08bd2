# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a solver is: the launches that turn the forces of an iteration into moves of the control points."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.reduction import maximum
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.collision.step_limit import measure_budget_use
from stitchmesh.yarnrelax.energies.term import Constraint, Launcher
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import State
from stitchmesh.yarnrelax.solvers.cell_strain import CellStrain


@dataclass(frozen=True, eq=False)
class SolverInputs:
    """What a solver works on."""

    model: Model
    state: State
    candidates: Candidates
    constraints: Sequence[Constraint]
    step_fraction: float
    """Largest move of a control point in one iteration, in mean yarn radii."""
    strain: CellStrain | None = None
    """The strains of a cell that relaxes."""


WORN = 0.7
"""Part of its budget that a control point has used when the candidate lists are made again."""


class Solver(ABC):
    """A solver. ``state.force`` and ``state.stiffness`` are fresh when its launches run."""

    needs_blocks: bool
    """Whether it wants ``state.sample_block`` and ``state.segment_block``."""
    allowed_rise: float
    """Rise of the energy between two assessments, over its size, that makes a relaxation back off."""
    left: int = 0
    """Iterations that are still to be done before the next assessment."""
    advanced: int = 0
    """Iterations that were done between the last two looks, by the cell that did most."""

    @abstractmethod
    def launches(self, scene: SolverInputs, launcher: Launcher) -> list[Any]:
        """Move the control points by one iteration, none by more than its limits."""

    def burst(self, scene: SolverInputs, point_stiffness: wp.array[Any], launcher: Launcher) -> Any:
        """One launch of ``quasi_newton_steps.PERIOD`` whole iterations, forces included; None if there is none."""
        return None

    @abstractmethod
    def restart(self, step_scale: NDArray[np.float64], cells: NDArray[np.bool_] | None = None) -> None:
        """Forget the past of some cells, or of all; ``step_scale`` in (0, 1] scales steps of each, 1 undisturbed."""

    @abstractmethod
    def set_step_scale(self, step_scale: NDArray[np.float64]) -> None:
        """Scale the steps of each cell by ``step_scale`` from now on."""

    @abstractmethod
    def arrays(self) -> dict[str, wp.array[Any]]:
        """Everything that it carries from one iteration to the next, by name."""

    def kinetic_energy(self) -> float:
        """Kinetic energy [erg]; none for a solver that knows no motion."""
        return 0.0

    def begin(self, count: NDArray[np.int64]) -> None:
        """Get ready for so many iterations of each cell."""
        self.left = int(count.max())

    def needs_new_lists(self, scene: SolverInputs, launched: int) -> bool:
        """Count what was launched, and tell whether the candidate lists must be made again."""
        self.left, self.advanced = self.left - launched, launched
        state = scene.state
        used = scene.model.empty(len(state.points))
        scene.model.launch(measure_budget_use, len(used), [state.points, state.listed_points, state.budget], [used])
        return maximum(used) > WORN
