# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The change of the spacing: zero for motions of the whole piece, and of first order in a uniform stretch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.solvers.spacing_change import SpacingChange
from tests.yarnrelax.stockinette import flat_patch, tube

CPU = device_named("cpu")
PIECES = {"stitches": tube(4, 6), "runs of points": replace(flat_patch(3, 4), face=np.full(144, -1))}


def in_radii(yarns: YarnSet) -> np.ndarray:
    return np.asarray(yarns.points / yarns.radius[0])


@pytest.mark.parametrize("yarns", PIECES.values(), ids=PIECES)
def test_a_rigid_motion_changes_no_spacing(yarns: YarnSet) -> None:
    points, spacing = in_radii(yarns), SpacingChange(yarns, CPU)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    assert spacing.of(points, np.tile([3.0, -2.0, 5.0], (len(points), 1))) < 1e-12  # rounding
    assert spacing.of(points, points @ turn.T - points) < 1e-12


@pytest.mark.parametrize("yarns", PIECES.values(), ids=PIECES)
def test_a_uniform_stretch_changes_the_spacing_by_itself(yarns: YarnSet) -> None:
    points = in_radii(yarns)
    assert SpacingChange(yarns, CPU).of(points, -0.2 * points) == pytest.approx(0.2, rel=1e-9)


def test_neighbours_are_those_of_the_given_yarns() -> None:
    """They stay the same while the points move, so that a relaxation that is resumed has the same estimate."""
    yarns = PIECES["stitches"]
    random = np.random.default_rng(4)
    points, motion = random.normal(size=yarns.points.shape), random.normal(size=yarns.points.shape)
    first, again = SpacingChange(yarns, CPU), SpacingChange(yarns, CPU)
    first.of(in_radii(yarns), motion)
    assert first.of(points, motion) == again.of(points, motion)
