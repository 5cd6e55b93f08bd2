# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxation of a fabric on the limit surface of a mesh (Yuksel et al. 2012, section 6.1).

After an edit only the stitches around it move. All others keep their relaxed yarns, from which the yarns of the edited
fabric can be relaxed.
"""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from stitchmesh.compute.device import alone, device_named
from stitchmesh.errors import MeshError, ParameterError, SolverError, check_kind
from stitchmesh.mesh import BORDER, FloatArray, IntArray, Mesh, StitchMesh
from stitchmesh.mesh.change import UNKNOWN_STRETCH
from stitchmesh.mesh.turns import with_tips_placed
from stitchmesh.meshrelax.assembly import assembly
from stitchmesh.meshrelax.attachment import attach
from stitchmesh.meshrelax.bobbles import Bobbles, carried, find_bobbles
from stitchmesh.meshrelax.dynamics import MeshDynamics, Outcome
from stitchmesh.meshrelax.forces import Elements, force_groups
from stitchmesh.meshrelax.linear_solver import StepSystem, patches
from stitchmesh.meshrelax.observer import MeshObserver
from stitchmesh.meshrelax.options import ASPECT, DEFAULT_OPTIONS, MeshRelaxOptions
from stitchmesh.meshrelax.placement import SurfacePlacement
from stitchmesh.meshrelax.report import MeshRelaxReport
from stitchmesh.meshrelax.rest_lengths import RestRectangle, rest_lengths
from stitchmesh.meshrelax.sub_quads import edge_ends, springs
from stitchmesh.meshrelax.surface.limit_surface import limit_surface
from stitchmesh.run import SHOWN, Run

logger = logging.getLogger(__name__)

TOLERANCE = 2e-3
"""Residual at which a relaxation has converged (``dynamics``)."""
MAX_ITERATIONS = 300
"""Number of iterations after which a relaxation stops without having converged. Garments, found rows and panels of
sewing patterns take at most 130 iterations. Stitches with twice or half the height with which they were made take at
most 230."""
SUITABLE_ASPECT = 2.0
"""Stitches still come to rest if the aspects at rest and as made differ by at most this factor."""
RINGS = 6
"""Rings of stitches around the changed ones that also move. An inserted row then takes its height from 14 rows."""


@dataclass(frozen=True, eq=False)
class RelaxedMesh:
    """The result of ``relax_mesh``."""

    fabric: StitchMesh
    """The same stitches with new vertices [cm] and the ``stretch`` of each edge."""
    report: MeshRelaxReport
    """Figures of the relaxation."""


@alone()
def relax_mesh(
    fabric: StitchMesh, *, surface: Mesh, options: MeshRelaxOptions = DEFAULT_OPTIONS,
    moving: NDArray[np.bool_] | None = None, tolerance: float = TOLERANCE, max_iterations: int = MAX_ITERATIONS,
    device: str | None = "cpu", run: Run[StitchMesh] = SHOWN,
) -> RelaxedMesh:  # fmt: skip
    """Equalize the sizes of the stitches of a fabric on the subdivision surface of a mesh.

    A relaxation that reaches the limit of iterations without having converged logs a warning. Bobbles, which stand off
    the surface, keep their shape and follow the stitches around them. A border of the fabric that lies on no border of
    the surface, for example after two rows have been separated, may move anywhere on the surface.

    Args:
        fabric: stitch mesh whose vertices are on the polygons of ``surface``.
        surface: the mesh from which the fabric was tessellated [cm]; the fabric moves onto its Catmull-Clark surface.
        options: the shape of unstressed stitches, the part of the surface that they cover, and the forces.
        moving: whether each vertex may move, shape (V,); None if all may move.
        tolerance: root mean square of the net force along the surface at which the relaxation has converged.
        max_iterations: iterations after which the relaxation stops without having converged.
        device: Warp's name of the device that finds closest points and computes the steps; None for the
            preferred device.
        run: progress after each iteration, and control, with one iteration as a step; all other fields are refused.

    Raises:
        ParameterError: a number is out of range, or the run has a field that this function does not obey.
        MeshError: the fabric or the surface has a lattice.
        SolverError: the forces are not finite, or stitches were pressed to a line or a point.
    """
    start = time.perf_counter()
    run.refuse_all_but("relax_mesh", "control")
    check_kind("relax_mesh", fabric, StitchMesh)
    check_kind("relax_mesh, surface", surface, Mesh)
    _check(fabric, tolerance=tolerance, max_iterations=max_iterations, moving=moving)
    # Edge length of the fine surface, divided by the size of a stitch.
    spacing = 0.5 * float(np.sqrt(np.linalg.norm(fabric.face_vector_area, axis=1).mean()))
    limit = limit_surface(surface, spacing)
    bobbles = find_bobbles(fabric)
    aspect = ASPECT if options.aspect is None else options.aspect
    rest = rest_lengths(fabric, limit.area, aspect=aspect, alpha=options.alpha, bobbles=bobbles)
    held = None if moving is None else ~moving
    # Distance within which a moved vertex usually finds the surface, divided by the size of a stitch.
    attachment, placement = attach(fabric, limit, 0.2 * rest.unit, device, bobbles=bobbles, held=held)
    model = springs(fabric, rest, bobbles=bobbles, area_force=options.area_force)
    whole = patches(placement.position, placement.normal, limit.area)
    count = len(fabric.vertices) if moving is None else max(1, int(moving.sum()))
    on = device_named(device)
    system = StepSystem(assembly(len(fabric.vertices), force_groups(model)), whole, on)
    relaxation = MeshDynamics(Elements(model, on), system, attachment, count)
    made = partial(_relaxed, fabric, rest, bobbles, moving)
    with run.assessments_shown("meshrelax", tolerance) as report_iteration:
        shown: MeshObserver[SurfacePlacement] = MeshObserver(
            lambda state: made(state.position)[0], tolerance, start, report_iteration, run.control
        )
        outcome = relaxation.run(placement, tolerance, max_iterations, shown.note)
    relaxed, known = made(outcome.placement.position)
    remedy = _remedy(fabric, outcome, aspect)
    report = MeshRelaxReport.of(outcome, known, tolerance=tolerance, seconds=shown.seconds(), remedy=remedy)
    if not (report.converged or report.stopped):
        logger.warning(not_converged(report))
    return RelaxedMesh(relaxed, report)


def _relaxed(
    fabric: StitchMesh, rest: RestRectangle, bobbles: Bobbles, moving: NDArray[np.bool_] | None, position: FloatArray
) -> tuple[StitchMesh, FloatArray]:
    """Return the fabric at new positions, shape (V, 3), and the stretch of the edges that lie on the surface."""
    position = position.copy()
    position[bobbles.raised] = carried(bobbles, fabric.vertices, position)
    stretch = edge_stretch(fabric, position, rest)
    on_surface = ~np.isin(edge_ends(fabric), bobbles.raised).any(axis=1)
    try:
        relaxed = replace(fabric, vertices=position, stretch=np.where(on_surface, stretch, UNKNOWN_STRETCH))
    except MeshError as error:
        raise _pressed_together(fabric, position) from error
    placed = ~bobbles.is_raised(len(position))
    return with_tips_placed(relaxed, placed if moving is None else placed & moving), stretch[on_surface]


def _pressed_together(fabric: StitchMesh, position: FloatArray) -> SolverError:
    """Return the error for stitches that lost their area; it names the former place of the smallest stitch."""
    corner = position[fabric.face_vertex]
    area = np.linalg.norm(np.add.reduceat(np.cross(corner, corner[fabric.side_next]), fabric.face_start[:-1]), axis=1)
    face = np.array([np.nan_to_num(area).argmin()])
    place = fabric.vertices[fabric.face_vertex[fabric.sides_of(face)]].mean(axis=0).round(1).tolist()
    return SolverError(
        f"mesh relaxation: near {place} cm stitches were pressed to a line or a point; choose another stitch width, or "
        "make the mesh smoother there"
    )


def not_converged(report: MeshRelaxReport) -> str:
    """Return the line that says that a relaxation has not converged, and what helps."""
    found = f"residual {report.residual:.2g} (expected {report.tolerance:g}) after {report.iterations} iterations"
    return f"stitches are not even: {found}; {report.remedy}"


def _remedy(fabric: StitchMesh, outcome: Outcome[SurfacePlacement], aspect: float) -> str:
    """Return what helps a relaxation that stopped after its last iteration."""
    if outcome.iterations < MAX_ITERATIONS:
        return f"allow more iterations (max_iterations, by default {MAX_ITERATIONS})"
    ends, wale = fabric.vertices[edge_ends(fabric)], fabric.is_wale[fabric.edge_side]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    made = float(length[wale].mean() / length[~wale].mean())
    lowest, highest = made / SUITABLE_ASPECT, made * SUITABLE_ASPECT
    if not lowest <= aspect <= highest:
        return f"choose an aspect from {lowest:.2f} to {highest:.2f}, because the stitches were made with {made:.2f}"
    place = outcome.placement.position[outcome.worst].round(1).tolist()
    return f"check near {place} cm that the surface is that of the fabric and that no stitch is inverted"


def edge_stretch(fabric: StitchMesh, position: FloatArray, rest: RestRectangle) -> FloatArray:
    """Return the stretch (length divided by rest length) of each edge, shape (E,).

    Args:
        fabric: stitch mesh.
        position: positions of its vertices [cm], shape (V, 3).
        rest: rest lengths of course and wale edges.
    """
    ends = edge_ends(fabric)
    length = np.linalg.norm(position[ends[:, 1]] - position[ends[:, 0]], axis=1)
    return length / np.where(fabric.is_wale[fabric.edge_side], rest.wale, rest.course)


def _check(fabric: StitchMesh, *, tolerance: float, max_iterations: int, moving: NDArray[np.bool_] | None) -> None:
    if fabric.lattice is not None:
        raise MeshError("mesh relaxation: got a fabric on a lattice; expected one that lies on a surface")
    if not tolerance > 0.0:
        raise ParameterError(f"tolerance: got {tolerance}; expected a positive number")
    if moving is not None and (moving.dtype != bool or moving.shape != (len(fabric.vertices),)):
        expected = f"one truth value for each of {len(fabric.vertices)} vertices"
        raise ParameterError(f"moving: got an array of {moving.dtype} and shape {moving.shape}; expected {expected}")
    if max_iterations < 0:
        raise ParameterError(f"max_iterations: got {max_iterations}; expected 0 or more")


def relax_mesh_around_edit(
    before: StitchMesh, after: StitchMesh, *, surface: Mesh | None = None, device: str | None = "cpu"
) -> RelaxedMesh:
    """Relax the stitches that an edit has changed, and those around them; all other vertices stay where they are.

    Args:
        before: relaxed stitch mesh before the edit.
        after: the stitch mesh after the edit.
        surface: the mesh of the garment; the surface of ``before`` if None.
        device: Warp's name of the device, as of ``relax_mesh``; None for the preferred device.

    Raises:
        MeshError: ``relax_mesh`` refuses the fabric or the surface.
        SolverError: ``relax_mesh`` cannot continue.
    """
    moving = vertices_around(after, changed_faces(before, after), RINGS)
    return relax_mesh(after, surface=before if surface is None else surface, moving=moving, device=device)


def changed_faces(before: StitchMesh, after: StitchMesh) -> IntArray:
    """Return the faces after an edit that are new or differ in their sides or their border sides, ascending."""
    tree = cKDTree(_centres(before))
    # Distance of coinciding points, divided by the size of the fabric.
    within = 1e-9 * float(np.ptp(before.vertices, axis=0).max())
    distance, same = tree.query(_centres(after), distance_upper_bound=within)
    found = np.isfinite(distance)
    sides = np.diff(after.face_start)
    found[found] &= np.diff(before.face_start)[same[found]] == sides[found]
    found[found] &= _border_sides(before)[same[found]] == _border_sides(after)[found]
    return np.flatnonzero(~found)


def vertices_around(fabric: StitchMesh, faces: IntArray, rings: int) -> NDArray[np.bool_]:
    """Return whether each vertex belongs to ``faces`` or to the ``rings`` rings of faces around them, shape (V,)."""
    chosen = np.zeros(len(fabric.vertices), dtype=bool)
    chosen[fabric.face_vertex[fabric.sides_of(faces)]] = True
    for _ in range(rings):
        touched = np.zeros(fabric.face_count, dtype=bool)
        touched[fabric.side_face[chosen[fabric.face_vertex]]] = True
        chosen[fabric.face_vertex[touched[fabric.side_face]]] = True
    return chosen


def _centres(fabric: StitchMesh) -> FloatArray:
    """Mean of the corners of each face [cm], shape (F, 3)."""
    total = np.add.reduceat(fabric.corner_position, fabric.face_start[:-1], axis=0)
    centres: FloatArray = total / np.diff(fabric.face_start)[:, None]
    return centres


def _border_sides(fabric: StitchMesh) -> IntArray:
    """Number of sides of each face that lie on a border, shape (F,)."""
    return np.bincount(fabric.side_face[fabric.twin == BORDER], minlength=fabric.face_count)
