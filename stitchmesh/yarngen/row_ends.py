# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Join or tie off the yarn where a row ends at a border (Yuksel et al. 2012, section 4.3).

Rows are knitted to and fro, so the yarn turns at a row end and continues in the next row. Row ends that follow each
other along a border form a run. Within a run, neighbouring row ends are joined in pairs: on a right border the first
and the second, on a left border the second and the third, and so on. A flat piece is then one yarn. Where two runs
begin at the same border vertex, at the foot of a slit or beside a bound-off edge, their first row ends are joined.
Where two runs end at the same vertex, at the head of a slit or on a shoulder, their last row ends are joined.

Only row ends of the same yarn are joined; where rows have several yarns, each yarn is joined on its own. A row end
without a partner is tied off, and its tail hangs on the wrong side of the fabric.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.mesh import BORDER, LEFT, RIGHT, FloatArray, StitchMesh
from stitchmesh.yarngen.bridges import Bridges, crossing_number
from stitchmesh.yarngen.templates.template import FOOT_SHARE, RADIUS_OVER_WIDTH

TURN_REACH = 0.45
"""Distance by which the turn between two rows extends beyond the border, over the stitch width."""
SHORTEST_REACH = 0.05
"""Smallest value of this distance. It is used at the end of a slit, where the turns of two opposite borders would
otherwise meet."""
TAIL = ((0.2, 0.15), (0.25, 0.5), (0.25, 0.85), (0.25, 1.2))
"""Points of a tail: distance beyond the border and depth behind the fabric, both over the stitch width. Tails hang on
the wrong side."""
TAIL_SEPARATION, TAIL_RETREAT = 0.2, 0.3
"""Shifts of two tails that begin side by side: one up and one down the wale side, over the length of that side, and
both back into their own stitches, over the stitch width."""


@dataclass(frozen=True, eq=False)
class RowEndStrand:
    """One of the yarns of a row, between its last stitch and the end of the row."""

    crossing: int
    """Number of the crossing at which the yarn leaves its last stitch."""
    points: FloatArray
    """Points between the last stitch and the border [cm], shape (n, 3)."""
    depth: float
    """Depth behind the border at which the yarn turns to the next row [cm]."""
    tail: FloatArray
    """Points of the tail that is used where the strand is not joined [cm], shape (n, 3)."""


Strands = dict[int, dict[int, RowEndStrand]]
"""Strands by the border side at which their row ends, and then by the number of their yarn."""
Pair = tuple[int, int, FloatArray]
"""Two border sides and the points of the turn between them [cm], shape (n, 3)."""


def finish_row_ends(fabric: StitchMesh, strands: Strands | None = None) -> Bridges:
    """Join all row ends of a fabric in pairs, or tie them off.

    Args:
        fabric: the stitch mesh.
        strands: the strands at row ends that more than one yarn reaches; other row ends have the one yarn of their
            stitch.

    Returns:
        The bridges and tails at the row ends.
    """
    bridges = Bridges()
    runs = [run for loop in fabric.boundary_loops for run in _row_end_runs(fabric, loop.tolist())]
    strands_by_side = {side: _strand_of_stitch(fabric, side) for run in runs for side in run} | (strands or {})
    for first, second, turn in _pairs(fabric, runs):
        for yarn in strands_by_side[first].keys() & strands_by_side[second].keys():
            _join_strands(fabric, bridges, (strands_by_side[first][yarn], strands_by_side[second][yarn]), first, turn)
        if len(turn) == 0:
            _separate_tails(fabric, strands_by_side, first, second)
    for each in strands_by_side.values():
        for strand in each.values():
            if not bridges.redirects(strand.crossing):
                bridges.end_in_tail(strand.crossing, strand.tail)
    return bridges


def _separate_tails(fabric: StitchMesh, strands_by_side: Strands, first: int, second: int) -> None:
    """Move the tails of two row ends that lie side by side apart; the yarn of the lower number gets the lower tail."""
    yarns = fabric.yarn[fabric.side_face[[first, second]]].tolist()
    for side, yarn in zip((first, second), yarns, strict=True):
        rise = TAIL_SEPARATION if yarn == max(yarns) else -TAIL_SEPARATION
        tail = tail_points(fabric, side, rise, TAIL_RETREAT)
        strands_by_side[side] |= {yarn: replace(strands_by_side[side][yarn], tail=tail)}


def _strand_of_stitch(fabric: StitchMesh, side: int) -> dict[int, RowEndStrand]:
    """The strand of the stitch at a row end, by the number of its yarn."""
    yarn = int(fabric.yarn[fabric.side_face[side]])
    return {yarn: RowEndStrand(crossing_number(side), np.zeros((0, 3)), 0.0, tail_points(fabric, side))}


def _join_strands(
    fabric: StitchMesh, bridges: Bridges, strands: tuple[RowEndStrand, RowEndStrand], side: int, turn: FloatArray
) -> None:
    """Join two strands by a turn, which lies behind the border by the larger depth of the two strands."""
    first, second = strands
    turn = turn - max(first.depth, second.depth) * fabric.vertex_normal[fabric.face_vertex[side]]
    bridges.join(first.crossing, second.crossing, np.concatenate([first.points, turn, second.points[::-1]]))


def _pairs(fabric: StitchMesh, runs: list[list[int]]) -> list[Pair]:
    """Pairs of row ends to be joined, whatever their yarns. A row end is in at most one pair."""
    reach, pairs = _turn_reaches(fabric, runs), []
    paired: set[int] = set()
    side_by_side = [
        pair for roles in ((LEFT, RIGHT), (RIGHT, RIGHT), (LEFT, LEFT)) for pair in _adjacent_row_ends(fabric, *roles)
    ]
    for first, second in side_by_side:
        if not paired & {first, second}:
            pairs.append((first, second, np.zeros((0, 3))))
            paired |= {first, second}
    for run in runs:
        for low, high in _pairs_along_run(fabric, run, paired):
            pairs.append((low, high, _turn_points(fabric, low, high, min(reach[low], reach[high]))))
            paired |= {low, high}
    for first, second in _adjacent_row_ends(fabric, RIGHT, LEFT):
        if not paired & {first, second}:
            pairs.append((first, second, _turn_points(fabric, first, second, min(reach[first], reach[second]))))
            paired |= {first, second}
    return pairs


def _adjacent_row_ends(fabric: StitchMesh, role: int, next_role: int) -> list[tuple[int, int]]:
    """Wale sides of two given roles that follow each other on a border and do not belong to the same wale."""
    sides = np.flatnonzero((fabric.side_role == role) & (fabric.twin == BORDER)).tolist()
    pairs = [(side, fabric.next_border_side(side)) for side in sides]
    return [pair for pair in pairs if fabric.side_role[pair[1]] == next_role and not _are_stacked(fabric, *pair)]


def _are_stacked(fabric: StitchMesh, side: int, following: int) -> bool:
    """Whether two sides that follow each other on a border belong to faces that lie above each other in one wale."""
    same_role = fabric.side_role[side] == fabric.side_role[following]
    return bool(same_role and fabric.twin[fabric.side_next[side]] == fabric.side_previous[following])


def _turn_reaches(fabric: StitchMesh, runs: list[list[int]]) -> dict[int, float]:
    """Largest reach of the turn at each side, over the stitch width: half the distance to the next run of row ends."""
    reach: dict[int, float] = {}
    middle = 0.5 * (fabric.corner_position + fabric.corner_position[fabric.side_next])
    for run in runs:
        others = [side for other in runs if other is not run for side in other]
        distances_to_others = cKDTree(middle[others]).query(middle[run])[0] if others else np.full(len(run), np.inf)
        for side, distance in zip(run, distances_to_others, strict=True):
            available = 0.5 * distance / _stitch_width(fabric, side) - RADIUS_OVER_WIDTH
            reach[side] = float(np.clip(available, SHORTEST_REACH, TURN_REACH))
    return reach


def _row_end_runs(fabric: StitchMesh, loop: list[int]) -> list[list[int]]:
    """Runs of row ends along a border: wale sides whose faces lie above each other, from the lowest to the highest."""
    before = [loop[-1], *loop[:-1]]
    starts = [place for place, pair in enumerate(zip(before, loop, strict=True)) if not _are_stacked(fabric, *pair)]
    first = starts[0] if starts else 0
    loop = loop[first:] + loop[:first]
    cuts = [start - first for start in starts] or [0]
    runs = [loop[a:b] for a, b in pairwise([*cuts, len(loop)])]
    return [run if fabric.side_role[run[0]] == RIGHT else run[::-1] for run in runs if fabric.is_wale[run[0]]]


def _pairs_along_run(fabric: StitchMesh, run: list[int], paired: set[int]) -> list[tuple[int, int]]:
    """Neighbouring row ends of a run in pairs, from below.

    On a left border where no row end is paired yet, the first row end stays alone.
    """
    unpaired = [side for side in run if side not in paired]
    skipped = int(fabric.side_role[run[0]] == LEFT and len(unpaired) == len(run))
    return list(zip(unpaired[skipped::2], unpaired[skipped + 1 :: 2], strict=False))


def tail_points(fabric: StitchMesh, side: int, rise: float = 0.0, retreat: float = 0.0) -> FloatArray:
    """Points of the tail of a row end that is tied off [cm], shape (n, 3).

    Args:
        fabric: the stitch mesh.
        side: the wale side at which the row ends.
        rise: distance by which the tail is moved up, over the length of the wale side.
        retreat: distance by which the tail is moved into its stitch, over the stitch width.
    """
    backwards = -_stitch_width(fabric, side) * fabric.vertex_normal[fabric.face_vertex[side]]
    wale = fabric.corner_position[fabric.side_next[side]] - fabric.corner_position[side]
    up = rise * (wale if fabric.side_role[side] == RIGHT else -wale)
    outside = [_point_outside(fabric, side, outwards - retreat) for outwards, _ in TAIL]
    return np.array([point + up + depth * backwards for point, (_, depth) in zip(outside, TAIL, strict=True)])


def _turn_points(fabric: StitchMesh, low: int, high: int, reach: float) -> FloatArray:
    """Points of half an ellipse from one row end to the next [cm], shape (3, 3)."""
    near = _point_outside(fabric, low, 0.8 * reach), _point_outside(fabric, high, 0.8 * reach)
    far = 0.5 * (_point_outside(fabric, low, reach) + _point_outside(fabric, high, reach))
    return np.array([near[0], far, near[1]])


def _point_outside(fabric: StitchMesh, side: int, reach: float) -> FloatArray:
    """A point outside the border, level with the foot of the loop that crosses this wale side [cm], shape (3,)."""
    tail, head = fabric.corner_position[side], fabric.corner_position[fabric.side_next[side]]
    share = FOOT_SHARE if fabric.side_role[side] == RIGHT else 1.0 - FOOT_SHARE
    normal = fabric.vertex_normal[fabric.face_vertex[side]]
    outward = np.cross(head - tail, normal)
    outward /= max(float(np.linalg.norm(outward)), 1e-300)
    return tail + share * (head - tail) + reach * _stitch_width(fabric, side) * outward


def _stitch_width(fabric: StitchMesh, side: int) -> float:
    """Width of the face at a wale side [cm]: its area over the length of the side."""
    area = np.linalg.norm(fabric.face_vector_area[fabric.side_face[side]])
    return float(area / fabric.side_length[side])
