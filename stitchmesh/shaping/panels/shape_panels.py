# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches on the panels of a sewing pattern: the order of operations.

First the outlines are divided. Then each panel gets its triangles, time, level lines and stitches. Last, the seams are
joined. At sharp folds, where panels lie on each other, the fabric needs room for its thickness. Two layers of stitches,
back to back or face to face, are moved apart along their normals until their distance is the thickness of a knitted
fabric. The motion is spread over the stitches beside them.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from stitchmesh.errors import ParameterError, TessellationError, check_kind, check_positive
from stitchmesh.mesh import FloatArray, IntArray, Mesh, StitchMesh
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.progress import Progress, shown_stages
from stitchmesh.shaping.auto_stitches import EDGE_OVER_WIDTH, MOST_STITCHES
from stitchmesh.shaping.counts import StitchSize
from stitchmesh.shaping.found_stitches import faces_of
from stitchmesh.shaping.level_lines import LevelLine, level_lines
from stitchmesh.shaping.options import DEFAULT_PLACEMENT, Placement, check_placement
from stitchmesh.shaping.panels.options import PanelDirection, PanelName, PanelOptions
from stitchmesh.shaping.panels.outline_pieces import outline_pieces
from stitchmesh.shaping.panels.panel_mesh import PanelMesh
from stitchmesh.shaping.panels.panel_rows import PanelStitches
from stitchmesh.shaping.panels.panel_seams import drawn_back, gap_at, sides_on_seams, with_equal_seams
from stitchmesh.shaping.panels.panel_time import PanelTime, hems_of, panel_time
from stitchmesh.shaping.panels.refined_panel import refined_panel
from stitchmesh.shaping.panels.sewing import SeamResult, sewn_fabric
from stitchmesh.shaping.seams import ShapedRows
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING, STITCH_WIDTH

THICKNESS = 0.8
"""Distance of two layers, in stitch widths: loops are six yarn radii thick, and a radius is an eighth of a width."""
Directions = (
    Mapping[int, tuple[float, float]] | Mapping[str, tuple[float, float]] | Mapping[PanelName, tuple[float, float]]
)
"""Direction of knitting of some panels in their texture (u, v), by number or name."""
Pairs = Sequence[tuple[PanelName, PanelName]]
"""Pairs of panels, each by number or name."""


def opened_folds(mesh: Mesh, width: float) -> FloatArray:
    """Return the vertices of a stitch mesh after opposed layers were moved apart [cm], shape (V, 3).

    Args:
        mesh: the stitches.
        width: width of a stitch [cm].
    """
    points, ends = mesh.vertices, np.stack([mesh.face_vertex, mesh.face_vertex[mesh.side_next]])
    # Number of times that layers are moved apart; the normals change each time.
    for _ in range(4):
        normals = _vertex_normals(mesh, points)
        motion = _motion(points, normals, THICKNESS * width)
        if not motion.any():
            break
        points = points + _spread(motion, ends)[:, None] * normals
    return points


def _vertex_normals(mesh: Mesh, points: FloatArray) -> FloatArray:
    """Unit normal at each vertex, shape (V, 3): the mean of the normals at its corners."""
    corner = mesh.face_vertex
    before = np.empty(mesh.side_count, dtype=np.int64)
    before[mesh.side_next] = np.arange(mesh.side_count)
    here = points[corner]
    area = np.cross(points[corner[mesh.side_next]] - here, points[corner[before]] - here)
    normal: FloatArray = np.stack([np.bincount(corner, area[:, axis], len(points)) for axis in range(3)], axis=1)
    return unit_vectors(normal)


def _motion(points: FloatArray, normals: FloatArray, thickness: float) -> FloatArray:
    """Half of the distance that each vertex lacks to the nearest opposed vertex, along its normal [cm], (V,)."""
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(thickness, output_type="ndarray")
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    first, second = pairs.T
    # Cosine of the angle of two normals below which their layers are opposed.
    opposed = np.einsum("ni,ni->n", normals[first], normals[second]) < -0.3
    first, second = first[opposed], second[opposed]
    height = np.einsum("ni,ni->n", points[first] - points[second], normals[first])
    # Layers that lie in one place are back to back: patterns are flat outside out.
    side = np.where(height > -0.1 * thickness, 1.0, -1.0)
    missing = 0.5 * (thickness - np.abs(height)).clip(0.0) * side
    order = np.argsort(np.abs(missing), kind="stable")
    motion = np.zeros(len(points))
    motion[first[order]] = missing[order]
    return motion


def _spread(motion: FloatArray, ends: IntArray) -> FloatArray:
    """Spread a motion over neighbouring vertices, shape (V,); no vertex moves less than it has to."""
    pairs = np.concatenate([ends, ends[::-1]], axis=1)
    count = np.bincount(pairs[0], minlength=len(motion))
    spread = motion
    # Number of stitches over which the motion is spread.
    for _ in range(3):
        mean = np.bincount(pairs[0], spread[pairs[1]], len(motion)) / np.maximum(count, 1)
        spread = np.where(np.abs(motion) > np.abs(mean), motion, mean)
    return spread


@dataclass(frozen=True)
class PanelReport:
    """Figures of stitches on panels."""

    seconds: float
    """Time that it took to find the stitches."""
    stitches: int
    """Number of stitches."""
    rows: int
    """Number of rows."""
    grafted_edges: int
    """Course edges at seams that two panels share."""
    joined_edges: int
    """Wale edges at seams, through which rows go on in the next panel."""
    sewn_edges: int
    """Border edges of the stitches that lie on seams, for a needle and a thread."""
    stacked_rows: int
    """Rows whose increases and decreases are stacked at the ends."""
    spread_rows: int
    """Rows whose increases and decreases are spread over the row."""
    mean_angle: float
    """Mean angle between the rows and the lines across the direction of knitting [degrees], weighted by area."""
    largest_angle: float
    """Angle that 99 % of the area does not exceed [degrees]."""


@dataclass(frozen=True, eq=False)
class ShapedPanels:
    """Stitches on panels, with how they were joined."""

    fabric: StitchMesh
    """The stitches, before mesh relaxation."""
    surface: Mesh
    """The faces of the stitches before mesh relaxation, which are its surface: a border with steps keeps its
    steps, and layers that were moved apart stay so."""
    face_panel: IntArray
    """Panel of each stitch, shape (F,)."""
    seams: tuple[SeamResult, ...]
    """How each piece of a seam was made."""
    report: PanelReport
    """Figures."""


def shape_panels(
    panels: PanelMesh, *, stitch_width: float = STITCH_WIDTH, stitch_height: float | None = None,
    directions: Directions | None = None, sewn: Pairs = (), shaping: Placement = DEFAULT_PLACEMENT,
) -> StitchMesh:  # fmt: skip
    """Knit each panel of a sewing pattern in a given direction, and join the panels at their seams.

    Seams of two hems are grafted. At seams of two sides the rows go on in the next panel if they agree. Other seams
    stay borders that lie on each other, to be sewn. ``knit_panels`` also returns the surface for mesh relaxation.

    Args:
        panels: the panels, from ``read_panels``.
        stitch_width: wale spacing [cm].
        stitch_height: course spacing [cm]; by default 0.77 times the width.
        directions: direction of knitting in the texture (u, v), by panel; by default the directions of ``panels``. A
            name stands for all panels whose object, group or material has it.
        sewn: pairs of panels whose seams are left to be sewn, also where their stitches fit.
        shaping: where increases and decreases stand: ``spread`` over the row, or ``seams``: at both ends of it, one
            stitch from the edge, in a steady rhythm. Where a panel needs more of them, they are spread in spite of
            ``seams``.

    Returns:
        A stitch mesh on the panels.

    Raises:
        ParameterError: a number is out of range, a panel does not exist, or a direction is zero.
        TessellationError: a panel is narrower than two stitches or lower than a row, its texture does not change along
            the direction, neighbouring rows differ too much, or there would be too many stitches.
    """
    return knit_panels(
        panels, stitch_width=stitch_width, stitch_height=stitch_height, directions=directions, sewn=sewn,
        shaping=shaping,
    ).fabric  # fmt: skip


def knit_panels(
    panels: PanelMesh, *, stitch_width: float = STITCH_WIDTH, stitch_height: float | None = None,
    directions: Directions | None = None, sewn: Pairs = (), shaping: Placement = DEFAULT_PLACEMENT,
    progress: Progress | Literal[False] | None = None,
) -> ShapedPanels:  # fmt: skip
    """Knit panels as ``shape_panels`` does, and return how they were joined; arguments and errors are the same."""
    check_kind("shape_panels", panels, PanelMesh, "sm.read_panels(path)")
    height = COURSE_OVER_WALE_SPACING * stitch_width if stitch_height is None else stitch_height
    check_placement(shaping)
    size = StitchSize(stitch_width, height, shaping=shaping)
    _check_size(panels, size)
    direction, apart = _directions(panels, directions or {}), _panels_apart(panels, sewn)
    with shown_stages(progress) as report_panel:
        return _knit(panels, size, direction, apart, report_panel)


def _knit(
    panels: PanelMesh, size: StitchSize, direction: FloatArray, apart: set[tuple[int, int]], progress: Progress
) -> ShapedPanels:
    """Knit panels in their directions, shape (panels, 2), and join them, except for pairs that stay apart."""
    start = time.perf_counter()
    pieces = outline_pieces(panels, direction, size.width)
    times = []
    for panel in range(panels.panel_count):
        progress("shape", 0.5 * panel / panels.panel_count, f"time of panel {panel}")
        refined = refined_panel(panels, panel, EDGE_OVER_WIDTH * size.width)
        with _named(panel):
            times.append(panel_time(panel, refined, pieces, direction[panel], size.height))
    times, made = with_equal_seams(times, pieces), PanelStitches(size)
    for panel, found in enumerate(times):
        progress("shape", 0.5 + 0.5 * panel / panels.panel_count, f"stitches of panel {panel}")
        with _named(panel):
            levels = level_lines(found.refined.surface, found.courses, found.ends, found.refined.flat)
            made.knit(panel, levels, hems_of(found, pieces, size.width))
    lines = [LevelLine(0, panels.mesh.vertices[piece.vertices], closed=False) for piece in pieces]
    fabric, seams = sewn_fabric(made, pieces, lines, apart)
    face_panel = np.array(made.face_panel)
    sewn, on_piece = sides_on_seams(fabric, face_panel, pieces, lines, size.width)
    gap = np.array([gap_at(pieces[number], size.width) for number in on_piece])
    fabric = replace(fabric, vertices=drawn_back(fabric, sewn, gap))
    fabric = replace(fabric, vertices=opened_folds(fabric, size.width))
    report = _report(fabric, seams, len(sewn), times, made.shaped, time.perf_counter() - start)
    return ShapedPanels(fabric, faces_of(fabric), face_panel, seams, report)


@contextmanager
def _named(panel: int) -> Iterator[None]:
    """Give the errors of a panel its number."""
    try:
        yield
    except TessellationError as error:
        raise TessellationError(f"panel {panel}: {error}") from error


def _report(
    fabric: StitchMesh, seams: Sequence[SeamResult], sewn: int, times: list[PanelTime], shaped: ShapedRows,
    seconds: float,
) -> PanelReport:  # fmt: skip
    """Gather the figures."""
    angle = np.degrees(np.concatenate([found.angle for found in times]))
    area = np.concatenate([found.refined.surface.area for found in times])
    order = np.argsort(angle)
    share = np.cumsum(area[order]) / area.sum()
    return PanelReport(
        seconds=round(seconds, 3),
        stitches=fabric.face_count,
        rows=len(np.unique(fabric.row)),
        grafted_edges=sum(seam.edges for seam in seams if seam.kind == "grafted"),
        joined_edges=sum(seam.edges for seam in seams if seam.kind == "joined"),
        sewn_edges=sewn,
        stacked_rows=shaped.stacked,
        spread_rows=shaped.spread,
        mean_angle=round(float(np.average(angle, weights=area)), 3),
        largest_angle=round(float(angle[order][np.searchsorted(share, 0.99)]), 3),
    )


def _directions(panels: PanelMesh, given: Directions) -> FloatArray:
    """Return the direction of knitting of each panel, shape (P, 2).

    Raises:
        ParameterError: a panel does not exist, or a direction is not two finite numbers that are not both zero.
    """
    direction = panels.direction.copy()
    named = tuple(PanelDirection(panel=name, direction=along) for name, along in given.items())
    for one in PanelOptions(directions=named).directions:
        direction[_numbers(panels, "directions", one.panel)] = one.direction
    bad = np.flatnonzero(~direction.any(axis=1))
    if len(bad):
        raise ParameterError(f"directions: panel {bad[0]}: got (0, 0); expected two numbers that are not both zero")
    return direction


def _panels_apart(panels: PanelMesh, sewn: Pairs) -> set[tuple[int, int]]:
    """Return the pairs of panels, the lower number first, whose seams are left to be sewn.

    Raises:
        ParameterError: a panel does not exist, or two panels have no seam.
    """
    seams = {(min(seam.panels), max(seam.panels)) for seam in panels.seams}
    apart: set[tuple[int, int]] = set()
    for first, second in sewn:
        ones, others = (_numbers(panels, "sewn", name) for name in (first, second))
        pairs = {(min(one, other), max(one, other)) for one in ones for other in others} & seams
        if not pairs:
            raise ParameterError(f"sewn: panels {first} and {second} have no seam; leave them out")
        apart |= pairs
    return apart


def _numbers(panels: PanelMesh, option: str, name: PanelName) -> list[int]:
    """Return the numbers of the panels that have a name; an error names the option."""
    try:
        return panels.panels_named(name)
    except ParameterError as error:
        raise ParameterError(f"{option}: {error}") from error


def _check_size(panels: PanelMesh, size: StitchSize) -> None:
    """Check the size of the stitches, and that they are not too many.

    Raises:
        ParameterError, TessellationError: as for ``shape_panels``.
    """
    for name, value in (("stitch width", size.width), ("stitch height", size.height)):
        check_positive(name, value, "cm")
    area = float(np.linalg.norm(panels.mesh.face_vector_area, axis=1).sum())
    count = area / (size.width * size.height)
    if count > MOST_STITCHES:
        raise TessellationError(
            f"panels of {area:.4g} cm^2 would take {count:.3g} stitches; at most {MOST_STITCHES:,} are made: choose a "
            "larger stitch, and check the unit"
        )
