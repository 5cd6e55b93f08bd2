# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Garments that are open in front, armholes without sleeves, and parts too small for a row."""

from __future__ import annotations

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import TessellationError
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.courses import find_courses
from stitchmesh.shaping.ends import automatic_ends
from stitchmesh.shaping.report import shaping_report
from stitchmesh.shaping.time_function import smooth_out
from tests.nightly import at_night
from tests.shaping.surfaces import closed_ball, in_triangles, surface_of

UP = np.array([0.0, 1.0, 0.0])
RADIUS, HEIGHT = 5.0, 14.0


def vest(opening: float) -> Mesh:
    """A tube with an armhole in its side, 4 cm wide and 6 cm high; in front it is open by an angle, or closed at 0."""
    around, rows = 96, 42
    angle = np.linspace(0.5 * opening, 2.0 * np.pi - 0.5 * opening, around + 1)
    height = np.linspace(0.0, HEIGHT, rows + 1)
    across, up = np.meshgrid(angle, height)
    points = np.stack([RADIUS * np.sin(across), up, RADIUS * np.cos(across)], axis=2).reshape(-1, 3)
    corner = np.arange(points.shape[0]).reshape(rows + 1, around + 1)
    if opening == 0.0:
        corner[:, -1] = corner[:, 0]
    quads = np.stack([corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]], axis=2).reshape(-1, 4)
    middle = points[quads].mean(axis=1)
    away = np.hypot((np.arctan2(middle[:, 0], middle[:, 2]) - 0.5 * np.pi) * RADIUS / 2.0, (middle[:, 1] - 7.5) / 3.0)
    kept = quads[away > 1.0]
    used, number = np.unique(kept, return_inverse=True)
    return in_triangles(Mesh.from_polygons(points[used], number.reshape(kept.shape).tolist()))


def test_a_garment_that_is_open_in_front_has_a_hem_and_a_neck():
    surface = surface_of(vest(0.3))
    ends = automatic_ends(surface, UP)
    heights = [np.unique(surface.vertices[end.vertices, 1]).tolist() for end in (*ends.roots, *ends.others)]
    # Rows end at the two fronts and at the armhole, which are no ends.
    assert heights == [[HEIGHT], [0.0]] and not ends.begins


@pytest.mark.decides
@pytest.mark.parametrize(("slope", "is_neck"), [(1.1, True), (5.0, False)])
def test_the_slanting_fronts_of_a_neck_belong_to_it_if_they_face_upwards_rather_than_sideways(slope, is_neck):
    # The upper border falls by 4 cm on both sides of the opening: by 48 degrees, or by 79 degrees.
    tube, fall = vest(0.3), 4.0
    x, y, z = tube.vertices.T
    beside = RADIUS * (np.abs(np.arctan2(x, z)) - 0.15)
    top = HEIGHT - np.clip(fall - slope * beside, 0.0, fall)
    cut = Mesh.from_polygons(np.stack([x, y * top / HEIGHT, z], axis=1), tube.face_vertex.reshape(-1, 3).tolist())
    surface = surface_of(cut)
    (root,) = automatic_ends(surface, UP).roots
    height = surface.vertices[root.vertices, 1]
    assert height.max() == HEIGHT and (height.min() < HEIGHT - 0.9 * fall) == is_neck


def with_round_neck(radius: float) -> Mesh:
    """A tube that is open in front, whose fronts pass into the upper border by a quarter of a circle."""
    tube = vest(0.3)
    x, y, z = tube.vertices.T
    beside = np.minimum(RADIUS * (np.abs(np.arctan2(x, z)) - 0.15) / radius, 1.0)
    top = HEIGHT - radius * (1.0 - np.sqrt(beside * (2.0 - beside)))
    return Mesh.from_polygons(np.stack([x, y * top / HEIGHT, z], axis=1), tube.face_vertex.reshape(-1, 3).tolist())


@pytest.mark.decides
@pytest.mark.parametrize("upright", [True, False])
def test_fronts_that_pass_smoothly_into_the_neck_or_the_hem_end_where_these_face_upwards_or_downwards(upright):
    radius = 7.0
    surface = surface_of(with_round_neck(radius))
    ends = automatic_ends(surface, UP if upright else -UP)
    (rounded,), (straight,) = (ends.roots, ends.others) if upright else (ends.others, ends.roots)
    height = surface.vertices[rounded.vertices, 1]
    # The border faces up by half where a circle has turned by 60 degrees, half its radius below its top. The mean over
    # 3 cm of a border moves that place by at most 1.5 cm.
    assert height.max() == HEIGHT and abs(HEIGHT - height.min() - 0.5 * radius) < 1.5
    assert np.unique(surface.vertices[straight.vertices, 1]).tolist() == [0.0]


@pytest.mark.nightly
@pytest.mark.parametrize("width", [0.55, 0.9])
def test_a_last_row_that_ends_on_a_straight_border_gets_room_and_its_loops_hold(width):
    shaped = sm.shape_fabric(with_round_neck(7.0), stitch_width=width, progress=False)
    fabric = sm.relax_mesh(shaped.fabric, surface=shaped.surface.mesh).fabric
    roomy = sm.make_room(fabric).fabric
    sm.check_loops(roomy, sm.generate_yarns(roomy))
    # Only corners are moved, by 0.3 of half the distance of their neighbours, which is at most 1.3 stitch widths.
    assert np.linalg.norm(roomy.vertices - fabric.vertices, axis=1).max() < 0.2 * width


@pytest.mark.decides
@pytest.mark.parametrize("opening", [0.0, *at_night(0.3)])
def test_rows_end_at_an_armhole_and_their_loops_hold(opening):
    width = 1.0
    shaped = sm.shape_fabric(vest(opening), stitch_width=width, progress=False)
    fabric = sm.relax_mesh(shaped.fabric, surface=shaped.surface.mesh).fabric
    courses = find_courses(fabric)
    assert any(course.closed for course in courses) == (opening == 0.0)
    assert not all(course.closed for course in courses)
    report = shaping_report(fabric, shaped.given, width, 0.0)
    # A tube needs no increases; a ring that is cut beside the armhole and not at it needs many in one row.
    assert report.largest_shaping < 0.2 and report.lost is None
    fabric = sm.make_room(fabric, quality="draft").fabric
    sm.check_loops(fabric, sm.generate_yarns(fabric, quality="draft"))


def hood() -> Mesh:
    """A tube with a round top and a round opening in front for the face, 7 cm wide."""
    along = np.concatenate([np.linspace(0.0, 8.0, 25), 8.0 + np.linspace(0.0, 0.5 * np.pi, 25)[1:-1] * RADIUS])
    lift = np.maximum(along - 8.0, 0.0) / RADIUS
    angle = np.linspace(0.0, 2.0 * np.pi, 97)[:-1]
    radius, height = RADIUS * np.cos(lift), np.minimum(along, 8.0) + RADIUS * np.sin(lift)
    ring = np.stack([np.outer(radius, np.sin(angle)), np.tile(height, (96, 1)).T, np.outer(radius, np.cos(angle))], 2)
    corner = np.arange(ring[..., 0].size).reshape(-1, 96)
    ahead = np.roll(corner, -1, axis=1)
    quads = np.stack([corner[:-1], ahead[:-1], ahead[1:], corner[1:]], axis=2).reshape(-1, 4)
    points = np.vstack([ring.reshape(-1, 3), [0.0, 8.0 + RADIUS, 0.0]])
    top = [[one, other, len(points) - 1] for one, other in zip(corner[-1].tolist(), ahead[-1].tolist(), strict=True)]
    kept = quads[np.linalg.norm(points[quads].mean(axis=1) - [0.0, 8.0, RADIUS], axis=1) > 3.5]
    used, number = np.unique(np.concatenate([kept.ravel(), np.array(top).ravel()]), return_inverse=True)
    faces = [*number[: kept.size].reshape(-1, 4).tolist(), *number[kept.size :].reshape(-1, 3).tolist()]
    return in_triangles(Mesh.from_polygons(points[used], faces))


@pytest.mark.decides
def test_a_hood_is_knitted_from_its_hem_to_its_top_and_rows_end_at_the_face():
    shaped = sm.shape_fabric(hood(), stitch_width=0.7, progress=False)
    (ends,) = shaped.ends
    assert ends.begins and not ends.others
    assert [np.unique(shaped.surface.vertices[end.vertices, 1]).tolist() for end in ends.roots] == [[0.0]]
    courses, fabric = find_courses(shaped.fabric), shaped.fabric
    height = np.maximum.reduceat(fabric.vertices[fabric.face_vertex, 1], fabric.face_start[:-1])
    middle = np.array([height[list(course.faces)].mean() for course in courses])
    beside = (middle > 6.0) & (middle < 10.0)
    assert not any(course.closed for course, inside in zip(courses, beside, strict=True) if inside)
    assert all(course.closed for course, place in zip(courses, middle, strict=True) if place < 3.0)
    assert shaped.report.lost is None


def test_a_hollow_beside_the_hem_is_smoothed_out_although_it_is_lower():
    surface = surface_of(vest(0.0))
    ends = automatic_ends(surface, UP)
    x, y, z = surface.vertices.T
    hollow = y - 3.0 * np.exp(-(x**2 + (y - 1.5) ** 2)) * (z > 0.0)
    hollow[ends.others[0].vertices] = 0.0
    assert hollow.min() < -1.0
    smooth = smooth_out(surface, hollow, 4.0, ends)
    assert smooth.min() == 0.0  # By the maximum principle the lowest place is the hem.


def test_a_part_without_room_for_a_row_is_named():
    ball = closed_ball(12, 8)
    small = Mesh(
        vertices=ball.vertices * 0.75 / np.abs(ball.vertices).max() + [7.0, 0.0, 0.0], face_start=ball.face_start,
        face_vertex=ball.face_vertex, twin=ball.twin,
    )  # fmt: skip
    with pytest.raises(TessellationError, match=r"near \[7\.0, .* too small for a row of stitches 0\.8 cm") as caught:
        sm.auto_stitches(small, stitch_width=0.8)
    assert "\n" not in str(caught.value)
