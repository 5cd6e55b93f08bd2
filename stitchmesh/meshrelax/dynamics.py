# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""First-order dynamics of a fabric on its surface, integrated by backward Euler (Yuksel et al. 2012, equation 1).

The equation of motion is x' = f(x), where f is the part of the forces in the allowed directions of each vertex. One
step is

    (I - h df/dx) dx = h f

The time step h [cm] grows while the forces decrease, and shrinks when they increase. At the end the iteration therefore
becomes Newton's method. The residual is the root mean square of f over the vertices and does not depend on h.
Forces are dimensionless; the force of an infinitely stretched edge is 2.

Most fabrics converge in this way within 60 iterations. In others the forces must increase before they can decrease, for
example where stitches turn over or rows slip past a fold; the time step then shrinks to nothing. After ``patience``
iterations such a fabric starts again, and two rules change. First, steps are judged by their work, and the residual may
rise: a step d is too long if f . d is negative after it, because it has then gone beyond the place where the fabric
comes to rest along d. Second, an inner vertex that is pressed against the end of the surface may move only along the
end. The first iterations use neither rule, so that fabrics that converge in them keep the same bits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Generic

import numpy as np
import warp as wp

from stitchmesh.errors import SolverError
from stitchmesh.mesh import FloatArray
from stitchmesh.meshrelax.forces import Elements
from stitchmesh.meshrelax.linear_solver import StepSystem
from stitchmesh.meshrelax.placement import MeshConstraint, P
from stitchmesh.run_control import RunStopped

Progress = Callable[[int, float], None]
"""Called after each iteration with its number and the residual."""
Note = Callable[[int, "MeshState[Any]"], None]
"""Called before the first iteration and after each one, with the number of iterations and the last accepted state. It
raises ``RunStopped`` if this state is to be the result."""

STRIDE = 1.0
"""Largest displacement between two projections, divided by the size of a stitch."""
SHORTEST_TIME, LONGEST_TIME = 1e-3, 1e4
"""Bounds of the time step divided by the size of a stitch. In practice a step of the lower bound is always accepted.
Above the upper bound the identity matrix is too small to regularize motions without stiffness."""
LINEAR_TOLERANCE, LINEAR_ITERATIONS = 0.01, 200
"""Tolerance and largest number of iterations of the conjugate gradients. A larger tolerance would leave jumps between
the patches of the preconditioner in the solution."""


@dataclass(frozen=True, eq=False)
class Outcome(Generic[P]):
    """Result of a relaxation."""

    placement: P
    """Last accepted placement."""
    residual: float
    """Residual of that placement."""
    iterations: int
    """Number of iterations, rejected steps included."""
    worst: int
    """Vertex with the largest force."""
    stopped: bool = False
    """Whether the user has stopped the relaxation."""


@dataclass(frozen=True, eq=False)
class MeshState(Generic[P]):
    """A placement with its forces."""

    placement: P
    projector: FloatArray
    """Projector onto the allowed directions of each vertex, shape (V, 3, 3)."""
    force: FloatArray
    """Net force on each vertex in its allowed directions, shape (V, 3)."""
    jacobian: wp.array[Any]
    """Jacobian of each element [1/cm], on the device (``forces.ElementForces``)."""
    turning_stiffness: FloatArray
    """Turning stiffness of each vertex [1/cm], shape (V, 3, 3)."""
    residual: float
    """Root mean square of ``force`` over the vertices."""


def residuals(before: MeshState[Any], after: MeshState[Any]) -> tuple[float, float]:
    """Return the residuals after and before a step."""
    return after.residual, before.residual


def works(before: MeshState[Any], after: MeshState[Any]) -> tuple[float, float]:
    """Return -f . d after a step d, and f . d before it, which is positive unless the surface ends on the way."""
    step = after.placement.position - before.placement.position
    first, last = (float(np.einsum("vi,vi->", state.force, step)) for state in (before, after))
    return (-last, first) if first > 0.0 else (np.inf, first)


@dataclass(frozen=True)
class StepControl:
    """How the time step changes with the number by which steps are judged."""

    compared: Callable[[MeshState[Any], MeshState[Any]], tuple[float, float]]
    """Returns the number by which steps are judged, after and before a step."""
    growth: float
    """Factor of the time step after a step whose rise is below ``mild_rise``."""
    mild_cut: float
    """Factor of the time step after a step with a larger rise."""
    cut: float
    """Factor of the time step after a rejected step."""
    mild_rise: float
    """Ratio of the number after a step to the number before it, from which on the time step shrinks."""
    largest_rise: float
    """Ratio from which on a step is rejected."""
    patience: int | None
    """Number of iterations after which steps are judged by their work instead of the residual; None for never."""


ON_SURFACE = StepControl(
    residuals, growth=4.0, mild_cut=0.5, cut=0.1, mild_rise=1.0, largest_rise=1.2, patience=60
)
"""Control of a relaxation on a surface."""
FREE = StepControl(residuals, growth=3.0, mild_cut=0.7, cut=0.3, mild_rise=1.0, largest_rise=2.0, patience=None)
"""Control of a relaxation without a surface. The slow motions of the whole fabric need long steps, which make the
residual rise for an iteration. With the control of a surface, large ribs would take many times as many iterations."""
BY_WORK = StepControl(works, growth=3.0, mild_cut=0.7, cut=0.3, mild_rise=0.1, largest_rise=0.5, patience=None)
"""Control after the patience. It rejects a step that goes at least 1.5 times as far as the place of rest along it."""


@dataclass(frozen=True, eq=False)
class MeshDynamics(Generic[P]):
    """The constant data of a relaxation, and its iteration."""

    elements: Elements
    """The elements between which the forces act."""
    system: StepSystem
    """The net forces and the linear system of a step."""
    attachment: MeshConstraint[P]
    """The constraint, which says where the vertices may move, for example on a surface."""
    moving_count: int
    """Number of vertices that are not held; the residual is the root mean square over them."""
    control: StepControl = ON_SURFACE
    """How the time step follows the residual, or the work."""

    def run(self, placement: P, tolerance: float, max_iterations: int, note: Note) -> Outcome[P]:
        """Iterate until the residual is at most the tolerance, the iterations reach their limit or the user stops.

        Raises:
            SolverError: the forces are not finite.
        """
        state, relaxation, iteration, stopped = self.state(placement), self, 0, False
        time_step = unit = self.elements.unit
        try:
            note(iteration, state)
            while state.residual > tolerance and iteration < max_iterations:
                if iteration == self.control.patience:
                    relaxation = replace(self, attachment=self.attachment.within(), control=BY_WORK)
                    state, time_step = relaxation.state(placement), unit
                trial = relaxation.state(relaxation.next_placement(state, time_step))
                iteration += 1
                control = relaxation.control
                new, old = control.compared(state, trial)
                if new < control.largest_rise * old:
                    time_step *= control.growth if new < control.mild_rise * old else control.mild_cut
                    state = trial
                else:
                    time_step *= control.cut
                time_step = min(max(time_step, SHORTEST_TIME * unit), LONGEST_TIME * unit)
                note(iteration, state)
        except RunStopped:
            stopped = True
        worst = int(np.einsum("vi,vi->v", state.force, state.force).argmax())
        return Outcome(state.placement, state.residual, iteration, worst, stopped)

    def state(self, placement: P) -> MeshState[P]:
        """Compute the forces at a placement.

        Raises:
            SolverError: the forces are not finite.
        """
        of_elements = self.elements.forces(placement)
        whole = self.system.net_force(of_elements.force)
        projector = self.attachment.projector(placement, whole)
        force = np.einsum("vij,vj->vi", projector, whole)
        residual = float(np.sqrt(np.einsum("vi,vi->v", force, force).sum() / self.moving_count))
        if not np.isfinite(residual):
            bad = int(np.flatnonzero(~np.isfinite(force).all(axis=1))[0])
            place = placement.position[bad].round(1).tolist()
            raise SolverError(f"mesh relaxation: near {place} cm: the force is not finite; check the mesh there")
        turning = self.attachment.turning_stiffness(placement, whole)
        return MeshState(placement, projector, force, of_elements.jacobian, turning, residual)

    def next_placement(self, state: MeshState[P], time_step: float) -> P:
        """Return the placement after one backward Euler step, scaled down to the largest allowed displacement."""
        self.system.set_matrix(state.jacobian, state.turning_stiffness + np.eye(3) / time_step, state.projector)
        step, _ = self.system.solve(state.force, tolerance=LINEAR_TOLERANCE, max_iterations=LINEAR_ITERATIONS)
        unit = self.elements.unit
        longest = float(np.linalg.norm(step, axis=1).max())
        # Largest displacement of a vertex in one iteration, divided by the size of a stitch.
        step *= min(1.0, 4.0 * unit / max(longest, np.finfo(float).tiny))
        return self.attachment.move(state.placement, step, STRIDE * unit)
