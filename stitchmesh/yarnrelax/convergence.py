# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""When a relaxation has come to rest.

The residual compares the force that is left with the forces that balance one another,

    residual = rms over control points of |F| / rms over control points of sum over terms of |F_term|

where F is the net force less what constraints carry, and the terms are stretch, length, bending, contact and those that
were asked for. It is 0 at balance and at most 1, has no unit and knows nothing of the start. Yarns without any force
are at rest: no force means no more than the rounding of coordinates makes, the rms of the row sums of stiffness times
the size of the set times the precision. A relaxation has converged when the residual is below ``Quality.tolerance``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.yarnrelax import forces
from stitchmesh.yarnrelax.candidates import Candidates
from stitchmesh.yarnrelax.model import Model
from stitchmesh.yarnrelax.reduction import Sums
from stitchmesh.yarnrelax.state import State
from stitchmesh.yarnrelax.term import Constraint, Term

wp.set_module_options({"enable_backward": False})


@wp.kernel(module="unique")
def add_effort(
    # state in
    point_force: wp.array[Any],
    # state out
    net: wp.array[Any],
    effort: wp.array[Any],
) -> None:
    """Add one term's force to the net force, and its magnitude to the effort."""
    i = wp.tid()
    net[i] += point_force[i]
    effort[i] += wp.length(point_force[i])


@wp.kernel(module="unique")
def square_forces(
    # state in
    net: wp.array[Any],
    effort: wp.array[Any],
    # state out
    net2: wp.array[Any],
    effort2: wp.array[Any],
) -> None:
    """Squares of the net force and of the effort."""
    i = wp.tid()
    net2[i] = wp.dot(net[i], net[i])
    effort2[i] = effort[i] * effort[i]


@dataclass(frozen=True)
class Assessment:
    """What is known of a state."""

    residual: float
    """Relative force residual."""
    energies: dict[str, float]
    """Energy of each term [erg]."""

    @property
    def energy(self) -> float:
        """Total energy [erg]."""
        return sum(self.energies.values())

    @property
    def finite(self) -> bool:
        """Whether all of it is finite."""
        return bool(np.isfinite(self.residual) and np.isfinite(self.energy))


def rounding_force(model: Model, stiffness: NDArray[np.float64]) -> float:
    """Root mean square of the force that the rounding of coordinates makes [erg / unit]."""
    precision = np.finfo(np.float32 if model.scalar is wp.float32 else np.float64).eps
    size = float(np.abs(model.to_device(model.yarns.points)).max())
    return float(np.sqrt(np.mean(stiffness**2)) * size * precision)


def assess(
    model: Model,
    state: State,
    candidates: Candidates,
    terms: Sequence[Term],
    constraints: Sequence[Constraint],
    point_stiffness: wp.array[Any],
    *,
    rounding: float,
) -> Assessment:
    """Residual and energies of a state; its forces are overwritten."""
    n = model.point_count
    net, effort = model.empty(n, 3), model.empty(n)
    forces.sample(model, state)
    for _ in forces.each_term(model, state, candidates, terms, point_stiffness):
        model.launch(add_effort, n, [state.point_force], [net, effort])
    for constraint in constraints:
        constraint.filter_forces(net, model.launch)
    net2, effort2 = model.empty(n), model.empty(n)
    model.launch(square_forces, n, [net, effort], [net2, effort2])
    sums = Sums(forces.BASE_TERMS + 2, model.sample_count + model.point_count, model.device)
    forces.sum_energies(model, state, candidates, sums)
    sums.add("net", net2)
    sums.add("effort", effort2)
    found = sums.read()
    left, whole = np.sqrt(found.pop("net") / n), np.sqrt(found.pop("effort") / n)
    residual = 0.0 if whole <= rounding else float(left / whole)
    return Assessment(residual, found | {term.name: term.energy(state, candidates) for term in terms})
