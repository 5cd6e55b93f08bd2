# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The memory of the quasistatic solver: pairs of moves and of what forces lost on them, for each cell its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import warp as wp

from stitchmesh.yarnrelax.model import Model
from stitchmesh.yarnrelax.quasi_newton_steps import NUMBERS


@dataclass(frozen=True, eq=False)
class Memory:
    """Arrays on the device."""

    moves: wp.array[Any]
    """What each entry did in the iteration of each slot, shape (7, E, 3)."""
    losses: wp.array[Any]
    """What the force on it lost, shape (7, E, 3)."""
    last_force: wp.array[Any]
    """Force of the last iteration, shape (E, 3)."""
    step: wp.array[Any]
    """Next move, shape (E, 3)."""
    limit: wp.array[Any]
    """How far it may go, shape (E,)."""
    numbers: wp.array[Any]
    """``quasi_newton_steps.NUMBERS`` of each cell, shape (C, 8)."""
    curvature: wp.array[Any]
    """Products of moves with losses, shape (C, 7, 7)."""
    fall: wp.array[Any]
    """Numbers a_j, shape (C, 7)."""
    rise: wp.array[Any]
    """Numbers a_j - b_j, shape (C, 7)."""

    @property
    def entries(self) -> int:
        """Control points and strains."""
        return len(self.step)

    @property
    def device(self) -> wp.Device:
        """Where the arrays are."""
        return self.step.device


def make_memory(model: Model, strains: int) -> Memory:
    """Room for a model's control points and so many cells' strains."""
    n, cells = model.point_count + strains, model.cell_count
    vectors = [model.empty((7, n), 3), model.empty((7, n), 3), model.empty(n, 3), model.empty(n, 3), model.empty(n)]
    shapes = [(cells, NUMBERS), (cells, 7, 7), (cells, 7), (cells, 7)]
    return Memory(*vectors, *(wp.zeros(shape, dtype=wp.float64, device=model.device) for shape in shapes))
