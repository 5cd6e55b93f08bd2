# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where yarn passes through yarn on its way from one state to another.

Between two moments the ends of edges move on straight lines. Two edges from p to p + u and from q to q + v can only
meet while they lie in one plane,

    f(t) = (u x v) . (q - p) = 0,

a cubic in t; they do if each then crosses the other's line between its ends. The sign of a pass is that of f after it:
1 where a right-handed crossing becomes a left-handed one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.loop_check.deformation_path import Way
from stitchmesh.yarngen.loop_check.strands import Ends, Strands

MOMENTS = 24
"""Equal parts of a way; on each of them edges move on straight lines."""
BERNSTEIN = np.array([[6, 0, 0, 0], [-5, 18, -9, 2], [2, -9, 18, -5], [0, 0, 0, 6]]) / 6.0
"""From the values of a cubic at 0, 1/3, 2/3 and 1 to its Bernstein coefficients, between which it stays."""
POWERS = np.array([[-1, 3, -3, 1], [3, -6, 3, 0], [-3, 3, 0, 0], [1, 0, 0, 0]])
"""From Bernstein coefficients to those of t^3, t^2, t and 1."""


@dataclass(frozen=True)
class Pass:
    """Two edges that pass through one another."""

    first: int
    """Sampled point at which the one edge starts."""
    second: int
    """Sampled point at which the other one starts."""
    image: tuple[int, int]
    """Lattice image of the second edge, seen from the first."""
    time: float
    """When, from 0 to 1."""
    sign: int
    """1 where a right-handed crossing becomes a left-handed one, else -1."""


@dataclass(frozen=True, eq=False)
class Journey:
    """Yarns at equal moments on a way, and what passes through what in between."""

    strands: Strands
    """How their polylines run on."""
    states: list[YarnSet]
    """The yarns at each moment, the first and the last one included."""
    ends: list[Ends]
    """Ends of their edges at each moment."""
    passes: list[Pass]
    """In the order of time."""

    @classmethod
    def along(cls, way: Way) -> Journey:
        """Go that way."""
        strands = Strands(way.begin)
        states = [way.at(moment / MOMENTS) for moment in range(MOMENTS + 1)]
        ends = [Ends.of(strands, state) for state in states]
        passes: list[Pass] = []
        for moment in range(MOMENTS):
            between = _Between(strands, states[moment], states[moment + 1], ends[moment], ends[moment + 1])
            passes += between.passes(moment / MOMENTS, 1.0 / MOMENTS)
        return cls(strands, states, ends, passes)

    def at(self, time: float) -> tuple[Ends, Lattice | None]:
        """Ends of edges and lattice at a time from 0 to 1."""
        moment = min(int(time * MOMENTS), MOMENTS - 1)
        part = time * MOMENTS - moment
        before, after = self.ends[moment : moment + 2]
        ends = Ends((1 - part) * before.first + part * after.first, (1 - part) * before.second + part * after.second)
        one, two = (state.lattice for state in self.states[moment : moment + 2])
        return ends, None if one is None or two is None else Lattice((1 - part) * one.periods + part * two.periods)


@dataclass(frozen=True, eq=False)
class _Between:
    """Edges on straight lines between two moments."""

    strands: Strands
    before: YarnSet
    after: YarnSet
    begin: Ends
    end: Ends

    def passes(self, begun: float, duration: float) -> list[Pass]:
        """Passes in the order of their time; the interval begins at one and lasts for another."""
        pairs = self._in_one_plane(self._apart(self._meeting_boxes()))
        found = []
        for pair, cubic in zip(pairs, (BERNSTEIN @ self._heights(pairs)).T, strict=True):
            powers = POWERS @ cubic
            for root in np.roots(powers):
                time = float(root.real)
                if root.imag == 0.0 and 0.0 <= time < 1.0 and self._met(pair, time):
                    sign = int(np.sign(np.polyval(np.polyder(powers), time)))
                    first, second = self.strands.edges[pair[:2]].tolist()
                    found.append(Pass(first, second, (int(pair[2]), int(pair[3])), begun + duration * time, sign))
        return sorted(found, key=lambda each: each.time)

    def _meeting_boxes(self) -> IntArray:
        """Pairs of edges whose ways' boxes meet and the image of the second one, shape (n, 4)."""
        images = self._images()
        count = len(self.begin.first)
        low, high = (np.concatenate([bound(image) for image in images]) for bound in (self._lower, self._upper))
        near = np.flatnonzero(((low <= high[:count].max(axis=0)) & (high >= low[:count].min(axis=0))).all(axis=1))
        low, high = low[near], high[near]
        reach = float((high - low).max())
        i, j = cKDTree((low + high) / 2).query_pairs(reach, p=np.inf, output_type="ndarray").T
        met = (i < count) & ((low[i] <= high[j]) & (low[j] <= high[i])).all(axis=1)
        i, j = i[met], near[j[met]]
        return np.column_stack([i, j % count, images[j // count]])

    def _images(self) -> IntArray:
        """Of every two opposite images in which edges come near one another one, (0, 0) first, shape (m, 2)."""
        if self.before.lattice is None or self.after.lattice is None:
            return np.zeros((1, 2), dtype=np.int64)
        found = [
            image
            for lattice, ends in ((self.before.lattice, self.begin), (self.after.lattice, self.end))
            for image in lattice.near_images(np.concatenate([ends.first, ends.second]), 0.0).tolist()
        ]
        return np.array(sorted({(a, b) for a, b in found if (a, b) >= (0, 0)}), dtype=np.int64)

    def _shifts(self, image: IntArray) -> list[FloatArray]:
        """Lattice shifts at both moments [cm], shape (..., 3)."""
        return [
            np.zeros((*np.shape(image)[:-1], 3)) if yarns.lattice is None else yarns.lattice.shift(image)
            for yarns in (self.before, self.after)
        ]

    def _lower(self, image: IntArray) -> FloatArray:
        return np.minimum.reduce(self._corners(image))

    def _upper(self, image: IntArray) -> FloatArray:
        return np.maximum.reduce(self._corners(image))

    def _corners(self, image: IntArray) -> list[FloatArray]:
        before, after = self._shifts(image)
        return [self.begin.first + before, self.begin.second + before, self.end.first + after, self.end.second + after]

    def _apart(self, pairs: IntArray) -> IntArray:
        """Pairs without a common end."""
        (i, j), image = self.strands.edges[pairs[:, :2].T], pairs[:, 2:]
        after, step = self.strands.following, self.strands.following_image
        shares = (after[i] == j) & (step[i] == image).all(axis=1)
        shares |= (after[j] == i) & (step[j] == -image).all(axis=1)
        return pairs[~shares]

    def _in_one_plane(self, pairs: IntArray) -> IntArray:
        """Pairs that may lie in one plane at some time."""
        cubics = BERNSTEIN @ self._heights(pairs)
        return pairs[(cubics.min(axis=0) <= 0.0) & (cubics.max(axis=0) >= 0.0)]

    def _heights(self, pairs: IntArray) -> FloatArray:
        """The cubic of the module's docstring at four equal times, shape (4, n)."""
        return np.stack([self._height(*self._at(pairs, time)) for time in (0.0, 1 / 3, 2 / 3, 1.0)])

    @staticmethod
    def _height(p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        height: FloatArray = np.einsum("nk,nk->n", np.cross(u, v), q - p)
        return height

    def _at(self, pairs: IntArray, time: float) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """p, u, q and v at a time, shape (n, 3) each."""
        i, j = pairs[:, :2].T
        first, second = ((1 - time) * a + time * b for a, b in ((self.begin.first, self.end.first),
                                                                 (self.begin.second, self.end.second)))  # fmt: skip
        before, after = self._shifts(pairs[:, 2:])
        return first[i], second[i] - first[i], first[j] + (1 - time) * before + time * after, second[j] - first[j]

    def _met(self, pair: IntArray, time: float) -> bool:
        """Whether two edges in one plane cross."""
        p, u, q, v = (value[0] for value in self._at(pair[None], time))
        (s, t), *_ = np.linalg.lstsq(np.stack([u, -v], axis=1), q - p, rcond=None)
        return bool(0.0 <= s < 1.0 and 0.0 <= t < 1.0)
