# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patterns without borders: the mesh is closed on its lattice, and its yarns equal those of a large flat piece."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.mesh import TOP, FloatArray, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import Cell, Loop, Pattern, Row, pattern_mesh, pattern_names, read_pattern
from stitchmesh.periodic.repeat.torus import torus_mesh
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.clearance import smallest_distance
from tests.chosen_patterns import CHOSEN_PATTERNS

WIDTH = 0.5
HEIGHT = COURSE_OVER_WALE_SPACING * WIDTH
RADIUS = WIDTH / 8
MARGIN = np.array([8, 6])
"""Stitches and rows from a border in which the border influences the yarn: floats extend to the end of the row, and the
influence of the end of a spline falls to a quarter at each control point, of which a slipped stitch has two."""
ROUNDING = 1e-9
"""Error of positions [cm]; control points are solved to 1e-8 of their spacing, equally in all copies."""
FADED = 1e-7
"""Influence of yarn ends [cm] inside the margin, where legs of slipped loops extend beyond the margin."""


@cache
def torus(name: str, columns: int = 1, rows: int = 1) -> StitchMesh:
    return torus_mesh(read_pattern(name), stitch_width=WIDTH, stitch_height=HEIGHT, columns=columns, rows=rows)


@cache
def torus_yarns(name: str) -> YarnSet:
    return generate_yarns(torus(name), yarn_radius=RADIUS, quality="draft")


def test_repeats_of_one_pattern_differ_in_their_size_alone() -> None:
    pattern = read_pattern("slip-stitch-honeycomb")
    sizes = (0.3, 0.2), (0.6, 0.8)
    small, large = (torus_mesh(pattern, stitch_width=width, stitch_height=height, columns=2) for width, height in sizes)
    assert small.lattice is not None and large.lattice is not None
    # twice as wide and four times as high: powers of two round nothing
    assert np.array_equal(large.vertices, small.vertices * [2.0, 4.0, 1.0])
    assert np.array_equal(large.lattice.periods, small.lattice.periods * [2.0, 4.0, 1.0])
    assert np.array_equal(large.face_vertex, small.face_vertex) and np.array_equal(large.twin, small.twin)


def in_cell(points: FloatArray, lattice_of: StitchMesh) -> cKDTree:
    """Return a search tree of points modulo a lattice along x and y; its period along z is too long to matter."""
    size = cell_size(lattice_of)
    return cKDTree(np.mod(points, size), boxsize=size)


def cell_size(fabric: StitchMesh) -> FloatArray:
    assert fabric.lattice is not None
    u, v = fabric.lattice.periods
    assert u[1] == u[2] == v[0] == v[2] == 0.0
    return np.array([u[0], v[1], 1e3])


def made(*rows: list[Cell], loops: dict[int, tuple[Loop, ...]] | None = None) -> Pattern:
    return Pattern("made", "test", tuple(Row(tuple(row), (loops or {}).get(k, ())) for k, row in enumerate(rows)))


@pytest.mark.parametrize("name", CHOSEN_PATTERNS)
def test_neighbours_meet_on_their_common_side(name):
    for fabric in (torus(name), torus(name, 2, 3)):
        position, twin = fabric.corner_position, fabric.twin
        shift = fabric.shift(fabric.side_image)
        assert (twin >= 0).all()
        np.testing.assert_array_equal(fabric.side_image, -fabric.side_image[twin])
        for start, end in ((np.arange(len(twin)), fabric.side_next[twin]), (fabric.side_next, twin)):
            np.testing.assert_allclose(position[start], position[end] + shift, atol=1e-12)  # rounding
        # Euler's formula for a torus: V - E + F = 0
        assert len(fabric.vertices) - len(fabric.edge_side) + fabric.face_count == 0
        assert (fabric.face_vector_area[:, 2] > 0).all()
        area = cell_size(fabric)[:2].prod()  # the faces fill the cell once
        assert fabric.face_vector_area[:, 2].sum() == pytest.approx(area, rel=1e-12)  # rounding


@pytest.mark.parametrize(("columns", "rows"), [(1, 1), (1, 3), (3, 1)])
def test_a_torus_of_few_stitches(columns, rows):
    fabric = torus_mesh(made(*[[Cell(Stitch.KNIT)] * columns] * rows), stitch_width=WIDTH, stitch_height=HEIGHT)
    yarns = generate_yarns(fabric, yarn_radius=RADIUS)
    assert fabric.face_count == len(fabric.vertices) == columns * rows
    assert yarns.yarn_count == rows and yarns.closed.all()
    np.testing.assert_array_equal(yarns.lattice_step, [[1, 0]] * rows)
    plain = generate_yarns(torus("stockinette"), yarn_radius=RADIUS)
    first = yarns.points[: len(yarns.points) // (rows * columns)]
    distance, _ = in_cell(plain.points, torus("stockinette")).query(np.mod(first, cell_size(torus("stockinette"))))
    assert distance.max() < ROUNDING


@pytest.mark.parametrize("name", CHOSEN_PATTERNS)
def test_marks_of_the_last_row_agree_with_the_first_row(name):
    fabric, pattern = torus(name), read_pattern(name)
    for row in (0, pattern.height - 1):
        left, tile, _ = pattern.rows[row].tops
        loops = pattern.loops_above(row)[left : left + tile]
        sides = np.flatnonzero((fabric.side_role == TOP) & (fabric.row[fabric.side_face] == row))
        # faces from left to right, top sides of each from right to left
        order = sides[np.lexsort((-sides, fabric.side_face[sides]))]
        found = np.stack([fabric.twist, fabric.cable_shift, fabric.cable_layer], axis=1)[order]
        np.testing.assert_array_equal(found, [(loop.twist, loop.shift, loop.layer) for loop in loops])


@pytest.mark.parametrize("name", CHOSEN_PATTERNS)
def test_each_yarn_goes_through_the_cell_once_without_a_gap(name):
    fabric, yarns = torus(name), torus_yarns(name)
    used = {(int(row), int(yarn)) for row, yarn in zip(fabric.row, fabric.yarn, strict=True)}
    assert yarns.closed.all() and yarns.yarn_count == len(used)
    # each row closes after one period to one side: no row changes its height, and no row turns back
    np.testing.assert_array_equal(np.abs(yarns.lattice_step), [[1, 0]] * yarns.yarn_count)
    for yarn, (first, last) in enumerate(zip(yarns.start[:-1], yarns.start[1:], strict=True)):
        after = yarns.points[first] + yarns.lattice.shift(yarns.lattice_step[yarn])
        gaps = np.linalg.norm(np.diff(yarns.points[first:last], axis=0, append=after[None]), axis=1)
        # the number of points of a part of a yarn is proportional to its length, so no segment is far longer
        assert gaps.max() < 4.0 * np.median(gaps)


@pytest.mark.parametrize("name", CHOSEN_PATTERNS)
def test_the_torus_equals_a_tile_inside_a_flat_piece(name):
    pattern, fabric = read_pattern(name), torus(name)
    size = np.array([pattern.width, pattern.height])
    tiles = 1 - -2 * MARGIN // size  # one tile with a margin on each side
    flat = pattern_mesh(pattern, *tiles.tolist(), stitch_width=WIDTH, stitch_height=HEIGHT)
    yarns = generate_yarns(flat, yarn_radius=RADIUS, quality="draft")
    corner = np.array([pattern.rows[0].bottoms[0] * WIDTH, HEIGHT, 0.0])  # corner of the first tile
    centre = np.add.reduceat(flat.corner_position, flat.face_start[:-1]) / np.diff(flat.face_start)[:, None] - corner
    low, high = (place * [WIDTH, HEIGHT] for place in (MARGIN, tiles * size - MARGIN))
    inside = ((centre[:, :2] > low) & (centre[:, :2] < high)).all(axis=1)
    distance, nearest = in_cell(torus_yarns(name).points, fabric).query(
        np.mod(yarns.points[inside[yarns.face]] - corner, cell_size(fabric))
    )
    assert distance.max() < FADED
    assert len(np.unique(nearest)) == len(torus_yarns(name).points)


@pytest.mark.parametrize("name", CHOSEN_PATTERNS)
def test_yarns_do_not_depend_on_the_image_of_each_face(name):
    fabric, yarns = torus(name), torus_yarns(name)
    image = np.random.default_rng(0).integers(-2, 3, size=(fabric.face_count, 2))
    moved = replace(fabric, corner_image=fabric.corner_image + image[fabric.side_face])
    again = generate_yarns(moved, yarn_radius=RADIUS, quality="draft")
    np.testing.assert_array_equal(again.start, yarns.start)
    np.testing.assert_array_equal(again.lattice_step, yarns.lattice_step)
    np.testing.assert_allclose(again.rest_length, yarns.rest_length, rtol=1e-9)  # rounding
    # the whole yarn lies in the image of its first face
    expected = yarns.points + yarns.lattice.shift(image[yarns.face[yarns.start[:-1]]])[yarns.point_yarn]
    np.testing.assert_allclose(again.points, expected, atol=ROUNDING)


@pytest.mark.parametrize("name", ["stockinette", "lice"])
def test_distances_do_not_depend_on_the_image_of_each_yarn(name):
    yarns = torus_yarns(name)
    assert yarns.lattice is not None
    image = np.random.default_rng(0).integers(-2, 3, size=(yarns.yarn_count, 2))
    moved = replace(yarns, points=yarns.points + yarns.lattice.shift(image)[yarns.point_yarn])
    distance, _ = smallest_distance(yarns, 2 * RADIUS)
    assert smallest_distance(moved, 2 * RADIUS)[0] == pytest.approx(distance, abs=ROUNDING)
    assert distance < 2 * RADIUS


@pytest.mark.parametrize("name", pattern_names())
def test_yarns_start_apart_from_all_images(name):
    # yarns touch at two radii; lace, whose loops are long in order to reach the next row, has the smallest distance
    assert smallest_distance(torus_yarns(name), 2 * RADIUS)[0] > 0.5 * RADIUS


def test_a_pattern_whose_borders_do_not_close_has_a_torus():
    row = Row((Cell(Stitch.KNIT),) * 3, left=1)
    wider = Row((Cell(Stitch.KY), *(Cell(Stitch.KNIT),) * 2), left=1)
    pattern = Pattern("shaped", "test", (row, wider))
    assert not pattern.closes
    fabric = torus_mesh(pattern, stitch_width=WIDTH, stitch_height=HEIGHT)
    assert fabric.face_count == 4


def test_a_pattern_that_does_not_close_is_refused():
    pattern = Pattern("growing", "test", (Row((Cell(Stitch.KNIT),) * 2), Row((Cell(Stitch.KNIT), Cell(Stitch.KY)))))
    with pytest.raises(PatternError, match="row 2: its tile leaves 3 loops, but row 1 is worked on 2"):
        torus_mesh(pattern, stitch_width=WIDTH, stitch_height=HEIGHT)


@pytest.mark.parametrize("wrong", [{"stitch_height": -1.0}, {"columns": 0}])
def test_sizes_must_be_positive(wrong):
    sizes = {"stitch_width": WIDTH, "stitch_height": HEIGHT} | wrong
    with pytest.raises(ParameterError, match=next(iter(wrong)).replace("_", " ")):
        torus_mesh(read_pattern("stockinette"), **sizes)
