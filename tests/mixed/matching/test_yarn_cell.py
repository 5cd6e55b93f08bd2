# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Repeats of fabrics, cut out of larger patches."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial, FabricMaterials
from stitchmesh.mixed.matching.yarn_cell import weave_cell

YARN = CrossingMaterial.named("gong-1")
PLAIN = [[1, 0], [0, 1]]


def test_a_plain_weave_has_one_node_for_each_crossing() -> None:
    cell = weave_cell(PLAIN, ends=4.0, picks=5.0, materials=FabricMaterials.of(YARN))
    assert cell.node_count == 4
    assert np.allclose(cell.period, [0.5, 0.4], atol=1e-15)


@pytest.mark.parametrize("over", [PLAIN, [[1, 1, 0, 0], [0, 1, 1, 0], [0, 0, 1, 1], [1, 0, 0, 1]]])
def test_the_mass_is_that_of_yarns_at_their_distances(over: list[list[int]]) -> None:
    cell = weave_cell(over, ends=4.0, picks=5.0, materials=FabricMaterials.of(YARN))
    assert cell.density == pytest.approx(9.0 * YARN.density, rel=1e-12)  # rounding; 9 cm of yarn for each cm^2


def test_elements_weigh_one_for_each_copy_in_the_repeat() -> None:
    cell = weave_cell(PLAIN, ends=4.0, picks=4.0, materials=FabricMaterials.of(YARN))
    # one segment along each yarn and one bend of each yarn for each of the four nodes; sums of thirds
    assert cell.elements.stretch.sum() == pytest.approx(8.0 * YARN.stretch_stiffness, rel=1e-12)
    assert cell.elements.bending.sum() == pytest.approx(8.0 * YARN.bending_stiffness, rel=1e-12)


@pytest.mark.parametrize(
    ("ends", "picks", "found"), [(0.0, 4.0, "ends is 0"), (4.0, np.nan, "picks is nan"), (4.0, -1.0, "picks is -1")]
)
def test_a_density_that_is_not_positive_is_refused(ends: float, picks: float, found: str) -> None:
    with pytest.raises(ParameterError, match=found):
        weave_cell(PLAIN, ends=ends, picks=picks, materials=FabricMaterials.of(YARN))
