# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Short rows in a tube and at the side of a flat piece, relaxed, as one picture.

The tube has three pairs of short rows within each other, as at a heel; the flat piece has three pairs
at its right border, each shorter than the one below.
"""

from __future__ import annotations

from functools import partial

import numpy as np

import stitchmesh as sm
from benchmarks.options import Output
from benchmarks.scenes.large_pieces import quads
from benchmarks.sheet import drawn
from benchmarks.table import Rows, note
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.courses import course_through
from stitchmesh.render.animation_pictures import joined
from stitchmesh.yarn import YarnSet

WIDTH, HEIGHT = 1.0, 0.72
"""Size of a stitch [cm]."""
SIZE = (800, 800)
"""Size of each picture [pixels]."""


def with_short_rows(fabric: StitchMesh, faces: list[int], trims: tuple[int, int], pairs: int) -> StitchMesh:
    """Pairs of short rows within each other.

    Args:
        fabric: the stitch mesh.
        faces: stitches under the first pair, from left to right.
        trims: stitches by which each pair is shorter than the one below, at the left and at the right.
        pairs: number of pairs.
    """
    for _ in range(pairs):
        before = fabric.face_count
        fabric = sm.edits.short_rows(fabric, faces=faces).fabric
        upper = list(range(before + 1, fabric.face_count, 2))
        faces = upper[trims[0] : len(upper) - trims[1]]
    return fabric


def relaxed(mesh: sm.Mesh, fabric: StitchMesh) -> YarnSet:
    """The yarns of a fabric at rest."""
    fabric = sm.relax_mesh(fabric, surface=mesh).fabric
    result = sm.relax_yarns(sm.generate_yarns(fabric), quality="draft", keep_shape=fabric)
    keys = ("converged", "residual", "max_strain", "pull_throughs")
    note(f"{fabric}: " + ", ".join(f"{key} {result.report[key]}" for key in keys))
    return result.yarns


def short_rows(*, output: Output) -> Rows:
    """Edit, relax and draw."""
    pictures = []
    for mesh, columns, trims, share, view in (
        (quads(40, 24, around=True, width=WIDTH, height=HEIGHT), slice(0, 16), (2, 2), 0.5, "90,5"),
        (quads(20, 16, around=False, width=WIDTH, height=HEIGHT), slice(8, 20), (3, 0), 0.4, "front"),
    ):
        fabric = sm.tessellate(sm.label(mesh), stitch_width=WIDTH)
        row = int(share * fabric.row.max())
        course = list(course_through(fabric, int(np.flatnonzero(fabric.row == row)[0])).faces)
        fabric = with_short_rows(fabric, course[columns], trims, 3)
        pictures.append(drawn(partial(sm.render, relaxed(mesh, fabric), size=SIZE, view=view)))
    joined(pictures, 2).save(output, quality=85)
    yield str(output)
