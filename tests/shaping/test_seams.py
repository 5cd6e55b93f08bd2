# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Increases and decreases that are stacked at seams: where they stand, in which rows, and when they are spread."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.hand_knitting import parse_instructions, written_pieces
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.selection.parts import face_centres
from stitchmesh.shaping.counts import SLACK, StitchSize, exact_counts
from stitchmesh.shaping.level_lines import Band, LevelLine, LevelLines
from stitchmesh.shaping.seams import NARROWEST_GORE, Gore, seam_plan, stacked_wales, steady_counts
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from tests.gallery import ROOT, grid, tube
from tests.hand_knitting.test_instructions import Comparison
from tests.shaping.surfaces import in_triangles, tube_with_holes

WIDTH = 0.8
SPREAD, SEAMS = sm.ShapingOptions(shaping="spread"), sm.ShapingOptions(shaping="seams")


def frustum(top: float, *, squeezed: float = 1.0) -> Mesh:
    """A frustum 20 cm high whose lower radius is 12 cm, and whose depth is a part of its width."""
    mesh = tube(48, 20, radius=12.0, top_radius=top)
    return in_triangles(replace(mesh, vertices=mesh.vertices * [1.0, 1.0, squeezed]))


def trapezoid(top: float) -> Mesh:
    """A flat piece 20 cm high and 30 cm wide below."""
    mesh = grid(20, 20)
    x, y = mesh.vertices[:, 0] / np.ptp(mesh.vertices[:, 0]), mesh.vertices[:, 1] / np.ptp(mesh.vertices[:, 1])
    wide = 30.0 + (top - 30.0) * y
    points = np.stack([(x - 0.5) * wide, 20.0 * y, 0.0 * y], axis=1)
    return in_triangles(replace(mesh, vertices=points))


def places_of(fabric: StitchMesh, more: bool) -> np.ndarray:
    """Centres of the increases, or of the decreases [cm]."""
    found = fabric.n_top > fabric.n_bottom if more else fabric.n_top < fabric.n_bottom
    return face_centres(fabric, np.flatnonzero(found))


def stitches_of_rows(fabric: StitchMesh) -> np.ndarray:
    """Loops on top of each row."""
    return np.bincount(fabric.row, fabric.n_top).astype(int)


@pytest.mark.decides
@pytest.mark.parametrize("top", [9.0, 13.5])
def test_the_shaping_of_a_frustum_is_stacked_at_its_two_sides(top):
    shaped = sm.shape_fabric(frustum(top), stitch_width=WIDTH, options=SEAMS)
    assert shaped.report.stacked_rows > 2 and shaped.report.spread_rows == 0
    place = places_of(shaped.fabric, more=top > 12.0)
    # At each side stand the seam's plain stitch and the middle of a decrease of two loops, or of an increase whose
    # plain loop is that stitch: 2 or 1 stitch widths from the seam. The seam is at a stitch and moves by half of one.
    away = np.linalg.norm(np.stack([np.abs(place[:, 0]) - _half_width(top, place[:, 1]), place[:, 2]], axis=1), axis=1)
    assert away.max() < 3.0 * WIDTH
    assert len(place) == 4 * shaped.report.stacked_rows


def _half_width(top: float, height: np.ndarray) -> np.ndarray:
    return 12.0 + (top - 12.0) * height / 20.0


def test_rows_have_the_stitches_that_fit_within_a_change():
    mesh = frustum(9.0)
    spread, seams = (sm.auto_stitches(mesh, stitch_width=WIDTH, options=options) for options in (SPREAD, SEAMS))
    counts = [stitches_of_rows(fabric) for fabric in (spread, seams)]
    assert len(counts[0]) == len(counts[1])
    # Two seams change a round by four stitches, which may be SLACK of four too many; spread ones SLACK of one, and
    # both begin with the nearest whole number.
    assert np.abs(counts[1] - counts[0]).max() <= SLACK * (4 + 1) + 0.5


@pytest.mark.decides
def test_left_and_right_mirror_each_other():
    """A mesh that mirrors itself has as many stitches on both sides, and decreases that lean towards each other."""
    fabric = sm.auto_stitches(frustum(9.0, squeezed=0.6), stitch_width=WIDTH, options=SEAMS)
    place, found = places_of(fabric, more=False), np.flatnonzero(fabric.n_top < fabric.n_bottom)
    for row in np.unique(fabric.row[found]):
        inside = fabric.row[found] == row
        sides = np.sign(place[inside][:, 0]), np.sign(place[inside][:, 2])
        assert sorted(zip(*sides, strict=True)) == [(-1, -1), (-1, 1), (1, -1), (1, 1)]
        stitch = fabric.stitch[found[inside]]
        # In front, at z > 0, left is -x as for a wearer seen from there; behind it is the other way around.
        left = sides[0] * sides[1] < 0
        assert (stitch[left] == Stitch.D12K).all() and (stitch[~left] == Stitch.D21K).all()


@pytest.mark.parametrize("top", [18.0, 36.0])
def test_a_flat_piece_is_shaped_at_both_edges_in_rows_on_the_right_side(top):
    fabric = sm.auto_stitches(trapezoid(top), stitch_width=WIDTH, options=SEAMS)
    place = places_of(fabric, more=top > 30.0)
    edge = 15.0 + (0.5 * top - 15.0) * place[:, 1] / 20.0
    at_edge = np.abs(edge - np.abs(place[:, 0])) < 2.5 * WIDTH
    # The last row below the bound-off edge has the stitches of this edge, whatever their number.
    assert at_edge.sum() >= len(place) - 1 and at_edge.sum() > 6
    changed = fabric.n_top > fabric.n_bottom if top > 30.0 else fabric.n_top < fabric.n_bottom
    rows = fabric.row[changed][at_edge]
    assert (np.bincount(rows)[np.unique(rows)] == 2).all() and (rows % 2 == 1).all()
    text = sm.knitting_instructions(fabric, charts=False)
    words = "k1, ssk, k to last 3, k2tog, k1" if top < 30.0 else "k1, m1l, k to last 1, m1r, k1"
    assert f" 1 st at each side every 4th row, 7 times: {words}; work the other rows plain." in text or top > 30.0
    assert words in text
    Comparison(fabric).check()


@pytest.mark.nightly
def test_a_sweater_has_raglan_lines_and_sleeves_with_an_underarm_seam():
    """A knitter who follows the text, with its markers, makes the stitches of the mesh from the same loops."""
    mesh = in_triangles(sm.read_mesh(ROOT / "assets" / "meshes" / "sweater.obj"))
    shaped = sm.shape_fabric(mesh, stitch_width=1.2, options=SEAMS)
    fabric = shaped.fabric
    assert shaped.report.lost is None and shaped.report.stacked_rows > 15
    text = sm.knitting_instructions(fabric, charts=False)
    assert parse_instructions(text) == written_pieces(fabric)
    Comparison(fabric).check()
    sleeves = [line for line in text.splitlines() if "increase 1 st at each side every" in line]
    yoke = [line for line in text.splitlines() if "k to 3 before marker" in line]
    assert len(sleeves) >= 2 and len(yoke) >= 1


def test_loops_hold_at_seams():
    fabric = sm.auto_stitches(frustum(9.0), stitch_width=1.2, options=SEAMS)
    assert len(places_of(fabric, more=False))
    check_loops(fabric, sm.generate_yarns(fabric, quality="draft"))


def test_what_seams_do_not_hold_is_spread_and_told(caplog):
    with caplog.at_level(logging.WARNING):
        shaped = sm.shape_fabric(frustum(2.0), stitch_width=2.0 * WIDTH, options=SEAMS)
    assert shaped.report.spread_rows > 0
    assert f"shaping: spread in {shaped.report.spread_rows} of the " in caplog.text


def test_rounds_of_whole_repeats_are_spread_and_told(caplog):
    with caplog.at_level(logging.WARNING):
        one, other = (
            sm.auto_stitches(frustum(9.0), stitch_width=2.0 * WIDTH, options=replace(options, multiple=4))
            for options in (SPREAD, SEAMS)
        )
    np.testing.assert_array_equal(one.stitch, other.stitch)
    assert "shaping: spread, because rounds of a multiple of 4 change by as many stitches at once" in caplog.text


def test_shaping_keeps_away_from_plain_places():
    side = sm.TimeMark("stroke", [[12.0, 0.0, 0.0], [9.0, 20.0, 0.0]], "plain", radius=3.0)
    fabric = sm.auto_stitches(frustum(9.0), stitch_width=WIDTH, options=replace(SEAMS, marks=[side]))
    place = places_of(fabric, more=False)
    line = np.stack([_half_width(9.0, place[:, 1]), place[:, 1], 0.0 * place[:, 1]], axis=1)
    # The middle of a stitch whose vertices are all outside may lie half a stitch inside.
    assert np.linalg.norm(place - line, axis=1).min() > 3.0 - 0.5 * WIDTH


def test_a_slit_below_a_narrow_tube_passes_no_seams_on():
    """The open rows beside the slit have their seams at its sides; the rounds above it are too narrow for seams."""
    mesh = tube_with_holes("############ ############ ############ #####..##### #####..##### #####..#####", 2.0)
    shaped = sm.shape_fabric(mesh, stitch_width=WIDTH, options=SEAMS)
    assert shaped.report.stacked_rows == 0 and shaped.report.lost is None


def test_gores_have_mirrored_ends():
    wales, left = stacked_wales([Gore(9, -1, -1), Gore(8, 1, 1), Gore(10)])
    loops, made = np.diff(wales.below).tolist(), np.diff(wales.above).tolist()
    assert loops == [1, 2, 1, 1, 1, 2, 1, *[1] * 8, *[1] * 10]
    assert made == [1] * 7 + [2, *[1] * 6, 2] + [1] * 10
    assert left.tolist()[:7] == [True] * 4 + [False] * 3
    assert not Gore(NARROWEST_GORE - 1, -1, -1).possible and Gore(1).possible


@pytest.mark.parametrize(("step", "slope"), [(1, 0.333), (2, -0.25), (4, 0.11), (8, -0.5)])
def test_steady_numbers_follow_the_exact_ones_in_one_rhythm(step, slope):
    exact = slope * step * np.arange(60)
    counts = steady_counts(exact, step)
    # A step more than the slack: a rhythm may begin up to a row before or after the best place.
    assert np.abs(counts - exact).max() <= SLACK * step + abs(slope) * step
    places = np.flatnonzero(np.diff(counts))
    assert set(np.abs(np.diff(counts)[places])) == {step}
    distances = np.diff(places)
    # A rhythm changes at most once while it stays within the slack, by one row.
    assert np.ptp(distances) <= 1 and np.count_nonzero(np.diff(distances)) <= 2


def test_numbers_to_and_fro_change_at_even_places():
    counts = steady_counts(np.linspace(0.0, -9.0, 47), 1, to_and_fro=True)
    assert (np.flatnonzero(np.diff(counts)) % 2 == 1).all()


def test_seams_of_limbs_are_where_they_meet():
    """Two sleeves beside a body: a seam for each sleeve, two for the body, and four above, between their parts."""
    lines = [_ring((x, 0.0), radius) for x, radius in ((-16.0, 5.0), (0.0, 10.0), (16.0, 5.0))]
    whole = LevelLine(1, np.array([[-22.0, 1.0, 0.0], [-22.0, 1.0, 6.0], [22.0, 1.0, 6.0], [22.0, 1.0, 0.0],
                                   [22.0, 1.0, -6.0], [-22.0, 1.0, -6.0]])[::-1], closed=True)  # fmt: skip
    top = replace(whole, level=2)
    bands = (Band([], [0]), Band([], [1]), Band([], [2]), Band([0, 1, 2], [3]), Band([3], [4]), Band([4], []))
    levels = LevelLines((*lines, whole, top), bands, frozenset())
    size = StitchSize(0.8, 0.6)
    starts = seam_plan(levels, exact_counts(levels, size), size).starts
    assert np.abs(np.abs(starts[3][:, 0]) - 10.5).max() < 2.0 and len(starts[3]) == 4


def _ring(centre: tuple[float, float], radius: float) -> LevelLine:
    angle = -2.0 * np.pi * np.arange(40) / 40
    x, z = centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)
    return LevelLine(0, np.stack([x, 0.0 * x, z], axis=1), closed=True)
