# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The parts of a border that are rows.

The border of a garment that is open in front, or whose skirt has a slit, has corners: its parts that face downwards and
upwards are rows, and those between them are sides.
"""

from __future__ import annotations

from itertools import groupby

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.selection.borders import CLOSED_LENGTH
from stitchmesh.shaping.borders import (
    FACING,
    FACING_BESIDE,
    SLIT_TURNING,
    facing_of,
    length_of,
    outline_sides,
    outward_of_edges,
    turning,
)
from stitchmesh.shaping.triangle_surface import TriangleSurface

OPEN_SIDES = 0.15
"""Part of a border that faces neither upwards nor downwards from which its corners divide it."""


def rows_of_border(surface: TriangleSurface, border: IntArray, up: FloatArray) -> list[IntArray]:
    """Return the parts of a border that are rows, the vertices of each in order: often the whole border.

    A border that runs down one front of a garment and up the other, or up and down a slit, is divided at its corners.
    Parts beside each other that face the same way are one row, as a rounded neck. A hole in a surface that is flat
    around it, such as a square neck, is not divided.
    """
    if turning(surface, border) <= SLIT_TURNING:
        return [border]
    pieces = outline_sides(surface, border)
    facing = facing_of(surface, pieces, up)
    if not facing.any():
        return [border]
    all_rows = {1.0, -1.0} <= set(facing)
    for side in (1.0, -1.0):
        # A piece of two fronts and the neck between them faces upwards on the whole.
        if side not in facing or (all_rows and facing.all()):
            pieces = _with_part_facing(surface, pieces, side * up)
    facing = facing_of(surface, pieces, up)
    length = np.array([length_of(surface, piece, closed=False) for piece in pieces])
    if length[facing == 0.0].sum() < OPEN_SIDES * length.sum():
        return [border]
    first = int(np.flatnonzero(facing != np.roll(facing, 1))[0])
    turned = sorted(range(len(pieces)), key=lambda number: (number - first) % len(pieces))
    runs = [(side, list(run)) for side, run in groupby(turned, key=lambda number: facing[number])]
    return [_joined([pieces[number] for number in run]) for side, run in runs if side != 0.0]


def _with_part_facing(surface: TriangleSurface, pieces: list[IntArray], direction: FloatArray) -> list[IntArray]:
    """Divide one of the parts of a border where it passes smoothly into a row that faces a direction, if one does.

    So do the fronts of a cardigan pass into its V-neck, or into a rounded hem. The longest such row is taken.
    """
    found = []
    for number, piece in enumerate(pieces):
        cosine = _cosine_of_edges(surface, piece, direction)
        for faces, run in groupby(range(len(cosine)), key=lambda edge: bool(cosine[edge] > FACING_BESIDE)):
            edges = list(run)
            if faces and cosine[edges].max() > FACING:
                row = piece[edges[0] : edges[-1] + 2]
                found.append((length_of(surface, row, closed=False), number, edges[0], edges[-1] + 1))
    length, number, first, last = max(found, default=(0.0, 0, 0, 0))
    if length < CLOSED_LENGTH:
        return pieces
    piece = pieces[number]
    parts = [part for part in (piece[: first + 1], piece[first : last + 1], piece[last:]) if len(part) > 1]
    return [*pieces[:number], *parts, *pieces[number + 1 :]]


def _cosine_of_edges(surface: TriangleSurface, piece: IntArray, up: FloatArray) -> FloatArray:
    """Cosine between the upward direction and that in which the border faces around each edge, shape (n - 1,).

    It is the mean over a length of a border that is no tip, because the border of a scan is jagged.
    """
    outward, step = outward_of_edges(surface, piece)
    place = np.cumsum(step) - 0.5 * step
    near = np.abs(place[:, None] - place[None, :]) <= 0.5 * CLOSED_LENGTH
    total = near @ (outward * step[:, None])
    size = np.maximum(np.linalg.norm(total, axis=1), np.finfo(np.float64).tiny)
    return np.asarray(total @ up / size)


def _joined(pieces: list[IntArray]) -> IntArray:
    """One part of a border from parts that follow each other and share their ends."""
    return np.append(np.concatenate([piece[:-1] for piece in pieces]), pieces[-1][-1])
