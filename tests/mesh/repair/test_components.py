# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Very small components and vertices without a face are removed, and the report of all changes."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh.repair import repair_mesh
from stitchmesh.mesh.repair.action import ActionLog
from tests.gallery import grid


@pytest.mark.parametrize(("side", "left"), [(0.9, 1), (1.1, 2)])
def test_components_below_a_ten_thousandth_of_the_largest_are_removed(side, left):
    """A square of 0.01 times the side of the sheet has exactly that area."""
    sheet, speck = grid(10, 10, width=1.0), grid(1, 1, width=0.1 * side, height=0.1 * side)
    vertices = np.concatenate([sheet.vertices, speck.vertices + np.array([0.0, 0.0, 5.0])])
    repaired = repair_mesh(vertices, [*sheet.polygons, [v + 121 for v in speck.polygons[0]]])
    assert len(repaired.components) == left
    assert [(action.name, action.where) for action in repaired.actions] == [("small components", (100,))] * (2 - left)


def test_a_change_in_several_passes_is_one_action():
    log = ActionLog()
    for places in ([5, 9], [], [2]):
        log.add("duplicate faces", places)
    log.add("crowded edges", [(3, 8), (1, 9)])
    found = log.actions()
    assert [(action.name, action.count, action.where) for action in found] == [
        ("duplicate faces", 3, (2, 5, 9)), ("crowded edges", 2, ((1, 9), (3, 8)))
    ]  # fmt: skip
    assert found[1].places == "edge 1-9, 3-8"
