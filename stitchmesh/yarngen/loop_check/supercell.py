# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The supercell of a periodic fabric: copies of its cell beside and above each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import BORDER, IntArray, StitchMesh


def supercell(fabric: StitchMesh, columns: int, rows: int) -> StitchMesh:
    """A stitch mesh on a lattice that consists of copies of a cell.

    Args:
        fabric: the stitch mesh of the cell, on a lattice.
        columns: number of copies along the courses.
        rows: number of copies along the wales.

    Returns:
        The supercell. Its copies are numbered along the courses first and then upwards.
    """
    assert fabric.lattice is not None and fabric.corner_image is not None
    size = np.array([columns, rows])
    copy = np.stack([index.ravel() for index in np.indices((rows, columns))[::-1]], axis=1)
    vertex_copy, corner_image = _reached(copy, fabric.corner_image, size)
    side_copy, _ = _reached(copy, fabric.side_image, size)
    count, corners = len(copy), fabric.side_count
    starts = (np.arange(count)[:, None] * corners + fabric.face_start[:-1]).ravel()
    marks = {
        name: np.tile(getattr(fabric, name), count)
        for name in ("n_bottom", "n_top", "stitch", "yarn", "twist", "cable_shift", "cable_layer")
    }
    return replace(
        fabric,
        vertices=(fabric.vertices + fabric.lattice.shift(copy)[:, None]).reshape(-1, 3),
        face_start=np.append(starts, count * corners),
        face_vertex=(fabric.face_vertex + vertex_copy * len(fabric.vertices)).ravel(),
        twin=np.where(fabric.twin == BORDER, BORDER, fabric.twin + side_copy * corners).ravel(),
        lattice=Lattice(fabric.lattice.periods * size[:, None]),
        corner_image=corner_image.reshape(-1, 2),
        row=(fabric.row + copy[:, 1:] * (fabric.row.max() + 1)).ravel(),
        stretch=None,
        **marks,  # type: ignore[arg-type]
    )


def _reached(copy: IntArray, image: IntArray, size: IntArray) -> tuple[IntArray, IntArray]:
    """The copy that each image leads to from each copy, and its image in the supercell.

    Args:
        copy: column and row of each copy, shape (n, 2).
        image: lattice images in the cell, shape (k, 2).
        size: numbers of columns and rows.

    Returns:
        Numbers of the copies, shape (n, k), and lattice images of the supercell, shape (n, k, 2).
    """
    there = copy[:, None] + image
    inside = there % size
    return inside[..., 0] + inside[..., 1] * size[0], there // size
