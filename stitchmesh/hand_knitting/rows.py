# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The words of one row, in the order in which its stitches are worked."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from stitchmesh.hand_knitting.pieces import PieceRow
from stitchmesh.hand_knitting.words import (
    MADE_ONES,
    cable_word,
    colour_letter,
    stitch_word,
    without_yarn_overs,
    word_with_twists,
)
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.cable_groups import CableGroup, cable_groups
from stitchmesh.mesh.courses import bottom_sides, top_sides
from stitchmesh.mesh.own_stitch import StitchType
from stitchmesh.mesh.stitch import Stitch


@dataclass(frozen=True)
class WrittenStitch:
    """One stitch, as seen from the right side."""

    stitch: StitchType
    twists: tuple[int, ...] = ()
    """Half turn of each loop that it is worked through, from left to right, as in ``StitchMesh.twist``."""
    yarn: int = 0
    """Number of the yarn."""
    made: int = 0
    """Half turn of the loop that a yarn-over makes; a yarn-over with a half turn is a made one."""

    def word(self, right_side: bool) -> str:
        """Return the word of the stitch, with the twists of its loops, for a knitter who looks at this side."""
        if self.made:
            return MADE_ONES[self.made]
        twists = self.twists[::-1] if right_side else self.twists
        return word_with_twists(stitch_word(self.stitch, right_side), twists)


@dataclass(frozen=True)
class CableCrossings:
    """The cables of a fabric, indexed by the top sides of their loops."""

    group_at: dict[int, CableGroup]
    """Cable group of each top side that belongs to a group."""
    loop_at: dict[int, int]
    """For each top side of a group, the top side from which its loop comes when the group is crossed."""

    @classmethod
    def of(cls, fabric: StitchMesh) -> CableCrossings:
        """Find the cables of a fabric.

        Raises:
            LabelError: the cable marks of the fabric contradict each other.
        """
        found = cls({}, {})
        for group in cable_groups(fabric):
            for side, place in zip(group.sides.tolist(), group.destination.tolist(), strict=True):
                found.group_at[side] = group
                found.loop_at[int(group.sides[place])] = side
        return found


def row_words(fabric: StitchMesh, row: PieceRow, crossings: CableCrossings) -> list[str]:
    """Return one word per stitch, and a word before loops that cross; with the yarn if the row has several yarns."""
    coloured = len(set(fabric.yarn[list(row.faces)].tolist())) > 1
    words = []
    for face, word in _worked(fabric, row, crossings):
        letter = f"{colour_letter(int(fabric.yarn[face]))}: " if coloured else ""
        words.append(letter + word)
    return words


def _worked(fabric: StitchMesh, row: PieceRow, crossings: CableCrossings) -> Iterator[tuple[int, str]]:
    """Each face of a row with its word, in working order; a cable of plain knit stitches is one word."""
    crossed: list[CableGroup] = []
    inside = 0
    for face in row.faces[::-1] if row.right_side else row.faces:
        places = places_below(fabric, face)[:: -1 if row.right_side else 1]
        for place in places:
            group = crossings.group_at.get(place)
            if group is None or any(group is other for other in crossed):
                continue
            crossed.append(group)
            short = _short_cable(fabric, group, row.right_side, crossings)
            inside = len(group.sides) if short else 0
            yield face, short or cable_word(group, row.right_side)
        if inside:
            inside -= 1
            continue
        worked = stitches_of_face(fabric, face, crossings)
        for stitch in worked[::-1] if row.right_side else worked:
            yield face, stitch.word(row.right_side)


def places_below(fabric: StitchMesh, face: int) -> list[int]:
    """Return the top sides below the bottom sides of a face, from left to right, without borders."""
    across = fabric.twin[bottom_sides(fabric, (face,))]
    return [int(side) for side in across if side != BORDER]


def stitches_of_face(fabric: StitchMesh, face: int, crossings: CableCrossings) -> list[WrittenStitch]:
    """Return the stitches that a knitter works for a face, from left to right.

    A face of loops that are cast on or drawn through is one stitch for each loop. A yarn-over at a side of an increase
    lies outside the loop below, and is a stitch by itself.
    """
    stitch, yarn = fabric.stitch_type(int(fabric.stitch[face])), int(fabric.yarn[face])
    if stitch == Stitch.CAST_ON:
        return [WrittenStitch(stitch, yarn=yarn)] * int(fabric.n_top[face])
    across = fabric.twin[bottom_sides(fabric, (face,))].tolist()
    twists = tuple(
        0 if side == BORDER else twist_worked(fabric, crossings.loop_at.get(side, side)) for side in across
    )
    if stitch == Stitch.DRAW_THROUGH:
        return [WrittenStitch(stitch, (twist,), yarn) for twist in twists]
    left, inner, right = without_yarn_overs(stitch)
    own = [] if inner is None else [WrittenStitch(inner, twists, yarn)]
    made = fabric.twist[top_sides(fabric, (face,))].tolist()
    over = [WrittenStitch(Stitch.YARN_OVER, yarn=yarn, made=turn) for turn in made]
    return [*over[:left], *own, *over[len(over) - right :]]


def twist_worked(fabric: StitchMesh, side: int) -> int:
    """Return the half turn of the loop at a top side for the stitch that works it.

    It is 0 for a yarn-over that is a stitch by itself: the word of that stitch says how the loop is twisted.
    """
    face = int(fabric.side_face[side])
    left, _, right = without_yarn_overs(fabric.stitch_type(int(fabric.stitch[face])))
    place = int(fabric.left_wale[face]) - 1 - side
    return int(fabric.twist[side]) if left <= place < fabric.n_top[face] - right else 0


def _short_cable(fabric: StitchMesh, group: CableGroup, right_side: bool, crossings: CableCrossings) -> str:
    """Return ``c4f`` or ``c4b`` for two equal bundles that are knit with one yarn, else an empty string."""
    words = cable_word(group, right_side).split()
    first, _, second = words[1].partition("/")
    faces = [int(fabric.side_face[side]) for side in fabric.twin[group.sides] if side != BORDER]
    if first != second or len(faces) != len(group.sides) or len(set(fabric.yarn[faces].tolist())) > 1:
        return ""
    plain = all(stitch_word(fabric.stitch_type(int(fabric.stitch[face])), right_side) == "k" for face in faces)
    turned = any(fabric.twist[side] for side in group.sides)
    return f"c{len(group.sides)}{words[2][0]}" if plain and not turned else ""
