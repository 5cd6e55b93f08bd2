# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How well stitches fit the surface that they were made for, and which borders, handles and joins of it they lack.

Features that are smaller than a stitch are lost: a hole closes, or a narrow strap between two holes breaks. The numbers
of parts, borders and handles describe a surface up to deformation, by its Euler characteristic.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.mesh.polygon_mesh import connected_faces
from stitchmesh.mesh.shaping_stitches import stitch_counts
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.mesh.turns import turn_edges, turn_slits
from stitchmesh.shaping.triangle_surface import TriangleSurface


@dataclass(frozen=True)
class Topology:
    """Numbers that do not change when a surface is deformed."""

    parts: int
    """Number of connected parts."""
    borders: int
    """Number of borders."""
    handles: int
    """Number of handles; a torus has one."""


def topology(mesh: Mesh, tips: int = 0) -> Topology:
    """Count the parts, borders and handles of a mesh.

    Args:
        mesh: the mesh.
        tips: number of borders that count as closed, because a yarn is drawn through the loops there.
    """
    parts = int(connected_faces(mesh).max(initial=-1)) + 1
    borders = len(mesh.boundary_loops) - tips
    euler = len(np.unique(mesh.face_vertex)) - len(mesh.edge_side) + mesh.face_count + tips
    return Topology(parts, borders, (2 * parts - borders - euler) // 2)


def lost_features(given: Topology, fabric: Topology) -> str | None:
    """Return one sentence that says what a fabric lacks of its surface, with a remedy; None if it lacks nothing.

    Args:
        given: numbers of the surface.
        fabric: numbers of the fabric, whose tips count as closed.
    """
    differences = [
        f"{number} {name}s instead of {wanted}" if number != 1 else f"1 {name} instead of {wanted}"
        for name, number, wanted in (
            ("part", fabric.parts, given.parts),
            ("border", fabric.borders, given.borders),
            ("handle", fabric.handles, given.handles),
        )
        if number != wanted
    ]
    if not differences:
        return None
    return (
        f"the fabric has {', '.join(differences)}: a hole or a join of the mesh is finer than its stitches, or rows "
        "end all around it; choose a smaller stitch, or mark the border as begin or end"
    )


@dataclass(frozen=True)
class ShapingReport:
    """Figures of stitches on a surface."""

    seconds: float
    """Time that it took to find the stitches."""
    stitches: int
    """Number of stitches."""
    rows: int
    """Number of rows."""
    irregular: int
    """Increases, decreases and closings."""
    irregular_per_thousand: float
    """The same for each thousand stitches."""
    short_rows: int
    """Number of short rows: the turns of the yarn within the fabric, because each short row ends at one turn."""
    mismatched_edges: int
    """Edges at grafts, where wale directions differ."""
    largest_shaping: float
    """Largest part of the stitches of a row that are increases, decreases or closings."""
    stacked_rows: int
    """Rows whose increases and decreases are stacked at seams."""
    spread_rows: int
    """Rows whose increases and decreases are spread over the row."""
    lost: str | None
    """What the fabric lacks of the borders, handles and joins of the surface, in one sentence; None for nothing."""
    rms_distance: float
    """Root mean square distance of the vertices from the surface, in stitch widths."""
    largest_distance: float
    """Largest distance of a vertex from the surface, in stitch widths."""
    rms_stretch: float | None
    """Root mean square deviation of the stretch of stitches from their mean; None before mesh relaxation."""
    rms_edge_stretch: float | None
    """The same for single edges, which differ more: an increase has one wide side and two narrow ones."""


def shaping_report(
    fabric: StitchMesh, surface: TriangleSurface, width: float, seconds: float, tips: int = 0,
    rows: tuple[int, int] = (0, 0),
) -> ShapingReport:  # fmt: skip
    """Measure stitches on a surface.

    Args:
        fabric: the stitch mesh.
        surface: the surface that it was made for.
        width: width of a stitch [cm].
        seconds: time that it took to find the stitches.
        tips: number of borders of the fabric at which a yarn is drawn through the loops, and which the surface lacks.
        rows: the number of rows with increases and decreases at seams, and the number of rows with spread ones.
    """
    counts = stitch_counts(fabric)
    closings = int((fabric.stitch == Stitch.DRAW_THROUGH).sum())
    irregular = counts["increases"] + counts["decreases"] + closings
    distance = distance_to_surface(fabric.vertices, surface) / width
    turns = len(turn_slits(fabric))
    return ShapingReport(
        seconds=round(seconds, 3),
        stitches=fabric.face_count,
        rows=len(np.unique(fabric.row)),
        irregular=irregular,
        irregular_per_thousand=round(1000.0 * irregular / fabric.face_count, 2),
        short_rows=turns,
        mismatched_edges=int(fabric.mismatched.sum()) // 2,
        largest_shaping=round(_largest_shaping(fabric), 4),
        stacked_rows=rows[0],
        spread_rows=rows[1],
        lost=lost_features(topology(surface.mesh), topology(fabric, tips + turns)),
        rms_distance=round(float(np.sqrt(np.mean(distance**2))), 4),
        largest_distance=round(float(distance.max()), 4),
        rms_stretch=None if fabric.stretch is None else round(_deviation(_stretch_of_stitches(fabric)), 4),
        rms_edge_stretch=None if fabric.stretch is None else round(_deviation(_counted_stretch(fabric)), 4),
    )


def _largest_shaping(fabric: StitchMesh) -> float:
    """Largest part of the stitches of a row that are increases, decreases or closings."""
    shaped = np.bincount(fabric.row, fabric.n_bottom != fabric.n_top)
    return float((shaped / np.maximum(np.bincount(fabric.row), 1)).max())


def _counted_stretch(fabric: StitchMesh) -> FloatArray:
    """Stretch of each edge, shape (E,); NaN at the row ends at turns, which are meant to be short."""
    assert fabric.stretch is not None
    return np.where(turn_edges(fabric), np.nan, fabric.stretch)


def _stretch_of_stitches(fabric: StitchMesh) -> FloatArray:
    """Mean stretch of the edges of each stitch, shape (F,)."""
    stretch = _counted_stretch(fabric)[fabric.side_edge]
    known = np.isfinite(stretch)
    total = np.bincount(fabric.side_face[known], stretch[known], fabric.face_count)
    return total / np.maximum(np.bincount(fabric.side_face[known], minlength=fabric.face_count), 1)


def _deviation(values: FloatArray) -> float:
    """Root mean square deviation of values from their mean, over the mean."""
    return float(np.nanstd(values) / np.nanmean(values))


def distance_to_surface(points: FloatArray, surface: TriangleSurface, nearest: int = 12) -> FloatArray:
    """Distance of points from a surface of triangles [cm], shape (n,).

    The distance to the triangles with the nearest centres is exact; the triangles of a surface made for stitches are
    about as large as stitches, so that the nearest triangle is among them.
    """
    from scipy.spatial import cKDTree

    corner = surface.vertices[surface.triangles]
    _, found = cKDTree(corner.mean(axis=1)).query(points, k=min(nearest, len(corner)))
    found = found.reshape(len(points), -1)
    best = np.full(len(points), np.inf)
    for column in found.T:
        best = np.minimum(best, _distance_to_triangles(points, corner[column]))
    return best


def _distance_to_triangles(points: FloatArray, corner: FloatArray) -> FloatArray:
    """Distance of each point from its triangle, shape (n,), for corners of shape (n, 3, 3)."""
    a, b, c = corner[:, 0], corner[:, 1], corner[:, 2]
    normal = np.cross(b - a, c - a)
    size = np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(np.float64).tiny)
    height = np.einsum("ni,ni->n", points - a, normal / size)
    foot = points - height[:, None] * normal / size
    inside = np.ones(len(points), dtype=bool)
    best = np.full(len(points), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        inside &= np.einsum("ni,ni->n", np.cross(end - start, foot - start), normal) >= 0.0
        step = end - start
        square = np.maximum(np.einsum("ni,ni->n", step, step), np.finfo(np.float64).tiny)
        share = np.clip(np.einsum("ni,ni->n", points - start, step) / square, 0.0, 1.0)
        best = np.minimum(best, np.linalg.norm(points - start - share[:, None] * step, axis=1))
    return np.where(inside, np.abs(height), best)


def irregular_faces(fabric: StitchMesh) -> NDArray[np.bool_]:
    """Whether each stitch is an increase, a decrease, a closing, or the last one before a turn, shape (F,)."""
    shaped: NDArray[np.bool_] = fabric.n_bottom != fabric.n_top
    shaped[fabric.side_face[[side for side, _ in turn_slits(fabric)]]] = True
    return shaped
