# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The yarns of a stitch mesh on its cloth: each stitch becomes a loop.

If a loop of the row below comes through a bottom side of a stitch, this side is two stitch contacts with four nodes, as
``knit`` describes: P lies in the stitch below the side and Q in the stitch above it. Along the yarn of a row, a stitch
passes the contacts at its left foot, then the contacts of the loops on its top sides from left to right, and then the
contacts at its right foot. A decrease passes the left sides of all loops through which it is drawn, and then their
right sides. A slipped loop has its contact with the row that works it, at the side where that row begins. A yarn-over
and a cast-on stitch have no feet. Loops that a cable moves are taken at their place in the mesh before the cable.

A course that is a ring continues in the ring above its first stitch, so that a tube is knitted in one spiral; this
changes nothing but the ends of the rings. Every other course is a yarn of its own.

Rest lengths belong to the loops of ``knit`` with the width and the height of the stitches, not to the mesh in space.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.mesh import BORDER, BOTTOM, TOP, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.courses import Course, course_of_faces, courses_below, find_courses, knitting_order, sides_across
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.from_stitches import stitch_triangles, triangle_start
from stitchmesh.mixed.layout.crossing_yarns import WEFT, CrossingYarns, LaidNodes, Passages, assembled
from stitchmesh.mixed.layout.embedding import embed_among
from stitchmesh.mixed.layout.knit import NODES, P, Q, contacts_of_links
from stitchmesh.mixed.layout.stitch_division import DividedStitches, divide_stitches, places_from_left

DRAWN = {Stitch.BIND_OFF: "k", Stitch.DRAW_THROUGH: "k"}
"""Kind of the stitches of faces with any number of sides whose yarn runs through the loops below."""


@dataclass(frozen=True, eq=False)
class _Links:
    """Bottom sides through which a loop is drawn."""

    side: IntArray
    """The bottom side, shape (n,)."""
    below: IntArray
    """The top side of the face below that lies on the same edge, shape (n,)."""
    maker: IntArray
    """The top side on which the loop was made, below any slipped stitches, shape (n,)."""
    slipped: IntArray
    """Number of rows over which the loop was slipped, shape (n,)."""
    is_knit: np.ndarray
    """Whether the stitch is knitted, not purled, shape (n,)."""


def lay_stitches(
    cloth: Cloth, fabric: StitchMesh, *, stitch_width: float, course_height: float, divisions: int = 1
) -> CrossingYarns:
    """Lay the yarns of a stitch mesh out on its cloth.

    Args:
        cloth: the cloth that ``cloth_from_stitches`` made of the fabric.
        fabric: the stitch mesh.
        stitch_width: wale spacing with which the cloth was made [cm].
        course_height: course spacing with which the cloth was made [cm].
        divisions: number k of loops along each side of a stitch; each stitch then stands for k x k smaller ones.

    Raises:
        ParameterError: the cloth does not belong to the fabric, no loop is drawn through another one, or a stitch
            cannot be divided (``divide_stitches``).
    """
    check_kind("lay_stitches", cloth, Cloth, "cloth_from_stitches(fabric)")
    check_kind("lay_stitches: fabric", fabric, StitchMesh)
    corners = stitch_triangles(fabric)
    if not np.array_equal(fabric.face_vertex[corners], cloth.triangles):
        raise ParameterError("lay_stitches: the triangles are not those of the fabric; make its cloth from the fabric")
    divided = divide_stitches(fabric, divisions)
    size = np.array([stitch_width, course_height]) / divisions
    links = _links(divided.fabric)
    nodes = _nodes(cloth, fabric, corners, divided, links)
    passages, yarn_count = _passages(divided.fabric, links, size)
    return assembled("knit", nodes, passages, np.full(yarn_count, WEFT), contacts_of_links(nodes.count))


def _links(fabric: StitchMesh) -> _Links:
    """All bottom sides whose stitch draws its yarn through a loop of a stitch below."""
    kind = dict(DRAWN)
    for stitch, making in VOCABULARY.items():
        drawn = [one for one in making.made if one in "kp"]
        if drawn and making.order:
            kind[stitch] = drawn[0]
    sides = np.flatnonzero(fabric.side_role == BOTTOM)
    below = sides_across(fabric, sides, TOP)
    draws = np.isin(fabric.stitch[fabric.side_face[sides]], list(kind))
    sides, below = sides[draws & (below != BORDER)], below[draws & (below != BORDER)]
    knits = [stitch for stitch, made in kind.items() if made == "k"]
    maker, slipped = _makers(fabric, below)
    kept = maker != BORDER
    is_knit = np.isin(fabric.stitch[fabric.side_face[sides]], knits)
    return _Links(sides[kept], below[kept], maker[kept], slipped[kept], is_knit[kept])


def _makers(fabric: StitchMesh, sides: IntArray) -> tuple[IntArray, IntArray]:
    """Top side on which each loop was made, ``BORDER`` if it is outside; number of rows over which it was slipped."""
    slipped_from = np.full(fabric.side_count, BORDER)
    for stitch, making in VOCABULARY.items():
        for loop, made in enumerate(making.made):
            if made == "s":
                first = fabric.face_start[:-1][fabric.stitch == stitch]
                slipped_from[first + making.n_bottom + making.n_top - loop] = first
    maker, rows = sides.copy(), np.zeros(len(sides), dtype=np.int64)
    for _ in range(fabric.face_count):  # a loop that is slipped in all rows of a torus has no maker
        moved = np.flatnonzero((maker != BORDER) & (slipped_from[maker] != BORDER))
        if not len(moved):
            return maker, rows
        maker[moved] = sides_across(fabric, slipped_from[maker[moved]], TOP)
        rows[moved] += 1
    maker[moved] = BORDER
    return maker, rows


def _nodes(cloth: Cloth, fabric: StitchMesh, corners: IntArray, divided: DividedStitches, links: _Links) -> LaidNodes:
    """The four nodes of each link, on the triangles of the face in which they lie."""
    side = np.repeat(links.side, 4)
    is_upper = np.tile(NODES[:, 1] > 0, len(links.side))
    along = np.tile(NODES[:, 0], len(links.side)) + 0.5
    own = np.where(is_upper, side, np.repeat(links.below, 4))
    height = np.where(is_upper, Q[1], 1.0 + P[1])
    place = _place_in_parent(divided, own, np.where(is_upper, along, 1.0 - along), height)
    parent = divided.parent[divided.fabric.side_face[own]]
    rest = np.empty((fabric.side_count, 2))
    rest[corners] = cloth.rest
    position = _within_face(fabric, rest, parent, place)  # flat, at rest
    start = triangle_start(fabric)
    found = embed_among(cloth, position, start[parent], start[parent + 1])
    sign = np.where(links.is_knit, 1, -1)[:, None] * np.array([-1, 1, 1, -1])
    panel = cloth.panel[found.triangle]
    return LaidNodes(panel, position, found.triangle, found.barycentric, sign.ravel(), np.zeros((len(side), 2)))


def _place_in_parent(divided: DividedStitches, side: IntArray, along: FloatArray, height: FloatArray) -> FloatArray:
    """Where points of the divided faces lie in the undivided faces.

    Args:
        divided: the divided stitches.
        side: course side of the face of each point, shape (n,).
        along: part of the way along the side, in its direction, shape (n,).
        height: part of the way from the bottom to the top of the face, shape (n,).
    """
    fabric = divided.fabric
    own = np.stack([places_from_left(fabric, side, along), height], axis=1)
    return _within_face(fabric, divided.corner_place, fabric.side_face[side], own)


def _within_face(fabric: StitchMesh, corners: FloatArray, face: IntArray, place: FloatArray) -> FloatArray:
    """Values at places in faces from values at all corners, shape (n, 2); both chains of a face are evenly divided."""
    first, bottom = fabric.face_start[face], fabric.n_bottom[face]
    low_left, low_right, high_right = corners[first], corners[first + bottom], corners[first + bottom + 1]
    high_left = corners[fabric.face_start[face + 1] - 1]
    x, y = place[:, :1], place[:, 1:]
    low, high = low_left + x * (low_right - low_left), high_left + x * (high_right - high_left)
    position: FloatArray = low + y * (high - low)
    return position


def _passages(fabric: StitchMesh, links: _Links, size: FloatArray) -> tuple[Passages, int]:
    """Each node as u along the yarn of the stitch above its side, and as v along the yarn that made the loop.

    Returns:
        The passages, and the number of yarns.
    """
    yarn, rank, origin, yarn_count = _yarns(fabric, size)
    face, maker_face = fabric.side_face[links.side], fabric.side_face[links.maker]
    bottom, top = fabric.n_bottom[face], fabric.n_top[face]
    from_left = fabric.side_place[links.side]
    maker_bottom, maker_top = fabric.n_bottom[maker_face], fabric.n_top[maker_face]
    top_from_left = maker_bottom + maker_top - fabric.side_place[links.maker]
    left = 2 * from_left
    right = 2 * bottom + 4 * top + 2 * from_left
    as_new = np.stack([left, left + 1, right, right + 1], axis=1)
    as_old = (2 * maker_bottom + 4 * top_from_left)[:, None] + np.arange(4)
    width = int(2 * (fabric.n_bottom + 2 * fabric.n_top).max() + 2 * fabric.n_bottom.max() + 2)
    node = np.arange(4 * len(face))
    x_new: FloatArray = from_left + 0.5 - bottom / 2
    x_old: FloatArray = top_from_left + 0.5 - maker_top / 2
    level: FloatArray = np.float64(1.0) + links.slipped
    new_place = _frame(origin[face], x_new, np.zeros_like(x_new), size)
    old_place = _frame(origin[maker_face], x_old, level, size)
    passages = Passages(
        np.repeat(np.concatenate([yarn[face], yarn[maker_face]]), 4),
        np.concatenate([rank[face][:, None] * width + as_new, rank[maker_face][:, None] * width + as_old]).ravel()
        * 1.0,
        np.tile(node, 2),
        np.repeat([0, 1], len(node)),
        np.concatenate([new_place, old_place]),
    )
    return passages, yarn_count


def _frame(origin: FloatArray, x: FloatArray, level: FloatArray, size: FloatArray) -> FloatArray:
    """Places of the four nodes of each link in the frame of a yarn [cm], shape (4 n, 2).

    Args:
        origin: place of the middle of the bottom of the face of each link [cm], shape (n, 2).
        x: middle of the side in stitch widths from the middle of the face, shape (n,).
        level: height of the side in course heights above the bottom of the face, shape (n,).
        size: stitch width and course height [cm].
    """
    middle = origin + np.stack([x, level], axis=1) * size
    return (middle[:, None] + NODES * size).reshape(-1, 2)


def _yarns(fabric: StitchMesh, size: FloatArray) -> tuple[IntArray, IntArray, FloatArray, int]:
    """Yarn of each face, rank along the yarn, place of the bottom in the frame of the yarn; and number of yarns."""
    yarn, rank = np.empty((2, fabric.face_count), dtype=np.int64)
    origin = np.empty((fabric.face_count, 2))
    width = size[0] * (fabric.n_bottom + fabric.n_top) / 2
    spirals = _spirals(fabric, find_courses(fabric))
    for number, courses in enumerate(spirals):
        faces = np.concatenate(courses)
        yarn[faces], rank[faces] = number, np.arange(len(faces))
        origin[faces, 0] = np.cumsum(width[faces]) - width[faces] / 2
        origin[faces, 1] = np.repeat(np.arange(len(courses)), [len(course) for course in courses]) * size[1]
    return yarn, rank, origin, len(spirals)


def _spirals(fabric: StitchMesh, courses: list[Course]) -> list[list[IntArray]]:
    """The courses of each yarn: the rings that continue in one another, from below, or one other course alone."""
    number = course_of_faces(fabric, courses)
    above = _face_above(fabric)
    order, cyclic = knitting_order(courses_below(fabric, courses))
    used = [False] * len(courses)
    spirals = []
    for index in [*order, *cyclic]:
        chain: list[IntArray] = []
        face = courses[index].faces[0]
        while face != BORDER and not used[number[face]] and (courses[number[face]].closed or not chain):
            course = courses[number[face]]
            used[number[face]] = True
            faces = np.array(course.faces)
            chain.append(np.roll(faces, -int(np.flatnonzero(faces == face)[0])) if course.closed else faces)
            face = int(above[face]) if course.closed else BORDER
        if chain:
            spirals.append(chain)
    return spirals


def _face_above(fabric: StitchMesh) -> IntArray:
    """Face above the left top side of each face, ``BORDER`` if there is none, shape (F,)."""
    has_top = fabric.n_top > 0
    sides = np.where(has_top, fabric.left_wale - 1, 0)
    above = sides_across(fabric, sides, BOTTOM)
    return np.where(has_top & (above != BORDER), fabric.side_face[above], BORDER)
