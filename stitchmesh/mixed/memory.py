# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""An estimate of the memory that a scene needs, before anything large is allocated, and how many yarn nodes fit.

The dense inverse of the hybrid region grows with the square of its vertices; everything else grows with the numbers of
nodes, vertices and contact points. The constants were measured in float64 on patches of 10^4 and 4 10^4 nodes,
including the maps for display, and rounded up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.memory_need import BASE_MEMORY, check_memory
from stitchmesh.mixed.enrichment.region import HYBRID, Region

PER_LAID_NODE, PER_NODE, PER_VERTEX = 2_500.0, 3_500.0, 25_000.0
"""Memory for each node of the layout, for each simulated node, and for each vertex with its triangles [bytes]."""
PER_NODE_IN_CONTACT, PER_VERTEX_IN_CONTACT = 1_500.0, 45_000.0
"""Additional memory for each simulated node and each vertex with contact [bytes]."""
PER_PAIR = 40.0
"""Memory for each pair of hybrid vertices [bytes]."""


@dataclass(frozen=True)
class MemoryEstimate:
    """Memory that a scene needs [bytes]."""

    total: float
    """All memory of the scene."""
    each_node: float
    """Memory of one more simulated node."""

    def nodes_within(self, available: float, nodes: int) -> int:
        """Return how many nodes fit into a memory, if a scene of ``nodes`` nodes needs ``total``."""
        return max(int(nodes - (self.total - available) / self.each_node), 0)


def estimate_memory(region: Region, *, contact: bool, may_grow_to: int = 0) -> MemoryEstimate:
    """Estimate the memory of a region.

    Args:
        region: the region at the start.
        contact: whether there is contact.
        may_grow_to: number of nodes that the region may have later; all of it then counts as hybrid.
    """
    vertices, laid = len(region.vertex_alpha), len(region.node_triangle)
    nodes = min(max(len(region.nodes), may_grow_to), laid)
    hybrid = len(np.unique(region.triangles[region.triangle_kind == HYBRID]))
    hybrid = max(hybrid, int(np.ceil(vertices * min(may_grow_to / max(laid, 1), 1.0))))
    each = PER_NODE + PER_NODE_IN_CONTACT * contact
    of_vertices = vertices * (PER_VERTEX + PER_VERTEX_IN_CONTACT * contact)
    total = BASE_MEMORY + PER_LAID_NODE * laid + each * nodes + of_vertices + PER_PAIR * hybrid**2
    return MemoryEstimate(total, each)


def check_layout_memory(nodes: float, available: float) -> None:
    """Check that the layout of a number of yarn nodes fits into a memory, before it is made.

    Raises:
        ParameterError: it does not fit; the message says how much it needs and how many nodes would fit.
    """
    fit = max(int((available - BASE_MEMORY) / PER_LAID_NODE), 0)
    check_memory(
        f"a cloth with about {nodes:,.3g} crossings of yarns", BASE_MEMORY + PER_LAID_NODE * nodes,
        f"fewer yarns for each cm, or a smaller cloth, for at most {fit:,} crossings", free=available,
    )  # fmt: skip


def check_scene_memory(region: Region, available: float, *, contact: bool, may_grow_to: int = 0) -> MemoryEstimate:
    """Check that a scene fits into a memory, and return its estimate, with the arguments of ``estimate_memory``.

    Raises:
        ParameterError: it does not fit; the message says how much it needs and which region would fit.
    """
    needed = estimate_memory(region, contact=contact, may_grow_to=may_grow_to)
    nodes = max(len(region.nodes), may_grow_to)
    fit = needed.nodes_within(available, nodes)
    remedy = f"a region of at most {fit:,} yarn nodes" if fit else "longer edges of triangles and a smaller cloth"
    check_memory(f"the scene with {nodes:,} yarn nodes", needed.total, remedy, free=available)
    return needed
