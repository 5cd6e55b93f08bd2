# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Small fabrics for the tests of edits."""

from __future__ import annotations

import numpy as np

from stitchmesh.labeling import label
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.tessellate import tessellate
from tests.gallery import grid, tube


def flat(columns: int = 7, rows: int = 6) -> StitchMesh:
    """Make a flat piece of plain knit; faces are numbered ``row * columns + column``."""
    fabric = tessellate(label(grid(columns, rows, height=0.72)), stitch_width=1.0)
    assert fabric.face_count == columns * rows
    return fabric


def around(columns: int = 9, rows: int = 5) -> StitchMesh:
    """Make a tube of plain knit."""
    mesh = tube(columns, rows, radius=columns / 6, height=0.72)
    return tessellate(label(mesh), stitch_width=1.0)


def face_at(fabric: StitchMesh, row: int, column: int) -> int:
    """Return a face by its row and its place there from the left."""
    faces = np.flatnonzero(fabric.row == row)
    return int(faces[np.argsort(fabric.corner_position[fabric.face_start[faces], 0])[column]])


def top_of(fabric: StitchMesh, face: int, loop: int = 0) -> int:
    """Return a top side of a face, counted from the left."""
    return int(fabric.left_wale[face]) - 1 - loop


def names(fabric: StitchMesh, *faces: int) -> list[Stitch]:
    return [Stitch(int(fabric.stitch[face])) for face in faces]
