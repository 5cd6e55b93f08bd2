# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The smallest value of each cell is that of NumPy, in however many parts a cell is searched."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.launch import launch
from stitchmesh.yarnrelax.collision.captured_search import smallest_of_cells, smallest_of_parts

START = np.array([0, 7, 8, 1000])


def smallest(values: np.ndarray, parts: int) -> list[float]:
    device = wp.get_device("cpu")
    of_parts = wp.zeros((len(START) - 1, parts), dtype=wp.float64, device=device)
    least = wp.zeros(len(START) - 1, dtype=wp.float64, device=device)
    inputs = [wp.array(START, dtype=wp.int32, device=device), wp.array(values, dtype=wp.float32, device=device)]
    launch(smallest_of_cells, of_parts.size, inputs, [of_parts], device)
    launch(smallest_of_parts, len(least), [of_parts], [least], device)
    return list(least.numpy())


@pytest.mark.parametrize("place", [8, 500, 999])
def test_a_value_that_is_not_a_number_makes_its_cell_not_a_number(place: int) -> None:
    values = np.linspace(0.0, 1.0, START[-1], dtype=np.float32)
    values[place] = np.nan
    assert np.isnan(smallest(values, parts=3)).tolist() == [False, False, True]
