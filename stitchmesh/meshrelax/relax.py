# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxation: even out the stitches of a fabric on the limit surface (Yuksel et al. 2012, section 6.1).

First-order dynamics x' = f(x), stepped by backward Euler within the surface:

    (I - h df/dx) dx = h f

The step h [cm] grows while the forces fall and shrinks when they rise, so that the iteration ends as Newton's method.
It has converged when the root mean square of the net force along the surface, which does not depend on h, is below a
tolerance; a force of one would be half the pull of an edge stretched without end.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.errors import MeshError, ParameterError, SolverError
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.meshrelax.assembly import Assembly
from stitchmesh.meshrelax.attachment import Attachment, Placement, attach
from stitchmesh.meshrelax.conjugate_gradients import modified_conjugate_gradients
from stitchmesh.meshrelax.forces import element_forces, force_assembly
from stitchmesh.meshrelax.limit_surface import limit_surface
from stitchmesh.meshrelax.preconditioner import Patches, patches, preconditioner
from stitchmesh.meshrelax.rest_lengths import RestLengths, rest_lengths
from stitchmesh.meshrelax.sub_quads import Springs, edge_ends, springs

Progress = Callable[[int, float], None]
"""Called after each iteration with its number and the residual."""

ASPECT = 0.77
"""Course spacing over wale spacing of relaxed plain knit."""
ALPHA = 0.9
"""Part of the surface covered at rest: with 1, rows where a garment is narrow are squeezed enough to buckle sideways."""
TOLERANCE = 2e-3
MAX_ITERATIONS = 60
SURFACE_SPACING = 0.5
"""Edge length of the fine surface over the size of a stitch."""
LARGEST_STEP = 4.0
"""Largest move of a vertex in one iteration over the size of a stitch."""
STRIDE = 1.0
"""Largest move between two projections over the size of a stitch."""
REACH = 0.2
"""Distance over the size of a stitch within which a moved vertex usually finds the surface."""
STEP_GROWTH, MILD_CUT, STEP_CUT = 4.0, 0.5, 0.1
"""Factors of the time step where the residual fell, where it rose a little, and where the step was taken back."""
LARGEST_RISE = 1.2
"""Rise of the residual at which a step is taken back."""
SHORTEST_TIME, LONGEST_TIME = 1e-3, 1e4
"""Bounds of the time step over the size of a stitch: a short one is always good, and beyond the long one the identity
no longer steadies free motions."""
LINEAR_TOLERANCE, LINEAR_ITERATIONS = 0.01, 200
"""Of the conjugate gradients: with a coarser tolerance the jumps between the preconditioner's patches remain."""


@dataclass(frozen=True)
class MeshRelaxReport:
    """How a mesh relaxation went, in plain numbers."""

    seconds: float
    iterations: int
    converged: bool
    residual: float
    """Root mean square of the net force along the surface."""
    max_stretch: float
    """Largest length over rest length of an edge."""
    rms_stretch: float
    """Root mean square of length over rest length."""


def relax_mesh(
    fabric: StitchMesh,
    *,
    surface: Mesh,
    aspect: float = ASPECT,
    alpha: float = ALPHA,
    tolerance: float = TOLERANCE,
    max_iterations: int = MAX_ITERATIONS,
    device: str | None = "cpu",
    progress: Progress | None = None,
) -> StitchMesh:
    """Even out the stitches of a fabric on the subdivision surface of a mesh.

    Args:
        fabric: stitch faces whose vertices lie on the polygons of ``surface``.
        surface: the mesh that the fabric was tessellated from [cm]; the fabric moves onto its Catmull-Clark surface.
        aspect: rest length of a wale edge over that of a course edge.
        alpha: part of the surface's area that the stitches cover at rest, in (0, 1].
        tolerance: root mean square net force along the surface at which to stop.
        max_iterations: iterations after which to stop without having converged.
        device: Warp's name of the device that finds closest points; None for its preferred one.
        progress: called after each iteration with its number and the residual.

    Returns:
        The same stitches with new vertices [cm] and the ``stretch`` of each edge.

    Raises:
        ParameterError: a number is out of its range.
        MeshError: the fabric or the surface repeats on a lattice, or the fabric has a border and the surface none.
        SolverError: the forces are not finite.
    """
    return relax_mesh_with_report(
        fabric,
        surface=surface,
        aspect=aspect,
        alpha=alpha,
        tolerance=tolerance,
        max_iterations=max_iterations,
        device=device,
        progress=progress,
    )[0]


def relax_mesh_with_report(
    fabric: StitchMesh,
    *,
    surface: Mesh,
    aspect: float = ASPECT,
    alpha: float = ALPHA,
    tolerance: float = TOLERANCE,
    max_iterations: int = MAX_ITERATIONS,
    device: str | None = "cpu",
    progress: Progress | None = None,
) -> tuple[StitchMesh, MeshRelaxReport]:
    """``relax_mesh`` and how it went; arguments and errors are the same."""
    start = time.perf_counter()
    _check(fabric, aspect=aspect, alpha=alpha, tolerance=tolerance, max_iterations=max_iterations)
    spacing = SURFACE_SPACING * float(np.sqrt(np.linalg.norm(fabric.face_vector_area, axis=1).mean()))
    limit = limit_surface(surface, spacing)
    rest = rest_lengths(fabric, limit.area, aspect=aspect, alpha=alpha)
    attachment, placement = attach(fabric, limit, REACH * rest.unit, device)
    model = springs(fabric, rest)
    whole = patches(placement.position, placement.normal, limit.area)
    relaxation = Relaxation(model, force_assembly(model, len(fabric.vertices)), attachment, whole)
    outcome = relaxation.run(placement, tolerance, max_iterations, progress)
    stretch = edge_stretch(fabric, outcome.placement.position, rest)
    relaxed = replace(fabric, vertices=outcome.placement.position, stretch=stretch)
    report = MeshRelaxReport(
        seconds=time.perf_counter() - start,
        iterations=outcome.iterations,
        converged=outcome.residual <= tolerance,
        residual=outcome.residual,
        max_stretch=float(stretch.max()),
        rms_stretch=float(np.sqrt(np.mean(stretch**2))),
    )
    return relaxed, report


def edge_stretch(fabric: StitchMesh, position: FloatArray, rest: RestLengths) -> FloatArray:
    """Length over rest length of each edge, shape (E,)."""
    ends = edge_ends(fabric)
    length = np.linalg.norm(position[ends[:, 1]] - position[ends[:, 0]], axis=1)
    return length / np.where(fabric.is_wale[fabric.edge_side], rest.wale, rest.course)


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
    border_stiffness: FloatArray
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
        element_force, jacobian = element_forces(self.springs, placement.position)
        projector = self.attachment.projector(placement)
        whole = self.assembly.force(element_force)
        force = np.einsum("vij,vj->vi", projector, whole)
        residual = float(np.sqrt(np.mean(np.einsum("vi,vi->v", force, force))))
        if not np.isfinite(residual):
            bad = int(np.flatnonzero(~np.isfinite(force).all(axis=1))[0])
            raise SolverError(f"mesh relaxation: the force on vertex {bad} is not finite; check the mesh around it")
        return State(placement, projector, force, jacobian, border_stiffness(placement, whole), residual)

    def stepped(self, state: State, time_step: float) -> Placement:
        """The placement after one backward Euler step, cut to the largest step."""
        matrix = self.assembly.system(state.jacobian, state.border_stiffness + np.eye(3) / time_step)
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


def border_stiffness(placement: Placement, force: FloatArray) -> FloatArray:
    """Resistance to moves along a bent border, shape (V, 3, 3) [1/cm].

    The force along the border is f . t, which changes with the tangent t by f . dt/ds: where the border turns within a
    stitch, at the ends of a slit, this outweighs the springs. Only the part that holds a vertex back is kept.
    """
    change = np.einsum("vi,vi->v", force, placement.bend)
    tangent = placement.tangent
    return np.maximum(-change, 0.0)[:, None, None] * (tangent[:, :, None] * tangent[:, None, :])


def _check(fabric: StitchMesh, *, aspect: float, alpha: float, tolerance: float, max_iterations: int) -> None:
    if fabric.lattice is not None:
        raise MeshError("mesh relaxation: got a fabric on a lattice; expected one that lies on a surface")
    if not (np.isfinite(aspect) and aspect > 0.0):
        raise ParameterError(f"aspect: got {aspect}; expected a positive number, course over wale spacing")
    if not 0.0 < alpha <= 1.0:
        raise ParameterError(f"alpha: got {alpha}; expected a part of the area, above 0 and at most 1")
    if not tolerance > 0.0:
        raise ParameterError(f"tolerance: got {tolerance}; expected a positive number")
    if max_iterations < 0:
        raise ParameterError(f"max_iterations: got {max_iterations}; expected 0 or more")
