# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The kinematic filter F = I - B (B'B)^-1 B' (Casafranca et al. 2020, equation 3), applied and never formed.

F removes from displacements of the hybrid nodes what the triangles can represent, each coordinate alike. It is the
projection of ``projection`` for vertices that do not move and nodes of unit metric: Sigma = B_C' B_C. Nodes in
full-yarn triangles stay as they are.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.mixed.enrichment.embedding import Embedding
from stitchmesh.mixed.enrichment.projection import Projection
from stitchmesh.mixed.mixed_blocks import MixedBlocks
from stitchmesh.mixed.mixed_vector import MixedVector


class Filter:
    """The filter of an embedding, on a device."""

    def __init__(self, embedding: Embedding, scalar: Any, device: wp.Device) -> None:
        """Factor B'B once.

        Raises:
            ParameterError: the hybrid region has too many vertices.
        """
        numbers = np.zeros(embedding.vertex_count), np.ones(embedding.node_count)
        metric = MixedBlocks.of_numbers(*numbers, scalar, device)
        self._projection = Projection(embedding, metric, element=wp.float64, device=device)
        self._projection.invert(*numbers)
        self._rest = wp.zeros(embedding.vertex_count, dtype=wp.types.vector(length=3, dtype=scalar), device=device)

    def launches(self, displacement: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that replace the part x of the nodes by F x."""
        at_rest = MixedVector(displacement.values, self._rest, displacement.nodes, displacement.sliding)
        return self._projection.launches(at_rest, launcher)
