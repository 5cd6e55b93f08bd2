# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh.arrays import distinct_rows


@pytest.mark.parametrize("shape", [(40, 3), (40, 1), (1, 2), (0, 2)])
def test_distinct_rows_are_those_of_numpy(shape: tuple[int, int]) -> None:
    table = np.random.default_rng(1).integers(-2, 3, size=shape)
    expected, place = np.unique(table, axis=0, return_inverse=True)
    found, found_place = distinct_rows(table)
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(found_place, place.ravel())
