# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The interface of solvers: launches that compute moves of the control points from the forces of an iteration."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.energies.term import Constraint, OnYarns
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import State
from stitchmesh.yarnrelax.solvers.cell_strain import CellStrain

ASSESSMENT_INTERVAL = wp.constant(20)
"""Number of iterations between two assessments."""
UNLIMITED = np.iinfo(np.int64).max
"""Stands for the limit of iterations if there is none."""
PATIENCE = 5
"""Number of iterations after which a piece gets new candidate lists if some of its control points, but not enough for
it to wait, have used up their budgets."""


@dataclass(frozen=True, eq=False)
class SolverInputs:
    """The inputs of a solver."""

    model: Model
    state: State
    candidates: Candidates
    constraints: Sequence[Constraint]
    step_fraction: float
    """Largest move of a control point in one iteration, in mean yarn radii."""
    strain: CellStrain | None = None
    """The strains of relaxing cells."""
    terms: Sequence[OnYarns] = ()
    """Further energies."""


@dataclass(frozen=True, eq=False)
class Progress:
    """Progress of a solver since ``Solver.begin``."""

    done: NDArray[Any]
    """Number of iterations of each cell, with the ones made before, shape (C,)."""
    waiting: NDArray[np.bool_]
    """Whether so many control points have used up their budgets that the cell waits for new lists, shape (C,)."""
    used_up: NDArray[np.bool_]
    """Whether any control point of the cell has used up its budget, shape (C,)."""

    def needs_lists(self, since_search: int) -> NDArray[np.bool_]:
        """Whether each cell needs new candidate lists, ``since_search`` iterations after the last ones, shape (C,)."""
        return self.waiting | (self.used_up & (since_search >= PATIENCE))


class Solver(ABC):
    """A solver. ``state.force`` and ``state.stiffness`` are up to date when its launches run."""

    needs_blocks: bool
    """Whether the solver reads ``state.sample_block`` and ``state.segment_block``."""
    stops_by_itself: bool = True
    """Whether a launch of several iterations ends after the number that ``begin`` was asked for."""
    allowed_rise: float
    """Largest rise of the energy between two assessments, over its size, that is accepted."""

    @abstractmethod
    def launches(self, inputs: SolverInputs, launcher: Launcher) -> list[Any]:
        """Return the launches that move the control points by one iteration, none by more than its limit."""

    def fused_launch(self, inputs: SolverInputs, point_stiffness: wp.array[Any], launcher: Launcher) -> Any:
        """Return one launch of ``ASSESSMENT_INTERVAL`` whole iterations, with their forces; None if there is none."""
        return None

    @abstractmethod
    def restart(self, step_scale: NDArray[np.float64], cells: NDArray[np.bool_] | None = None) -> None:
        """Clear the memory of some cells, or of all; ``step_scale`` in (0, 1] scales the steps of each cell."""

    @abstractmethod
    def set_step_scale(self, step_scale: NDArray[np.float64]) -> None:
        """Scale the steps of each cell by ``step_scale`` from now on."""

    @abstractmethod
    def arrays(self) -> dict[str, wp.array[Any]]:
        """Return all arrays that persist from one iteration to the next, by name."""

    def kinetic_energy(self) -> float:
        """Return the kinetic energy [erg]; zero for a solver without motion."""
        return 0.0

    @abstractmethod
    def begin(self, wanted: NDArray[np.int64], done: int = 0) -> None:
        """Prepare for ``wanted`` iterations of each cell, shape (C,), of which ``done`` were made before."""

    @abstractmethod
    def progress(self, inputs: SolverInputs, launched: int) -> Progress:
        """Read the progress of each cell after ``launched`` more iterations."""
