# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers of things of which some leave and others come."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh.renumbering import GONE, Renumbering


@pytest.mark.parametrize(
    ("coming", "added", "after"),
    [
        (0, [], [0, GONE, 1, GONE, 2]),
        (1, [1], [0, GONE, 2, GONE, 3]),
        (2, [1, 3], [0, GONE, 2, GONE, 4]),
        (4, [1, 3, 5, 6], [0, GONE, 2, GONE, 4]),
    ],
)
def test_what_comes_fills_the_gaps_and_what_stays_closes_those_left(coming, added, after):
    numbering = Renumbering.filling(5, np.array([1, 3]), coming)
    assert numbering.added.tolist() == added
    assert numbering.after.tolist() == after


def test_values_go_with_their_things():
    numbering = Renumbering.of(4, np.array([0]), np.array([1, 4]))
    merged = numbering.merged(np.array([10, 11, 12, 13]), np.array([20, 21]))
    assert merged.tolist() == [11, 20, 12, 13, 21]
    assert (merged[numbering.after[1:]] == [11, 12, 13]).all()
