# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Growth and shrinkage of a region while a run goes on.

In the region itself the triangles carry no error, because yarns carry what they cannot. What the triangles would be
wrong by without yarns is read from the yarns there: nodes at the root mean square distance d from the triangles, in
waves whose half length is the size h of a triangle, take up the compression e = (pi d / h)^2 / 2, which triangles would
have to store as 1/2 Y e^2 (``detail_errors``). h^2 is twice the area of the triangle.

A region changes only if this is worth it. Triangles that have yarns now count ``KEPT`` times as much as others, and the
new region is taken only if it removes ``WORTH`` times as much error as the present one would; otherwise the present
region stays as it is. Changes cost a new factorisation and a jump of the state, and a region that follows every
fluctuation would pay them at each step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.enrichment.region import TRIANGLES, Region
from stitchmesh.mixed.placement.chosen_region import NodeBudget, choose_triangles, simulated_nodes
from stitchmesh.mixed.placement.error_indicator import indicate_errors
from stitchmesh.mixed.placement.moved_state import place_hidden_vertices
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial

Integers = NDArray[np.int64]
Numbers = NDArray[np.float64]
KEPT = 2.0
"""Factor of the error of triangles that have yarns."""
WORTH = 1.1
"""Removed error of a new region over that of the present one from which the region changes."""


def changed_triangles(
    triangles: ArrayLike,
    node_triangle: ArrayLike,
    error: ArrayLike,
    present: ArrayLike,
    budget: NodeBudget,
    *,
    rings: int = 1,
    kept: float = KEPT,
    worth: float = WORTH,
) -> Integers:
    """The full-yarn triangles with which a run goes on, ascending; those of the present region if no change pays.

    Args:
        triangles: vertices of each triangle, shape (T, 3).
        node_triangle: triangle of each yarn node of the layout, shape (N,).
        error: indicated error of each triangle, shape (T,); in the region with ``detail_errors``.
        present: numbers of the full-yarn triangles of the present region.
        budget: nodes that may be simulated.
        rings: width of the hybrid region in rings of triangles.
        kept: factor of the error of triangles that have yarns, at least 1.
        worth: removed error of a new region over that of the present one from which the region changes, at least 1.

    Raises:
        ParameterError: as ``choose_triangles``, or a factor is less than 1.
    """
    if not (kept >= 1.0 and worth >= 1.0):
        raise ParameterError(f"region: got the factors {kept:g} and {worth:g}; expected numbers of at least 1")
    now = np.unique(np.asarray(present, dtype=np.int64))
    values = np.array(error, dtype=np.float64)
    preferred = values.copy()
    preferred[now] *= kept
    new = choose_triangles(triangles, node_triangle, preferred, budget, rings=rings)
    fits = simulated_nodes(triangles, node_triangle, now, rings=rings) <= budget.nodes
    if fits and values[new].sum() <= worth * values[now].sum():
        return now
    return new


def present_errors(cloth: Cloth, region: Region, material: ClothMaterial, vertices: Numbers, nodes: Numbers) -> Numbers:
    """The error that triangles alone would have in the present state of a run [erg], shape (T,).

    Outside the region this is ``indicate_errors``. Inside, where the vertices are placed by the yarns, it is the larger
    one of the indicator and ``detail_errors``. Arguments are those of ``detail_errors``.
    """
    placed = place_hidden_vertices(region, vertices, nodes)
    indicated = indicate_errors(cloth, placed, material).total
    return np.maximum(indicated, detail_errors(cloth, region, material, placed, nodes))


def detail_errors(cloth: Cloth, region: Region, material: ClothMaterial, vertices: Numbers, nodes: Numbers) -> Numbers:
    """The error that triangles would have where yarns are simulated now [erg], shape (T,); zero elsewhere.

    Args:
        cloth: the cloth.
        region: the present region.
        material: material of the triangles.
        vertices: positions of the vertices [cm], shape (V, 3).
        nodes: positions of the simulated nodes [cm], shape (n, 3).
    """
    simulated = region.nodes
    home = region.node_triangle[simulated]
    corners = np.asarray(vertices, dtype=np.float64)[region.triangles[home]]
    base = np.einsum("nk,nkd->nd", region.node_weight[simulated], corners)
    count = np.bincount(home, minlength=len(region.triangles))
    square = np.bincount(home, ((nodes - base) ** 2).sum(axis=1), minlength=len(region.triangles))
    strain = np.pi**2 * (square / np.maximum(count, 1)) / (2.0 * 2.0 * cloth.rest_area)
    moduli = material.moduli()
    stiffness = float(np.sqrt(moduli[0, 0] * moduli[1, 1]))
    return np.where(region.triangle_kind == TRIANGLES, 0.0, cloth.rest_area * stiffness * strain**2 / 2.0)
