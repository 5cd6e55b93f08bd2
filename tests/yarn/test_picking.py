# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A ray meets the nearest yarn on its surface; lengths are measured along the yarn."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.picking import length_between, pick_yarn, yarn_picking_table
from tests.io.yarn_sets import ring
from tests.yarn.test_strand_distance import lines


def test_a_ray_meets_the_surface_of_the_nearest_yarn():
    yarns = lines(0.0, 1.0)
    found = pick_yarn(yarn_picking_table(yarns), [2.0, 5.0, 0.0], [0.0, -3.0, 0.0])
    assert found is not None and found.yarn == 1
    np.testing.assert_allclose(found.point, [2.0, 1.1, 0.0], atol=1e-12)
    assert found.depth == pytest.approx(3.9, abs=1e-12)


def test_a_ray_that_misses_finds_nothing():
    table = yarn_picking_table(lines(0.0))
    assert pick_yarn(table, [2.0, 5.0, 0.11], [0.0, -1.0, 0.0]) is None
    assert pick_yarn(table, [2.0, 5.0, 0.09], [0.0, -1.0, 0.0]) is not None
    assert pick_yarn(table, [2.0, 5.0, 0.0], [0.0, 1.0, 0.0]) is None  # the yarn is behind


def test_the_length_between_two_places_follows_the_yarn():
    yarns = lines(0.0)
    table = yarn_picking_table(yarns)
    first, second = (pick_yarn(table, [x, 1.0, 0.0], [0.0, -1.0, 0.0]) for x in (1.0, 3.0))
    assert first is not None and second is not None
    assert length_between(yarns, first, second) == pytest.approx(2.0, rel=1e-9)  # the control points are evenly spaced


def test_a_ring_is_measured_the_shorter_way():
    yarns = YarnSet.from_curves([ring([0, 0, 0])], closed=[True], radius=0.05)
    table = yarn_picking_table(yarns)
    first, second = (
        pick_yarn(table, [3 * np.cos(a), 3 * np.sin(a), 0], [-np.cos(a), -np.sin(a), 0]) for a in (0.05, -0.35)
    )
    assert first is not None and second is not None
    # an arc of 0.4 rad of radius 1, less 0.4 % because the spline lies inside its control points
    assert length_between(yarns, first, second) == pytest.approx(0.4, rel=0.01)


def test_two_yarns_have_no_length_between_them():
    yarns = lines(0.0, 1.0)
    table = yarn_picking_table(yarns)
    first, second = (pick_yarn(table, [1.0, y, 1.0], [0.0, 0.0, -1.0]) for y in (0.0, 1.0))
    assert first is not None and second is not None and length_between(yarns, first, second) is None
