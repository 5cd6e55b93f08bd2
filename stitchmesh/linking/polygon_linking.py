# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Linking numbers of closed polygons, by the same projection and the same crossings as the certificate of yarns.

A later polygon counts as displaced relative to an earlier one (``predicate``). Every number therefore belongs to two
polygons in general position, and is whole even where polygons touch.
"""

from __future__ import annotations

from collections.abc import Sequence

from scipy.sparse import coo_array, csr_array

from stitchmesh.compute.device import CPU, alone, device_named
from stitchmesh.linking.crossings import decoded, edge_crossings
from stitchmesh.linking.projection import project_polygons
from stitchmesh.mesh import FloatArray


@alone()
def linking_numbers(points: FloatArray, polygons: Sequence[Sequence[int]]) -> csr_array:
    """Linking numbers of all pairs of polygons, a symmetric integer matrix of shape (P, P).

    Args:
        points: positions [cm], shape (n, 3).
        polygons: for each polygon the points through which it passes, in order; the last one is joined to the first.
    """
    projection = project_polygons(points, polygons, device_named(CPU))
    pairs, _, signs = decoded(projection, edge_crossings(projection))
    doubled = coo_array((signs, (pairs[:, 0], pairs[:, 1])), shape=(len(polygons),) * 2).tocsr()
    numbers = doubled + doubled.T
    numbers.data //= 2
    return numbers
