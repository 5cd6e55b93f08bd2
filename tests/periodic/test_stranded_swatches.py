# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stranded charts as swatches: they come to rest, with loops as long as in one colour, or a float is too long."""

from __future__ import annotations

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import Cell, Pattern, Row
from stitchmesh.periodic.repeat.drawn_swatch import LOOP_OVER_WIDTH, draw_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch_options import LONGEST_FLOAT, SwatchOptions
from stitchmesh.quality import quality_named
from stitchmesh.reporting.verdict import relaxation_verdict
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import carried_segments, segment_faces
from stitchmesh.yarn.yarn_set import basis
from tests.nightly import at_night, mostly_at_night
from tests.periodic.free_cells import FREE

DRAFT = {"quality": "draft", "device": "cpu"}
CHARTS = {
    "peerie": "peerie",
    "checks": "checks",
    "standing columns of two": "0011/0011",
    "standing columns of one": "0001/0001",
    "a lone pixel": "0000/0000/0000/0001",
    "three colours": "012/120/201",
    "the longest float": "0" * LONGEST_FLOAT + "1",
}


def chart(text: str) -> Pattern:
    """Return a chart of yarn numbers, the upper row first, or the pattern of a name."""
    if not text[0].isdigit():
        return resolve_pattern(text)
    rows = (Row(tuple(Cell(Stitch.KNIT, yarn=int(yarn)) for yarn in row)) for row in reversed(text.split("/")))
    return Pattern("chart", "", tuple(rows))


def check_rest(name, **options):
    report = sm.swatch(chart(CHARTS[name]), **options, **DRAFT).report
    assert report["converged"] and report["pull_throughs"] == 0
    # Yarns that touch are 2 radii apart. At the default loop length the yarn is loose, and little force presses it.
    assert report["min_distance_over_radius"] > 1.5
    # The yarn of each loop and of each float is as long as its way through the fabric; nothing has to stretch.
    assert report["max_strain"] < 0.01


@pytest.mark.usefixtures("first_state")
@pytest.mark.parametrize("name", mostly_at_night(CHARTS, by_day=("three colours", "the longest float")))
def test_a_stranded_chart_of_held_size_comes_to_rest(name):
    check_rest(name, relax_cell=False)


@pytest.mark.nightly
@pytest.mark.usefixtures("first_state")
@pytest.mark.parametrize("name", CHARTS)
def test_a_stranded_chart_comes_to_rest_off_the_needles(name):
    check_rest(name, relax_cell=True)


@pytest.mark.parametrize("name", at_night("standing columns of two", "three colours"))
def test_the_lowest_state_of_a_stranded_chart_is_at_rest_too(name):
    check_rest(name, **FREE)


def test_standing_columns_come_to_rest_at_standard():
    assert sm.swatch(chart("0001/0001"), quality="standard", device="cpu").report["converged"]


@pytest.mark.parametrize("name", CHARTS)
def test_every_loop_has_the_loop_length_beside_its_float(name):
    _fabric, yarns = draw_swatch(chart(CHARTS[name]), SwatchOptions(loop_length=4.0), quality_named("draft"))
    carried, face = carried_segments(yarns), segment_faces(yarns)
    # A head has the rest length of its own face here, because all stitches are plain.
    loops = np.bincount(face[~carried], yarns.rest_length[~carried])
    np.testing.assert_allclose(loops, 4.0, rtol=1e-12)  # rounding of a sum
    # The rest length of a float is its drawn length at the loop length that was drawn, about 1 % apart. Floats of three
    # yarns, here over two stitches, are drawn three radii further behind, which makes them longer by 0.75 cm of 3.2 cm,
    # less what a slanted way saves; at rest they are no longer for it.
    least, most = (0.76, 0.9) if name == "three colours" else (0.95, 1.05)
    assert least < yarns.rest_length[carried].sum() / yarns.lengths[carried].sum() < most


def shown(yarns: YarnSet, pixels: int = 6, per_segment: int = 16) -> np.ndarray:
    """The area that the loop of each stitch shows from the front, over the area of a stitch, by a map of depths."""
    weights = basis(np.arange(per_segment) / per_segment)
    corners = yarns.points[yarns.segment_points] + yarns.point_shift
    points = np.einsum("kj,sjd->skd", weights, corners).reshape(-1, 3)
    face = np.repeat(np.where(carried_segments(yarns), -1, segment_faces(yarns)), per_segment)
    radius, size = float(yarns.radius[0]), np.linalg.norm(yarns.lattice.periods, axis=1)
    shape = np.round(size * pixels / radius).astype(int)
    place = np.floor(points[:, :2] / size * shape).astype(int)
    depth, seen = np.full(shape, -np.inf), np.full(shape, -1)
    for offset in np.argwhere(np.ones((2 * pixels + 1, 2 * pixels + 1))) - pixels:
        beside = radius**2 - ((offset * radius / pixels) ** 2).sum()
        if beside >= 0.0:
            column, row = ((place + offset) % shape).T
            height = points[:, 2] + np.sqrt(beside)
            order = np.argsort(height)  # the highest is written last
            order = order[height[order] > depth[column[order], row[order]]]
            depth[column[order], row[order]], seen[column[order], row[order]] = height[order], face[order]
    count = int(face.max()) + 1
    return np.bincount(seen[seen >= 0], minlength=count) * count / seen.size


@pytest.mark.usefixtures("first_state")
@pytest.mark.parametrize("text", ["012/120/201", *at_night("001122/011220/112200/122001")])
def test_each_stitch_of_three_colours_shows_its_colour_on_the_front(text):
    swatch = sm.swatch(chart(text), **DRAFT)
    assert swatch.report["converged"]
    # The loops of drawn charts and of relaxed ones in two colours show 0.84 and more; heads of other loops hide the
    # rest. With slack floats single loops showed 0.56.
    assert shown(swatch.yarns).min() > 0.75


@pytest.mark.usefixtures("first_state")
def test_a_held_width_keeps_three_colours_from_drawing_together():
    """This is what the verdict on a free repeat advises."""
    width = 3 * SwatchOptions().plain_loop / LOOP_OVER_WIDTH
    report = sm.swatch(chart(CHARTS["three colours"]), **FREE, period=(width, None), **DRAFT).report
    assert relaxation_verdict(report).good


def test_a_float_that_is_too_long_is_refused_with_its_place():
    longest = "0" * 9 + "1"
    expected = (
        r"row 1, stitch 10 from the left: yarn 1 floats behind 9 stitches \(9\.2 cm\); at most 7 are allowed; work a "
        r"stitch of this yarn among them, or raise longest_float \(--longest-float\)"
    )
    with pytest.raises(PatternError, match=expected):
        sm.swatch(chart("0" * 10 + "/" + longest), **DRAFT)
    allowed = sm.swatch(chart(longest), longest_float=9, **DRAFT)
    assert allowed.report["wales"] == 10 and allowed.report["certificate"] == "unchanged"
    with pytest.raises(PatternError, match="floats behind 3 stitches"):
        sm.swatch(chart("0001/0001"), longest_float=2, **DRAFT)
    with pytest.raises(ParameterError, match="longest float: got -1; expected 0 or more stitches"):
        SwatchOptions(longest_float=-1)


def test_the_longest_float_counts_across_the_border_of_the_cell():
    """Two stitches of yarn 1 that are 5 apart in the chart are 6 apart across its border."""
    text = "1" + "0" * 5 + "1" + "0" * 6
    with pytest.raises(PatternError, match="floats behind 6 stitches"):
        sm.swatch(chart(text), longest_float=5, **DRAFT)
