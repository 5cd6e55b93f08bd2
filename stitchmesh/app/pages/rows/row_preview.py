# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows without their stitches, which take a fraction of the time: first on large triangles, then on smaller ones."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.pages.rows.found_rows import FoundRows, found_rows
from stitchmesh.app.project.shaping import Shaping
from stitchmesh.app.task import TaskControl
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import Mesh
from stitchmesh.shaping.auto_stitches import EDGE_OVER_WIDTH, marks_by_part
from stitchmesh.shaping.counts import StitchSize
from stitchmesh.shaping.finer_than_stitches import knitted_surface
from stitchmesh.shaping.marks import marked_ends
from stitchmesh.shaping.time_function import knitting_time
from stitchmesh.shaping.triangle_surface import connected_parts, divided

COARSE, FINE = 500.0, 1_500.0
"""Area of a surface over the square of the longest edge of its triangles: about 3,000 and 10,000 triangles."""


def preview(mesh: Mesh, shaping: Shaping, control: TaskControl) -> FoundRows:
    """Find rows on large triangles, publish them as a frame, and return those on smaller triangles.

    Raises:
        StitchMeshError: the marks contradict each other; on large triangles neighbouring marks may only seem to.
    """
    area = float(np.linalg.norm(mesh.face_vector_area, axis=1).sum())
    control.progress("shape", 0.0, "large triangles")
    coarse, fine = (max(EDGE_OVER_WIDTH * shaping.stitch_width, (area / count) ** 0.5) for count in (COARSE, FINE))
    if coarse > fine:
        try:
            control.frame(rows_on(mesh, shaping, coarse))
        except StitchMeshError:
            pass
    control.progress("shape", 0.2, "small triangles")
    return rows_on(mesh, shaping, fine)


def rows_on(mesh: Mesh, shaping: Shaping, longest_edge: float) -> FoundRows:
    """Find rows on triangles whose edges are at most so long [cm].

    Raises:
        StitchMeshError: the marks contradict each other, or are off the surface.
    """
    knitted, _ = knitted_surface(mesh, StitchSize(shaping.stitch_width, shaping.height), shaping.marks)
    surface = divided(knitted, longest_edge)
    courses, ends = np.zeros(len(surface.vertices)), []
    parts = connected_parts(surface)
    for (part, vertices), marks in zip(parts, marks_by_part(parts, shaping.marks), strict=True):
        found = marked_ends(part, marks, np.array(shaping.up))
        courses[vertices], found = knitting_time(part, found, shaping.height)
        ends.append(found)
    return found_rows(surface, courses, ends, shaping)
