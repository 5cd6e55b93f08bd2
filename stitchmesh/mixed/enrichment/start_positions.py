# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Positions at the beginning that are of the form p = B v + F x, next to given ones.

Nodes that stand out of their triangles are not of this form: the mean of their heights around a vertex is not zero. The
change of vertices and hybrid nodes with the smallest sum of squares makes it so. Around a vertex lie several nodes, so
that mainly the vertices move, to the middle of the yarns, and the yarns keep their shape. What is fixed stays. Since
E (v, p) = 0 then is linear and homogeneous, it holds for a cloth that is turned too.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import warp as wp

from stitchmesh.compute.launch import launch
from stitchmesh.mixed.enrichment.embedding import Embedding
from stitchmesh.mixed.enrichment.free_unknowns import FreeUnknowns
from stitchmesh.mixed.enrichment.projection import Projection
from stitchmesh.mixed.mixed_blocks import MixedBlocks
from stitchmesh.mixed.mixed_vector import MixedVector


def make_consistent(embedding: Embedding, free: FreeUnknowns, positions: MixedVector) -> None:
    """Change positions the least so that p = B v + F x.

    Args:
        embedding: the base motion of the hybrid nodes.
        free: what moves.
        positions: positions at the beginning; changed.
    """
    numbers = free.vertices.astype(np.float64), free.nodes.astype(np.float64)
    metric = MixedBlocks.of_numbers(*numbers, positions.scalar, positions.device)
    projection = Projection(embedding, metric, element=wp.float64, device=positions.device)
    projection.invert(*numbers)
    projection.launches(positions, partial(launch, device=positions.device))
