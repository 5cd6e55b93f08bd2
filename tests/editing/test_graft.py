# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Grafted seams: linked yarns, exact inverse, and refused sides."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from stitchmesh.edits import graft, ungraft
from stitchmesh.errors import ParameterError
from stitchmesh.labeling import label
from stitchmesh.mesh import BORDER, Mesh, StitchMesh
from stitchmesh.tessellate import tessellate
from stitchmesh.yarngen import generate_yarns
from tests.gallery import grid, tube

pytestmark = pytest.mark.decides


def two_pieces(piece: Mesh, other: Mesh) -> StitchMesh:
    """Return two pieces; the second is turned upside down above the first, and its outside stays outside."""
    turned = other.vertices * [-1.0, -1.0, 1.0] + [other.vertices[:, 0].max() + other.vertices[:, 0].min(), 8.0, 0.0]
    corners = [piece.face_vertex.reshape(-1, 4), other.face_vertex.reshape(-1, 4) + len(piece.vertices)]
    mesh = Mesh.from_polygons(np.concatenate([piece.vertices, turned]), np.concatenate(corners).tolist())
    lowest = [0, piece.side_count]
    return tessellate(label(mesh, seeds=[tuple(mesh.face_vertex[[s, mesh.side_next[s]]].tolist()) for s in lowest]),
                      stitch_width=0.6)  # fmt: skip


def top_sides(fabric: StitchMesh) -> list[int]:
    """Return one side on each of the two top borders."""
    sides = np.flatnonzero((fabric.side_role == 2) & (fabric.twin == BORDER))
    height = fabric.vertices[fabric.face_vertex[sides], 1]
    return [int(sides[height.argmin()]), int(sides[height.argmax()])]


PIECES = {
    "flat": lambda: two_pieces(grid(1, 1, width=4.0, height=2.0), grid(1, 1, width=4.0, height=2.0)),
    "round": lambda: two_pieces(tube(8, 2, radius=2.0), tube(8, 2, radius=2.0)),
}


@pytest.mark.parametrize("name", PIECES)
def test_two_tops_are_linked_by_a_ring_between_every_two_wales(name):
    fabric = PIECES[name]()
    first, second = top_sides(fabric)
    sewn = graft(fabric, first_side=first, second_side=second).fabric
    loops = int(sewn.mismatched.sum()) // 2
    assert loops == int((fabric.row == 0).sum())
    yarns = generate_yarns(sewn, quality="draft")
    faces = [set(yarns.face[a:b]) for a, b in pairwise(yarns.start)]
    rings = sum(len(each) == 4 for each, closed in zip(faces, yarns.closed, strict=True) if closed)
    assert rings == (loops if name == "round" else loops - 1)


@pytest.mark.parametrize("name", PIECES)
def test_ungrafting_a_seam_restores_the_two_pieces(name):
    fabric = PIECES[name]()
    first, second = top_sides(fabric)
    again = ungraft(graft(fabric, first_side=first, second_side=second).fabric, side=first).fabric
    np.testing.assert_array_equal(again.twin, fabric.twin)
    assert len(again.vertices) == len(fabric.vertices)


def test_merged_vertices_take_their_mean_position():
    fabric = PIECES["round"]()
    first, second = top_sides(fabric)
    sewn = graft(fabric, first_side=first, second_side=second).fabric
    start, end = fabric.face_vertex, fabric.face_vertex[fabric.side_next]
    middle = (fabric.vertices[start[first]] + fabric.vertices[end[second]]) / 2
    np.testing.assert_allclose(sewn.vertices[sewn.face_vertex[first]], middle, atol=1e-14)  # rounding of a mean


def test_lines_with_different_numbers_of_loops_are_refused():
    fabric = two_pieces(grid(1, 1, width=4.0, height=2.0), grid(1, 1, width=6.0, height=2.0))
    first, second = top_sides(fabric)
    with pytest.raises(ParameterError, match=r"got 7 loops at side \d+ and 10 at side \d+; expected equal numbers"):
        graft(fabric, first_side=first, second_side=second)


def test_only_loops_can_be_grafted():
    fabric = PIECES["flat"]()
    first, _ = top_sides(fabric)
    cast_on = int(np.flatnonzero((fabric.side_role == 0) & (fabric.twin == BORDER))[0])
    wale = int(fabric.right_wale[0])
    with pytest.raises(ParameterError, match="is cast on: it has no loop"):
        graft(fabric, first_side=first, second_side=cast_on)
    with pytest.raises(ParameterError, match=f"got side {wale}; expected a course side on a border"):
        graft(fabric, first_side=wale, second_side=first)
    with pytest.raises(ParameterError, match="lie on one line"):
        graft(fabric, first_side=first, second_side=first)
    with pytest.raises(ParameterError, match="ungraft: got side"):
        ungraft(fabric, side=first)


def tube_with_a_triangle() -> Mesh:
    """A tube of three rounds; the second round has seven quads and a triangle with nothing above."""
    rings = [
        np.stack([3 * np.sin(angle), np.full(count, 2.0 * height), 3 * np.cos(angle)], axis=1)
        for height, count in enumerate((8, 8, 7, 7))
        for angle in [2 * np.pi * np.arange(count) / count]
    ]
    faces = [[k, (k + 1) % 8, 8 + (k + 1) % 8, 8 + k] for k in range(8)]
    faces += [[8 + k, 9 + k, 16 + (k + 1) % 7, 16 + k] for k in range(7)] + [[15, 8, 16]]
    faces += [[16 + k, 16 + (k + 1) % 7, 23 + (k + 1) % 7, 23 + k] for k in range(7)]
    return Mesh.from_polygons(np.concatenate(rings), faces)


def test_a_line_ends_beside_a_stitch_with_nothing_above():
    """The line went down along this stitch to the ring below and never came back to its start."""
    fabric = tessellate(label(tube_with_a_triangle(), seeds=[(0, 1)]), stitch_width=0.8)
    ends = np.flatnonzero((fabric.n_top == 0) & (fabric.twin[fabric.left_wale] != BORDER))
    beside = fabric.side_face[fabric.twin[fabric.right_wale[ends]]]
    side = int(fabric.right_wale[beside[fabric.n_top[beside] > 0][0]]) + 1
    apart = ungraft(fabric, side=side).fabric
    assert np.count_nonzero(apart.twin == BORDER) > np.count_nonzero(fabric.twin == BORDER)
