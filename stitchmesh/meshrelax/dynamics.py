# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""First-order dynamics of a fabric on its surface, stepped by backward Euler (Yuksel et al. 2012, equation 1).

With x' = f(x) and f the part of the forces along the directions in which each vertex may move,

    (I - h df/dx) dx = h f

The step h [cm] grows while the forces fall and shrinks when they rise, so that the iteration ends as Newton's method.
The residual, the root mean square of f over the vertices, does not depend on h; a force of one would be half the pull
of an edge stretched without end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import SolverError
from stitchmesh.mesh import FloatArray
from stitchmesh.meshrelax.assembly import Assembly
from stitchmesh.meshrelax.attachment import Attachment, Placement
from stitchmesh.meshrelax.conjugate_gradients import modified_conjugate_gradients
from stitchmesh.meshrelax.forces import element_forces
from stitchmesh.meshrelax.preconditioner import Patches, preconditioner
from stitchmesh.meshrelax.sub_quads import Springs
from stitchmesh.meshrelax.turning import turning_stiffness

Progress = Callable[[int, float], None]
"""Called after each iteration with its number and the residual."""

LARGEST_STEP = 4.0
"""Largest move of a vertex in one iteration over the size of a stitch."""
STRIDE = 1.0
"""Largest move between two projections over the size of a stitch."""
STEP_GROWTH, MILD_CUT, STEP_CUT = 4.0, 0.5, 0.1
"""Factors of the time step where the residual fell, where it rose a little, and where the step was taken back."""
LARGEST_RISE = 1.2
"""Rise of the residual at which a step is taken back."""
SHORTEST_TIME, LONGEST_TIME = 1e-3, 1e4
"""Bounds of the time step over the size of a stitch: a short one is always good, and beyond the long one the identity
no longer steadies free motions."""
LINEAR_TOLERANCE, LINEAR_ITERATIONS = 0.01, 200
"""Of the conjugate gradients: with a coarser tolerance the jumps between the preconditioner's patches remain."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """Where a relaxation ended."""

    placement: Placement
    residual: float
    iterations: int


@dataclass(frozen=True, eq=False)
class State:
    """A placement with its forces."""

    placement: Placement
    projector: FloatArray
    force: FloatArray
    """Net force along the allowed directions, shape (V, 3)."""
    jacobian: FloatArray
    """Of every element [1/cm], shape (elements, 3, 3)."""
    turning_stiffness: FloatArray
    """Of each vertex [1/cm], shape (V, 3, 3)."""
    residual: float


@dataclass(frozen=True, eq=False)
class Relaxation:
    """What stays the same during a relaxation."""

    springs: Springs
    assembly: Assembly
    attachment: Attachment
    patches: Patches

    def run(self, placement: Placement, tolerance: float, max_iterations: int, progress: Progress | None) -> Outcome:
        """Step until the residual is below the tolerance or the iterations are used up."""
        state = self.state(placement)
        shortest, longest = SHORTEST_TIME * self.springs.rest.unit, LONGEST_TIME * self.springs.rest.unit
        time_step = self.springs.rest.unit
        iteration = 0
        while state.residual > tolerance and iteration < max_iterations:
            trial = self.state(self.stepped(state, time_step))
            iteration += 1
            if trial.residual < LARGEST_RISE * state.residual:
                time_step *= STEP_GROWTH if trial.residual < state.residual else MILD_CUT
                state = trial
            else:
                time_step *= STEP_CUT
            time_step = min(max(time_step, shortest), longest)
            if progress is not None:
                progress(iteration, state.residual)
        return Outcome(state.placement, state.residual, iteration)

    def state(self, placement: Placement) -> State:
        """Forces at a placement.

        Raises:
            SolverError: they are not finite.
        """
        element_force, jacobian = element_forces(self.springs, placement)
        projector = self.attachment.projector(placement)
        whole = self.assembly.force(element_force)
        force = np.einsum("vij,vj->vi", projector, whole)
        residual = float(np.sqrt(np.mean(np.einsum("vi,vi->v", force, force))))
        if not np.isfinite(residual):
            bad = int(np.flatnonzero(~np.isfinite(force).all(axis=1))[0])
            raise SolverError(f"mesh relaxation: the force on vertex {bad} is not finite; check the mesh around it")
        return State(placement, projector, force, jacobian, turning_stiffness(placement, whole), residual)

    def stepped(self, state: State, time_step: float) -> Placement:
        """The placement after one backward Euler step, cut to the largest step."""
        matrix = self.assembly.system(state.jacobian, state.turning_stiffness + np.eye(3) / time_step)
        diagonal = matrix.data[self.assembly.diagonal]
        step, _ = modified_conjugate_gradients(
            matrix,
            state.force.ravel(),
            preconditioner(matrix, diagonal, state.projector, self.patches),
            tolerance=LINEAR_TOLERANCE,
            max_iterations=LINEAR_ITERATIONS,
        )
        step = step.reshape(-1, 3)
        unit = self.springs.rest.unit
        longest = float(np.linalg.norm(step, axis=1).max())
        step *= min(1.0, LARGEST_STEP * unit / max(longest, np.finfo(float).tiny))
        return self.attachment.moved(state.placement, step, STRIDE * unit)
