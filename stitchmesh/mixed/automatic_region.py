# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The region of a scene that the error of triangles alone chooses.

A run with triangles alone says how much energy is wrong in each triangle (``triangle_run``). A region within the number
of nodes of the scene follows from it (``placement.chosen_region``). The scene then begins with yarns in this region, so
that a result does not depend on how the region was found.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.placement.chosen_region import NodeBudget, choose_triangles
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, check_simulated, with_region


def place_yarns(prepared: PreparedScene, error: NDArray[np.float64], budget: NodeBudget) -> PreparedScene:
    """Choose the region of a scene.

    Args:
        prepared: a scene whose region is ``automatic``, with yarns nowhere.
        error: the largest error of each triangle in a run with triangles alone [erg], shape (T,).
        budget: nodes that may be simulated.

    Raises:
        ParameterError: the number of nodes does not suffice for one triangle and the rings around it.
    """
    section, fabric = prepared.scene.region, prepared.fabric
    cloth, yarns = fabric.cloth, fabric.yarns
    allowed = section.placing_errors(cloth, error)
    chosen = choose_triangles(cloth.triangles, yarns.triangle, allowed, budget, rings=section.rings)
    if len(chosen) == 0 and allowed.any():
        raise ParameterError(
            f"region: {budget.nodes} nodes hold no triangle with {section.rings} hybrid rings around it; expected more "
            "nodes or seconds, or smaller triangles"
        )
    placed = with_region(prepared, chosen)
    check_simulated(placed.held, placed.region)
    return placed
