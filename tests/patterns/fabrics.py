# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Fabrics on which tests put patterns, and the properties that the tests compare."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.stitch import CODES, Stitch
from stitchmesh.patterns import Cell, Loop, Pattern, Row, read_pattern
from stitchmesh.patterns.swatch_mesh import plain_piece


def pattern(*rows: str, left: int = 0, right: int = 0, below: dict[int, tuple[Loop, ...]] | None = None) -> Pattern:
    """Make a pattern from the codes of its rows, bottom first; ``left`` and ``right`` count border cells."""
    held = below or {}
    cells = [tuple(Cell(CODES[code]) for code in row.split()) for row in rows]
    return Pattern("tried", "", tuple(Row(row, held.get(index, ()), left, right) for index, row in enumerate(cells)))


def flat(columns: int, rows: int) -> StitchMesh:
    """Make a flat fabric of knit stitches of 1 cm on a cast-on row."""
    return plain_piece(columns, rows, 1.0, 1.0)


def tube(around: int, rows: int) -> StitchMesh:
    """Make a tube of knit stitches on a cast-on row."""
    piece = plain_piece(around, rows, 1.0, 1.0)
    angle = 2.0 * np.pi * np.arange(around) / around
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1) * around / (2.0 * np.pi)
    points = np.concatenate([np.tile(ring, (rows + 1, 1)), np.repeat(np.arange(rows + 1.0), around)[:, None]], axis=1)
    level, place = np.divmod(piece.face_vertex, around + 1)
    corners = level * around + place % around
    return StitchMesh(
        vertices=points,
        face_start=piece.face_start,
        face_vertex=corners,
        twin=find_twins(piece.face_start, corners, len(points)),
        n_bottom=piece.n_bottom,
        n_top=piece.n_top,
        stitch=piece.stitch,
        row=piece.row,
    )


def codes(fabric: StitchMesh) -> list[str]:
    """Return one sign for each stitch, row by row from below: c (cast on), k, p, or + for another stitch."""
    signs = {Stitch.CAST_ON: "c", Stitch.KNIT: "k", Stitch.PURL: "p"}
    rows = [np.flatnonzero(fabric.row == row) for row in range(fabric.row.max() + 1)]
    return ["".join(signs.get(Stitch(int(stitch)), "+") for stitch in fabric.stitch[row]) for row in rows]


def checked(fabric: StitchMesh) -> StitchMesh:
    """Return a copy of a stitch mesh; making the copy checks the whole mesh again."""
    return StitchMesh(**{part.name: getattr(fabric, part.name) for part in fields(StitchMesh)})


def differing(one: StitchMesh, other: StitchMesh) -> list[str]:
    """Return the names of the arrays that differ between two stitch meshes."""
    names = [part.name for part in fields(StitchMesh)]
    return [name for name in names if not np.array_equal(getattr(one, name), getattr(other, name))]


def stitches(name: str) -> np.ndarray:
    """Return the stitches of a pattern whose rows are equally long, from the lower left, shape (rows, columns)."""
    return np.array([[cell.stitch for cell in row.cells] for row in read_pattern(name).rows])


def is_shift_of(cells: np.ndarray, other: np.ndarray) -> bool:
    """Whether a chart equals another chart that begins at another row or column."""
    rows, columns = cells.shape
    return any(
        np.array_equal(np.roll(cells, (row, column), axis=(0, 1)), other)
        for row in range(rows)
        for column in range(columns)
    )
