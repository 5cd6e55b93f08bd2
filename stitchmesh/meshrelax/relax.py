# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxation: even out the stitches of a fabric on the limit surface (Yuksel et al. 2012, section 6.1)."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.compute.device import alone
from stitchmesh.errors import MeshError, ParameterError
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.meshrelax.attachment import attach
from stitchmesh.meshrelax.dynamics import Progress, Relaxation
from stitchmesh.meshrelax.forces import force_assembly
from stitchmesh.meshrelax.limit_surface import limit_surface
from stitchmesh.meshrelax.preconditioner import patches
from stitchmesh.meshrelax.rest_lengths import RestLengths, rest_lengths
from stitchmesh.meshrelax.sub_quads import edge_ends, springs

ASPECT = 0.77
"""Course spacing over wale spacing of relaxed plain knit."""
ALPHA = 0.9
"""Part of the surface covered at rest: with 1, rows in narrow places are squeezed enough to buckle sideways."""
TOLERANCE = 2e-3
"""Residual at which a relaxation has converged (``dynamics``)."""
MAX_ITERATIONS = 60
SURFACE_SPACING = 0.5
"""Edge length of the fine surface over the size of a stitch."""
REACH = 0.2
"""Distance over the size of a stitch within which a moved vertex usually finds the surface."""


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


@alone()
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
