# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows with too few or too many stitches are found and named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import UNKNOWN_STRETCH
from stitchmesh.meshrelax import MeshRelaxOptions, relax_mesh
from stitchmesh.meshrelax.evenness import ALLOWED_RATIO, evenness_verdict, relative_sizes, uneven_rows
from tests.meshrelax.fabrics import grid_fabric, rectangle_points

ROWS, STITCHES = 10, 20


def with_stretch(width: dict[int, float], height: dict[int, float] | None = None) -> StitchMesh:
    """A fabric of square stitches, some of whose rows are as wide or as high as given; all others are of size 1."""
    fabric = grid_fabric(rectangle_points(STITCHES, ROWS, 20.0, 10.0))
    stretch = np.ones(len(fabric.edge_side))
    for sides, sizes in ((~fabric.is_wale, width), (fabric.is_wale, height or {})):
        for row, size in sizes.items():
            stretch[fabric.side_edge[sides & (fabric.row[fabric.side_face] == row)]] = size
    return replace(fabric, stretch=stretch)


def test_even_stitches_have_no_findings_and_all_are_said_to_be_average():
    fabric = with_stretch({})
    assert uneven_rows(fabric) == []
    verdict = evenness_verdict(fabric)
    assert verdict.good and verdict.praise.startswith("100 % of the sides")


def test_a_scale_of_the_whole_fabric_changes_nothing():
    fabric = with_stretch({4: 1.6, 5: 1.6})
    assert uneven_rows(replace(fabric, stretch=3.0 * fabric.stretch)) == pytest.approx(uneven_rows(fabric))


def test_wide_rows_have_too_few_stitches():
    (band,) = uneven_rows(with_stretch({4: 2.0, 5: 2.0}))
    # the rows beside them share an edge with them, so their mean is (1 + 2) / 2; it exceeds the allowed ratio too
    assert (band.first, band.last, band.direction) == (3, 6, "width") and band.ratio > ALLOWED_RATIO
    assert band.stitches == STITCHES and band.missing == round(STITCHES * (band.ratio - 1.0)) > 0
    finding = band.finding()
    assert finding.kind == "too few stitches" and "rows 3 to 6" in finding.text
    assert finding.remedy.startswith("add about") and "in each" in finding.remedy
    assert evenness_verdict(with_stretch({1: 0.4, 2: 0.4, 7: 1.5, 8: 1.5})).findings[0].kind == "too many stitches"


def test_high_rows_stand_where_there_are_too_few_rows_and_low_ones_where_there_are_too_many():
    high, low = uneven_rows(with_stretch({}, {2: 1.9, 7: 0.6}))
    assert (high.first, high.last, high.direction, high.missing) == (2, 2, "height", 1)
    assert (low.first, low.last, low.direction, low.missing) == (7, 7, "height", -1)
    assert high.finding().kind == "too few rows" and low.finding().kind == "too many rows"
    assert "row 7 is crowded" in low.finding().text and low.finding().remedy == "leave out about 1 row"


def test_edges_of_unknown_stretch_do_not_count():
    fabric = with_stretch({4: 1.6, 5: 1.6})
    stretch = fabric.stretch.copy()
    stretch[fabric.side_edge[fabric.is_wale & (fabric.row[fabric.side_face] == 0)]] = UNKNOWN_STRETCH
    assert uneven_rows(replace(fabric, stretch=stretch)) == uneven_rows(fabric)
    assert np.isfinite(float(evenness_verdict(replace(fabric, stretch=stretch)).praise.split(" ")[0]))


def test_the_size_of_a_stitch_is_the_mean_of_its_sides():
    fabric = with_stretch(dict.fromkeys(range(ROWS), 2.0))  # all course sides are twice as long as at rest
    unit = np.sqrt(2.0)
    np.testing.assert_allclose(relative_sizes(fabric, "width"), 2.0 / unit)
    np.testing.assert_allclose(relative_sizes(fabric, "height"), 1.0 / unit)
    np.testing.assert_allclose(relative_sizes(fabric), 1.5 / unit)


def test_a_relaxed_rectangle_is_even():
    fabric = grid_fabric(rectangle_points(12, 8, 6.0, 4.0))
    surface = grid_fabric(rectangle_points(3, 2, 6.0, 4.0))
    relaxed = relax_mesh(fabric, surface=surface, options=MeshRelaxOptions(aspect=1.0)).fabric
    assert evenness_verdict(relaxed).good


def test_a_fabric_that_was_not_relaxed_is_refused():
    with pytest.raises(ParameterError, match="stretch: the stitch mesh has none; relax the mesh first"):
        evenness_verdict(grid_fabric(rectangle_points(3, 2, 6.0, 4.0)))
