# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxation of a fabric on the limit surface of a mesh (Yuksel et al. 2012, section 6.1)."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.compute.device import alone
from stitchmesh.errors import MeshError, ParameterError, check_kind
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.meshrelax.attachment import attach
from stitchmesh.meshrelax.dynamics import Progress, Relaxation
from stitchmesh.meshrelax.forces import force_assembly
from stitchmesh.meshrelax.limit_surface import limit_surface
from stitchmesh.meshrelax.preconditioner import patches
from stitchmesh.meshrelax.rest_lengths import RestLengths, rest_lengths
from stitchmesh.meshrelax.sub_quads import edge_ends, springs

ASPECT = 0.77
"""Course spacing divided by wale spacing of relaxed plain knit."""
ALPHA = 0.9
"""Part of the surface that unstressed stitches cover; with 1, rows in narrow places are compressed until they buckle
sideways."""
TOLERANCE = 2e-3
"""Residual at which a relaxation has converged (``dynamics``)."""
MAX_ITERATIONS = 60
"""Iterations after which a relaxation stops without having converged."""
SURFACE_SPACING = 0.5
"""Edge length of the fine surface, divided by the size of a stitch."""
REACH = 0.2
"""Distance within which a moved vertex usually finds the surface, divided by the size of a stitch."""


@dataclass(frozen=True)
class MeshRelaxReport:
    """Figures of a mesh relaxation."""

    seconds: float
    """Duration of the relaxation [s]."""
    iterations: int
    """Number of iterations."""
    converged: bool
    """Whether the residual is at most the tolerance."""
    residual: float
    """Root mean square of the net force along the surface, dimensionless."""
    max_stretch: float
    """Largest stretch (length divided by rest length) of an edge."""
    rms_stretch: float
    """Root mean square of the stretch of the edges."""


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
    """Equalize the sizes of the stitches of a fabric on the subdivision surface of a mesh.

    Args:
        fabric: stitch mesh whose vertices are on the polygons of ``surface``.
        surface: the mesh from which the fabric was tessellated [cm]; the fabric moves onto its Catmull-Clark surface.
        aspect: rest length of a wale edge divided by the rest length of a course edge.
        alpha: part of the area of the surface that unstressed stitches cover, in (0, 1].
        tolerance: root mean square of the net force along the surface at which the relaxation has converged.
        max_iterations: iterations after which the relaxation stops without having converged.
        device: Warp's name of the device that finds closest points; None for the preferred device.
        progress: called after each iteration with the number of the iteration and the residual.

    Returns:
        The same stitches with new vertices [cm] and the ``stretch`` of each edge.

    Raises:
        ParameterError: a number is out of range.
        MeshError: the fabric or the surface has a lattice, or the fabric has a border and the surface has none.
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
    """Relax a fabric as ``relax_mesh`` does, and also return the report; arguments and errors are the same."""
    start = time.perf_counter()
    check_kind("relax_mesh", fabric, StitchMesh)
    check_kind("relax_mesh, surface", surface, Mesh)
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
    """Return the stretch (length divided by rest length) of each edge, shape (E,).

    Args:
        fabric: stitch mesh.
        position: positions of its vertices [cm], shape (V, 3).
        rest: rest lengths of course and wale edges.
    """
    ends = edge_ends(fabric)
    length = np.linalg.norm(position[ends[:, 1]] - position[ends[:, 0]], axis=1)
    return length / np.where(fabric.is_wale[fabric.edge_side], rest.wale, rest.course)


def _check(fabric: StitchMesh, *, aspect: float, alpha: float, tolerance: float, max_iterations: int) -> None:
    if fabric.lattice is not None:
        raise MeshError("mesh relaxation: got a fabric on a lattice; expected one that lies on a surface")
    if not (np.isfinite(aspect) and aspect > 0.0):
        raise ParameterError(f"aspect: got {aspect}; expected a positive number, course spacing over wale spacing")
    if not 0.0 < alpha <= 1.0:
        raise ParameterError(f"alpha: got {alpha}; expected a part of the area, above 0 and at most 1")
    if not tolerance > 0.0:
        raise ParameterError(f"tolerance: got {tolerance}; expected a positive number")
    if max_iterations < 0:
        raise ParameterError(f"max_iterations: got {max_iterations}; expected 0 or more")
