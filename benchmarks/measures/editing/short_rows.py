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
from benchmarks.sheet import drawn, joined
from benchmarks.table import Rows, note
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.courses import course_through
from stitchmesh.yarn import YarnSet

WIDTH, HEIGHT = 1.0, 0.72
"""Size of a stitch [cm]."""
SIZE = (800, 800)
"""Size of each picture [pixels]."""


def tube_mesh(columns: int, rows: int) -> sm.Mesh:
    """A tube of square faces."""
    turns = 2.0 * np.pi * np.arange(columns) / columns
    ring = columns * WIDTH / (2.0 * np.pi) * np.column_stack([np.sin(turns), 0.0 * turns, np.cos(turns)])
    up = np.array([0.0, HEIGHT, 0.0])
    points = np.concatenate([ring + row * up for row in range(rows + 1)])
    return sm.Mesh.from_polygons(points, quads(columns, rows, columns))


def flat_mesh(columns: int, rows: int) -> sm.Mesh:
    """A flat piece of square faces."""
    places = np.stack(np.meshgrid(np.arange(columns + 1) * WIDTH, np.arange(rows + 1) * HEIGHT), axis=-1).reshape(-1, 2)
    return sm.Mesh.from_polygons(np.column_stack([places, 0.0 * places[:, 0]]), quads(columns, rows, columns + 1))


def quads(columns: int, rows: int, stride: int) -> list[list[int]]:
    """Faces between rows of vertices, each ``stride`` long; the last column returns to the first in a tube."""
    return [
        [row * stride + column, row * stride + (column + 1) % stride,
         (row + 1) * stride + (column + 1) % stride, (row + 1) * stride + column]
        for row in range(rows) for column in range(columns)
    ]  # fmt: skip


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
        (tube_mesh(40, 24), slice(0, 16), (2, 2), 0.5, "90,5"), (flat_mesh(20, 16), slice(8, 20), (3, 0), 0.4, "front")
    ):  # fmt: skip
        fabric = sm.tessellate(sm.label(mesh), stitch_width=WIDTH)
        row = int(share * fabric.row.max())
        course = list(course_through(fabric, int(np.flatnonzero(fabric.row == row)[0])).faces)
        fabric = with_short_rows(fabric, course[columns], trims, 3)
        pictures.append(drawn(partial(sm.render, relaxed(mesh, fabric), size=SIZE, view=view)))
    joined(pictures, 2).save(output, quality=85)
    yield str(output)
