# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bibs, straps and leg openings: a part of a row is bound off while the rest goes on."""

from __future__ import annotations

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.shaping.auto_stitches import ShapedFabric
from stitchmesh.shaping.ends import automatic_ends
from stitchmesh.shaping.marks import TimeMark, marked_ends
from tests.benchmarks.test_surface_shapes import shape
from tests.shaping.surfaces import closed_ball, in_triangles, surface_of

UP = np.array([0.0, 1.0, 0.0])
RADIUS, EDGE, TOP = 6.0, 8.0, 16.0


def kept(points: FloatArray, quads: IntArray, chosen: IntArray) -> Mesh:
    """Triangles of some of the quads."""
    used, number = np.unique(quads[chosen], return_inverse=True)
    return in_triangles(Mesh.from_polygons(points[used], number.reshape(-1, 4).tolist()))


def bib() -> Mesh:
    """A tube up to ``EDGE`` with a bib of a quarter of its width up to ``TOP`` in front."""
    around, rows = 96, 32
    angle, height = np.meshgrid(2 * np.pi * np.arange(around) / around, np.linspace(0.0, TOP, rows + 1))
    points = np.stack([RADIUS * np.sin(angle), height, RADIUS * np.cos(angle)], axis=2).reshape(-1, 3)
    corner = np.arange(len(points)).reshape(rows + 1, around)
    right = np.roll(corner, -1, axis=1)
    quads = np.stack([corner[:-1], right[:-1], right[1:], corner[1:]], axis=2).reshape(-1, 4)
    middle = points[quads].mean(axis=1)
    in_front = np.abs(np.arctan2(middle[:, 0], middle[:, 2])) < 0.25 * np.pi
    return kept(points, quads, in_front | (middle[:, 1] < EDGE))


def check_loops_of(shaped: ShapedFabric) -> None:
    fabric = sm.make_room(relax_mesh(shaped.fabric, surface=shaped.surface.mesh).fabric, quality="draft").fabric
    sm.check_loops(fabric, sm.generate_yarns(fabric, quality="draft"))


@pytest.mark.decides
def test_a_bib_ends_at_its_top_and_the_row_behind_is_bound_off():
    surface = surface_of(bib())
    ends = automatic_ends(surface, UP)
    heights = [
        np.unique(surface.vertices[end.vertices, 1]).tolist() for end in (*ends.roots, *ends.others, *ends.lines)
    ]
    assert heights == [[TOP], [0.0], [EDGE]] and not ends.begins and not ends.grafts


def test_a_bib_on_a_tube_needs_no_increase_or_decrease_and_its_loops_hold():
    # All courses of the tube are equally long, and so are those of the bib.
    mesh = bib()
    shaped = sm.shape_fabric(mesh, stitch_width=0.9, progress=False)
    assert shaped.report.irregular == 0 and shaped.report.mismatched_edges == 0 and shaped.report.lost is None
    stitches = np.bincount(shaped.fabric.row)
    around, across = round(2 * np.pi * RADIUS / 0.9), round(0.5 * np.pi * RADIUS / 0.9)
    assert set(stitches[stitches > 0].tolist()) == {around, across}
    check_loops_of(shaped)


@pytest.mark.decides
def test_a_camisole_is_bound_off_between_its_straps_which_are_grafted_at_their_tops():
    shaped = sm.shape_fabric(shape("camisole"), stitch_width=2.4, progress=False)
    (ends,) = shaped.ends
    assert ends.begins and not ends.others and len(ends.roots) == 1 and len(ends.grafts) == 2
    heights = np.array([shaped.surface.vertices[end.vertices, 1].mean() for end in ends.lines])
    # In front, behind, and below both arms the border is at a height of 46; straps are highest above 60.
    assert len(heights) == 4 and np.abs(heights - 46.0).max() < 0.5
    assert all(shaped.surface.vertices[end.vertices, 1].min() > 60.0 for end in ends.grafts)
    for end in ends.grafts:  # the last rows of both halves of a strap are half a course away from its top
        assert np.abs(shaped.time[end.vertices] % 1.0 - 0.5).max() < 1e-6  # rounding of a solution of size 100
    assert shaped.report.lost is None and shaped.report.mismatched_edges > 0
    check_loops_of(shaped)


def test_a_ball_whose_only_opening_is_in_its_side_has_no_part_of_it_bound_off():
    ball = closed_ball(48, 24)
    corners = ball.face_vertex.reshape(-1, 3)
    x, y, z = ball.vertices[corners].mean(axis=1).T
    kept_corners = corners[~((z > 0.0) & (np.abs(x) < 2.5) & (np.abs(y) < 2.5))]
    used, number = np.unique(kept_corners, return_inverse=True)
    surface = surface_of(Mesh.from_polygons(ball.vertices[used], number.reshape(-1, 3).tolist()))
    ends = automatic_ends(surface, UP)
    vertices = np.concatenate([end.vertices for end in ends.all])
    assert len(vertices) == len(np.unique(vertices)) and not ends.lines


def test_marks_leave_the_other_parts_of_a_camisole_as_they_are():
    surface = surface_of(shape("camisole"))
    automatic = automatic_ends(surface, UP)
    hem = TimeMark("border", [[0.0, 0.0, 12.0]], "begin")
    marked = marked_ends(surface, [hem], UP)
    for own, other in ((marked.lines, automatic.lines), (marked.grafts, automatic.grafts)):
        assert [end.vertices.tolist() for end in own] == [end.vertices.tolist() for end in other]


@pytest.mark.decides
def test_briefs_are_knitted_from_the_crotch_and_rows_end_at_both_legs():
    # Above the hips no row closes around a leg, and both legs are equal: none of them is an end.
    shaped = sm.shape_fabric(shape("briefs"), stitch_width=2.0, progress=False)
    (ends,) = shaped.ends
    assert not ends.others and not ends.begins and shaped.report.lost is None
    first = shaped.surface.vertices[shaped.time.argmin()]
    assert abs(first[0]) < 4.0 and first[1] < 72.0  # half of the crotch is 3.5 wide
