# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The region of a scene that the error of triangles alone chooses.

The scene runs with triangles first (``triangle_run``). A region within the number of nodes of the scene follows from
the error of each triangle (``placement.chosen_region``). The scene then begins again with yarns in this region, so that
a result does not depend on how the region was found; or, where it says so, on the result of the triangles.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.enrichment.region import region_around
from stitchmesh.mixed.placement.chosen_region import NodeBudget, choose_triangles
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, check_simulated


def place_yarns(prepared: PreparedScene, error: NDArray[np.float64]) -> PreparedScene:
    """Choose the region of a scene.

    Args:
        prepared: a scene whose region is ``automatic``, with yarns nowhere.
        error: the error of each triangle in a run with triangles alone [erg], shape (T,).

    Raises:
        ParameterError: the number of nodes does not suffice for one triangle and the rings around it.
    """
    section, fabric = prepared.scene.region, prepared.fabric
    cloth, yarns = fabric.cloth, fabric.yarns
    if section.boxes or section.faces:
        error = np.where(np.isin(np.arange(len(error)), section.named_triangles(cloth)), error, 0.0)
    nodes = int(section.nodes or 0)
    chosen = choose_triangles(cloth.triangles, yarns.triangle, error, NodeBudget(nodes=nodes), rings=section.rings)
    if len(chosen) == 0 and error.any():
        raise ParameterError(
            f"region.nodes: {nodes} nodes hold no triangle with {section.rings} hybrid rings around it; expected more "
            "nodes, or smaller triangles"
        )
    layout = len(cloth.vertices), yarns.triangle, yarns.barycentric
    region = region_around(cloth.triangles, *layout, chosen, rings=section.rings)
    check_simulated(prepared.held, region)
    return replace(prepared, region=region)
