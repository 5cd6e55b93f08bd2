# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The number of stitches of each course: steps that rows can take, and the chosen part of increases and decreases."""

from __future__ import annotations

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.shaping.counts import StitchSize, count_beside, exact_counts
from stitchmesh.shaping.level_lines import Band, LevelLine, LevelLines
from tests.shaping.surfaces import closed_ball


def ring(length: float, level: int = 0) -> LevelLine:
    """A round of a given length [cm]."""
    angle = 2 * np.pi * np.arange(400) / 400
    radius = length / (800 * np.sin(np.pi / 400))
    return LevelLine(level, np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1), True)


def stacked(*lengths: float) -> LevelLines:
    """Rounds above each other."""
    bands = [Band([], [0]), *(Band([k], [k + 1]) for k in range(len(lengths) - 1)), Band([len(lengths) - 1], [])]
    return LevelLines(tuple(ring(length, k) for k, length in enumerate(lengths)), tuple(bands), frozenset())


def test_counts_that_fit_are_the_exact_ones():
    lengths = [20.0, 22.0, 21.0, 15.0]
    np.testing.assert_allclose(exact_counts(stacked(*lengths), StitchSize(0.5, 0.4)), np.array(lengths) / 0.5)


def test_two_counts_that_differ_too_much_share_the_error():
    """30 and 5 become 15 sqrt(2) and 5 sqrt(2): the quotient is 3, and both differ by the same factor."""
    counts = exact_counts(stacked(30.0, 5.0), StitchSize(1.0, 1.0))
    np.testing.assert_allclose(counts, np.sqrt(2.0) * np.array([15.0, 5.0]))


def test_no_step_is_larger_than_the_chosen_part():
    counts = exact_counts(stacked(40.0, 10.0, 12.0, 50.0, 9.0), StitchSize(1.0, 1.0, most_shaping=0.25))
    # Rounding of sums of logarithms near 4.
    assert np.abs(np.diff(np.log(counts))).max() <= np.log(1.25) + 1e-12


@pytest.mark.parametrize(
    ("exact", "other", "part", "multiple", "count"),
    [
        (40.0, 20, None, 1, 40),
        (80.0, 20, None, 1, 60),  # three of one
        (2.0, 21, None, 1, 7),  # one of three
        (40.0, 20, 0.25, 1, 25),
        (10.0, 20, 0.25, 1, 16),
        (40.0, 4, 0.1, 1, 5),  # one increase is always permitted
        (60.0, 20, 0.1, 4, 24),  # one multiple is always permitted
        (20.6, 20, 0.25, 1, 20),  # the count of the neighbour is kept
    ],
)
def test_a_course_has_as_many_stitches_as_its_neighbour_permits(exact, other, part, multiple, count):
    assert count_beside(ring(exact), exact, other, StitchSize(1.0, 1.0, multiple, part)) == count


@pytest.mark.decides
def test_increases_and_decreases_are_at_most_the_chosen_part_of_each_row():
    ball = closed_ball(24, 20)
    free = sm.shape_fabric(ball, stitch_width=0.9)
    limited = sm.shape_fabric(ball, stitch_width=0.9, options=sm.ShapingOptions(most_shaping=0.25))
    assert free.report.largest_shaping > 0.3  # The ball asks for more near its tips.
    fabric = limited.fabric
    shaped = np.bincount(fabric.row, fabric.n_bottom != fabric.n_top)
    assert (shaped <= np.maximum(0.25 * np.bincount(fabric.row), 1.0)).all()
    assert limited.report.largest_shaping == pytest.approx((shaped / np.bincount(fabric.row)).max(), abs=1e-4)
