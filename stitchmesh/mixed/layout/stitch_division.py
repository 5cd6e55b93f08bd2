# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Division of each stitch of a stitch mesh into k x k smaller ones.

The triangles of a cloth should be much larger than its stitches (Casafranca et al. 2020: hundreds of nodes on each),
but a stitch mesh has only two triangles for each stitch. A coarse stitch mesh can therefore serve as the cloth, and its
division lays out the yarns. Every edge is divided into k edges, and a stitch with one bottom and one top side into k
rows of k stitches. Where a stitch has more top than bottom sides, the k stitches of its last row make the loops; where
it has more bottom sides, the k stitches of its first row work them together.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from stitchmesh.errors import ParameterError, first_few
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.arrays import distinct_rows
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.stitch import Stitch


@dataclass(frozen=True, eq=False)
class DividedStitches:
    """A stitch mesh whose faces are parts of the faces of another mesh."""

    fabric: StitchMesh
    """The smaller stitches."""
    parent: IntArray
    """Face of the other mesh to which each face belongs, shape (F,)."""
    corner_place: FloatArray
    """Place of each corner in that face, shape (C, 2): from 0 at the left to 1 at the right wale side, and from 0 at
    the bottom to 1 at the top."""


@dataclass(frozen=True)
class _Part:
    """A small stitch in the division of a face; its corners are numbers of points of the division."""

    corners: tuple[int, ...]
    n_bottom: int
    n_top: int
    row: int


@dataclass(frozen=True)
class _Division:
    """The division of a kind of face."""

    places: tuple[tuple[float, float], ...]
    """Place of each point in the face."""
    sources: tuple[tuple[int, int], ...]
    """Side of the face on which each point lies, and its place along the side from 0 to k - 1; (-1, n) inside."""
    parts: tuple[_Part, ...]


def divide_stitches(fabric: StitchMesh, k: int) -> DividedStitches:
    """Divide each stitch into k rows of stitches.

    Args:
        fabric: stitch mesh.
        k: number of parts of each edge.

    Raises:
        ParameterError: k is below 1, or a face has several bottom and several top sides, or none of one kind.
    """
    if k < 1:
        raise ParameterError(f"division of stitches: got {k}; expected a number of at least 1")
    if k == 1:
        return DividedStitches(fabric, np.arange(fabric.face_count), _corner_places(fabric))
    fewest = np.minimum(fabric.n_bottom, fabric.n_top)
    bad = np.flatnonzero(fewest != 1)
    if len(bad):
        found = f"{fabric.n_bottom[bad[0]]} bottom and {fabric.n_top[bad[0]]} top sides"
        raise ParameterError(f"face {first_few(bad)}: got {found}; expected one of one kind, to divide the stitch")
    kinds, kind = distinct_rows(np.stack([fabric.n_bottom, fabric.n_top], axis=1))
    first_inside = len(fabric.vertices) + len(fabric.edge_side) * (k - 1)
    inside = (k - 1) ** 2  # a row between two other rows has as many loops as the side with one edge
    groups = []
    positions = np.zeros((first_inside + inside * fabric.face_count, 3))
    for number, (bottom, top) in enumerate(kinds.tolist()):
        faces = np.flatnonzero(kind == number)
        division = _division(bottom, top, k)
        points = _point_numbers(fabric, faces, division, k, first_inside)
        weights = _corner_weights(np.array(division.places), bottom, top)
        corners = fabric.face_start[faces][:, None] + np.arange(bottom + top + 2)
        positions[points] = np.einsum("pc,fcd->fpd", weights, fabric.corner_position[corners])
        groups.append((faces, division, points))
    return _divided(fabric, positions, groups, k)


def _corner_places(fabric: StitchMesh) -> FloatArray:
    """Place of each corner in its own face, shape (C, 2)."""
    at_top = fabric.side_place > fabric.n_bottom[fabric.side_face]
    along = places_from_left(fabric, np.arange(fabric.side_count), np.zeros(fabric.side_count))
    return np.stack([along, at_top.astype(np.float64)], axis=1)


def places_from_left(fabric: StitchMesh, side: IntArray, along: FloatArray) -> FloatArray:
    """Return places of points on bottom and top sides as a part of the width of their face, from the left, shape (n,).

    Args:
        fabric: stitch mesh.
        side: side of each point, shape (n,).
        along: part of the way along the side, in its direction, shape (n,).
    """
    face, step = fabric.side_face[side], fabric.side_place[side] + along
    bottom, top = fabric.n_bottom[face], fabric.n_top[face]
    at_top = fabric.side_place[side] > bottom
    part: FloatArray = np.where(at_top, (bottom + 1 + top - step) / np.maximum(top, 1), step / np.maximum(bottom, 1))
    return part


def _corner_weights(places: FloatArray, bottom: int, top: int) -> FloatArray:
    """Weights of the corners of a face at places in it, shape (p, c): linear along both chains and between them."""
    weights = np.zeros((len(places), bottom + top + 2))
    for chain, count in ((0, bottom), (1, top)):
        along = places[:, 0] * count
        low = np.minimum(along.astype(np.int64), max(count - 1, 0))
        share = np.abs(1 - chain - places[:, 1])
        for step, part in ((0, 1.0 - (along - low)), (1, along - low)):
            at = np.minimum(low + step, count)
            weights[np.arange(len(places)), at if chain == 0 else bottom + 1 + top - at] += share * part
    return weights


@cache
def _division(bottom: int, top: int, k: int) -> _Division:
    """The division of a face; rows of points go from left to right, and follow one another from bottom to top."""
    places: list[tuple[float, float]] = []
    sources: list[tuple[int, int]] = []
    rows: list[list[int]] = []
    for level in range(k + 1):
        count = (bottom if level == 0 else top if level == k else 1) * k
        rows.append([len(places) + at for at in range(count + 1)])
        for at in range(count + 1):
            places.append((at / count, level / k))
            sources.append(_source(level, at, count, bottom, top, k))
    return _Division(tuple(places), tuple(sources), tuple(_parts(rows, bottom, top, k)))


def _source(level: int, at: int, count: int, bottom: int, top: int, k: int) -> tuple[int, int]:
    """Where a point of a division lies: a side of the face and the place along it, or inside."""
    if level == 0 and at < count:
        return at // k, at % k
    if level == k and at > 0:
        from_right = count - at
        return bottom + 1 + from_right // k, from_right % k
    if at == count:
        return bottom, level
    if at == 0:
        return bottom + top + 1, k - level
    return -1, (level - 1) * (k - 1) + at - 1


def _parts(rows: list[list[int]], bottom: int, top: int, k: int) -> list[_Part]:
    made = []
    for level in range(k):
        n_bottom, n_top = bottom if level == 0 else 1, top if level == k - 1 else 1
        low, high = rows[level], rows[level + 1]
        for at in range(k):
            below = low[at * n_bottom : (at + 1) * n_bottom + 1]
            above = high[at * n_top : (at + 1) * n_top + 1]
            made.append(_Part((*below, *above[::-1]), n_bottom, n_top, level))
    return made


def _point_numbers(fabric: StitchMesh, faces: IntArray, division: _Division, k: int, first_inside: int) -> IntArray:
    """Vertex of each point of the division of each face, shape (faces, points)."""
    place, step = np.array(division.sources).T
    side = fabric.face_start[faces][:, None] + np.maximum(place, 0)
    edge = fabric.side_edge[side]
    forwards = fabric.edge_side[edge] == side
    on_edge = len(fabric.vertices) + edge * (k - 1) + np.where(forwards, step - 1, k - 1 - step)
    at_vertex = fabric.face_vertex[side]
    inside = first_inside + faces[:, None] * (k - 1) ** 2 + step
    return np.where(place < 0, inside, np.where(step == 0, at_vertex, on_edge))


def _divided(
    fabric: StitchMesh, positions: FloatArray, groups: list[tuple[IntArray, _Division, IntArray]], k: int
) -> DividedStitches:
    """The mesh of the parts of all faces."""
    corners, counts, parent, places, kinds = [], [], [], [], []
    for faces, division, points in groups:
        for part in division.parts:
            corners += points[:, part.corners].tolist()
            counts.append(np.full(len(faces), len(part.corners)))
            parent.append(faces)
            places.append(np.tile(np.array(division.places)[list(part.corners)], (len(faces), 1)))
            shape = np.array([part.n_bottom, part.n_top, part.row])
            kinds.append(np.column_stack([np.tile(shape, (len(faces), 1)), _stitches(fabric, faces, part, k)]))
    start = np.concatenate([[0], np.cumsum(np.concatenate(counts))])
    vertex = np.array([one for face in corners for one in face])
    used, vertex = np.unique(vertex, return_inverse=True)
    of_part, owner = np.concatenate(kinds), np.concatenate(parent)
    divided = StitchMesh(
        vertices=positions[used],
        face_start=start,
        face_vertex=vertex,
        twin=find_twins(start, vertex, len(used)),
        n_bottom=of_part[:, 0],
        n_top=of_part[:, 1],
        stitch=of_part[:, 3],
        row=fabric.row[owner] * k + of_part[:, 2],
        yarn=fabric.yarn[owner],
        palette=fabric.palette,
        own_stitches=fabric.own_stitches,
    )
    divided = replace(divided, twist=_half_turns(fabric, divided, owner))
    return DividedStitches(divided, owner, np.concatenate(places))


def _half_turns(fabric: StitchMesh, divided: StitchMesh, owner: IntArray) -> IntArray:
    """Half turns of the loops of increases among the parts, copied from their faces, shape (C,)."""
    twist = np.zeros(divided.side_count, dtype=np.int64)
    for part in np.flatnonzero(divided.n_top > 1):
        loops = 1 + np.arange(divided.n_top[part])
        twist[divided.left_wale[part] - loops] = fabric.twist[fabric.left_wale[owner[part]] - loops]
    return twist


def _stitches(fabric: StitchMesh, faces: IntArray, part: _Part, k: int) -> IntArray:
    """Stitch of one part of each face: the stitch of the face where the part has its sides, else plain knit or purl."""
    own = fabric.stitch[faces]
    is_first, is_last = part.row == 0, part.row == k - 1
    plain = np.where(own == Stitch.PURL, Stitch.PURL, Stitch.KNIT)
    if fabric.n_bottom[faces[0]] != fabric.n_top[faces[0]]:
        keeps = (is_first and part.n_bottom > 1) or (is_last and part.n_top > 1)
        return own if keeps else plain
    return np.where((own == Stitch.CAST_ON) & (not is_first), plain, own)
