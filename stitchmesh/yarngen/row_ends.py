# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What becomes of the yarn where a row ends at a border (Yuksel et al. 2012, section 4.3).

Rows are knitted to and fro: along each stretch of row ends, those of neighbouring rows are joined in pairs, the
first two on the right border, the second and third on the left, so that a flat piece is one yarn. Where a bound-off
edge meets the row ends beside it, at the foot of an armhole say, its yarn goes on into the row. A row end without a
partner is tied: it gets a tail.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.mesh import BORDER, FloatArray, StitchMesh
from stitchmesh.stitch import Stitch
from stitchmesh.yarngen.template import FOOT_PLACE, RADIUS_OVER_WIDTH

TURN_REACH = 0.45
"""How far the turn between two rows reaches beyond the border, over the stitch width."""
SHORTEST_REACH = 0.05
"""The same where another border is so near, at the end of a slit, that turns would meet half way."""
TAIL = (0.35, 0.7, 1.05, 1.4)
"""Points of a tail beyond the border, over the stitch width."""


@dataclass(frozen=True)
class RowEnds:
    """Row ends at wale borders."""

    partner: dict[int, int]
    """Side that each joined side is joined to, both ways."""
    turn: dict[int, FloatArray]
    """Points on the way from a joined side to its partner [cm], shape (n, 3); none where they lie side by side."""
    tail: dict[int, FloatArray]
    """Points of the tail at each tied side [cm], outwards, shape (n, 3)."""


def finish_row_ends(fabric: StitchMesh) -> RowEnds:
    """Join or tie all row ends of a fabric."""
    ends = RowEnds({}, {}, {})
    runs = [run for loop in fabric.boundary_loops for run in _runs(fabric, loop.tolist())]
    _join_bind_off(fabric, ends)
    reach = _reaches(fabric, runs)
    for run in runs:
        _finish_run(fabric, run, reach, ends)
    return ends


def _join_bind_off(fabric: StitchMesh, ends: RowEnds) -> None:
    """Let the yarn of a bind-off row go on into the row that begins where it ends, in a concave corner."""
    for side in np.flatnonzero((fabric.side_role == 3) & (fabric.twin == BORDER)):
        other = fabric.next_border_side(int(side))
        meets = fabric.stitch[fabric.side_face[[side, other]]] == Stitch.BIND_OFF
        if fabric.side_role[other] == 1 and meets.any():
            ends.partner[int(side)], ends.partner[other] = other, int(side)


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
    """Stretches of wale sides of one kind along a border, each upwards."""
    roles = fabric.side_role[loop]
    breaks = np.flatnonzero(roles != np.roll(roles, 1))
    first = int(breaks[0]) if len(breaks) else 0
    loop, roles = loop[first:] + loop[:first], np.roll(roles, -first)
    cuts = [0, *(np.flatnonzero(np.diff(roles)) + 1).tolist(), len(loop)]
    runs = [(loop[a:b], int(roles[a])) for a, b in pairwise(cuts)]
    return [run if role == 1 else run[::-1] for run, role in runs if role % 2 == 1]


def _finish_run(fabric: StitchMesh, run: list[int], reach: dict[int, float], ends: RowEnds) -> None:
    skipped = 0 if fabric.side_role[run[0]] == 1 else 1
    run = [side for side in run if side not in ends.partner]
    paired = [(run[i], run[i + 1]) for i in range(skipped, len(run) - 1, 2)]
    for low, high in paired:
        ends.partner[low], ends.partner[high] = high, low
        turn = _turn(fabric, low, high, min(reach[low], reach[high]))
        ends.turn[low], ends.turn[high] = turn, turn[::-1]
    for side in set(run) - {side for pair in paired for side in pair}:
        ends.tail[side] = np.array([_beyond(fabric, side, place) for place in TAIL])


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


