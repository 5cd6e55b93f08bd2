# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Weights of the stretch of hybrid yarns and triangles with which uniform tension balances.

Under uniform stretch all yarns of a family c, at distances h, have the same tension. A segment of yarn with the weight
w pulls with w times this tension. A triangle of area A with the weight s resists with s A g, where g are the gradients
of its linear functions along the yarns. Let r at each node be the w after it less the w before it (r = D w). Forces
balance at the nodes and at the vertices if

    F r = 0, that is r = B q for some q at the vertices,        h B' r = sum of s A g.

With the weights alpha and 1 - alpha neither condition holds: the gradient of a piecewise linear alpha jumps from
triangle to triangle, and the yarns that cross a triangle are a sample of its area. The energy of stretch along each
family therefore has weights of its own, w for each segment and s for each triangle and family, which differ from alpha
and 1 - alpha by some hundredths or tenths. They solve a least squares problem, within bounds between the weights of
yarns and of triangles. Its sum contains both conditions, a small part of the differences from alpha, and the sum of the
first condition along each passage of a yarn through the hybrid region, because a yarn moves along itself easily.

A passage has one condition for its sum, and each vertex one number q. With one ring there are more passages than
vertices, and the yarns of a triangle share the remaining error; with two rings and more the balance is nearly exact.
Borders of panels and ends of yarns have no condition, because tension does not end in the cloth there. Weights are
constants of a run, so energy and momentum are kept. Unbalanced forces from blending alone are known as ghost forces
where atoms and finite elements meet; every blend with the same weight for all energies has them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_array, csr_array, diags_array, hstack
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from stitchmesh.mixed.enrichment.region import HYBRID, TRIANGLES, Integers, Numbers, Region, basis_of
from stitchmesh.mixed.term import FULL

OF_PASSAGES = 3.0
"""Weight of the sums along passages, relative to the weight of the balance at a node."""
OF_SEGMENTS, OF_TRIANGLES = 1.0, 0.01
"""Weights of two kinds of differences: of w from alpha, over the mean number of segments of a passage, and of s from
1 - alpha. A difference that is spread over more segments leaves less at each node."""
OF_VERTICES = 1e-5
"""Weight of the numbers q, some of which are undetermined at vertices with few nodes."""
MOST_CHANGE = 0.9
"""Largest change of s, over 1 - alpha and over alpha, so that no triangle loses its stiffness."""
MOST_SEGMENTS = 1000
"""Largest number of segments of a family in the hybrid region with balanced weights; beyond it the weights stay alpha
and 1 - alpha. The matrix of the balance has dense blocks for all segments around a vertex, and some thousands take
minutes."""
MOST_ROUNDS = 50
"""Largest number of Newton steps within the bounds."""
ROUNDING = 1e-9
"""Rounding of weights."""


@dataclass(frozen=True, eq=False)
class StretchedCloth:
    """The values on which the tension of a weave depends."""

    gradients: Numbers
    """Gradients of the linear functions of the corners at rest [1/cm], shape (T, 3, 2); the yarns of family c run along
    axis c."""
    area: Numbers
    """Area of the triangles at rest [cm^2], shape (T,)."""
    border: NDArray[np.bool_]
    """Whether vertices lie on the border of a panel, shape (V,)."""
    segments: Integers
    """Layout numbers of the nodes before and after each segment, shape (E, 2)."""
    family: Integers
    """Family of each segment: 0, 1, or another number for a rod, shape (E,)."""
    spacing: Numbers
    """Distances of the yarns of both families [cm], shape (2,)."""


@dataclass(frozen=True, eq=False)
class StretchWeights:
    """Weights of the energies of stretch."""

    segments: Numbers
    """Weight w of each segment of yarn, shape (E,)."""
    triangles: Numbers
    """Weight s of each triangle along both families, shape (T, 2)."""


def balanced_weights(region: Region, cloth: StretchedCloth) -> StretchWeights:
    """The weights with which uniform tension of both families balances; alpha and 1 - alpha outside the hybrid region.

    Args:
        region: the region of interest.
        cloth: the triangles of the cloth, and the segments of its yarns.
    """
    segments = region.element_alpha(cloth.segments)
    triangles = np.repeat(1.0 - region.triangle_alpha[:, None], 2, axis=1)
    if not (region.triangle_kind == HYBRID).any():
        return StretchWeights(segments, triangles)
    for c in range(2):
        own = np.flatnonzero(cloth.family == c)
        balance = _Balance(region, cloth, own, c)
        if len(balance.segments) <= MOST_SEGMENTS:
            segments[own], triangles[:, c] = balance.solve(segments[own], triangles[:, c])
    return StretchWeights(segments, triangles)


class _Balance:
    """The conditions of one family."""

    def __init__(self, region: Region, cloth: StretchedCloth, own: Integers, c: int) -> None:
        ends, vertices = cloth.segments[own], len(region.vertex_alpha)
        node = np.flatnonzero(region.node_kind == HYBRID)
        number = np.full(len(region.node_triangle), -1)
        number[node] = np.arange(len(node))
        corners = region.triangles[region.node_triangle[node]]
        basis = basis_of(corners, region.node_weight[node], vertices)
        self.changes = _differences(number[ends], len(node))
        between = np.asarray(abs(self.changes).sum(axis=1)).ravel() > 1.0  # two segments
        self.inner = diags_array(between.astype(np.float64))
        self.passages = _passages(number[ends], len(node))
        whole = (region.node_alpha[ends] >= FULL).any(axis=1)
        exists = (region.node_kind[ends] != TRIANGLES).all(axis=1)
        self.segments = np.flatnonzero(exists & ~whole)
        weight = 1.0 - region.triangle_alpha
        self.triangles = np.flatnonzero((region.triangle_kind == HYBRID) & (weight > 0.0))
        self.vertices = np.flatnonzero(np.asarray(basis.power(2).sum(axis=0)).ravel() > 0.0)
        held = np.setdiff1d(region.triangles[self.triangles], np.flatnonzero(cloth.border))
        self.spacing, self.basis = float(cloth.spacing[c]), csr_array(basis[:, self.vertices])
        self.transposed = csr_array(basis.T)[held]
        pulls = cloth.gradients[:, :, c] * cloth.area[:, None]
        self.size = np.linalg.norm(pulls[self.triangles], axis=1)
        self.pulls = _pulls(region.triangles, pulls, vertices)[held]
        self.least = region.smallest_alpha

    def solve(self, segments: Numbers, triangles: Numbers) -> tuple[Numbers, Numbers]:
        """Return the weights w and s of the family, from alpha and 1 - alpha."""
        w, s = np.array(segments), np.array(triangles)
        free, hybrid = self.segments, self.triangles
        none, most = np.full(len(self.vertices), np.inf), MOST_CHANGE * np.minimum(s[hybrid], 1.0 - s[hybrid])
        low = np.concatenate([np.minimum(self.least - w[free], 0.0), -none, -most])
        high = np.concatenate([np.maximum(1.0 - w[free], 0.0), none, most])
        change = _within(*self._conditions(w, s), low, high)
        w[free] += change[: len(free)]
        s[hybrid] += change[len(change) - len(hybrid) :]
        return w, s

    def _conditions(self, w: Numbers, s: Numbers) -> tuple[csr_array, Numbers]:
        """Matrix and right side of the changes of w, q and s."""
        h, changes = self.spacing, self.changes[:, self.segments]
        left = self.inner @ (self.changes @ w)
        balance = h * hstack([self.inner @ changes, -(self.inner @ self.basis)])
        nodes, passages, vertices = len(left), self.passages.shape[0], self.transposed.shape[0]
        of_segment = OF_SEGMENTS / max(len(self.segments) / max(passages, 1), 1.0)
        kept = h * np.concatenate([np.full(len(self.segments), of_segment), np.full(len(self.vertices), OF_VERTICES)])
        rows = [
            [balance, csr_array((nodes, len(self.triangles)))],
            [OF_PASSAGES * (self.passages @ balance), csr_array((passages, len(self.triangles)))],
            [
                hstack([h * (self.transposed @ changes), csr_array((vertices, len(self.vertices)))]),
                -self.pulls[:, self.triangles],
            ],
            [diags_array(kept), None],
            [None, diags_array(OF_TRIANGLES * self.size)],
        ]
        at_vertices = h * (self.transposed @ (self.changes @ w)) - self.pulls @ s
        rest = np.zeros(len(kept) + len(self.triangles))
        right = np.concatenate([h * left, OF_PASSAGES * h * (self.passages @ left), at_vertices, rest])
        return csr_array(block_array(rows)), -right


def _within(matrix: csr_array, right: Numbers, low: Numbers, high: Numbers) -> Numbers:
    """Least squares within bounds by Newton steps on the unknowns that no bound holds (Bertsekas 1982)."""
    gram, pull = csr_array(matrix.T @ matrix), matrix.T @ right
    found = np.zeros(len(low))
    for _ in range(MOST_ROUNDS):
        slope = gram @ found - pull
        held = ((found <= low) & (slope > 0.0)) | ((found >= high) & (slope < 0.0))
        free = np.flatnonzero(~held)
        step = np.zeros(len(low))
        step[free] = splu(gram[free][:, free].tocsc()).solve(-slope[free])
        moved = _lowered(gram, pull, (low, high), found, step)
        if np.abs(moved - found).max(initial=0.0) < ROUNDING:
            break
        found = moved
    return found


def _lowered(gram: csr_array, pull: Numbers, bounds: tuple[Numbers, Numbers], found: Numbers, step: Numbers) -> Numbers:
    """The first point along a step, halved and clipped to the bounds, with a smaller sum of squares."""
    before, part = found @ (0.5 * (gram @ found) - pull), 1.0
    while part > ROUNDING:
        moved: Numbers = np.clip(found + part * step, *bounds)
        if moved @ (0.5 * (gram @ moved) - pull) < before:
            return moved
        part *= 0.5
    return found


def _differences(ends: Integers, count: int) -> csr_array:
    """D: from the weights of segments to the weight after less the weight before each hybrid node, shape (H, E)."""
    segment, side = np.nonzero(ends >= 0)
    sign = np.where(side == 0, 1.0, -1.0)
    return csr_array((sign, (ends[segment, side], segment)), shape=(count, len(ends)))


def _passages(ends: Integers, count: int) -> csr_array:
    """Sums over the nodes of each passage of a yarn through the hybrid region, shape (P, H)."""
    inside = ends[(ends >= 0).all(axis=1)]
    links = csr_array((np.ones(len(inside)), tuple(inside.T)), shape=(count, count))
    passages, number = connected_components(links, directed=False)
    return csr_array((np.ones(count), (number, np.arange(count))), shape=(passages, count))


def _pulls(triangles: Integers, values: Numbers, vertices: int) -> csr_array:
    """Matrix of the forces of a unit stress in each triangle on the vertices, shape (V, T)."""
    column = np.repeat(np.arange(len(triangles)), 3)
    return csr_array((values.ravel(), (triangles.ravel(), column)), shape=(vertices, len(triangles)))
