# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flat pieces with corners, such as the front of a vest: they are knitted as the panels of a sewing pattern are.

The direction of knitting of a flat piece is the same everywhere, so that its time is the height along this direction.
Rows begin and end at the parts of the outline that run across this direction. All other parts are sides. Beside a
corner a row is bound off or cast on, and at the foot of a hole or a notch a row parts into two.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.shaping.borders import turning
from stitchmesh.shaping.counts import StitchSize
from stitchmesh.shaping.ends import FLAT_TURNING, Ends, direction_in_piece
from stitchmesh.shaping.level_lines import LevelLine, level_lines
from stitchmesh.shaping.panels.outline_pieces import BEGINS, outline_pieces
from stitchmesh.shaping.panels.panel_mesh import UPWARDS, PanelMesh
from stitchmesh.shaping.panels.panel_rows import PanelStitches
from stitchmesh.shaping.panels.panel_time import hems_of, panel_time
from stitchmesh.shaping.panels.refined_panel import RefinedPanel
from stitchmesh.shaping.panels.sewing import sewn_fabric
from stitchmesh.shaping.seams import ShapedRows
from stitchmesh.shaping.triangle_surface import TriangleSurface


def knitted_flat_piece(
    part: TriangleSurface, up: FloatArray, size: StitchSize
) -> tuple[StitchMesh, ShapedRows, FloatArray, Ends] | None:
    """Knit a flat piece whose outline has a part at which rows begin.

    Args:
        part: a connected surface.
        up: unit vector, shape (3,).
        size: size of the stitches.

    Returns:
        The stitches, where rows have increases and decreases, the time of each vertex of the part in courses, shape
        (V,), and the ends; None if the part is no such piece, for example a disc.

    Raises:
        TessellationError: the piece is narrower than two stitches or lower than a row, or neighbouring rows differ too
            much.
    """
    panel = _as_panel(part, up)
    direction = np.array([UPWARDS])
    pieces = [] if panel is None else outline_pieces(panel, direction, size.width)
    if panel is None or not any(piece.kind == BEGINS for piece in pieces):
        return None
    found = panel_time(
        0, RefinedPanel(part, panel.texture, np.arange(len(part.vertices))), pieces, direction[0], size.height
    )
    made = PanelStitches(size)
    made.knit(0, level_lines(part, found.courses, found.ends, panel.texture), hems_of(found, pieces, size.width))
    lines = [LevelLine(0, part.vertices[piece.vertices], closed=False) for piece in pieces]
    return sewn_fabric(made, pieces, lines)[0], made.shaped, found.courses, found.ends


def _as_panel(part: TriangleSurface, up: FloatArray) -> PanelMesh | None:
    """A flat surface as a panel whose texture is its plane, with the direction of knitting upwards; None for others."""
    normal = part.vector_area.sum(axis=0)
    outlines = sum(turning(part, border) > FLAT_TURNING for border in part.borders)
    # Length of the sum of the normals of a piece, over its area, above which it is knitted along one direction.
    if outlines != 1 or np.linalg.norm(normal) < 0.95 * part.area.sum():
        return None
    upwards = direction_in_piece(part, up)
    across = np.cross(upwards, normal / np.linalg.norm(normal))
    texture = part.vertices @ np.stack([across, upwards], axis=1)
    return PanelMesh(part.mesh, texture, np.zeros(part.mesh.face_count, dtype=np.int64))
