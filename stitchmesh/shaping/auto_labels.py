# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A labeled mesh of large panels on any surface: rows to edit before they are divided into stitches.

The search finds the level lines of all courses, keeps some of them, and puts panels between these.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from numpy.typing import ArrayLike

from stitchmesh.errors import ParameterError
from stitchmesh.io.library_meshes import MeshLike, as_mesh
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.progress import Progress, shown_stages
from stitchmesh.shaping.auto_stitches import (
    SHARE_OF_TIME,
    PartProgress,
    joined,
    levels_of_part,
    marks_by_part,
    progress_of_part,
    saddle_points,
    shaping_surface,
)
from stitchmesh.shaping.counts import StitchSize
from stitchmesh.shaping.marks import TimeMark
from stitchmesh.shaping.options import PANEL_SIZE, UP
from stitchmesh.shaping.panel_rows import panels_between
from stitchmesh.shaping.plain_places import plain_places
from stitchmesh.shaping.triangle_surface import TriangleSurface, connected_parts
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING, STITCH_WIDTH

SMALLEST_PANEL = 2
"""Smallest size of a panel; a panel of one stitch would be a stitch."""


def auto_labels(
    mesh: MeshLike, *, stitch_width: float = STITCH_WIDTH, stitch_height: float | None = None,
    panel_size: int = PANEL_SIZE, marks: Sequence[TimeMark] = (), up: ArrayLike = UP, multiple: int = 1,
    progress: Progress | Literal[False] | None = None,
) -> StitchMesh:  # fmt: skip
    """Find rows of large panels on any surface: a labeled mesh, as ``label`` returns it for modelled rows.

    Each row of panels stands for several rows of ``auto_stitches``. Edit the labeled mesh, divide it by ``tessellate``
    with the same size of stitches, and relax the stitches on the given mesh.

    Args:
        mesh: any oriented surface, of polygons of any kind [cm].
        stitch_width: wale spacing of the stitches that the panels are made for [cm].
        stitch_height: their course spacing [cm]; by default 0.77 times the width.
        panel_size: stitches along a panel, and courses in a row of panels; panels get up to a third narrower or
            wider, and rows are lower where limbs meet or rows end.
        marks: where knitting begins and ends, and lines along which rows run; automatic without any.
        up: direction in which garments are knitted where nothing else decides, shape (3,).
        multiple: the stitches of each round are a multiple of this number, but not at another size of stitches.
        progress: called with the progress; by default a line shows it on a terminal or in a notebook, and False shows
            nothing.

    Returns:
        A stitch mesh of ``Stitch.PANEL`` faces, whose corners lie near the surface.

    Raises:
        ParameterError: a number is out of range, or marks contradict each other or are off the surface.
        MeshError: the mesh has a lattice or is thinner than a stitch.
        TessellationError: a part is too small for its stitches, or neighbouring rows differ too much.
    """
    mesh = as_mesh(mesh, place="auto_labels")
    if panel_size < SMALLEST_PANEL:
        raise ParameterError(f"panel size: got {panel_size}; expected {SMALLEST_PANEL} or more stitches")
    height = COURSE_OVER_WALE_SPACING * stitch_width if stitch_height is None else stitch_height
    size = StitchSize(stitch_width, height, multiple, shaping="spread")
    labeled = []
    with shown_stages(progress) as report_stage:
        report_stage("label", 0.0, "dividing the surface into triangles")
        _, surface, upwards = shaping_surface(mesh, size, up, marks)
        parts = connected_parts(surface)
        for number, own_marks in enumerate(marks_by_part(parts, marks)):
            report = progress_of_part(report_stage, "label", number, parts)
            labeled.append(_label_part(parts[number][0], own_marks, upwards, size, panel_size, report))
    return joined(labeled)


def _label_part(
    part: TriangleSurface, marks: Sequence[TimeMark], up: FloatArray, size: StitchSize, panel_size: int,
    report: PartProgress,
) -> StitchMesh:  # fmt: skip
    """Find the panels of a connected surface."""
    levels, courses, _ = levels_of_part(part, marks, up, size, report)
    return panels_between(
        levels, saddle_points(part, courses), size, plain_places(part, marks, size.width), panel_size,
        lambda done: report(SHARE_OF_TIME + (1.0 - SHARE_OF_TIME) * done, "rows"),
    )  # fmt: skip
