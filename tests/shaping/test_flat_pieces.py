# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flat pieces with re-entrant corners and holes: rows are bound off and cast on beside a corner, without a slit."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np
import pytest
from matplotlib.path import Path as Outline

import stitchmesh as sm
from benchmarks.scenes.surface_shapes.flat_sheets import sheet as triangulated_outline
from benchmarks.scenes.surface_shapes.level_surface import triangle_mesh
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.mesh.courses import find_courses
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from tests.gallery import ROOT
from tests.shaping.surfaces import in_triangles, sheet

WIDTH = 1.0
CELL = 4.0
HEIGHT = 0.8
"""Of a stitch [cm]; 4 cells are 20 rows."""
FIELD = ROOT.parent / "shared" / "data" / "cases" / "field"
PIECES = {
    "T": "###### ###### ..##.. ..##..",
    "U": "##..## ##..## ###### ######",
    "steps": "#... ##.. ###. ####",
}


def knitted(drawing: str) -> sm.ShapedFabric:
    return sm.shape_fabric(sheet(drawing, CELL), stitch_width=WIDTH, stitch_height=HEIGHT, progress=False)


@pytest.mark.decides
@pytest.mark.parametrize("name", PIECES)
def test_a_row_beside_a_corner_is_one_row_begins_at_each_part_of_the_outline_below_and_its_loops_hold(name):
    shaped = knitted(PIECES[name])
    fabric = shaped.fabric
    # Squares of 4 cm are whole numbers of stitches and rows, and no stitch is an increase or a decrease.
    assert fabric.face_count == PIECES[name].count("#") * round(CELL / WIDTH) * round(CELL / HEIGHT)
    assert (fabric.n_bottom == 1).all() and (fabric.n_top == 1).all()
    # A slit beside the corner would be a side of length 0.
    assert fabric.side_length.min() > 0.5 * HEIGHT
    assert len(fabric.boundary_loops) == 1
    lines = PIECES[name].split()
    below = sum(
        sign == "#" and (row + 1 == len(lines) or lines[row + 1][place] == ".")
        for row, line in enumerate(lines) for place, sign in enumerate(line)
    )  # fmt: skip
    assert (fabric.stitch == sm.Stitch.CAST_ON).sum() == below * round(CELL / WIDTH)
    relaxed = sm.relax_mesh(fabric, surface=shaped.surface_mesh).fabric
    check_loops(relaxed, sm.generate_yarns(relaxed, quality="draft"))


@pytest.mark.decides
def test_limbs_between_holes_join_and_part_in_one_row():
    shaped = knitted("###### #..#.# #.##.# ######")
    assert len(shaped.fabric.boundary_loops) == len(shaped.surface.borders) and not shaped.report.lost
    relaxed = sm.relax_mesh(shaped.fabric, surface=shaped.surface_mesh).fabric
    check_loops(relaxed, sm.generate_yarns(relaxed, quality="draft"))


def test_a_disc_is_knitted_in_rounds():
    angle = np.linspace(0.0, 2.0 * np.pi, 36, endpoint=False)
    disc = sm.Mesh.from_polygons(10.0 * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1), [range(36)])
    fabric = sm.auto_stitches(in_triangles(disc), stitch_width=WIDTH)
    assert all(course.closed for course in find_courses(fabric))


def test_a_step_piece_of_a_bug_report_is_knitted_to_its_last_row():
    path = FIELD / "01-flat-step-piece.obj"
    if not path.exists():
        pytest.skip("the inputs of bug reports are not there")
    shaped = sm.shape_fabric(in_triangles(sm.read_mesh(path)), stitch_width=1.2, progress=False)
    area = 300.0  # 20 x 20 cm without a quarter [cm^2]
    # The outline takes whole numbers of stitches and rows: up to half a row and half a stitch at each of 4 sides.
    assert shaped.fabric.face_count == pytest.approx(area / (1.2 * 0.77 * 1.2), rel=0.07)
    relaxed = sm.relax_mesh(shaped.fabric, surface=shaped.surface_mesh).fabric
    assert np.isfinite(relaxed.vertices).all() and relaxed.side_length.min() > 0.2


Point = tuple[float, float]
EDGE = 1.5
"""Length of an edge of a triangle of a garment piece [cm]."""
CURVE_POINTS = 14
"""Points along a curve."""


def curve(start: Point, control: Point, end: Point) -> list[Point]:
    """Points of a quadratic curve."""
    t = np.linspace(0.0, 1.0, CURVE_POINTS)[:, None]
    points = (1.0 - t) ** 2 * np.array(start) + 2.0 * t * (1.0 - t) * np.array(control) + t**2 * np.array(end)
    return [(float(x), float(y)) for x, y in points]


LETTERS: dict[str, list[Point]] = {
    "L": [(0, 0), (30, 0), (30, 14), (12, 14), (12, 36), (0, 36)],
    "T": [(0, 0), (12, 0), (12, 20), (26, 20), (26, 32), (-14, 32), (-14, 20), (0, 20)],
    "U": [(0, 0), (32, 0), (32, 30), (21, 30), (21, 12), (11, 12), (11, 30), (0, 30)],
    "plus": [
        (10, 0), (22, 0), (22, 10), (32, 10), (32, 22), (22, 22), (22, 32), (10, 32), (10, 22), (0, 22),
        (0, 10), (10, 10),
    ],
    "steps": [(0, 0), (30, 0), (30, 10), (20, 10), (20, 20), (10, 20), (10, 30), (0, 30)],
}  # fmt: skip
"""Pieces whose sides are straight."""
BODY: list[Point] = [(0, 0), (46, 0), *curve((46, 30), (40, 31), (39, 40)), (38, 54), (30, 56)]
ARMHOLE: list[Point] = [(16, 56), (8, 54), *curve((7, 40), (6, 31), (0, 30))]
GARMENTS: dict[str, list[Point]] = {
    "vest front": [*BODY, (23, 36), *ARMHOLE],
    "vest back": [*BODY, *curve((30, 56), (23, 51), (16, 56))[1:-1], *ARMHOLE],
    "T-shirt front": [
        (0, 0), (48, 0), *curve((49, 38), (42, 44), (44, 58)), *curve((31, 62), (24, 46), (17, 62)),
        *curve((4, 58), (6, 44), (-1, 38)),
    ],
    "sleeve": [
        (6, 0), (30, 0), *curve((38, 30), (32, 32), (28, 38)), *curve((28, 38), (24, 44), (18, 44))[1:],
        *curve((18, 44), (12, 44), (8, 38))[1:], *curve((8, 38), (4, 32), (-2, 30))[1:],
    ],
    "trousers": [(4, 0), (24, 0), *curve((28, 50), (23, 52), (22, 60)), (21, 76), (0, 78), (0, 50)],
    "dress": [
        *curve((-30, 0), (0, -6), (30, 0)), (14, 50), *curve((20, 66), (14, 70), (15, 80)),
        *curve((9, 84), (0, 66), (-9, 84)), *curve((-15, 80), (-14, 70), (-20, 66)), (-14, 50),
    ],
}  # fmt: skip


def piece(outline: list[Point]) -> Mesh:
    """Triangles of a piece in the plane z = 0."""
    corners = np.array([*outline, outline[0]], dtype=np.float64)
    border = np.concatenate([divided(start, end) for start, end in pairwise(corners)])
    points, triangles = triangulated_outline(border, Outline(corners, closed=True).contains_points, EDGE)
    used, numbered = np.unique(triangles, return_inverse=True)
    return triangle_mesh(np.column_stack([points[used], np.zeros(len(used))]), numbered.reshape(-1, 3))


def divided(start: FloatArray, end: FloatArray) -> FloatArray:
    """Points along a side without its end, at most an edge apart, shape (n, 2)."""
    count = int(np.ceil(np.linalg.norm(end - start) / EDGE))
    return start + (end - start) * np.arange(count)[:, None] / count


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "width"), [*product(LETTERS, (0.8, 1.2, 1.6, 2.4)), *product(GARMENTS, (1.0, 1.4, 2.0, 2.8))]
)
def test_loops_of_letters_and_of_pieces_of_garments_hold(name, width):
    shaped = sm.shape_fabric(piece((LETTERS | GARMENTS)[name]), stitch_width=width, progress=False)
    fabric = sm.relax_mesh(shaped.fabric, surface=shaped.surface_mesh).fabric
    fabric = sm.make_room(fabric, quality="draft").fabric
    check_loops(fabric, sm.generate_yarns(fabric, quality="draft"))
