# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far a mixed run is from a run with yarns everywhere: positions, stored energy, and the spectrum of wrinkles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mixed.enrichment.region import Region
from stitchmesh.mixed.layout.crossing_yarns import WEFT, CrossingYarns
from stitchmesh.mixed.region_change import place_hidden_vertices

Numbers = NDArray[np.float64]


def all_nodes(region: Region, vertices: Numbers, nodes: Numbers) -> Numbers:
    """Positions of all nodes of the layout [cm], shape (N, 3): on the triangles where yarns are not simulated.

    Args:
        region: the region of the run.
        vertices: vertices, shape (V, 3).
        nodes: simulated nodes, shape (n, 3).
    """
    placed = place_hidden_vertices(region, vertices, nodes)
    everywhere: Numbers = np.einsum("nk,nkd->nd", region.node_weight, placed[region.triangles[region.node_triangle]])
    everywhere[region.nodes] = nodes
    return everywhere


def position_error(found: Numbers, expected: Numbers, spacing: float) -> float:
    """Root mean square distance of nodes, in yarn spacings; both arrays of shape (n, 3)."""
    return float(np.sqrt(((found - expected) ** 2).sum(axis=1).mean())) / spacing


def wrinkle_spectrum(
    yarns: CrossingYarns, chosen: NDArray[np.bool_], positions: Numbers, normal: tuple[float, float, float]
) -> Numbers:
    """Mean amplitude of the height of wefts (courses) over their waves [cm], from the longest wave down.

    Entry k belongs to waves of which k + 1 fit into the chosen part. Each weft is the row of its chosen nodes, without
    the straight line that is nearest to it, and padded to the longest row.

    Args:
        yarns: the layout.
        chosen: whether each node belongs to the part that is measured, shape (N,).
        positions: positions of all nodes [cm], shape (N, 3).
        normal: direction of the height.
    """
    height = positions @ np.asarray(normal, dtype=np.float64)
    rows = []
    for yarn in np.flatnonzero(yarns.yarn_family == WEFT):
        own = yarns.yarn_node[yarns.yarn_start[yarn] : yarns.yarn_start[yarn + 1]]
        own = own[chosen[own]]
        if len(own) > 3:
            place = np.arange(len(own))
            line = np.polyval(np.polyfit(place, height[own], 1), place)
            rows.append(height[own] - line)
    if not rows:
        return np.zeros(0)
    longest = max(len(row) for row in rows)
    waves = [np.abs(np.fft.rfft(row, longest))[1:] * 2.0 / len(row) for row in rows]
    result: Numbers = np.mean(waves, axis=0)
    return result


def spectrum_error(found: Numbers, expected: Numbers) -> float:
    """Relative difference of two spectra."""
    size = float(np.linalg.norm(expected))
    return float(np.linalg.norm(found - expected)) / size if size > 0.0 else float(np.linalg.norm(found) > 0.0)
