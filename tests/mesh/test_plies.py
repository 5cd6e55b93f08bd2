# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The strands of a yarn lie inside it, touch one another, and are closed where the yarn is closed."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh.tube_mesh import LAY, plies_around, ply_radius
from tests.io.yarn_sets import ring

STRAIGHT = np.stack([np.linspace(0.0, 20.0, 400), np.zeros(400), np.zeros(400)], axis=1)


@pytest.mark.parametrize("count", [2, 6])
def test_strands_touch_one_another_inside_the_yarn(count):
    """The strands of a straight yarn are circles around its axis: their distance from it plus their radius is R."""
    strands = plies_around([STRAIGHT], [False], 0.5, count)
    small = float(ply_radius(0.5, count))
    assert len(strands) == count
    for strand in strands:
        np.testing.assert_allclose(np.hypot(strand[:, 1], strand[:, 2]) + small, 0.5, atol=1e-12)
    between = np.linalg.norm(strands[0] - strands[1], axis=1)
    np.testing.assert_allclose(between, 2 * small, atol=1e-12)


def test_strands_turn_once_in_a_lay():
    (strand, _) = plies_around([STRAIGHT], [False], 0.5, 2)
    angle = np.unwrap(np.arctan2(strand[:, 2], strand[:, 1]))
    assert abs(angle[-1] - angle[0]) == pytest.approx(2 * np.pi * 20.0 / (LAY * 0.5), rel=1e-9)


def test_strands_of_a_closed_yarn_are_closed():
    """The step from the last point to the first is as long as the other steps."""
    for strand in plies_around([ring([0, 0, 0], 3.0, 200)], [True], 0.2, 3):
        steps = np.linalg.norm(np.diff(strand, axis=0, append=strand[:1]), axis=1)
        assert steps[-1] <= 1.01 * steps[:-1].max()
