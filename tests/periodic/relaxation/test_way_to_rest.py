# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Free repeats whose stitches are drawn far longer than they end, or whose forces are as small as rounding."""

from __future__ import annotations

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.patterns import parse_pattern
from stitchmesh.periodic.relaxation import way_to_rest
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch, prepare_swatch
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.quality import PRESETS
from stitchmesh.yarngen.clearance import smallest_distance
from tests.periodic.free_cells import FREE, yarn_lengths

DOUBLE_EYELET = parse_pattern("row 1 RS: k2tog yo2 ssk\nrow 2 WS: p1 p1 k1 p1")


@pytest.fixture(scope="module")
def prepared() -> PreparedSwatch:
    return prepare_swatch(DOUBLE_EYELET, material=None, quality="draft", device="cpu", **FREE)


def test_settled_yarns_are_the_prepared_ones_further_apart(prepared):
    settled, before = way_to_rest._settled(prepared), prepared.yarns
    assert settled.lattice.periods == pytest.approx(before.lattice.periods) and (settled.start == before.start).all()
    np.testing.assert_allclose(yarn_lengths(settled), yarn_lengths(before), rtol=1e-12)  # rounding of sums
    near = [smallest_distance(yarns, 2 * yarns.radius[0])[0] / yarns.radius[0] for yarns in (before, settled)]
    assert near[0] < way_to_rest.WEDGED and near[1] > 1.4


@pytest.mark.nightly
@pytest.mark.decides
def test_a_double_yarn_over_comes_to_rest_without_wedged_yarns():
    made = sm.swatch(DOUBLE_EYELET, **FREE, quality="draft", device="cpu", progress=False).report
    assert made["converged"] and made["min_distance_over_radius"] > 1.4


@pytest.mark.nightly
@pytest.mark.decides
def test_a_satin_comes_to_rest_where_rounding_alone_exceeds_its_tolerance():
    """Each weft of a satin floats over one warp of eight, and its long floats carry almost no force."""
    ends, step = 8, 3
    place = np.arange(ends)
    over = (step * place[:, None] % ends == place).astype(int)
    made = sm.swatch(Weave(over.tolist()), relax_cell=True, quality="draft", device="cpu", progress=False).report
    assert made["converged"] and not made["hidden_by_rounding"]
    assert made["iterations"] < PRESETS["draft"].max_iterations / 2  # in float32 it goes on to the limit
    assert made["min_distance_over_radius"] > 1.4
