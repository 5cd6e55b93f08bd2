# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits that change only marks of faces and sides: stitches, twists of loops, yarns and cables.

In a cable, loops of one course line exchange places (Yuksel et al. 2012, sections 4.5 and 5.3).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stitchmesh.editing.fitting import check_fit
from stitchmesh.editing.sides import check_face, check_side
from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting.words import stitch_named
from stitchmesh.mesh import BORDER, BOTTOM, IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups, course_line
from stitchmesh.mesh.change import Change, Marks, PaletteChange
from stitchmesh.mesh.palette import (
    LONGEST_NUMBER,
    Palette,
    check_yarn_number,
    filled_palette,
    parse_colour,
    recolour_palette,
)
from stitchmesh.mesh.stitch import SIDE_COUNTS, Stitch

MOST_ROWS = 10_000
"""Largest number of rows of one stripe."""


def change_stitch(fabric: StitchMesh, faces: Sequence[int], stitch: str) -> list[Change]:
    """Replace the stitch of some faces by another stitch with as many loops below and above.

    Args:
        fabric: a mesh of stitches.
        faces: numbers of the faces.
        stitch: code of the stitch, ``cast-on`` or ``draw-through``.

    Raises:
        ParameterError: a face does not exist or has other numbers of sides, the stitch is unknown, or the stitch works
            loops at a border.
    """
    wanted, places = stitch_named(stitch), _faces(fabric, faces)
    for face in places.tolist():
        start, n_bottom = int(fabric.face_start[face]), int(fabric.n_bottom[face])
        free = int((fabric.twin[start : start + n_bottom] == BORDER).sum())
        check_fit(f"face {face}", wanted, n_bottom, int(fabric.n_top[face]), free)
    return [Marks("stitch", places, np.full(len(places), int(wanted)))]


def faces_for_stitch(fabric: StitchMesh, faces: IntArray, stitch: str) -> IntArray:
    """Return the faces that can take a stitch: the faces for which ``change_stitch`` raises no error.

    Args:
        fabric: a mesh of stitches.
        faces: numbers of faces, shape (n,).
        stitch: code of the stitch, ``cast-on`` or ``draw-through``.

    Raises:
        ParameterError: the stitch is unknown.
    """
    wanted = stitch_named(stitch)
    low, high = fabric.n_bottom[faces], fabric.n_top[faces]
    sides = fabric.sides_of(faces)
    at_border = (fabric.twin[sides] == BORDER) & (fabric.role_of(sides) == BOTTOM)
    owner = np.repeat(np.arange(len(faces)), np.diff(fabric.face_start)[faces])
    free = np.bincount(owner[at_border], minlength=len(faces))
    if wanted == Stitch.CAST_ON:
        return faces[(free == low) & (high > 0)]
    if wanted == Stitch.DRAW_THROUGH:
        return faces[(high == 0) & (low > 0) & (free == 0)]
    n_bottom, n_top = SIDE_COUNTS[wanted]
    return faces[(low == n_bottom) & (high == n_top) & (free == 0)]


def twist_loop(fabric: StitchMesh, side: int, twist: int) -> list[Change]:
    """Set the half turn of the loop at a top side.

    Args:
        fabric: a mesh of stitches.
        side: the top side of the loop.
        twist: 1 if the leg that comes from the left lies in front, -1 if it lies behind, 0 for no twist.

    Raises:
        ParameterError: the side is not a top side, or the twist is not -1, 0 or 1.
    """
    check_side(fabric, side, "top")
    if twist not in (-1, 0, 1):
        raise ParameterError(f"{fabric.side_name(side)}: twist {twist}; expected -1, 0 or 1")
    return [Marks("twist", np.array([side]), np.array([twist]))]


def stripe(
    fabric: StitchMesh, yarn: int, rows: Sequence[int] | None = None, faces: Sequence[int] | None = None
) -> list[Change]:
    """Change the yarn of rows or faces.

    Args:
        fabric: a mesh of stitches.
        yarn: number of the yarn, from 0.
        rows: numbers of whole rows.
        faces: numbers of single faces.

    Raises:
        ParameterError: a row or a face does not exist, neither is given, or the number of the yarn is negative.
    """
    if yarn < 0:
        raise ParameterError(f"yarn: got {yarn}; yarns are numbered from 0")
    numbers = np.unique(np.asarray(rows or [], dtype=np.int64))
    missing = numbers[~np.isin(numbers, fabric.row)]
    if len(missing):
        raise ParameterError(f"row {missing[0]}: does not exist; the mesh has rows 0 to {fabric.row.max()}")
    places = np.flatnonzero(np.isin(fabric.row, numbers))
    if faces or not rows:
        places = np.union1d(places, _faces(fabric, faces or []))
    return [Marks("yarn", places, np.full(len(places), yarn))]


def stripes(fabric: StitchMesh, bands: str, faces: Sequence[int] | None = None) -> list[Change]:
    """Knit rows in stripes that repeat from the lowest row upwards.

    Args:
        fabric: a mesh of stitches.
        bands: rows and colour of each stripe from the bottom up, such as ``4 cream, 2 navy``. A colour is a name,
            ``#rrggbb``, or the number of a yarn; a colour that the fabric does not have is added to its palette.
        faces: numbers of the faces that get stripes; by default the whole fabric.

    Raises:
        ParameterError: a face does not exist, none is given, or a band has no rows or no colour.
    """
    places = np.arange(fabric.face_count) if faces is None else _faces(fabric, faces)
    palette = filled_palette(fabric.palette, int(fabric.yarn.max()) + 1)
    yarn_of_row, wanted = _parse_bands(bands, palette)
    level = fabric.row[places] - fabric.row[places].min()
    added: list[Change] = [PaletteChange(wanted)] if len(wanted) > len(palette) else []
    return [*added, Marks("yarn", places, yarn_of_row[level % len(yarn_of_row)])]


def _parse_bands(bands: str, palette: Palette) -> tuple[IntArray, Palette]:
    """Return the number of the yarn of each row of one repeat, shape (rows,), and the palette with all colours."""
    colours = [tuple(colour) for colour in palette.tolist()]
    rows: list[int] = []
    for band in bands.split(","):
        count, _, colour = band.strip().partition(" ")
        if not (count.isdecimal() and 1 <= int(count[:LONGEST_NUMBER]) <= MOST_ROWS and colour.strip()):
            expected = f"1 to {MOST_ROWS} rows and a colour, such as '4 cream, 2 navy'"
            raise ParameterError(f"stripes: got {band.strip()[:40]!r}; expected {expected}")
        if colour.strip().isdecimal():
            number = check_yarn_number(int(colour[:LONGEST_NUMBER]))
        else:
            wanted = tuple(parse_colour(colour).tolist())
            colours += [] if wanted in colours else [wanted]
            number = check_yarn_number(colours.index(wanted))
        rows += [number] * int(count)
    return np.array(rows), np.array(colours, dtype=np.uint8).reshape(-1, 3)


def _faces(fabric: StitchMesh, faces: Sequence[int]) -> IntArray:
    """Check some faces; return each face once, in ascending order."""
    if not faces:
        raise ParameterError("faces: got none; expected at least one")
    for face in faces:
        check_face(fabric, face)
    return np.unique(np.asarray(faces, dtype=np.int64))


def recolour(fabric: StitchMesh, yarn: int, colour: str) -> list[Change]:
    """Give one yarn number another colour; lower numbers that have no colour yet keep their stock colours.

    Args:
        fabric: any stitch mesh.
        yarn: number of the yarn.
        colour: ``#rrggbb``, or a name such as ``navy`` (``parse_colour``).

    Raises:
        ParameterError: the number is negative or above ``LAST_YARN``, or the text is no colour.
    """
    return [PaletteChange(recolour_palette(fabric.palette, {check_yarn_number(yarn): parse_colour(colour)}))]


def cross_cable(fabric: StitchMesh, side: int, left: int, right: int, front: str) -> list[Change]:
    """Cross adjacent loops: a group on the left with a group on its right.

    The cable ``c4f`` (the cable needle is held in front) crosses 2 loops with 2 loops, the right ones in front. In
    ``c4b`` the left ones lie in front.

    Args:
        fabric: a mesh of stitches.
        side: top side of the leftmost loop.
        left: number of loops that move to the right.
        right: number of loops that move to the left.
        front: ``"left"`` or ``"right"``: which of the two groups lies in front.

    Raises:
        ParameterError: the side is not a top side, the row is too short, a loop is part of another cable, or a group
            has no loops.
    """
    if left < 1 or right < 1:
        raise ParameterError(f"cable: got {left} loops on the left and {right} on the right; expected at least 1 each")
    if front not in ("left", "right"):
        raise ParameterError(f"front: got {front!r}; expected left or right")
    destinations = [*range(right, left + right), *range(right)]
    in_front = front == "left"
    return set_cable(fabric, side, destinations, [int(in_front)] * left + [int(not in_front)] * right)


def set_cable(fabric: StitchMesh, side: int, destinations: Sequence[int], layers: Sequence[int]) -> list[Change]:
    """Permute adjacent loops.

    Args:
        fabric: a mesh of stitches.
        side: top side of the leftmost loop.
        destinations: the place to which each loop moves, counted from the left: a permutation of 0 to n - 1.
        layers: the layer of each loop; of two loops that cross, the loop with the higher layer lies in front.

    Raises:
        ParameterError: the side is not a top side, the row is too short, a loop is part of another cable, the
            destinations are not a permutation, or the number of layers is wrong.
        LabelError: loops that cross have the same layer, or the row above runs in the opposite direction.
    """
    count = len(destinations)
    if sorted(destinations) != list(range(count)) or count < 2:
        raise ParameterError(f"destinations: got {list(destinations)}; expected the places 0 to {count - 1} once each")
    if len(layers) != count:
        raise ParameterError(f"layers: got {len(layers)} for {count} loops; expected one each")
    sides = _loops(fabric, side, count)
    shift = np.asarray(destinations, dtype=np.int64) - np.arange(count)
    return _marks(sides, shift, np.asarray(layers, dtype=np.int64))


def clear_cable(fabric: StitchMesh, side: int) -> list[Change]:
    """Remove a cable; its loops stay in their places.

    Args:
        fabric: a mesh of stitches.
        side: top side of any loop of the cable.

    Raises:
        ParameterError: the side is not a top side, or its loop is not part of a cable.
    """
    check_side(fabric, side, "top")
    sides = next((group.sides for group in cable_groups(fabric, np.array([side])) if side in group.sides), None)
    if sides is None:
        raise ParameterError(f"{fabric.side_name(side)}: its loop is not part of a cable")
    zero = np.zeros(len(sides), dtype=np.int64)
    return _marks(sides, zero, zero)


def _loops(fabric: StitchMesh, side: int, count: int) -> IntArray:
    """Return ``count`` top sides from a side to the right; none of their loops may be part of a cable."""
    check_side(fabric, side, "top")
    line, is_ring = course_line(fabric, side)
    first = int(np.flatnonzero(line == side)[0])
    available = len(line) - first
    if available < count or (is_ring and available == count):
        where = "around the row" if is_ring else "to the right end of its row"
        raise ParameterError(
            f"{fabric.side_name(side)}: a cable of {count} loops does not fit; there are {available} {where}"
        )
    sides = line[first : first + count]
    for group in cable_groups(fabric, np.array([side])):
        taken = np.intersect1d(sides, group.sides)
        if len(taken):
            raise ParameterError(f"{fabric.side_name(taken[0])}: its loop is part of another cable; clear it first")
    return sides


def _marks(sides: IntArray, shift: IntArray, layer: IntArray) -> list[Change]:
    return [Marks("cable_layer", sides, layer), Marks("cable_shift", sides, shift)]
