# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The solvers, by name."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.solvers.dynamics import YarnDynamics
from stitchmesh.yarnrelax.solvers.lbfgs import LBFGS
from stitchmesh.yarnrelax.solvers.lbfgs_cells import CellLBFGS
from stitchmesh.yarnrelax.solvers.lbfgs_fused import FusedLBFGS, suits_fusing
from stitchmesh.yarnrelax.solvers.solver import Solver


def quasistatic(model: Model, further: NDArray[np.float64], strains: int = 0, *, alone: bool = True) -> LBFGS:
    """Return L-BFGS for one piece, for cells on a lattice, or for small cells in one launch.

    Args:
        model: the model of the yarns.
        further: row sums of the stiffness of further terms, shape (N,).
        strains: number of relaxing cells: all cells, or 0.
        alone: whether there are only the yarns' own forces and no constraints.
    """
    if not model.on_lattice:
        return LBFGS(model, further, strains)
    kind = FusedLBFGS if alone and suits_fusing(model) else CellLBFGS
    return kind(model, further, strains)


SOLVERS: dict[str, Callable[..., Solver]] = {"quasistatic": quasistatic, "dynamics": YarnDynamics}


def solver_named(name: str) -> Callable[..., Solver]:
    """Return the function that makes the solver of a name for a model.

    Raises:
        ParameterError: there is no solver of that name.
    """
    if name not in SOLVERS:
        raise ParameterError(f"solver: got {name!r}; expected one of {', '.join(SOLVERS)}")
    return SOLVERS[name]
