# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxation of a fabric that no surface holds (Yuksel et al. 2012, section 7 and figure 14c).

The forces are the same as in the relaxation on a surface, and every stitch has the rest size that follows from its
neighbourhood (``stitch_sizes``). The fabric stays in its plane, as on a table. Springs have no bending stiffness, so
that in space a fabric would buckle wherever its stitches are compressed. The periods of a fabric on a lattice relax
too.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError, check_kind, check_positive
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.mesh.change import UNKNOWN_STRETCH
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.mesh.turns import with_tips_placed
from stitchmesh.meshrelax.assembly import assembly
from stitchmesh.meshrelax.bobbles import NO_BOBBLES, Bobbles, carried, find_bobbles
from stitchmesh.meshrelax.dynamics import FREE, MeshDynamics
from stitchmesh.meshrelax.forces import Elements, force_groups
from stitchmesh.meshrelax.free.free_shape import FreeShape
from stitchmesh.meshrelax.free.free_springs import FreeSprings, free_springs
from stitchmesh.meshrelax.free.points import FabricPlane, plane_normal
from stitchmesh.meshrelax.free.stitch_sizes import stitch_sizes
from stitchmesh.meshrelax.linear_solver import StepSystem
from stitchmesh.meshrelax.observer import MeshObserver
from stitchmesh.meshrelax.options import ASPECT, STITCH_WIDTH
from stitchmesh.meshrelax.placement import PlacedPoints
from stitchmesh.meshrelax.report import MeshRelaxReport
from stitchmesh.run import SHOWN, Run

logger = logging.getLogger(__name__)

FREE_TOLERANCE = 1e-4
"""Residual at which a relaxation without a surface has converged. Small forces shape the outline of a long piece."""
FREE_MAX_ITERATIONS = 200
"""Iterations after which a relaxation without a surface stops without having converged."""


def relax_mesh_freely(
    fabric: StitchMesh,
    *,
    stitch_width: float = STITCH_WIDTH,
    aspect: float = ASPECT,
    tolerance: float = FREE_TOLERANCE,
    max_iterations: int = FREE_MAX_ITERATIONS,
    run: Run[StitchMesh] = SHOWN,
    shown_as: Callable[[StitchMesh], StitchMesh] | None = None,
) -> FreeShape:
    """Relax a fabric without a surface, so that it takes the outline that its stitches give it.

    The fabric stays in its plane. The periods of a fabric on a lattice relax too; afterwards the first one lies along
    x. A tube is also relaxed as such a fabric: as a strip on a lattice with one period around it (``unroll_tube``).

    Args:
        fabric: stitch mesh, for example from ``pattern_mesh``.
        stitch_width: rest width of plain knit [cm].
        aspect: rest height of plain knit divided by its rest width.
        tolerance: root mean square of the net force at which the relaxation has converged, dimensionless.
        max_iterations: iterations after which the relaxation stops without having converged; it then logs a warning.
        run: progress after each iteration, and control, with one iteration as a step. Its snapshots hold the positions
            and the stretch of each edge. The function refuses all other fields of the run.
        shown_as: makes the fabric of the snapshots and of the result, for example a round tube, from the relaxed
            fabric.

    Returns:
        The same stitches with new vertices [cm] and the ``stretch`` of each edge, with their size and outline.

    Raises:
        ParameterError: a number is out of range, or the mesh has panels that are not divided into stitches.
        MeshError: the fabric is not flat.
        SolverError: the forces are not finite.
    """
    start = time.perf_counter()
    run.refuse_all_but("relax_mesh_freely", "control")
    _check(fabric, stitch_width, aspect, tolerance, max_iterations)
    bobbles = find_bobbles(fabric) if fabric.lattice is None else NO_BOBBLES
    forces = free_springs(fabric, stitch_sizes(fabric, width=stitch_width, height=aspect * stitch_width), bobbles)
    points, model = forces.corners.points, forces.springs
    plane = FabricPlane(points, plane_normal(fabric))
    groups = [points.on_unknowns(*group) for group in force_groups(model)]
    patches = plane.patches(forces.corners.position, model.unit)
    on = device_named("cpu")
    system = StepSystem(assembly(points.unknown_count, groups), patches, on)
    relaxation = MeshDynamics(Elements(model, on), system, plane, points.unknown_count, FREE)

    def made(placement: PlacedPoints) -> StitchMesh:
        relaxed = _relaxed(fabric, forces, bobbles, placement)
        return relaxed if shown_as is None else shown_as(relaxed)

    with run.assessments_shown("outline", tolerance) as report_iteration:
        shown = MeshObserver(made, tolerance, start, report_iteration, run.control)
        outcome = relaxation.run(plane.place(forces.corners.position), tolerance, max_iterations, shown.note)
    relaxed = made(outcome.placement)
    assert relaxed.stretch is not None  # The relaxation fills it.
    known, remedy = relaxed.stretch[np.isfinite(relaxed.stretch)], "allow more iterations (max_iterations)"
    report = MeshRelaxReport.of(outcome, known, tolerance=tolerance, seconds=shown.seconds(), remedy=remedy)
    if not (report.converged or report.stopped):
        found = f"residual {report.residual:.2g} (expected {tolerance:g}) after {report.iterations} iterations"
        logger.warning(f"the outline is not at rest: {found}; {report.remedy}")
    return FreeShape(relaxed, report, (stitch_width, aspect * stitch_width))


def _check(fabric: object, stitch_width: float, aspect: float, tolerance: float, max_iterations: int) -> None:
    check_kind("relax_mesh_freely", fabric, StitchMesh)
    assert isinstance(fabric, StitchMesh)  # Checked above.
    for name, value in (("stitch_width", stitch_width), ("aspect", aspect), ("tolerance", tolerance)):
        check_positive(name, value)
    if max_iterations < 0:
        raise ParameterError(f"max_iterations: got {max_iterations}; expected 0 or more")
    panels = np.flatnonzero(fabric.stitch == Stitch.PANEL)
    if len(panels):
        raise ParameterError(f"face {panels[0]}: is a panel of a coarse mesh, not a stitch; tessellate the mesh first")


def _relaxed(fabric: StitchMesh, forces: FreeSprings, bobbles: Bobbles, placement: PlacedPoints) -> StitchMesh:
    """Return the fabric at a placement, with the stretch of its edges."""
    position = placement.position
    ends = position[forces.edge_points]
    stretch = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / forces.edge_rest
    vertices = position[: len(fabric.vertices)].copy()
    vertices[bobbles.raised] = carried(bobbles, fabric.vertices, vertices)
    raised = bobbles.is_raised(len(vertices))[fabric.face_vertex[fabric.edge_side]]
    raised |= bobbles.is_raised(len(vertices))[fabric.face_vertex[fabric.side_next[fabric.edge_side]]]
    stretch = np.where(raised, UNKNOWN_STRETCH, stretch)
    if fabric.lattice is None:
        flat = replace(fabric, vertices=vertices, stretch=stretch)
        return with_tips_placed(flat, ~bobbles.is_raised(len(vertices)))
    periods = _periods(fabric.lattice, forces, position)
    turn = _along_x(periods)
    return replace(fabric, vertices=vertices @ turn, lattice=Lattice(periods @ turn), stretch=stretch)


def _periods(before: Lattice, forces: FreeSprings, position: FloatArray) -> FloatArray:
    """Return the periods after a motion of the points [cm], shape (2, 3); one that no stitch crosses stays upright."""
    points = forces.corners.points
    apart = position - position[points.vertex]
    images = points.share - points.share[points.vertex]
    found = np.linalg.lstsq(images, apart, rcond=None)[0]
    if len(found) == len(before.periods):
        return np.array(found)
    normal = np.cross(before.periods[0], before.periods[1])
    upward = np.cross(normal, found[0])
    size = np.linalg.norm(before.periods[1]) / np.linalg.norm(upward)
    return np.stack([found[0], size * upward])


def _along_x(periods: FloatArray) -> FloatArray:
    """Return the matrix that turns row vectors so that the first period lies along x, and both in the plane z = 0."""
    first = periods[0] / np.linalg.norm(periods[0])
    upward: FloatArray = np.cross(periods[0], periods[1])
    normal = upward / np.linalg.norm(upward)
    return np.stack([first, np.cross(normal, first), normal], axis=1)
