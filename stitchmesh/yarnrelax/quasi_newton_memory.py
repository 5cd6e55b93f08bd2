# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The memory of the quasistatic solver: pairs of moves and of what forces lost on them, for each cell its own."""

from __future__ import annotations

import functools
from typing import Any

import warp as wp

from stitchmesh.yarnrelax.model import Model
from stitchmesh.yarnrelax.precision import vector
from stitchmesh.yarnrelax.quasi_newton_steps import NUMBERS, PRODUCTS


@functools.cache
def _struct(scalar: Any) -> Any:
    """The struct of a memory in one precision.

    Of each entry: ``moves``, what it did in the iteration of each slot, and ``losses``, what the force on it lost,
    shape (7, E, 3); ``last_force``, that of the last iteration, and ``step``, its next move, shape (E, 3); ``limit``,
    how far it may go, shape (E,). Of each cell: ``numbers``, (C, 12); ``curvature``, products of moves with losses,
    (C, 7, 7); ``fall``, the numbers a_j, and ``rise``, a_j - b_j, (C, 7); ``products``, sums over its entries, (C, 19).
    """
    threes, doubles = vector(3, scalar), wp.float64
    annotations = {
        "moves": wp.array2d(dtype=threes),
        "losses": wp.array2d(dtype=threes),
        "last_force": wp.array(dtype=threes),
        "step": wp.array(dtype=threes),
        "limit": wp.array(dtype=scalar),
        "numbers": wp.array2d(dtype=doubles),
        "curvature": wp.array3d(dtype=doubles),
        "fall": wp.array2d(dtype=doubles),
        "rise": wp.array2d(dtype=doubles),
        "products": wp.array2d(dtype=doubles),
    }
    return wp.struct(type(f"Memory_{scalar.__name__}", (), {"__annotations__": annotations}))


def make_memory(model: Model, strains: int) -> Any:
    """Room for a model's control points and so many cells' strains, in a struct for kernels."""
    n, cells = model.point_count + strains, model.cell_count
    memory = _struct(model.scalar)()
    memory.moves, memory.losses = model.empty((7, n), 3), model.empty((7, n), 3)
    memory.last_force, memory.step, memory.limit = model.empty(n, 3), model.empty(n, 3), model.empty(n)
    shapes = {"numbers": (cells, NUMBERS), "curvature": (cells, 7, 7), "fall": (cells, 7), "rise": (cells, 7),
              "products": (cells, PRODUCTS)}  # fmt: skip
    for name, shape in shapes.items():
        setattr(memory, name, wp.zeros(shape, dtype=wp.float64, device=model.device))
    return memory
