# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What becomes of the yarn where a row ends at a border (Yuksel et al. 2012, section 4.3).

Rows are knitted to and fro: along each stretch of row ends, those of neighbouring rows are joined in pairs, the
first two on the right border, the second and third on the left, so that a flat piece is one yarn. Where two
stretches begin in one border vertex, at the foot of a slit or beside a bound-off edge, the yarn goes on across it;
likewise where two end in one, at the head of a slit or on a shoulder. Only rows of the same yarn are joined; where
rows are knitted with several yarns, each is. A row end without a partner is tied: its tail hangs on the wrong side.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.mesh import BORDER, LEFT, RIGHT, FloatArray, StitchMesh
from stitchmesh.yarngen.bridges import Bridges, crossing_number
from stitchmesh.yarngen.templates.template import FOOT_PLACE, RADIUS_OVER_WIDTH

TURN_REACH = 0.45
"""How far the turn between two rows reaches beyond the border, over the stitch width."""
SHORTEST_REACH = 0.05
"""The same where another border is so near, at the end of a slit, that turns would meet half way."""
TAIL = ((0.2, 0.15), (0.25, 0.5), (0.25, 0.85), (0.25, 1.2))
"""Points of a tail, beyond the border and behind the fabric, over the stitch width: ends hang on the wrong side."""
ABREAST = 0.2
"""How far up and down the wale side tails hang that begin side by side, over its length."""


@dataclass(frozen=True, eq=False)
class Strand:
    """One of the yarns of a row, from its last stitch to the row's end."""

    crossing: int
    """Where it leaves its last stitch."""
    points: FloatArray
    """Points on the way to the border [cm], shape (n, 3)."""
    behind: float
    """How far behind the border it turns to the next row [cm]."""
    tail: FloatArray
    """Points of its tail where it is not joined [cm], shape (n, 3)."""


Strands = dict[int, dict[int, Strand]]
"""By the border side at which their row ends, and by the number of their yarn."""
Pair = tuple[int, int, FloatArray]
"""Two border sides and the points of the turn between them [cm], shape (n, 3)."""


def finish_row_ends(fabric: StitchMesh, strands: Strands | None = None) -> Bridges:
    """Join or tie all row ends of a fabric.

    Args:
        fabric: the stitch mesh.
        strands: yarns of the row ends that more than one comes to.
    """
    ends = Bridges()
    runs = [run for loop in fabric.boundary_loops for run in _runs(fabric, loop.tolist())]
    arrive = {side: _strand(fabric, side) for run in runs for side in run} | (strands or {})
    for first, second, turn in _pairs(fabric, runs):
        for yarn in arrive[first].keys() & arrive[second].keys():
            _join(fabric, ends, (arrive[first][yarn], arrive[second][yarn]), first, turn)
        if len(turn) == 0:
            _part_tails(fabric, arrive, first, second)
    for each in arrive.values():
        for strand in each.values():
            if not ends.holds(strand.crossing):
                ends.tie(strand.crossing, strand.tail)
    return ends


def _part_tails(fabric: StitchMesh, arrive: Strands, first: int, second: int) -> None:
    """Hang the tails of two row ends that lie side by side past one another, that of the lower number lower."""
    yarns = fabric.yarn[fabric.side_face[[first, second]]].tolist()
    for side, yarn in zip((first, second), yarns, strict=True):
        tail = tail_points(fabric, side, ABREAST if yarn == max(yarns) else -ABREAST)
        arrive[side] |= {yarn: replace(arrive[side][yarn], tail=tail)}


def _strand(fabric: StitchMesh, side: int) -> dict[int, Strand]:
    """The yarn of the stitch at a row's end."""
    yarn = int(fabric.yarn[fabric.side_face[side]])
    return {yarn: Strand(crossing_number(side), np.zeros((0, 3)), 0.0, tail_points(fabric, side))}


def _join(fabric: StitchMesh, ends: Bridges, strands: tuple[Strand, Strand], side: int, turn: FloatArray) -> None:
    first, second = strands
    turn = turn - max(first.behind, second.behind) * fabric.vertex_normal[fabric.face_vertex[side]]
    ends.join(first.crossing, second.crossing, np.concatenate([first.points, turn, second.points[::-1]]))


def _pairs(fabric: StitchMesh, runs: list[list[int]]) -> list[Pair]:
    """Row ends that belong together, whatever their yarns; each stands in one pair at most."""
    reach, pairs = _reaches(fabric, runs), []
    taken: set[int] = set()
    at_feet = [pair for roles in ((LEFT, RIGHT), (RIGHT, RIGHT), (LEFT, LEFT)) for pair in _meetings(fabric, *roles)]
    for first, second in at_feet:
        if not taken & {first, second}:
            pairs.append((first, second, np.zeros((0, 3))))
            taken |= {first, second}
    for run in runs:
        for low, high in _neighbours(fabric, run, taken):
            pairs.append((low, high, _turn(fabric, low, high, min(reach[low], reach[high]))))
            taken |= {low, high}
    for first, second in _meetings(fabric, RIGHT, LEFT):
        if not taken & {first, second}:
            pairs.append((first, second, _turn(fabric, first, second, min(reach[first], reach[second]))))
            taken |= {first, second}
    return pairs


def _meetings(fabric: StitchMesh, role: int, next_role: int) -> list[tuple[int, int]]:
    """Wale sides of these roles that follow each other on a border without being neighbours in one wale."""
    sides = np.flatnonzero((fabric.side_role == role) & (fabric.twin == BORDER)).tolist()
    pairs = [(side, fabric.next_border_side(side)) for side in sides]
    return [pair for pair in pairs if fabric.side_role[pair[1]] == next_role and not _stacked(fabric, *pair)]


def _stacked(fabric: StitchMesh, side: int, following: int) -> bool:
    """Whether the faces of two sides that follow each other on a border stand on one another."""
    return bool(fabric.twin[fabric.side_next[side]] == fabric.side_previous[following])


def _reaches(fabric: StitchMesh, runs: list[list[int]]) -> dict[int, float]:
    """How far turns may reach beyond each side, over the stitch width: half way to the next stretch of row ends."""
    reach: dict[int, float] = {}
    middle = 0.5 * (fabric.corner_position + fabric.corner_position[fabric.side_next])
    for run in runs:
        others = [side for other in runs if other is not run for side in other]
        gap = cKDTree(middle[others]).query(middle[run])[0] if others else np.full(len(run), np.inf)
        for side, distance in zip(run, gap, strict=True):
            room = 0.5 * distance / _stitch_width(fabric, side) - RADIUS_OVER_WIDTH
            reach[side] = float(np.clip(room, SHORTEST_REACH, TURN_REACH))
    return reach


def _runs(fabric: StitchMesh, loop: list[int]) -> list[list[int]]:
    """Stretches of wale sides along a border whose faces stand on one another, each upwards."""
    before = [loop[-1], *loop[:-1]]
    starts = [place for place, pair in enumerate(zip(before, loop, strict=True)) if not _stacked(fabric, *pair)]
    first = starts[0] if starts else 0
    loop = loop[first:] + loop[:first]
    cuts = [start - first for start in starts] or [0]
    runs = [loop[a:b] for a, b in pairwise([*cuts, len(loop)])]
    return [run if fabric.side_role[run[0]] == RIGHT else run[::-1] for run in runs if fabric.is_wale[run[0]]]


def _neighbours(fabric: StitchMesh, run: list[int], taken: set[int]) -> list[tuple[int, int]]:
    """Neighbouring row ends in pairs, from below; on a left border that starts free, the first stays alone."""
    free = [side for side in run if side not in taken]
    alone = int(fabric.side_role[run[0]] == LEFT and len(free) == len(run))
    return list(zip(free[alone::2], free[alone + 1 :: 2], strict=False))


def tail_points(fabric: StitchMesh, side: int, rise: float = 0.0) -> FloatArray:
    """Points of the tail of a tied row end, raised by a share of its wale side."""
    behind = -_stitch_width(fabric, side) * fabric.vertex_normal[fabric.face_vertex[side]]
    wale = fabric.corner_position[fabric.side_next[side]] - fabric.corner_position[side]
    up = rise * (wale if fabric.side_role[side] == RIGHT else -wale)
    return np.array([_beyond(fabric, side, out) + up + depth * behind for out, depth in TAIL])


def _turn(fabric: StitchMesh, low: int, high: int, reach: float) -> FloatArray:
    """Half an ellipse from one row end to the next."""
    near = _beyond(fabric, low, 0.8 * reach), _beyond(fabric, high, 0.8 * reach)
    far = 0.5 * (_beyond(fabric, low, reach) + _beyond(fabric, high, reach))
    return np.array([near[0], far, near[1]])


def _beyond(fabric: StitchMesh, side: int, reach: float) -> FloatArray:
    """A point outside the border, level with the foot that crosses this wale side [cm]."""
    tail, head = fabric.corner_position[side], fabric.corner_position[fabric.side_next[side]]
    share = FOOT_PLACE if fabric.side_role[side] == RIGHT else 1.0 - FOOT_PLACE
    normal = fabric.vertex_normal[fabric.face_vertex[side]]
    outward = np.cross(head - tail, normal)
    outward /= max(float(np.linalg.norm(outward)), 1e-300)
    return tail + share * (head - tail) + reach * _stitch_width(fabric, side) * outward


def _stitch_width(fabric: StitchMesh, side: int) -> float:
    """Width of the face at a wale side [cm]."""
    area = np.linalg.norm(fabric.face_vector_area[fabric.side_face[side]])
    return float(area / fabric.side_length[side])


