# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact points that are neighbours in the cloth at rest, and therefore do not collide.

Two points of one panel are neighbours if their distance at rest is below ``ARC`` times the sum of their radii; the
search for pairs compares the distance where it lists them. Two points on different sides of a seam are neighbours if a
path over the seam is shorter,

    |X_i - A| + |B - X_j| < ARC (r_i + r_j),       A = B a place of the seam, in the panels of i and j

Their pairs are listed here, once and for all.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.contact.contact_points import ContactPoints
from stitchmesh.mixed.contact.triangle_points import SeamLinks

ARC = 2.0
"""Largest distance of neighbours over that of contact. A fold of cloth as sharp as its thickness allows has layers one
thickness apart, and joins them by an arc of pi / 2 thicknesses; the rest is for cloth that is compressed."""


@dataclass(frozen=True, eq=False)
class SeamNeighbours:
    """Neighbours across seams of each contact point, as compressed rows."""

    start: IntArray
    """Where the row of each point begins; shape (M + 1,)."""
    point: IntArray
    """Neighbours, ascending in each row."""


def seam_neighbours(points: ContactPoints, links: SeamLinks) -> SeamNeighbours:
    """The pairs of points that a path over a seam joins.

    Args:
        points: the contact points.
        links: the places where panels meet.
    """
    reach = 2.0 * ARC * float(points.layer_radius.max(initial=0.0))
    pairs = [np.zeros((0, 2), dtype=np.int64)]
    near = [_near(points, links.panel[:, side], links.rest[:, side], reach) for side in (0, 1)]
    for link, (here, there) in enumerate(zip(*near, strict=True)):
        if here and there:
            pairs.append(_joined(points, links.rest[link], here, there))
    both = np.concatenate(pairs)
    both = np.unique(np.concatenate([both, both[:, ::-1]]), axis=0)
    both = both[both[:, 0] != both[:, 1]]
    return SeamNeighbours(np.searchsorted(both[:, 0], np.arange(len(points) + 1)), both[:, 1])


def _near(points: ContactPoints, panel: IntArray, place: FloatArray, reach: float) -> list[list[int]]:
    """Points within reach of each place."""
    far = 4.0 * (np.abs(points.rest).max(initial=0.0) + np.abs(place).max(initial=0.0) + reach)
    tree = cKDTree(np.column_stack([points.rest, far * points.panel]))
    found: list[list[int]] = tree.query_ball_point(np.column_stack([place, far * panel]), reach).tolist()
    return found


def _joined(points: ContactPoints, rest: FloatArray, here: list[int], there: list[int]) -> IntArray:
    """Pairs whose path over one link is short enough, shape (n, 2)."""
    one, other = np.array(here), np.array(there)
    path = np.linalg.norm(points.rest[one] - rest[0], axis=1)[:, None]
    path = path + np.linalg.norm(points.rest[other] - rest[1], axis=1)[None, :]
    i, j = np.nonzero(path < ARC * (points.layer_radius[one][:, None] + points.layer_radius[other][None, :]))
    return np.stack([one[i], other[j]], axis=1)
