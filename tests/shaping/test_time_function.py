# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The time of a surface, its level lines, and the marks that change it."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.io.checked import check_table
from stitchmesh.recipe.sections import RowsSection
from stitchmesh.shaping.auto_stitches import shape_fabric
from stitchmesh.shaping.borders import is_slit, turning
from stitchmesh.shaping.ends import automatic_ends
from stitchmesh.shaping.level_lines import level_lines
from stitchmesh.shaping.marks import TimeMark, marked_ends
from stitchmesh.shaping.options import ShapingOptions
from stitchmesh.shaping.time_function import knitting_time, smooth_out, summits
from stitchmesh.shaping.triangle_surface import triangle_surface, without_fine_features
from tests.gallery import ROOT, grid, tube
from tests.shaping.surfaces import closed_ball, in_triangles, surface_of

UP = np.array([0.0, 1.0, 0.0])


def test_dividing_edges_keeps_the_area_and_the_borders():
    mesh = in_triangles(tube(12, 3, radius=3.0))
    fine = triangle_surface(mesh, 0.4)
    edges = fine.vertices[fine.edges]
    assert np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1).max() <= 0.4
    # Sums over a few thousand triangles; each has a relative rounding error near 1e-16.
    assert fine.area.sum() == pytest.approx(surface_of(mesh).area.sum(), rel=1e-12)
    assert len(fine.borders) == 2


def test_gradients_of_linear_functions_are_exact():
    surface = surface_of(in_triangles(grid(5, 4)))
    gradient = surface.gradient(surface.vertices @ [2.0, -3.0, 0.0])
    np.testing.assert_allclose(gradient, np.broadcast_to([2.0, -3.0, 0.0], gradient.shape), atol=1e-12)
    # A constant has no gradient, so that each row of the stiffness matrix sums to zero.
    assert np.abs(surface.stiffness().sum(axis=1)).max() < 1e-12


def test_the_turning_of_borders_tells_tubes_from_flat_pieces():
    around = turning(surface_of(grid(4, 4)), surface_of(grid(4, 4)).borders[0])
    assert around == pytest.approx(2 * np.pi)  # The theorem of Gauss and Bonnet on a flat disc.
    ends = surface_of(tube(24, 5))
    assert [turning(ends, border) for border in ends.borders] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert not any(is_slit(ends, border) for border in ends.borders)


def test_the_time_of_a_tube_is_its_height():
    surface = triangle_surface(in_triangles(tube(24, 8, radius=3.0)), 1.0)
    time, ends = knitting_time(surface, automatic_ends(surface, UP), 0.5)
    # The weight of steep places has half its height at the slope 1, which leaves a part in a thousand of a course.
    np.testing.assert_allclose(time - time.min(), surface.vertices[:, 1] / 0.5, atol=1e-3)
    assert not ends.begins  # Knitting ends at the upper border.


def test_level_lines_run_with_later_rows_on_their_left():
    surface = triangle_surface(in_triangles(tube(24, 8, radius=3.0)), 1.0)
    time, ends = knitting_time(surface, automatic_ends(surface, UP), 0.5)
    levels = level_lines(surface, time, ends)
    assert len(levels.lines) == 17 and all(line.closed for line in levels.lines)
    for line in levels.lines:
        step = np.roll(line.points, -1, axis=0) - line.points
        outward = line.points * [1.0, 0.0, 1.0]
        assert np.cross(outward, step)[:, 1].sum() > 0.0
    assert all(len(band.below) <= 1 and len(band.above) <= 1 for band in levels.bands)


def test_summits_are_found_with_their_heights_and_smoothed_out():
    surface = surface_of(in_triangles(grid(20, 20, width=0.5, height=0.5)))
    x, y = surface.vertices[:, 0], surface.vertices[:, 1]
    bumps = y + 3.0 * np.exp(-((x - 5.0) ** 2 + (y - 5.0) ** 2))
    found = summits(surface, bumps)
    lasting = [height for _, height, _ in found if height > 0.5]
    assert len(lasting) == 2 and max(lasting) == np.inf
    ends = automatic_ends(surface, UP)
    smooth = smooth_out(surface, bumps, 2.0, ends)
    assert [height for _, height, _ in summits(surface, smooth) if 1e-9 < height < np.inf] == []


def test_a_fabric_spans_dents_finer_than_a_stitch_and_keeps_borders():
    surface = surface_of(in_triangles(grid(20, 20, width=0.25, height=0.25)))
    dented = surface.vertices.copy()
    dented[10 * 21 + 10, 2] = -1.0
    depths = []
    for size in (0.2, 0.5, 1.0, 2.0):
        flat = without_fine_features(type(surface)(dented, surface.triangles), size)
        border = np.concatenate(surface.borders)
        np.testing.assert_array_equal(flat.vertices[border], surface.vertices[border])
        depths.append(float(-flat.vertices[:, 2].min()))
    # Diffusion over a longer time leaves less of a dent, whose width is an edge of 0.25 cm.
    assert depths == sorted(depths, reverse=True) and depths[0] < 1.0 and depths[-1] < 0.2


def test_a_mark_turns_the_direction_of_knitting():
    mesh = in_triangles(tube(24, 6, radius=3.0))
    upper = TimeMark("border", [[0.0, 6.0, 3.0]], "begin")
    fabric = shape_fabric(mesh, stitch_width=0.7, options=ShapingOptions(marks=[upper])).fabric
    first = fabric.row == fabric.row.min()
    assert fabric.vertices[fabric.face_vertex[fabric.face_start[:-1][first]], 1].min() == pytest.approx(6.0)


def test_a_row_runs_along_a_stroke():
    mesh = in_triangles(tube(36, 12, radius=3.0, height=0.5))
    surface = triangle_surface(mesh, 0.7)
    angle = np.linspace(0.2, 2.0, 9)
    tilted = np.stack([3 * np.sin(angle), 2.0 + angle, 3 * np.cos(angle)], axis=1)
    ends = marked_ends(surface, [TimeMark("stroke", tilted.tolist(), "row")], UP)
    time, ends = knitting_time(surface, ends, 0.5)
    assert np.ptp(time[ends.lines[0].vertices]) < 1e-9


def test_a_side_is_a_border_at_which_rows_end():
    mesh = in_triangles(tube(24, 6, radius=3.0))
    side = TimeMark("border", [[0.0, 6.0, 3.0]], "side")
    ends = marked_ends(triangle_surface(mesh, 1.0), [side], UP)
    assert len(ends.all) == 1 and ends.all[0].vertices.size


@pytest.mark.parametrize(
    ("marks", "words"),
    [
        ([TimeMark("border", [[0, 0, 3]], "side"), TimeMark("border", [[0, 6, 3]], "side")], "begins or ends"),
        ([TimeMark("point", [[50.0, 0.0, 0.0]], "end")], "off"),
        ([TimeMark("border", [[0, 0, 3]], "begin"), TimeMark("border", [[0, 0, -3]], "end")], "meet"),
        ([TimeMark("border", [[0, 0, 3]], "begin", 5.0), TimeMark("border", [[0, 6, 3]], "end", 1.0)], "exchange"),
    ],
)
def test_marks_that_contradict_each_other_are_refused(marks, words):
    with pytest.raises(ParameterError, match=words):
        shape_fabric(in_triangles(tube(24, 6, radius=3.0)), stitch_width=0.7, options=ShapingOptions(marks=marks))


@pytest.mark.parametrize(
    "record",
    [
        {"kind": "line", "points": [[0, 0, 0]]},
        {"kind": "point", "points": [[0, float("nan"), 0]]},
        {"kind": "stroke", "points": [[0, 0, 0]], "role": "side"},
        {"kind": "point", "points": [[0, 0, 0]], "role": "plain", "radius": -1},
        {"kind": "point", "points": [[0, 0, 0]], "time": float("inf")},
    ],
)
def test_records_that_are_no_marks_are_refused(record):
    with pytest.raises(ParameterError, match="marks"):
        check_table({"auto": True, "marks": [record]}, RowsSection)


def test_borders_of_a_closed_surface_cannot_be_marked():
    surface = surface_of(closed_ball(12, 8))
    with pytest.raises(ParameterError, match="closed"):
        marked_ends(surface, [TimeMark("border", [[0, 0, 0]], "begin")], UP)


def test_slits_of_garments_are_sides():
    import stitchmesh as sm

    surface = triangle_surface(sm.read_mesh(ROOT / "assets" / "meshes" / "tea_cozy.obj"), 1.5)
    assert sorted(is_slit(surface, border) for border in surface.borders) == [False, False, True, True]
