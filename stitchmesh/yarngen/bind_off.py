# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The bind-off row, and the templates of first and last rows.

A face above every top side on the border holds the last loops. Like the cable faces of Yuksel et al. 2012, the bind-off
row exists only while yarn is generated (section 4.3). The selected cast-on and bind-off decide which template each face
of a first or last row has.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import YarnError
from stitchmesh.mesh import BORDER, RIGHT, TOP, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.arrays import runs_of
from stitchmesh.mesh.border_lean import border_lean, vertex_step
from stitchmesh.mesh.courses import course_through, find_courses
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarngen.bridges import Bridges, crossing_number
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarngen.templates.edge_templates import CHAIN_HEIGHT, Edge

DRAWN_HEIGHT = 0.8
"""Height of a bind-off face with a drawn-through yarn, over the mean height of the stitches below it."""
SMALL_RING_LOOPS = 16
"""Largest number of loops of a small border ring. Such a ring is too short for a chain bind-off; knitters break the
yarn and draw it through these loops."""
DRAWN_OUT = 2.0
"""A yarn is drawn through a row with no more loops than a small ring if a stitch of a chain would be more than this
many times as wide as the stitch below. In a notch, the loops of a chain would be drawn out so far that they miss one
another."""


def with_bind_off(fabric: StitchMesh, height: float = DRAWN_HEIGHT) -> StitchMesh:
    """The stitch mesh with one more row above each border that has top sides.

    The given faces keep their numbers; the new faces follow them.

    Args:
        fabric: stitch faces.
        height: height of the new faces, over the mean height of the stitches below; faces above ``drawn_sides`` always
            have ``DRAWN_HEIGHT``.
    """
    sides = np.flatnonzero((fabric.side_role == TOP) & (fabric.twin == BORDER))
    if len(sides) == 0:
        return fabric
    border_vertices, ends = _ends(fabric, sides)
    right, left = border_vertices[ends]
    drawn, _ = _ends(fabric, drawn_sides(fabric))
    shares = np.where(np.isin(border_vertices, drawn), DRAWN_HEIGHT, height)
    raised = len(fabric.vertices) + ends
    quads = np.stack([left, right, raised[0], raised[1]], axis=1)
    first = fabric.side_count + 4 * np.arange(len(sides))
    twin = np.concatenate([fabric.twin, np.full(4 * len(sides), BORDER)])
    twin[sides], twin[first] = first, sides
    _join_neighbours(twin, first, left, right)
    count = len(sides)
    plain = np.zeros(4 * count, dtype=np.int64)
    whole = StitchMesh(
        vertices=np.concatenate([fabric.vertices, _raised_vertices(fabric, border_vertices, ends, shares)]),
        face_start=np.concatenate([fabric.face_start, fabric.face_start[-1] + 4 * np.arange(1, count + 1)]),
        face_vertex=np.concatenate([fabric.face_vertex, quads.ravel()]),
        twin=twin,
        n_bottom=np.concatenate([fabric.n_bottom, np.ones(count, dtype=np.int64)]),
        n_top=np.concatenate([fabric.n_top, np.ones(count, dtype=np.int64)]),
        stitch=np.concatenate([fabric.stitch, np.full(count, Stitch.BIND_OFF)]),
        row=np.concatenate([fabric.row, fabric.row.max() + 1 + fabric.row[fabric.side_face[sides]]]),
        yarn=np.concatenate([fabric.yarn, fabric.yarn[fabric.side_face[sides]]]),
        twist=np.concatenate([fabric.twist, plain]),
        cable_shift=np.concatenate([fabric.cable_shift, plain]),
        cable_layer=np.concatenate([fabric.cable_layer, plain]),
        palette=fabric.palette,
        own_stitches=fabric.own_stitches,
    )
    return whole if (fabric.yarn == fabric.yarn[0]).all() else _with_one_yarn_per_bind_off(whole, fabric.face_count)


def _with_one_yarn_per_bind_off(whole: StitchMesh, first: int) -> StitchMesh:
    """The mesh with one yarn in each bind-off row: the most frequent yarn of the stitches below it.

    If several yarns are equally frequent, the row takes the lowest number.

    Args:
        whole: the stitch mesh with its bind-off rows.
        first: number of the first bind-off face.
    """
    yarn = whole.yarn.copy()
    for course in find_courses(whole):
        faces = [face for face in course.faces if face >= first]
        if faces:
            yarn[faces] = np.bincount(yarn[faces]).argmax()
    return replace(whole, yarn=yarn)


def drawn_sides(fabric: StitchMesh) -> IntArray:
    """Return the top sides through whose loops a yarn is always drawn, because a chain has no room there.

    They belong to small rings, such as a crown or a fingertip, to touching borders, and to short rows in a notch.
    """
    found = [loop for loop in fabric.boundary_loops if len(loop) <= SMALL_RING_LOOPS and _is_top(fabric, loop).all()]
    found += [loop[_is_top(fabric, loop)] for loop in _touching_borders(fabric)]
    found += _rows_in_notches(fabric)
    return np.unique(np.concatenate(found)) if found else np.zeros(0, dtype=np.int64)


def _rows_in_notches(fabric: StitchMesh) -> list[IntArray]:
    """Return the top sides of each short row on which a stitch of a chain would be drawn out."""
    rows = [row for loop in fabric.boundary_loops for row in _short_rows(fabric, loop)]
    if not rows:
        return []
    sides = np.concatenate(rows)
    vertices, ends = _ends(fabric, sides)
    raised = _raised_vertices(fabric, vertices, ends, np.full(len(vertices), CHAIN_HEIGHT))
    wide = np.linalg.norm(raised[ends[1]] - raised[ends[0]], axis=1) > DRAWN_OUT * fabric.side_length[sides]
    return [row for row in rows if np.isin(row, sides[wide]).any()]


def _short_rows(fabric: StitchMesh, loop: IntArray) -> list[IntArray]:
    """Return the runs of neighbouring top sides of a border that are no longer than a small ring."""
    top = _is_top(fabric, loop)
    if top.all():
        return []
    loop = np.roll(loop, -int(np.flatnonzero(~top)[0]))
    runs = [loop[first:beyond] for first, beyond in runs_of(_is_top(fabric, loop))]
    return [run for run in runs if len(run) <= SMALL_RING_LOOPS]


def _ends(fabric: StitchMesh, sides: IntArray) -> tuple[IntArray, IntArray]:
    """Return the vertices of top sides, ascending, and the right and the left end of each as indices into them."""
    ends = np.stack([fabric.face_vertex[sides], fabric.face_vertex[fabric.side_next[sides]]])
    vertices, place = np.unique(ends, return_inverse=True)
    return vertices, place.reshape(2, -1)


def _is_top(fabric: StitchMesh, sides: IntArray) -> NDArray[np.bool_]:
    return np.asarray(fabric.side_role[sides] == TOP)


def _touching_borders(fabric: StitchMesh) -> list[IntArray]:
    """Return the sides of each border that has no room for a chain between itself and another border.

    The two borders touch, for example where a fabric was separated.
    """
    from scipy.spatial import cKDTree

    loops = fabric.boundary_loops
    if len(loops) < 2:
        return []
    number = np.repeat(np.arange(len(loops)), [len(loop) for loop in loops])
    places = fabric.vertices[fabric.face_vertex[np.concatenate(loops)]]
    near = CHAIN_HEIGHT * float(fabric.side_length[fabric.is_wale].mean())
    pairs = number[cKDTree(places).query_pairs(near, output_type="ndarray")].reshape(-1, 2)
    return [loops[border] for border in np.unique(pairs[pairs[:, 0] != pairs[:, 1]])]


def _join_neighbours(twin: IntArray, first: IntArray, left: IntArray, right: IntArray) -> None:
    """Set the twins of wale sides between bind-off faces that share a vertex of the border."""
    by_left = {int(vertex): int(side) for vertex, side in zip(left, first, strict=True)}
    for vertex, side in zip(right, first, strict=True):
        neighbour = by_left.get(int(vertex))
        if neighbour is not None:
            twin[side + 1], twin[neighbour + 3] = neighbour + 3, side + 1


def _raised_vertices(fabric: StitchMesh, vertices: IntArray, sides: IntArray, shares: FloatArray) -> FloatArray:
    """New vertices above border vertices [cm], shape (n, 3), along the wales that end there.

    Where the border is a small ring, as at a crown, the wales converge. The new row then points along the normal.

    Args:
        fabric: stitch faces.
        vertices: border vertices, ascending, shape (n,).
        sides: index into ``vertices`` of the right and the left end of each top side, shape (2, S).
        shares: height of the new faces, over the mean height of the stitches below, shape (n,).

    Raises:
        YarnError: a wale that ends at the border has no length.
    """
    base, up = fabric.vertices[vertices], shares[..., None] * _mean_wale(fabric)[vertices]
    flat = vertices[~up.any(axis=1)]
    if len(flat):
        face = int(fabric.side_face[fabric.face_vertex == flat[0]][0])
        remedy = "relax the stitch mesh on a surface that has room for the row"
        raise YarnError(f"face {face}: is bound off, but has no height at one side", face=face, remedy=remedy)
    raised = base + vertex_step(up, border_lean(base, up, sides), fabric.vertex_normal[vertices])
    for foot, head in _steps(fabric):
        if foot not in vertices:
            continue
        wale = fabric.vertices[head] - fabric.vertices[foot]
        place = np.searchsorted(vertices, foot)
        raised[place] = fabric.vertices[foot] + max(shares[place], 1.0) * wale
    return raised


def _steps(fabric: StitchMesh) -> list[tuple[int, int]]:
    """Foot and head vertices of steps one row high between two top borders; a stitch and a bind-off face meet there."""
    steps = []
    wales = np.flatnonzero(fabric.is_wale & (fabric.twin == BORDER))
    before = {fabric.next_border_side(int(side)): int(side) for loop in fabric.boundary_loops for side in loop}
    for side in wales.tolist():
        if fabric.side_role[before[side]] == fabric.side_role[fabric.next_border_side(side)] == TOP:
            ends = fabric.face_vertex[[side, fabric.side_next[side]]].tolist()
            steps.append((ends[0], ends[1]) if fabric.side_role[side] == RIGHT else (ends[1], ends[0]))
    return steps


def _mean_wale(fabric: StitchMesh) -> FloatArray:
    """Mean upward vector of the wale edges that end in each vertex [cm], shape (V, 3).

    A vertex at which no wale edge ends takes the mean of the wale sides of the faces around it.
    """
    is_right, sides = fabric.side_role == RIGHT, np.arange(fabric.side_count)
    ends, starts = np.where(is_right, fabric.side_next, sides), np.where(is_right, sides, fabric.side_next)
    wales = np.flatnonzero(fabric.is_wale)
    up = fabric.corner_position[ends[wales]] - fabric.corner_position[starts[wales]]
    total, count = np.zeros_like(fabric.vertices), np.zeros(len(fabric.vertices))
    np.add.at(total, fabric.face_vertex[ends[wales]], up)
    np.add.at(count, fabric.face_vertex[ends[wales]], 1.0)
    # corners between the loops of one face take the mean of the wale sides of that face
    corners_inside = np.flatnonzero(count[fabric.face_vertex] == 0)
    rise = np.zeros((fabric.face_count, 3))
    np.add.at(rise, fabric.side_face[wales], up)
    np.add.at(total, fabric.face_vertex[corners_inside], rise[fabric.side_face[corners_inside]])
    np.add.at(count, fabric.face_vertex[corners_inside], 2.0)
    return total / np.maximum(count, 1.0)[:, None]


def choose_edges(whole: StitchMesh, bridges: Bridges, finish: YarnFinish, drawn: IntArray) -> IntArray:
    """Template of each face of a first or last row (``Edge``), shape (F,).

    Args:
        whole: the stitch mesh with its bind-off row.
        bridges: the row ends; a bind-off row is worked away from the end at which the yarn arrives.
        finish: the selected cast-on and bind-off.
        drawn: top sides of the stitches below through which a yarn is drawn with any bind-off (``drawn_sides``).
    """
    edge = np.full(whole.face_count, Edge.BY_STITCH)
    if finish.cast_on == "open":
        edge[whole.stitch == Stitch.CAST_ON] = Edge.YARN_OVERS
    if finish.bind_off == "chain":
        _choose_chains(whole, bridges, edge, whole.side_face[whole.twin[drawn]])
    return edge


def _choose_chains(whole: StitchMesh, bridges: Bridges, edge: IntArray, drawn: IntArray) -> None:
    """Set the templates of all rows that are bound off in a chain; some faces keep their drawn-through yarn."""
    bound = whole.stitch == Stitch.BIND_OFF
    bound[drawn] = False
    edge[bound] = Edge.CHAIN
    for face in np.flatnonzero(bound & (whole.twin[whole.left_wale] == BORDER)).tolist():
        row = list(course_through(whole, face, climbing=True).faces)
        if len(row) == 1:
            edge[face] = Edge.CHAIN_ALONE
        elif _yarn_arrives_right(bridges, int(whole.left_wale[face]), int(whole.right_wale[row[-1]])):
            edge[row] = [Edge.LEFTWARD_LAST, *[Edge.LEFTWARD_CHAIN] * (len(row) - 2), Edge.LEFTWARD_FIRST]
        else:
            edge[row] = [Edge.CHAIN_FIRST, *[Edge.CHAIN] * (len(row) - 2), Edge.CHAIN_LAST]


def _yarn_arrives_right(bridges: Bridges, left: int, right: int) -> bool:
    """Whether the yarn arrives at the right end of a row and not at its left end."""
    return crossing_number(right) in bridges.paths and crossing_number(left) not in bridges.paths
