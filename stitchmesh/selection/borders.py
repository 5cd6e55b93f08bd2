# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The borders of a garment: their names, which follow from their places, and bands of faces along them.

The y axis points up, and the wearer looks along +z, so that +x is the wearer's left. The names do not depend on the
width of the stitches:

- A *tip* is a ring shorter than ``TIP_LENGTH`` in which the rows converge, or a ring shorter than ``CLOSED_LENGTH``: a
  crown, a toe, a fingertip.
- A border away from the middle plane is a *cuff* if it runs along rows only, and an *armhole* if rows end at it.
- Of the borders at the middle plane, the lowest one in the lower half of the garment is the *hem*, and the highest one
  in the upper half is the *neck*. A border that is higher than half the garment, such as that of a flat piece, has no
  name.
- A garment can have one border and tips. The border is then the hem if it is the lower border of a garment with one tip
  (a hat), and a cuff otherwise (a sock, a mitten, a glove).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.mesh import LEFT, RIGHT, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.polygon_mesh import ranges

TIP_LENGTH = 15.0
"""A shorter border can be a tip [cm]; the hand of a small child does not go through it."""
CLOSED_LENGTH = 3.0
"""A shorter ring is a tip, even if the rows run straight up to it [cm]; no finger goes through it."""
TALLEST = 0.5
"""Largest height of a hem or a neck, divided by the height of the garment."""


@dataclass(frozen=True, eq=False)
class Border:
    """One border of a fabric."""

    number: int
    """Number of the border, in the order of ``Mesh.boundary_loops``."""
    name: str
    """Name in selections: ``hem``, ``left cuff`` ..., or ``border N`` for a border without a name."""
    sides: IntArray
    """Sides of the border in their order, shape (n,)."""
    length: float
    """Length [cm]."""
    centre: FloatArray
    """Centre of the border line [cm], shape (3,)."""
    along_rows: bool
    """Whether the border is a first or a last row: all sides are course sides, except for the step of a spiral."""


def borders(fabric: StitchMesh) -> list[Border]:
    """Return the borders of a fabric, with the names that selections use.

    Args:
        fabric: a stitch mesh; the y axis points up and the wearer looks along +z.
    """
    found = [_measured(fabric, number, sides) for number, sides in enumerate(fabric.boundary_loops)]
    if not found:
        return []
    low, high = fabric.vertices.min(axis=0), fabric.vertices.max(axis=0)
    tips = {border.number for border in found if _is_tip(fabric, border)}
    names = dict.fromkeys(tips, "tip")
    wide = [border for border in found if border.number not in tips]
    if len(wide) == 1 and tips:
        is_hem = len(tips) == 1 and wide[0].centre[1] < (low[1] + high[1]) / 2
        names[wide[0].number] = "hem" if is_hem else "cuff"
    else:
        names |= _names_by_place(fabric, wide, low, high)
    return [replace(border, name=names.get(border.number, border.name)) for border in found]


def band_distance(fabric: StitchMesh, sides: IntArray, farthest: int | None = None) -> IntArray:
    """Return the distance of each face from the nearest of some borders, shape (F,); 1 for a face that touches it.

    Faces that share a vertex are one apart. The vertices lie on the course lines between the rows, so that along a
    first or last row the distance counts rows. Where rows end at the border, the distance counts stitches.

    Args:
        fabric: stitch mesh.
        sides: sides of the borders, shape (n,).
        farthest: largest distance that is computed; farther faces and unreachable faces have the distance 0.
    """
    start, order = _corners_by_vertex(fabric)
    distance = np.zeros(fabric.face_count, dtype=np.int64)
    seen = np.zeros(len(fabric.vertices), dtype=bool)
    front = np.unique(fabric.face_vertex[sides])
    level = 0
    while len(front) and level != farthest:
        level += 1
        seen[front] = True
        faces = fabric.side_face[order[ranges(start, front)]]
        faces = np.unique(faces[distance[faces] == 0])
        distance[faces] = level
        corners = fabric.face_vertex[fabric.sides_of(faces)]
        front = np.unique(corners[~seen[corners]])
    return distance


def _corners_by_vertex(fabric: StitchMesh) -> tuple[IntArray, IntArray]:
    """Return the index of the first corner of each vertex, and the corners sorted by their vertices (CSR)."""
    from scipy.sparse import coo_array

    corners = np.arange(fabric.side_count)
    shape = len(fabric.vertices), fabric.side_count
    sorted_corners = coo_array((np.ones(len(corners), dtype=bool), (fabric.face_vertex, corners)), shape=shape).tocsr()
    return sorted_corners.indptr, sorted_corners.indices


def _measured(fabric: StitchMesh, number: int, sides: IntArray) -> Border:
    start = fabric.vertices[fabric.face_vertex[sides]]
    end = np.roll(start, -1, axis=0)  # A border side ends where the next one starts.
    length = np.linalg.norm(end - start, axis=1)
    role = fabric.role_of(sides)
    # Number of wale sides at the border of a spiral, where its first or its last turn begins
    return Border(
        number=number,
        name=f"border {number}",
        sides=sides,
        length=float(length.sum()),
        centre=np.average((start + end) / 2, axis=0, weights=length),
        along_rows=bool(np.isin(role, (LEFT, RIGHT)).sum() <= 1),
    )


def _is_tip(fabric: StitchMesh, border: Border) -> bool:
    if border.length >= TIP_LENGTH or not border.along_rows:
        return False
    if border.length < CLOSED_LENGTH:
        return True
    faces = fabric.side_face[border.sides]
    left, right = fabric.left_wale[faces], fabric.right_wale[faces]
    start, end = fabric.face_start[:-1][faces], right + 1  # Corners at the lower left and at the upper right.
    position = fabric.vertices[fabric.face_vertex[np.stack([left, end, start, right])]]
    wales = position[0] + position[1] - position[2] - position[3]
    # Largest alignment of the wales at a tip: length of the sum of their vectors, divided by the sum of their lengths.
    return bool(np.linalg.norm(wales.sum(axis=0)) <= 0.8 * np.linalg.norm(wales, axis=1).sum())


def _names_by_place(fabric: StitchMesh, wide: list[Border], low: FloatArray, high: FloatArray) -> dict[int, str]:
    """Return the names of the borders that are not tips, by number; a border without a name is left out."""
    middle, half = (low + high) / 2, (high - low) / 2
    names: dict[int, str] = {}
    centred = []
    for border in wide:
        across = border.centre[0] - middle[0]
        # A border lies on one side if its distance from the middle plane is larger, as a share of half the width of the
        # garment
        if abs(across) > 0.2 * half[0]:
            names[border.number] = ("left " if across > 0 else "right ") + ("cuff" if border.along_rows else "armhole")
        elif np.ptp(fabric.vertices[fabric.face_vertex[border.sides], 1]) <= TALLEST * 2 * half[1]:
            centred.append(border)
    below = sorted((border.centre[1], border.number) for border in centred if border.centre[1] < middle[1])
    above = sorted((-border.centre[1], border.number) for border in centred if border.centre[1] >= middle[1])
    if below:
        names[below[0][1]] = "hem"
    if above:
        names[above[0][1]] = "neck"
    return names


def named_borders(found: list[Border], name: str, hand: str | None) -> list[Border]:
    """Return the borders that a word of selections, such as ``cuffs``, names.

    Args:
        found: the borders of a fabric.
        name: ``hem``, ``cuffs``, ``neck``, ``armholes`` or ``tips``.
        hand: ``left`` or ``right``; None for all.
    """
    one = name.removesuffix("s")
    wanted = one if hand is None else f"{hand} {one}"
    return [border for border in found if border.name == wanted or (hand is None and border.name.endswith(f" {one}"))]
