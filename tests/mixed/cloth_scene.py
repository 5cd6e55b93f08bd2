# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A fabric with yarns in a region as a mixed system, with its positions at the beginning."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.assembly import Loads, MixedFabric, fabric_masses, loaded_system, start_positions
from stitchmesh.mixed.contact.motion import Attachment
from stitchmesh.mixed.dynamics.mass_matrix import BlendedMasses
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.enrichment.region import Region
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.simulation.dead_load import EARTH


@dataclass(frozen=True, eq=False)
class ClothScene:
    fabric: MixedFabric
    region: Region
    system: MixedSystem
    positions: MixedVector

    @property
    def masses(self) -> BlendedMasses:
        return fabric_masses(self.fabric, self.region)


def cloth_scene(
    fabric: MixedFabric,
    region: Region,
    *,
    nodes: Sequence[int] | IntArray = (),
    vertices: Sequence[int] | IntArray = (),
    places: FloatArray | None = None,
    gravity: tuple[float, float, float] = EARTH,
    scalar: Any = wp.float64,
) -> ClothScene:
    """A fabric of which some vertices and nodes are held, with its vertices at given places [cm]."""
    any_held = len(nodes) or len(vertices)
    held = [Attachment(np.array(vertices, dtype=np.int64), np.array(nodes, dtype=np.int64))] if any_held else []
    loads = Loads(gravity=gravity, held=held)
    system = loaded_system(fabric, region, loads, scalar=scalar, device=device_named("cpu"))
    return ClothScene(fabric, region, system, start_positions(fabric, region, system, places))
