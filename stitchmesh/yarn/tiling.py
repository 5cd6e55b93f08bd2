# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tiles of a periodic cell: a piece of the fabric cut to size, a larger cell, or only where its copies lie.

A yarn of lattice step (a, b) goes on from its copy in tile (i, j) into its copy in tile (i + a, j + b). In a box of
tiles its strands begin at the copies whose predecessor (i - a, j - b) lies outside and end with the last copy inside.
A strand of m copies of a yarn with n control points is an open yarn of the m n segments of those copies, and so of
m n + 3 control points: the last three are the first three of the copy that would come next. A yarn of step (0, 0), a
ring, stays closed; so does everything where the box itself repeats, there a strand runs until it comes back.

Labels number on: faces tile by tile along the courses and then up, rows by rows of tiles, and where no stitch made a
control point its row is the number of its yarn. Tiles beyond the box carry the labels of those that repeat there.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from math import gcd, lcm

import numpy as np

from stitchmesh.errors import ParameterError, YarnError
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn.yarn_set import UNKNOWN_FACE, YarnSet

OVERLAP = 3
"""Control points that an open yarn has more than segments."""


@dataclass(frozen=True)
class _Strand:
    """The copies that follow one another along one yarn of the tiling."""

    yarn: int
    """Yarn of the cell."""
    tiles: IntArray
    """Tile of each copy, one after another in space, shape (m, 2)."""
    cut: bool
    """Whether it ends at the border of the box, where the cell's yarn goes on."""


def tile_yarns(yarns: YarnSet, columns: int, rows: int, *, periodic: bool = False) -> YarnSet:
    """A cell written out tile by tile; curves, yarn at rest and labels as the module says.

    Args:
        yarns: a set on a lattice.
        columns: tiles along the courses.
        rows: tiles along the wales.
        periodic: whether the piece repeats in its turn, with ``columns`` and ``rows`` times the periods; else it ends
            at its borders and has no lattice.

    Returns:
        The strands by the tile that they start in, along the courses and then up, in each tile in the order of the
        cell's yarns.

    Raises:
        ParameterError: a count is not a whole number from 1.
        YarnError: the set has no lattice.
    """
    lattice, steps = _lattice_of(yarns)
    _check_counts(columns, rows)
    strands = list(_strands(yarns, steps, columns, rows, periodic))
    pieces = [_copied_points(yarns, lattice, strand, steps) for strand in strands]
    taken = [_copied_numbers(yarns, strand) for strand in strands]
    source = np.concatenate(taken)
    start = np.concatenate([[0], np.cumsum([len(own) for own in taken])])
    owner = np.array([strand.yarn for strand in strands])
    tile = np.concatenate([_tile_of_points(yarns, strand, steps) for strand in strands])
    number = np.repeat(np.arange(len(strands)), np.diff(start))
    face, row = _labels(yarns, source, tile % [columns, rows], columns, number)
    plain = YarnSet(
        points=np.concatenate(pieces),
        start=start,
        closed=yarns.closed[owner] & ~np.array([strand.cut for strand in strands]),
        radius=yarns.radius[owner],
        rest_length=np.concatenate([_copied_rest_lengths(yarns, strand) for strand in strands]),
        row=row,
        face=face,
        part=yarns.part[source],
        colour=yarns.colour[owner],
        natural_curvature=yarns.natural_curvature[source],
    )
    if not periodic:
        return plain
    step = np.stack([_whole_step(strand, steps) for strand in strands]) // np.array([columns, rows])
    larger = Lattice(lattice.periods * np.array([[columns], [rows]]))
    return dataclasses.replace(plain, lattice=larger, lattice_step=step)


def instances(lattice: Lattice, columns: int, rows: int) -> FloatArray:
    """Where to draw the copies of one period so that they show ``columns`` by ``rows`` tiles.

    Returns:
        Displacement of each tile [cm], along the courses and then up, shape (columns * rows, 3).

    Raises:
        ParameterError: a count is not a whole number from 1.
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
    row, column = np.divmod(np.arange(columns * rows), columns)
    return np.stack([column, row], axis=1)


def _strands(yarns: YarnSet, steps: IntArray, columns: int, rows: int, periodic: bool) -> Iterator[_Strand]:
    seen: set[tuple[int, int, int]] = set()
    for column, row in _tiles(columns, rows).tolist():
        for yarn, (a, b) in enumerate(steps.tolist()):
            endless = not yarns.closed[yarn] or (a, b) == (0, 0)
            if endless:
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
    """How often one can be at a place inside ``count`` places, going on by a step."""
    if step == 0:
        return 10**9
    return (count - 1 - place) // step + 1 if step > 0 else place // -step + 1


def _copied_numbers(yarns: YarnSet, strand: _Strand) -> IntArray:
    """Control point of the cell that each point of the strand copies."""
    own = np.arange(yarns.start[strand.yarn], yarns.start[strand.yarn + 1])
    return np.concatenate([np.tile(own, len(strand.tiles)), own[:OVERLAP] if strand.cut else own[:0]])


def _tile_of_points(yarns: YarnSet, strand: _Strand, steps: IntArray) -> IntArray:
    """Tile of the copy that each point of the strand belongs to, shape (n, 2)."""
    size = yarns.start[strand.yarn + 1] - yarns.start[strand.yarn]
    beyond = strand.tiles[-1:] + steps[strand.yarn]
    return np.concatenate([np.repeat(strand.tiles, size, axis=0), np.repeat(beyond, OVERLAP * strand.cut, axis=0)])


def _copied_points(yarns: YarnSet, lattice: Lattice, strand: _Strand, steps: IntArray) -> FloatArray:
    return yarns.points[_copied_numbers(yarns, strand)] + lattice.shift(_tile_of_points(yarns, strand, steps))


def _copied_rest_lengths(yarns: YarnSet, strand: _Strand) -> FloatArray:
    own = yarns.rest_length[yarns.segment_start[strand.yarn] : yarns.segment_start[strand.yarn + 1]]
    return np.tile(own, len(strand.tiles))


def _labels(
    yarns: YarnSet, source: IntArray, tile: IntArray, columns: int, number: IntArray
) -> tuple[IntArray, IntArray]:
    """Face and row of each control point, from the one that it copies, its tile and the number of its strand."""
    face, row = yarns.face[source], yarns.row[source]
    made = face != UNKNOWN_FACE
    faces = max(int(yarns.face.max()) + 1, 1)
    rows = int(yarns.row[yarns.face != UNKNOWN_FACE].max(initial=0)) + 1
    face = np.where(made, face + faces * (tile[:, 0] + columns * tile[:, 1]), UNKNOWN_FACE)
    return face, np.where(made, row + rows * tile[:, 1], number)


def _whole_step(strand: _Strand, steps: IntArray) -> IntArray:
    """Tiles from the strand's first copy to the one after its last; for a ring and for an open yarn its own step."""
    return len(strand.tiles) * steps[strand.yarn]
