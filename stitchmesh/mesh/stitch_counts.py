# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How many stitches a fabric has, and how many of them change its number of loops."""

from __future__ import annotations

from stitchmesh.mesh.stitch_mesh import StitchMesh


def stitch_counts(fabric: StitchMesh) -> dict[str, int]:
    """Faces, increases and decreases of a stitch mesh."""
    more, fewer = fabric.n_top > fabric.n_bottom, fabric.n_top < fabric.n_bottom
    shaped = (fabric.n_top > 0) & (fabric.n_bottom > 0)
    return {
        "faces": fabric.face_count,
        "increases": int((more & shaped).sum()),
        "decreases": int((fewer & shaped).sum()),
    }
