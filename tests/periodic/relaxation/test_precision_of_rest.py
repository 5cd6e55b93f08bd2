# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Swatches whose forces are as small as the rounding of float32 come to rest in float64."""

from __future__ import annotations

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.quality import PRESETS

ENDS, STEP = 8, 3


@pytest.mark.nightly
@pytest.mark.decides
def test_a_satin_comes_to_rest_where_rounding_alone_exceeds_its_tolerance():
    """Each weft of a satin floats over one warp of eight, and its long floats carry almost no force."""
    place = np.arange(ENDS)
    over = (STEP * place[:, None] % ENDS == place).astype(int)
    made = sm.swatch(Weave(over.tolist()), relax_cell=True, quality="draft", device="cpu", progress=False).report
    assert made["converged"] and not made["hidden_by_rounding"]
    assert made["iterations"] < PRESETS["draft"].max_iterations / 2  # in float32 it goes on to the limit
    assert made["min_distance_over_radius"] > 1.4
