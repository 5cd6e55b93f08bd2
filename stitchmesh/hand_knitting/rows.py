# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The words of one row, in the order in which its stitches are worked."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from stitchmesh.hand_knitting.pieces import PieceRow
from stitchmesh.hand_knitting.words import cable_word, colour_letter, stitch_word, word_with_twists
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.cable_groups import CableGroup, cable_groups
from stitchmesh.mesh.courses import bottom_sides
from stitchmesh.mesh.stitch import Stitch


@dataclass(frozen=True)
class Crossings:
    """The cables of a fabric, indexed by the top sides of their loops."""

    group_at: dict[int, CableGroup]
    """Cable group of each top side that belongs to a group."""
    loop_at: dict[int, int]
    """For each top side of a group, the top side from which its loop comes when the group is crossed."""

    @classmethod
    def of(cls, fabric: StitchMesh) -> Crossings:
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


def row_words(fabric: StitchMesh, row: PieceRow, crossings: Crossings) -> list[str]:
    """Return one word per stitch, and one before loops that cross; with the yarn if the row has several yarns."""
    coloured = len(set(fabric.yarn[list(row.faces)].tolist())) > 1
    words = []
    for face, word in _worked(fabric, row, crossings):
        letter = f"{colour_letter(int(fabric.yarn[face]))}: " if coloured else ""
        words.append(letter + word)
    return words


def _worked(fabric: StitchMesh, row: PieceRow, crossings: Crossings) -> Iterator[tuple[int, str]]:
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
        stitch = fabric.stitch_type(int(fabric.stitch[face]))
        twists = twists_below(fabric, face, crossings)[:: -1 if row.right_side else 1]
        word = stitch_word(stitch, row.right_side)
        if stitch == Stitch.DRAW_THROUGH:
            yield from [(face, word_with_twists(word, [twist])) for twist in twists]
            continue
        for _ in range(times_written(fabric, face)):
            yield face, word_with_twists(word, twists)


def places_below(fabric: StitchMesh, face: int) -> list[int]:
    """Return the top sides below the bottom sides of a face, from left to right, without borders."""
    across = fabric.twin[bottom_sides(fabric, (face,))]
    return [int(side) for side in across if side != BORDER]


def twists_below(fabric: StitchMesh, face: int, crossings: Crossings) -> list[int]:
    """Return the half turn of each loop that a face is worked through, from left to right; 0 for a loop cast on."""
    if fabric.stitch[face] == Stitch.CAST_ON:
        return []
    across = fabric.twin[bottom_sides(fabric, (face,))].tolist()
    return [0 if side == BORDER else int(fabric.twist[crossings.loop_at.get(side, side)]) for side in across]


def times_written(fabric: StitchMesh, face: int) -> int:
    """Number of times that the word of a face is written: once per loop for cast-on, else once."""
    return int(fabric.n_top[face]) if fabric.stitch[face] == Stitch.CAST_ON else 1


def _short_cable(fabric: StitchMesh, group: CableGroup, right_side: bool, crossings: Crossings) -> str:
    """Return ``c4f`` or ``c4b`` for two equal bundles that are knit with one yarn, else an empty string."""
    words = cable_word(group, right_side).split()
    first, _, second = words[1].partition("/")
    faces = [int(fabric.side_face[side]) for side in fabric.twin[group.sides] if side != BORDER]
    if first != second or len(faces) != len(group.sides) or len(set(fabric.yarn[faces].tolist())) > 1:
        return ""
    plain = all(stitch_word(fabric.stitch_type(int(fabric.stitch[face])), right_side) == "k" for face in faces)
    turned = any(fabric.twist[side] for side in group.sides)
    return f"c{len(group.sides)}{words[2][0]}" if plain and not turned else ""
