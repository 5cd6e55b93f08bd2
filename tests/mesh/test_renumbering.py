# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Numbers of elements before and after some are removed and others are added."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh.renumbering import REMOVED, Renumbering


@pytest.mark.parametrize(
    ("added_count", "added", "after"),
    [
        (0, [], [0, REMOVED, 1, REMOVED, 2]),
        (1, [1], [0, REMOVED, 2, REMOVED, 3]),
        (2, [1, 3], [0, REMOVED, 2, REMOVED, 4]),
        (4, [1, 3, 5, 6], [0, REMOVED, 2, REMOVED, 4]),
    ],
)
def test_added_elements_fill_the_gaps_and_kept_elements_close_the_others(added_count, added, after):
    numbering = Renumbering.filling(5, np.array([1, 3]), added_count)
    assert numbering.added.tolist() == added
    assert numbering.after.tolist() == after


def test_values_keep_to_their_elements():
    numbering = Renumbering.of(4, np.array([0]), np.array([1, 4]))
    merged = numbering.merged(np.array([10, 11, 12, 13]), np.array([20, 21]))
    assert merged.tolist() == [11, 20, 12, 13, 21]
    assert (merged[numbering.after[1:]] == [11, 12, 13]).all()
