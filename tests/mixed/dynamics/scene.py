# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A patch of springs with yarns in a region, for the tests of the dynamics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.mixed.dynamics.mass_matrix import BlendedMasses, ConstantNodeMasses, blend_masses
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.enrichment.region import Embedding, FreeUnknowns, Region, embed
from stitchmesh.mixed.mixed_vector import MixedVector
from tests.mixed.patch import Patch
from tests.mixed.springs import Springs

CPU = device_named("cpu")
MASS = 0.1
"""Mass of a patch [g]."""
STIFFNESS = 50.0
"""Stiffness of a spring [dyn/cm]."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A patch, its region and its system."""

    patch: Patch
    region: Region
    embedding: Embedding
    masses: BlendedMasses
    system: MixedSystem

    def vector(self, vertices: Any, nodes: Any) -> MixedVector:
        """A vector from values of all vertices and of all nodes of the layout."""
        of_nodes = np.asarray(nodes)[self.region.nodes]
        return MixedVector.from_numpy(vertices, of_nodes, np.zeros((len(of_nodes), 2)), self.system.scalar, CPU)

    def at_rest(self) -> MixedVector:
        """The flat patch."""
        return self.vector(self.patch.vertices, self.patch.nodes)


def masses_of(patch: Patch, region: Region, mass: float = MASS) -> BlendedMasses:
    segments = patch.segments()
    share = np.full(len(segments), mass / len(segments))
    family = np.repeat([0, 1], len(segments) // 2)
    coordinate = np.stack([family, family], axis=1)
    of_triangles = np.full(len(patch.triangles), mass / len(patch.triangles))
    return blend_masses(region, segments, share, coordinate, of_triangles)


def spring_scene(
    patch: Patch,
    region: Region,
    *,
    rest: float = 1.0,
    stiffness: float = STIFFNESS,
    fixed_vertices: Sequence[int] = (),
    fixed_nodes: Sequence[int] = (),
    scalar: Any = wp.float64,
    masses: BlendedMasses | None = None,
    slides: bool = False,
) -> Scene:
    """Springs along the yarns and along the legs of the triangles; ``rest`` is their rest length over their length.

    With rest lengths of zero both models have the energy k/2 |grad x|^2 per area for affine deformations. Springs do
    not depend on Eulerian coordinates: where they are free, they have mass alone.
    """
    embedding = embed(region)
    free = FreeUnknowns.of(region, fixed_vertices=fixed_vertices, fixed_nodes=fixed_nodes)
    if not slides:
        free = replace(free, sliding=np.zeros_like(free.sliding))
    masses = masses_of(patch, region) if masses is None else masses
    springs = [
        yarn_springs(patch, region, rest, stiffness, scalar),
        triangle_springs(patch, region, rest, stiffness, scalar),
    ]
    crossing = crossing_masses(masses.yarns, scalar) if slides else None
    system = MixedSystem(embedding, free, masses, springs, node_masses=crossing, scalar=scalar, device=CPU)
    return Scene(patch, region, embedding, masses, system)


def crossing_masses(yarns: np.ndarray, scalar: Any, along: np.ndarray | None = None) -> ConstantNodeMasses:
    """Blocks of yarns along given directions, shape (n, 2, 3)."""
    w = np.tile([[0.0, 1.0, 0.0], [1.0, 0.3, 0.0]], (len(yarns), 1, 1)) if along is None else along
    masses = ConstantNodeMasses(yarns.sum(axis=1), scalar, CPU)
    for k in range(2):
        masses.coupling[k].assign(-w[:, k] * yarns[:, k, None])
    masses.sliding_mass.assign(yarns * (w**2).sum(axis=2))
    return masses


def yarn_springs(patch: Patch, region: Region, rest: float, stiffness: float, scalar: Any) -> Springs:
    segments = patch.segments()
    alpha = region.element_alpha(segments)
    kept = alpha > 0.0
    ends = region.node_number[segments[kept]]
    length = np.linalg.norm(np.diff(patch.nodes[segments[kept]], axis=1)[:, 0], axis=1)
    return Springs("nodes", ends, len(region.nodes), stiffness * alpha[kept], rest * length, scalar, CPU)


def triangle_springs(patch: Patch, region: Region, rest: float, stiffness: float, scalar: Any) -> Springs:
    pairs = patch.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    d = np.diff(patch.vertices[pairs], axis=1)[:, 0]
    length = np.linalg.norm(d, axis=1)
    weight = np.repeat(1.0 - region.triangle_alpha, 3)
    # Half of the cotangent of the opposite angle: 1/2 for a leg, 0 for the long side; the springs against shear of a
    # patch with rest lengths get a tenth.
    slanted = (d[:, :2] != 0.0).all(axis=1)
    share = np.where(slanted, 0.1 if rest else 0.0, 0.5)
    kept = (weight * share) > 0.0
    k = (stiffness * weight * share)[kept]
    return Springs("vertices", pairs[kept], len(patch.vertices), k, (rest * length)[kept], scalar, CPU)


def set_hessian_product(system: MixedSystem, direction: MixedVector, product: MixedVector) -> None:
    """Set ``product`` to H d of the last ``linearize``."""
    product.values.zero_()
    for term in system.terms:
        term.products(direction, product, system.launch)
