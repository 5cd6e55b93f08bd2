# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tiling of a periodic cell: a finite piece of the fabric, a larger cell, or the positions of the copies of the cell.

A yarn with lattice step (a, b) continues from its copy in tile (i, j) to its copy in tile (i + a, j + b). The copies
inside a box of tiles form strands. A strand begins at a copy whose predecessor, in tile (i - a, j - b), is outside the
box, and ends with the last copy inside. A strand of m copies of a yarn with n control points becomes an open yarn with
the m n segments of these copies, and therefore with m n + 3 control points: the last three are the first three control
points of the next copy. A closed ring (step (0, 0)) stays closed. If the tiled piece is periodic itself, all strands
are closed: a strand continues until it returns to its first copy.

Faces are numbered tile by tile, first along the courses and then along the wales. Rows are numbered by rows of tiles.
The row of a control point that no stitch made is the number of its yarn. A control point in a tile outside the box has
the labels of the tile inside the box from which it differs by periods of the box.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from math import gcd, lcm

import numpy as np

from stitchmesh.errors import ParameterError, YarnError, check_kind
from stitchmesh.lattice import Lattice
from stitchmesh.memory_need import BASE_MEMORY, BYTES_PER_TILED_POINT, check_memory
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn.yarn_set import UNKNOWN_FACE, YarnSet

OVERLAP = 3
"""Number of control points of an open yarn minus its number of segments."""


@dataclass(frozen=True)
class _Strand:
    """The consecutive copies along one yarn of the tiling."""

    yarn: int
    """Yarn of the cell."""
    tiles: IntArray
    """Tile of each copy, in their order along the strand, shape (m, 2)."""
    cut: bool
    """Whether the strand is cut at the border of the box."""


def tile_yarns(yarns: YarnSet, columns: int, rows: int, *, periodic: bool = False) -> YarnSet:
    """Tile a periodic cell; the module docstring says how curves, rest lengths and labels are copied.

    Args:
        yarns: a set of yarns on a lattice.
        columns: number of tiles along the courses.
        rows: number of tiles along the wales.
        periodic: whether the piece is periodic, with ``columns`` and ``rows`` times the periods of the cell; otherwise
            the piece ends at its borders and has no lattice.

    Returns:
        One yarn per strand. Strands are ordered by the tile in which they start, first along the courses and then
        along the wales; strands that start in the same tile have the order of the yarns of the cell.

    Raises:
        ParameterError: a count is not a positive integer.
        YarnError: the set of yarns has no lattice.
    """
    check_kind("tile_yarns", yarns, YarnSet)
    lattice, steps = _lattice_of(yarns)
    check_tiled_memory(len(yarns.points), columns, rows)
    strands = list(_strands(yarns, steps, columns, rows, periodic))
    taken = [_copied_indices(yarns, strand) for strand in strands]
    source = np.concatenate(taken)
    start = np.concatenate([[0], np.cumsum([len(own) for own in taken])])
    owner = np.array([strand.yarn for strand in strands])
    tile = np.concatenate([_tile_of_points(yarns, strand, steps) for strand in strands])
    number = np.repeat(np.arange(len(strands)), np.diff(start))
    face, row = _labels(yarns, source, tile % [columns, rows], columns, number)
    plain = YarnSet(
        points=yarns.points[source] + lattice.shift(tile),
        start=start,
        closed=yarns.closed[owner] & ~np.array([strand.cut for strand in strands]),
        radius=yarns.radius[owner],
        rest_length=np.concatenate([_copied_rest_lengths(yarns, strand) for strand in strands]),
        row=row,
        face=face,
        part=yarns.part[source],
        colour=yarns.colour[owner],
        natural_curvature=yarns.natural_curvature[source],
        palette=yarns.palette,
        drawn_radius=yarns.drawn_radius[owner],
        mass_per_length=yarns.mass_per_length[owner],
        made_of=yarns.made_of,
    )
    if not periodic:
        return plain
    # The copy after the last one of a strand lies as many steps of its yarn away as the strand has copies.
    step = np.stack([len(strand.tiles) * steps[strand.yarn] for strand in strands]) // np.array([columns, rows])
    larger = Lattice(lattice.periods * np.array([[columns], [rows]]))
    return dataclasses.replace(plain, lattice=larger, lattice_step=step)


def check_tiled_memory(points: float, columns: int, rows: int) -> None:
    """Refuse tiles that do not fit into the memory, before they are made.

    Args:
        points: number of control points of the cell.
        columns: number of tiles along the courses.
        rows: number of tiles along the wales.

    Raises:
        ParameterError: a count is not a positive integer, or as for ``check_memory``.
    """
    _check_counts(columns, rows)
    check_memory(
        f"a piece of {columns} x {rows} tiles with {points * columns * rows:,.3g} control points",
        BASE_MEMORY + BYTES_PER_TILED_POINT * points * columns * rows, "fewer tiles",
    )  # fmt: skip


def instances(lattice: Lattice, columns: int, rows: int) -> FloatArray:
    """Return the displacements of the copies of one cell in a piece of ``columns`` by ``rows`` tiles.

    Returns:
        Displacement of each tile [cm], first along the courses and then along the wales, shape (columns * rows, 3).

    Raises:
        ParameterError: a count is not a positive integer.
    """
    _check_counts(columns, rows)
    return lattice.shift(_tiles(columns, rows))


def _lattice_of(yarns: YarnSet) -> tuple[Lattice, IntArray]:
    if yarns.lattice is None or yarns.lattice_step is None:
        raise YarnError("yarns: they do not repeat; expected a cell on a lattice, such as a periodic swatch")
    return yarns.lattice, yarns.lattice_step


def _check_counts(columns: int, rows: int) -> None:
    for name, count in (("columns", columns), ("rows", rows)):
        if not isinstance(count, int | np.integer) or count < 1:
            raise ParameterError(f"tiles: got {count} {name}; expected a whole number from 1")


def _tiles(columns: int, rows: int) -> IntArray:
    """Column and row of each tile, shape (columns * rows, 2)."""
    row, column = np.divmod(np.arange(columns * rows), columns)
    return np.stack([column, row], axis=1)


def _strands(yarns: YarnSet, steps: IntArray, columns: int, rows: int, periodic: bool) -> Iterator[_Strand]:
    """All strands of a box of tiles, in the order of the tiles in which they start."""
    seen: set[tuple[int, int, int]] = set()
    for column, row in _tiles(columns, rows).tolist():
        for yarn, (a, b) in enumerate(steps.tolist()):
            single_copy = not yarns.closed[yarn] or (a, b) == (0, 0)
            if single_copy:
                yield _Strand(yarn, np.array([[column, row]]), cut=False)
            elif periodic and (yarn, column, row) not in seen:
                count = lcm(columns // gcd(a, columns), rows // gcd(b, rows))
                tiles = np.array([column, row]) + np.arange(count)[:, None] * [a, b]
                seen.update((yarn, i, j) for i, j in (tiles % [columns, rows]).tolist())
                yield _Strand(yarn, tiles, cut=False)
            elif not periodic and not (0 <= column - a < columns and 0 <= row - b < rows):
                count = min(_copies_inside(column, a, columns), _copies_inside(row, b, rows))
                yield _Strand(yarn, np.array([column, row]) + np.arange(count)[:, None] * [a, b], cut=True)


def _copies_inside(place: int, step: int, count: int) -> int:
    """Number of copies from ``place`` onwards, at distances of ``step``, that are inside ``count`` places."""
    if step == 0:
        return 10**9  # There is no limit in this direction.
    return (count - 1 - place) // step + 1 if step > 0 else place // -step + 1


def _copied_indices(yarns: YarnSet, strand: _Strand) -> IntArray:
    """Control point of the cell from which each point of the strand is copied, shape (n,)."""
    own = np.arange(yarns.start[strand.yarn], yarns.start[strand.yarn + 1])
    return np.concatenate([np.tile(own, len(strand.tiles)), own[:OVERLAP] if strand.cut else own[:0]])


def _tile_of_points(yarns: YarnSet, strand: _Strand, steps: IntArray) -> IntArray:
    """Tile of the copy that each point of the strand belongs to, shape (n, 2)."""
    size = yarns.start[strand.yarn + 1] - yarns.start[strand.yarn]
    beyond = strand.tiles[-1:] + steps[strand.yarn]
    return np.concatenate([np.repeat(strand.tiles, size, axis=0), np.repeat(beyond, OVERLAP * strand.cut, axis=0)])


def _copied_rest_lengths(yarns: YarnSet, strand: _Strand) -> FloatArray:
    own = yarns.rest_length[yarns.segment_start[strand.yarn] : yarns.segment_start[strand.yarn + 1]]
    return np.tile(own, len(strand.tiles))


def _labels(
    yarns: YarnSet, source: IntArray, tile: IntArray, columns: int, number: IntArray
) -> tuple[IntArray, IntArray]:
    """Face and row of each control point.

    Args:
        yarns: the cell.
        source: control point of the cell from which each point is copied, shape (n,).
        tile: tile of each point inside the box, shape (n, 2).
        columns: number of tiles along the courses.
        number: strand of each point, shape (n,).
    """
    face, row = yarns.face[source], yarns.row[source]
    made = face != UNKNOWN_FACE
    faces = max(int(yarns.face.max()) + 1, 1)
    rows = int(yarns.row[yarns.face != UNKNOWN_FACE].max(initial=0)) + 1
    face = np.where(made, face + faces * (tile[:, 0] + columns * tile[:, 1]), UNKNOWN_FACE)
    return face, np.where(made, row + rows * tile[:, 1], number)
