# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Many swatches are those that ``swatch`` makes, and one that cannot be made does not end the others."""

from __future__ import annotations

import numpy as np

import stitchmesh as sm
from stitchmesh.errors import ParameterError


def test_swatches_are_those_of_swatch_and_an_error_is_in_the_place_of_one():
    requests = [
        sm.SwatchRequest("stockinette", quality="draft"),
        sm.SwatchRequest("stockinette", quality="draft", options={"gamma": -1.0}),
        sm.SwatchRequest("stockinette", quality="draft", options={"gamma": 1.1}),
    ]
    told = list[tuple[int, int]]()
    first, refused, last = sm.relax_swatches(requests, device="cpu", progress=lambda *done: told.append(done))
    assert told == [(1, 3), (2, 3), (3, 3)]
    assert isinstance(refused, ParameterError) and "gamma" in str(refused)
    for made, gamma in ((first, 1.0), (last, 1.1)):
        assert isinstance(made, sm.Swatch)
        alone = sm.swatch("stockinette", quality="draft", device="cpu", progress=False, gamma=gamma)
        assert made.report["converged"]
        np.testing.assert_array_equal(made.yarns.points, alone.yarns.points)
