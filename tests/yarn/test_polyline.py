# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polylines of segments agree with the sampled yarns, and their points store the right segment and control point."""

from __future__ import annotations

import numpy as np

from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.polyline import polylines_of_segments


def yarns() -> YarnSet:
    rng = np.random.default_rng(5)
    return YarnSet.from_curves([rng.random((n, 3)) for n in (7, 9, 5)], closed=[True, False, True], radius=0.1)


def test_curves_of_all_segments_are_the_sampled_yarns():
    curves = polylines_of_segments(yarns(), np.arange(7 + 6 + 5), 3)
    assert curves.closed == [True, False, True]
    for mine, sampled in zip(curves.points, yarns().sampled(3), strict=True):
        np.testing.assert_allclose(mine, sampled, atol=1e-15)  # The sums are the same, in another order.
    np.testing.assert_array_equal(yarns().row[curves.control_point], np.repeat([0, 1, 2], [21, 19, 15]))
    # A segment starts near its second control point and ends near its third.
    np.testing.assert_array_equal(curves.control_point[:5], [1, 1, 2, 2, 2])


def test_points_store_their_segments_including_the_end_of_an_open_yarn():
    curves = polylines_of_segments(yarns(), np.arange(7 + 6 + 5), 3)
    expected = [*np.repeat(np.arange(13), 3), 12, *np.repeat(np.arange(13, 18), 3)]
    np.testing.assert_array_equal(curves.segment, expected)


def test_a_run_of_segments_becomes_an_open_curve():
    curves = polylines_of_segments(yarns(), np.array([1, 2, 6, 7, 8, 17]), 2)
    assert [len(points) for points in curves.points] == [5, 3, 5, 3]
    assert curves.closed == [False] * 4
    assert curves.yarn.tolist() == [0, 0, 1, 2]
    whole = np.concatenate([yarns().sampled(2)[0]] * 2)
    np.testing.assert_allclose(curves.points[0], whole[2:7], atol=1e-15)
    np.testing.assert_allclose(curves.points[1], whole[12:15], atol=1e-15)
