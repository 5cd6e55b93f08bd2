# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What becomes of the yarn where a row ends at a border (Yuksel et al. 2012, section 4.3).

Rows are knitted to and fro: along each stretch of row ends, those of neighbouring rows are joined in pairs, the
first two on the right border, the second and third on the left, so that a flat piece is one yarn. Where two
stretches begin in one border vertex, at the foot of a slit or beside a bound-off edge, the yarn goes on across it;
likewise where two end in one, at the head of a slit or on a shoulder. A row end without a partner is tied: its
tail hangs on the wrong side.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.mesh import BORDER, FloatArray, StitchMesh
from stitchmesh.yarngen.template import FOOT_PLACE, RADIUS_OVER_WIDTH

TURN_REACH = 0.45
"""How far the turn between two rows reaches beyond the border, over the stitch width."""
SHORTEST_REACH = 0.05
"""The same where another border is so near, at the end of a slit, that turns would meet half way."""
TAIL = ((0.2, 0.15), (0.25, 0.5), (0.25, 0.85), (0.25, 1.2))
"""Points of a tail, beyond the border and behind the fabric, over the stitch width: ends hang on the wrong side."""


@dataclass(frozen=True)
class RowEnds:
    """Row ends at wale borders."""

    partner: dict[int, int]
    """Side that each joined side is joined to, both ways."""
    turn: dict[int, FloatArray]
    """Points on the way from a joined side to its partner [cm], shape (n, 3); none where they lie side by side."""
    tail: dict[int, FloatArray]
    """Points of the tail at each tied side [cm], away from it, shape (n, 3)."""


def finish_row_ends(fabric: StitchMesh) -> RowEnds:
    """Join or tie all row ends of a fabric."""
    ends = RowEnds({}, {}, {})
    runs = [run for loop in fabric.boundary_loops for run in _runs(fabric, loop.tolist())]
    reach = _reaches(fabric, runs)
    for first, second in [*_meetings(fabric, 3, 1), *_meetings(fabric, 1, 1), *_meetings(fabric, 3, 3)]:
        if first not in ends.partner and second not in ends.partner:
            _join(ends, first, second, np.zeros((0, 3)))
    for run in runs:
        _pair(fabric, run, reach, ends)
    for first, second in _meetings(fabric, 1, 3):
        if first not in ends.partner and second not in ends.partner:
            _join(ends, first, second, _turn(fabric, first, second, min(reach[first], reach[second])))
    for side in (side for run in runs for side in run if side not in ends.partner):
        ends.tail[side] = _tail(fabric, side)
    return ends


def _meetings(fabric: StitchMesh, role: int, next_role: int) -> list[tuple[int, int]]:
    """Wale sides of these roles that follow each other on a border without being neighbours in one wale."""
    sides = np.flatnonzero((fabric.side_role == role) & (fabric.twin == BORDER)).tolist()
    pairs = [(side, fabric.next_border_side(side)) for side in sides]
    return [pair for pair in pairs if fabric.side_role[pair[1]] == next_role and not _stacked(fabric, *pair)]


def _stacked(fabric: StitchMesh, side: int, following: int) -> bool:
    """Whether the faces of two sides that follow each other on a border stand on one another."""
    return bool(fabric.twin[fabric.side_next[side]] == fabric.side_previous[following])


def _join(ends: RowEnds, first: int, second: int, turn: FloatArray) -> None:
    ends.partner[first], ends.partner[second] = second, first
    ends.turn[first], ends.turn[second] = turn, turn[::-1]


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
    return [run if fabric.side_role[run[0]] == 1 else run[::-1] for run in runs if fabric.is_wale[run[0]]]


def _pair(fabric: StitchMesh, run: list[int], reach: dict[int, float], ends: RowEnds) -> None:
    """Join neighbouring row ends in pairs, from below; on a left border that starts free, the first stays alone."""
    free = [side for side in run if side not in ends.partner]
    alone = int(fabric.side_role[run[0]] == 3 and len(free) == len(run))
    for low, high in zip(free[alone::2], free[alone + 1 :: 2], strict=False):
        _join(ends, low, high, _turn(fabric, low, high, min(reach[low], reach[high])))


def _tail(fabric: StitchMesh, side: int) -> FloatArray:
    """Points of the tail of a tied row end."""
    behind = -_stitch_width(fabric, side) * fabric.vertex_normal[fabric.face_vertex[side]]
    return np.array([_beyond(fabric, side, out) + depth * behind for out, depth in TAIL])


def _turn(fabric: StitchMesh, low: int, high: int, reach: float) -> FloatArray:
    """Half an ellipse from one row end to the next."""
    near = _beyond(fabric, low, 0.8 * reach), _beyond(fabric, high, 0.8 * reach)
    far = 0.5 * (_beyond(fabric, low, reach) + _beyond(fabric, high, reach))
    return np.array([near[0], far, near[1]])


def _beyond(fabric: StitchMesh, side: int, reach: float) -> FloatArray:
    """A point outside the border, level with the foot that crosses this wale side [cm]."""
    tail, head = fabric.corner_position[side], fabric.corner_position[fabric.side_next[side]]
    share = FOOT_PLACE if fabric.side_role[side] == 1 else 1.0 - FOOT_PLACE
    normal = fabric.vertex_normal[fabric.face_vertex[side]]
    outward = np.cross(head - tail, normal)
    outward /= max(float(np.linalg.norm(outward)), 1e-300)
    return tail + share * (head - tail) + reach * _stitch_width(fabric, side) * outward


def _stitch_width(fabric: StitchMesh, side: int) -> float:
    """Width of the face at a wale side [cm]."""
    area = np.linalg.norm(fabric.face_vector_area[fabric.side_face[side]])
    return float(area / fabric.side_length[side])


