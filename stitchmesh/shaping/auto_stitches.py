# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches on any surface: the order of operations.

    mesh -> triangles -> ends -> time -> level lines and bands -> stitches

Parts of a mesh that are not connected are knitted one after another.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import MeshError, ParameterError, TessellationError, check_kind, check_positive
from stitchmesh.io.library_meshes import MeshLike, as_mesh
from stitchmesh.memory_need import BASE_MEMORY, BYTES_PER_FOUND_STITCH, check_memory
from stitchmesh.mesh import BORDER, FloatArray, IntArray, Mesh, StitchMesh
from stitchmesh.mesh.shaping_stitches import DEFAULT_INCREASE, Increase, check_increase, with_increases
from stitchmesh.progress import Progress, shown_stages
from stitchmesh.shaping.branchings import changes_around, with_joins_and_parts_apart
from stitchmesh.shaping.counts import SMALLEST_TIP, StitchSize, rounded_count
from stitchmesh.shaping.ends import Ends
from stitchmesh.shaping.finer_than_stitches import knitted_surface
from stitchmesh.shaping.flat_pieces import knitted_flat_piece
from stitchmesh.shaping.found_stitches import faces_of
from stitchmesh.shaping.level_lines import LevelLines, without_small_tips
from stitchmesh.shaping.marks import TimeMark, marked_ends
from stitchmesh.shaping.options import AUTOMATIC, ShapingOptions, check_most_shaping
from stitchmesh.shaping.plain_places import plain_places
from stitchmesh.shaping.report import ShapingReport, shaping_report
from stitchmesh.shaping.rows import stitches_between
from stitchmesh.shaping.seams import ShapedRows
from stitchmesh.shaping.short_row_plan import with_short_rows
from stitchmesh.shaping.time_function import knitting_time
from stitchmesh.shaping.triangle_surface import TriangleSurface, connected_parts, divided, without_fine_features
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING, STITCH_WIDTH

logger = logging.getLogger(__name__)

EDGE_OVER_WIDTH = 2.0
"""Longest edge of the triangles on which the time is computed, over the width of a stitch."""
MOST_STITCHES = 3_000_000
"""Largest number of stitches; the tables of more would not fit in the memory of a usual machine."""
SHARE_OF_TIME, SHARE_OF_ROWS = 0.25, 0.95
"""Completed parts of the search when it knows the time, and when it knows all rows."""


@dataclass(frozen=True, eq=False)
class ShapedFabric:
    """Stitches on a surface, with the data from which they follow."""

    fabric: StitchMesh
    """The stitches, before mesh relaxation."""
    given: TriangleSurface
    """The triangles of the given surface."""
    surface: TriangleSurface
    """The same triangles without features finer than a stitch."""
    time: FloatArray
    """Time of each vertex of the surface in courses, shape (V,)."""
    ends: tuple[Ends, ...]
    """The ends of each connected part."""
    report: ShapingReport
    """Figures."""
    flat: bool = False
    """Whether all parts are flat pieces, whose stitches are relaxed on their own faces: a border with steps keeps them.
    """

    @property
    def surface_mesh(self) -> Mesh:
        """The surface for mesh relaxation."""
        return faces_of(self.fabric) if self.flat else self.surface.mesh


def auto_stitches(
    mesh: MeshLike, *, stitch_width: float = STITCH_WIDTH, stitch_height: float | None = None,
    increase: Increase = DEFAULT_INCREASE, options: ShapingOptions = AUTOMATIC,
) -> StitchMesh:  # fmt: skip
    """Knit any surface: find rows and stitches without a labeled mesh.

    Rows run along the level lines of a smooth time, from hems, cuffs and toes to the top; where limbs meet, they are
    grafted. Relax the stitches on the same mesh afterwards.

    Args:
        mesh: any oriented surface, of polygons of any kind [cm].
        stitch_width: wale spacing [cm].
        stitch_height: course spacing [cm]; by default 0.77 times the width.
        increase: how increases are made: ``m1``, ``kfb``, ``lifted`` or ``yo`` (``with_increases``).
        options: marks, where increases and decreases stand and how many there are, and short rows.

    Returns:
        A stitch mesh on the polygons of ``mesh``.

    Raises:
        ParameterError: a number is out of range, or marks contradict each other or are off the surface.
        MeshError: the mesh has a lattice or is thinner than a stitch.
        TessellationError: a part is too small for its stitches, or the stitches would not fit in memory.
    """
    return shape_fabric(
        mesh, stitch_width=stitch_width, stitch_height=stitch_height, increase=increase, options=options
    ).fabric


def shape_fabric(
    mesh: MeshLike, *, stitch_width: float = STITCH_WIDTH, stitch_height: float | None = None,
    increase: Increase = DEFAULT_INCREASE, options: ShapingOptions = AUTOMATIC,
    progress: Progress | Literal[False] | None = None,
) -> ShapedFabric:  # fmt: skip
    """Knit any surface as ``auto_stitches`` does, and also return the data from which the stitches follow.

    The arguments and the errors are the same. ``progress`` is called with the progress of each stage, and an error
    that it raises ends the search; by default a line shows the progress on a terminal or in a notebook, and False
    shows nothing.
    """
    start = time.perf_counter()
    mesh = as_mesh(mesh, place="auto_stitches")
    height = COURSE_OVER_WALE_SPACING * stitch_width if stitch_height is None else stitch_height
    check_kind("auto_stitches, options", options, ShapingOptions)
    check_increase(increase)
    size = StitchSize(stitch_width, height, options.multiple, options.most_shaping, options.shaping)
    with shown_stages(progress) as report_stage:
        report_stage("shape", 0.0, "dividing the surface into triangles")
        given, surface, upwards = shaping_surface(mesh, size, options.up, options.marks)
        parts = connected_parts(surface)
        shaped = []
        for number, own_marks in enumerate(marks_by_part(parts, options.marks)):
            report_part = progress_of_part(report_stage, "shape", number, parts)
            shaped.append(_shape_part(parts[number][0], own_marks, upwards, size, options.short_rows, report_part))
    fabric = with_increases(joined([part.fabric for part in shaped]), increase)
    times = np.zeros(len(surface.vertices))
    for (_, vertices), part in zip(parts, shaped, strict=True):
        times[vertices] = part.time
    seconds, tips = time.perf_counter() - start, sum(part.tips for part in shaped)
    rows = sum(part.rows.stacked for part in shaped), sum(part.rows.spread for part in shaped)
    report = shaping_report(fabric, given, stitch_width, seconds, tips, rows)
    if options.shaping == "seams" and report.spread_rows:
        logger.warning(_spread_all_the_same(report, options.multiple))
    flat = all(part.flat for part in shaped)
    return ShapedFabric(fabric, given, surface, times, tuple(part.ends for part in shaped), report, flat)


PartProgress = Callable[[float, str], None]
"""Function that the search of one part of the surface calls with its progress, from 0 to 1, and the name of its
step."""


def progress_of_part(
    report_stage: Progress, stage: str, number: int, parts: Sequence[tuple[TriangleSurface, IntArray]]
) -> PartProgress:
    """Return the progress function of one part of a surface. Each part counts by the number of its triangles."""
    sizes = [len(part.triangles) for part, _ in parts]
    before, own, whole = sum(sizes[:number]), sizes[number], sum(sizes)
    place = "" if len(sizes) == 1 else f", part {number + 1} of {len(sizes)}"

    def report(done: float, note: str) -> None:
        report_stage(stage, (before + done * own) / whole, note + place)

    return report


@dataclass(frozen=True, eq=False)
class _ShapedPart:
    """Stitches on a connected part of the surface."""

    fabric: StitchMesh
    rows: ShapedRows
    """Where its rows have increases and decreases."""
    time: FloatArray
    """Time of each vertex of the part in courses, shape (V,)."""
    ends: Ends
    tips: int
    """Number of borders of the fabric that the surface lacks, at which a yarn is drawn through the loops."""
    flat: bool = False
    """Whether it is a flat piece."""


def _shape_part(
    part: TriangleSurface, marks: Sequence[TimeMark], up: FloatArray, size: StitchSize, short_rows: bool,
    report: PartProgress,
) -> _ShapedPart:  # fmt: skip
    """Knit a connected surface; a flat piece without marks and limits is knitted along one direction."""
    flat = None if marks or size.most_shaping is not None else knitted_flat_piece(part, up, size)
    if flat is not None:
        return _ShapedPart(*flat, tips=0, flat=True)
    levels, courses, ends = levels_of_part(part, marks, up, size, report)
    plain = plain_places(part, marks, size.width)
    fabric, rows, leaning = stitches_between(
        levels, saddle_points(part, courses), size, plain,
        lambda done: report(SHARE_OF_TIME + (SHARE_OF_ROWS - SHARE_OF_TIME) * done, "rows"),
    )  # fmt: skip
    if short_rows:
        report(SHARE_OF_ROWS, "short rows")
        fabric = with_short_rows(fabric, size.height, plain, leaning)
    return _ShapedPart(fabric, rows, courses, ends, levels.tips)


def _spread_all_the_same(report: ShapingReport, multiple: int) -> str:
    """The line that says why increases and decreases are not at seams."""
    if multiple > 1:
        return f"shaping: spread, because rounds of a multiple of {multiple} change by as many stitches at once"
    shaped = report.stacked_rows + report.spread_rows
    return (
        f"shaping: spread in {report.spread_rows} of the {shaped} rows with increases or decreases, where the surface "
        "asks for more than seams hold"
    )


def levels_of_part(
    part: TriangleSurface, marks: Sequence[TimeMark], up: FloatArray, size: StitchSize, report: PartProgress
) -> tuple[LevelLines, FloatArray, Ends]:
    """Return the lines of all courses of a connected surface, the time of each vertex in courses, and the ends.

    Raises:
        TessellationError: the surface is too small for a row, or its stitches are too many.
        ParameterError: as for ``marked_ends`` and for ``check_memory``.
    """
    ends = marked_ends(part, marks, up)
    courses, ends = knitting_time(part, ends, size.height, lambda done: report(SHARE_OF_TIME * done, "time"))
    report(SHARE_OF_TIME, "lines")
    lines, courses = with_joins_and_parts_apart(part, courses, ends, size.height)
    levels = without_small_tips(lines, SMALLEST_TIP * size.width)
    if not any(band.below and band.above for band in levels.bands):
        place, extent = part.vertices.mean(axis=0).round(1).tolist(), np.ptp(part.vertices, axis=0).max()
        raise TessellationError(
            f"near {place} cm: a part of {extent:.3g} cm is too small for a row of stitches {size.width:g} cm wide; "
            "choose a smaller stitch, or leave the part out"
        )
    if size.multiple > 1:
        count = sum(rounded_count(line, line.length / size.width, size) for line in levels.lines)
        _check_memory(f"rounds of a multiple of {size.multiple}", count, "a smaller multiple")
    return levels, courses, ends


def shaping_surface(
    mesh: Mesh, size: StitchSize, up: ArrayLike, marks: Sequence[TimeMark]
) -> tuple[TriangleSurface, TriangleSurface, FloatArray]:
    """Check the arguments; return the given triangles, those without fine features, and the unit vector upwards.

    Features that are finer than the stitches are left out, with a warning.

    Raises:
        ParameterError, MeshError, TessellationError: as for ``auto_stitches``.
    """
    upwards = _checked(mesh, size, up)
    knitted, notes = knitted_surface(mesh, size, marks)
    for note in notes:
        logger.warning(note)
    given = divided(knitted, EDGE_OVER_WIDTH * size.width)
    # Size of the finest dents and ridges that a fabric follows, over the width of a stitch.
    return given, without_fine_features(given, 0.3 * size.width), upwards


def saddle_points(surface: TriangleSurface, values: FloatArray) -> FloatArray:
    """Return the inner vertices at which a function has a saddle [cm], shape (n, 3).

    Around a saddle the function is four times or more often alternately higher and lower than at the vertex.
    """
    return surface.vertices[changes_around(surface, values) >= 4]


def marks_by_part(
    parts: list[tuple[TriangleSurface, IntArray]], marks: Sequence[TimeMark]
) -> list[list[TimeMark]]:
    """Give each mark to the part nearest to its first point."""
    from scipy.spatial import cKDTree

    trees = [cKDTree(part.vertices) for part, _ in parts]
    found: list[list[TimeMark]] = [[] for _ in parts]
    for mark in marks:
        found[int(np.argmin([tree.query(mark.points[0])[0] for tree in trees]))].append(mark)
    return found


def joined(fabrics: Sequence[StitchMesh]) -> StitchMesh:
    """Return several stitch meshes as one, whose rows are numbered one after another."""
    if len(fabrics) == 1:
        return fabrics[0]
    vertex = _first_numbers([len(fabric.vertices) for fabric in fabrics])
    corner = _first_numbers([fabric.side_count for fabric in fabrics])
    row = _first_numbers([int(fabric.row.max()) + 1 for fabric in fabrics])
    numbered = list(zip(fabrics, vertex, corner, row, strict=False))
    return StitchMesh(
        vertices=np.concatenate([fabric.vertices for fabric in fabrics]),
        face_start=np.concatenate([[0], *(fabric.face_start[1:] + first for fabric, _, first, _ in numbered)]),
        face_vertex=np.concatenate([fabric.face_vertex + first for fabric, first, _, _ in numbered]),
        twin=np.concatenate([np.where(one.twin == BORDER, BORDER, one.twin + first) for one, _, first, _ in numbered]),
        n_bottom=np.concatenate([fabric.n_bottom for fabric in fabrics]),
        n_top=np.concatenate([fabric.n_top for fabric in fabrics]),
        stitch=np.concatenate([fabric.stitch for fabric in fabrics]),
        row=np.concatenate([fabric.row + first for fabric, _, _, first in numbered]),
        twist=np.concatenate([fabric.twist for fabric in fabrics]),
    )


def _first_numbers(counts: Sequence[int]) -> list[int]:
    """The number of the first element of each part, if the elements of all parts are numbered in sequence."""
    return [0, *np.cumsum(counts).tolist()]


def _check_memory(found: str, count: float, remedy: str) -> None:
    """Check that a number of stitches is not too large, and fits into the memory.

    Args:
        found: where the stitches are, for the message.
        count: how many they are.
        remedy: what to ask for instead.

    Raises:
        TessellationError: the stitches are too many.
        ParameterError: as for ``check_memory``.
    """
    found = f"{found} with {count:.3g} stitches"
    if count > MOST_STITCHES:
        raise TessellationError(f"{found}: at most {MOST_STITCHES:,} are made; choose {remedy}")
    check_memory(found, BASE_MEMORY + BYTES_PER_FOUND_STITCH * count, remedy)


def _checked(mesh: Mesh, size: StitchSize, up: ArrayLike) -> FloatArray:
    """Check the arguments; return the unit vector upwards.

    Raises:
        ParameterError, MeshError, TessellationError: as for ``auto_stitches``.
    """
    for name, value in (("stitch width", size.width), ("stitch height", size.height)):
        check_positive(name, value, "cm")
    if size.multiple < 1:
        raise ParameterError(f"multiple: got {size.multiple}; expected 1 or more stitches")
    check_most_shaping(size.most_shaping)
    direction = np.asarray(up, dtype=np.float64)
    if direction.shape != (3,) or not np.isfinite(direction).all() or not direction.any():
        raise ParameterError(f"up: got {up!r}; expected three numbers that are not all zero")
    if mesh.lattice is not None:
        raise MeshError("auto_stitches: got a mesh on a lattice; make periodic stitch meshes from charts instead")
    area = float(np.linalg.norm(mesh.face_vector_area, axis=1).sum())
    count, remedy = area / (size.width * size.height), "a larger stitch, and check the unit"
    _check_memory(f"the surface of {area:.4g} cm^2", count, remedy)
    return direction / np.linalg.norm(direction)
