# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The solvers, by name."""

from __future__ import annotations

from collections.abc import Callable

from stitchmesh.errors import ParameterError
from stitchmesh.yarnrelax.solvers.dynamics import YarnDynamics
from stitchmesh.yarnrelax.solvers.lbfgs import LBFGS
from stitchmesh.yarnrelax.solvers.solver import Solver

SOLVERS: dict[str, Callable[..., Solver]] = {"quasistatic": LBFGS, "dynamics": YarnDynamics}


def solver_named(name: str) -> Callable[..., Solver]:
    """Return the function that makes the solver of a name for a model.

    Raises:
        ParameterError: there is no solver of that name.
    """
    if name not in SOLVERS:
        raise ParameterError(f"solver: got {name!r}; expected one of {', '.join(SOLVERS)}")
    return SOLVERS[name]
