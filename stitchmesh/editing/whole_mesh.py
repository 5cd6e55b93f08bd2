# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Spirals and grafts as edits; each edit replaces the whole stitch mesh."""

from __future__ import annotations

import numpy as np

from stitchmesh.editing import graft as grafting
from stitchmesh.editing import spiral as spirals
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import Change, Patch, inverse_change


def spiral(fabric: StitchMesh, seam: int | None = None) -> list[Change]:
    """Convert stacked rings to one row that rises around the tube, as ``make_spiral`` does."""
    return [_replacement(fabric, spirals.make_spiral(fabric, seam))]


def unspiral(fabric: StitchMesh) -> list[Change]:
    """Convert every spiral back to rings, as ``editing.spiral.unspiral`` does."""
    return [_replacement(fabric, spirals.unspiral(fabric))]


def graft(fabric: StitchMesh, first_side: int, second_side: int) -> list[Change]:
    """Graft the loops of two borders together, as ``editing.graft.graft`` does."""
    return [_replacement(fabric, grafting.graft(fabric, first_side, second_side))]


def ungraft(fabric: StitchMesh, side: int) -> list[Change]:
    """Separate two rows, as ``editing.graft.ungraft`` does."""
    return [_replacement(fabric, grafting.ungraft(fabric, side))]


def _replacement(before: StitchMesh, after: StitchMesh) -> Change:
    """Return the change from one stitch mesh to another: the inverse of the change from the second to the first."""
    nothing = np.zeros(0, dtype=np.int64)
    backwards = Patch(
        removed_faces=np.arange(after.face_count), removed_vertices=np.arange(len(after.vertices)),
        added_faces=np.arange(before.face_count), added_vertices=np.arange(len(before.vertices)),
        positions=np.zeros((0, 3)), face_size=nothing, corners=nothing, twin=np.zeros((0, 2), dtype=np.int64),
        faces={}, sides={}, stretch=np.zeros(0),
    )  # fmt: skip
    return inverse_change(after, backwards)
