# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A ray picks the first control point that it meets."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.picking import pick_point

LINE = np.stack([np.arange(8.0), np.zeros(8), np.zeros(8)], axis=1)
YARNS = YarnSet.from_curves([LINE, LINE - [0.0, 0.0, 3.0]], closed=[False, False], radius=0.3)
"""Two straight yarns along x, the second one 3 cm behind the first."""


@pytest.mark.parametrize("place", range(8))
def test_a_ray_at_a_control_point_picks_it_and_not_the_one_behind(place: int):
    origin = YARNS.points[place] + [0.0, 0.1, 10.0]
    assert pick_point(YARNS, origin, [0.0, 0.0, -2.0]) == place
    assert pick_point(YARNS, origin - [0.0, 0.0, 20.0], [0.0, 0.0, 1.0]) == place + 8


def test_a_ray_beside_all_yarns_or_away_from_them_picks_none():
    assert pick_point(YARNS, [3.0, 2.0, 10.0], [0.0, 0.0, -1.0]) is None
    assert pick_point(YARNS, [3.0, 0.0, 10.0], [0.0, 0.0, 1.0]) is None


@pytest.mark.parametrize("direction", [[0.0, 0.0, 0.0], [np.nan, 0.0, 1.0], [1.0, 0.0]])
def test_a_ray_without_a_direction_is_refused(direction: list[float]):
    with pytest.raises(ParameterError, match="ray: got origin"):
        pick_point(YARNS, [0.0, 0.0, 0.0], direction)
