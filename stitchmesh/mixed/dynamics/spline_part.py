# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What B-spline yarns bring to a mixed system: their energy, and the loads that keep the hybrid region in balance."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from stitchmesh.compute.launch import launch
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.enrichment.region import HYBRID, ROUNDING, TRIANGLES, Region
from stitchmesh.mixed.layout.spline_yarns import SplineYarns
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.splines.layout_balance import LayoutBalance
from stitchmesh.mixed.splines.spline_material import SplineMaterial
from stitchmesh.mixed.splines.spline_pieces import spline_pieces
from stitchmesh.mixed.splines.spline_term import SplineTerm
from stitchmesh.mixed.term import Term

REACH = 3
"""Rings of triangles around the region within which yarns act on those of the region: triangles are half a stitch."""
Numbers = NDArray[np.float64]


def spline_terms(
    cloth: Cloth, yarns: SplineYarns, material: SplineMaterial, region: Region, scalar: Any, device: wp.Device
) -> list[Term]:
    """Return the energies of B-spline yarns in a region.

    Args:
        cloth: the cloth, in the shape in which the yarns were laid out.
        yarns: the yarns, everywhere on it.
        material: their material.
        region: the region of interest.
        scalar: Warp's floating-point type.
        device: where the terms run.
    """
    pieces = spline_pieces(
        yarns.curves, nodes=region.nodes, alpha=region.element_alpha(yarns.curves.segment_points)
    )
    if pieces.curves is None:
        return []
    term = SplineTerm(pieces, material, scalar, device)
    loads = _balance(cloth, yarns, material, region, term, device)
    return [term]


def _balance(
    cloth: Cloth, yarns: SplineYarns, material: SplineMaterial, region: Region, term: SplineTerm, device: wp.Device
) -> LayoutBalance | None:
    """The loads that keep the layout in balance; none where all yarns have their full weight."""
    hybrid = np.flatnonzero(region.triangle_kind == HYBRID)
    if len(hybrid) == 0 or (region.vertex_alpha > 1.0 - ROUNDING).all():
        return None
    scalar = term.model.scalar
    near = np.flatnonzero(_near(region)[region.node_triangle])
    exists = np.isin(yarns.curves.segment_points, near).all(axis=1).astype(np.float64)
    whole = SplineTerm(spline_pieces(yarns.curves, nodes=near, alpha=exists), material, scalar, device)
    full = np.zeros((yarns.node_count, 3))
    full[near] = _forces(whole, yarns.curves.points[near])
    nodes = region.nodes
    load = region.node_alpha[nodes, None] * full[nodes] - _forces(term, yarns.curves.points[nodes])
    own = region.node_triangle[nodes]
    middle = cloth.vertices[cloth.triangles].mean(axis=1)
    nearest = hybrid[cKDTree(middle[hybrid]).query(yarns.curves.points[nodes])[1]]
    corners = cloth.triangles[np.where(region.triangle_kind[own] == HYBRID, own, nearest)]
    loaded = np.flatnonzero(load.any(axis=1))
    return LayoutBalance(loaded, corners[loaded], load[loaded], cloth.vertices, scalar, device)


def _near(region: Region) -> NDArray[np.bool_]:
    """Whether each triangle belongs to the region or lies within ``REACH`` rings around it, shape (T,)."""
    near = region.triangle_kind != TRIANGLES
    for _ in range(REACH):
        reached = np.zeros(len(region.vertex_alpha), dtype=bool)
        reached[region.triangles[near]] = True
        near = reached[region.triangles].any(axis=1)
    return near


def _forces(term: SplineTerm, points: Numbers) -> Numbers:
    """Forces of a term on its nodes at given places [dyn], shape (n, 3)."""
    device = term.model.device
    state = MixedVector.from_numpy([], points, np.zeros((len(points), 2)), term.model.scalar, device)
    force = state.like()
    term.begin_step(state, 0.0, 0.0)
    term.forces(state, force, partial(launch, device=device))
    return force.numpy()[1]
