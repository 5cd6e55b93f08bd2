# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Crossings of two edges that move on straight lines, decided without rounding errors.

One edge goes from p to p + u, the other from q to q + v; all four are linear in the time t from 0 to 1. The edges have
a common point where p + a u = q + b v with a and b from 0 to 1. With n = u x v and w = q - p this is

    f = n . w = 0,        a n.n = (w x v) . n,        b n.n = (w x u) . n.

f is a cubic polynomial in t, and a n.n and b n.n are quartic. In the Bernstein basis a polynomial lies between its
smallest and its largest coefficient, and a cubic polynomial whose coefficients change sign once has one root. An
interval of time therefore contains

- no crossing if all coefficients of f have one sign, or if all coefficients of a n.n, of (1 - a) n.n, of b n.n or of
  (1 - b) n.n are negative,
- exactly one crossing if the coefficients of f change sign once and all coefficients of these four quartics are
  positive.

Most pairs do not cross, because f has one sign during the whole motion. Any other interval is halved (Lane and
Riesenfeld 1981). The result is certain if the signs of the coefficients are certain. They are in double precision where
a coefficient exceeds a bound of its rounding error. Otherwise they are computed with whole numbers, which requires that
all coordinates are whole multiples of a unit. The halving ends for edges in general position, because f then has simple
roots and no vertex lies on an edge at these times.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import FloatArray, IntArray

ROUNDING = 2.0**-42
"""Bound of the rounding error of a coefficient, over the product of the lengths from which it is computed.

A coefficient is a sum of less than 60 products after at most 10 roundings, and each halving adds 4 roundings. The error
is less than 2^9 units of 2^-53 in all.
"""
DOUBLE_HALVINGS, WHOLE_HALVINGS = 16, 160
"""Largest number of halvings of time, in double precision and with whole numbers."""


class NotInGeneralPosition(StitchMeshError):
    """Two edges meet at a vertex, or they touch without crossing."""


@dataclass(frozen=True, eq=False)
class EdgePairs:
    """Pairs of moving edges, at the start and at the end of their motion."""

    u: FloatArray
    """Vector along each first edge [cm], shape (2, n, 3)."""
    v: FloatArray
    """Vector along each second edge [cm], shape (2, n, 3)."""
    w: FloatArray
    """Vector from the first point of each first edge to the first point of the second edge [cm], shape (2, n, 3)."""

    def some(self, which: NDArray[Any]) -> EdgePairs:
        """The pairs that are selected by their numbers or by a mask."""
        return EdgePairs(self.u[:, which], self.v[:, which], self.w[:, which])

    def in_units(self, unit: float) -> EdgePairs:
        """The pairs in units, as whole numbers of any size."""
        return EdgePairs(*(np.rint(part / unit).astype(np.int64).astype(object) for part in (self.u, self.v, self.w)))

    def lengths(self) -> list[FloatArray]:
        """Bounds of the lengths of u, v and w at all times [cm], three arrays of shape (n,)."""
        return [np.abs(part).sum(axis=-1).max(axis=0) for part in (self.u, self.v, self.w)]


@dataclass(frozen=True, eq=False)
class EdgeCrossings:
    """Crossings of pairs of edges."""

    pair: IntArray
    """Number of the pair, shape (c,)."""
    time: FloatArray
    """Time of each crossing, from 0 to 1, shape (c,)."""
    sign: IntArray
    """Sign of f after each crossing, shape (c,)."""


def edge_crossings(pairs: EdgePairs, unit: float) -> EdgeCrossings:
    """All crossings of pairs of moving edges.

    Args:
        pairs: edges in general position; all coordinates are whole multiples of the unit and below 2^53 units.
        unit: the unit, a power of two [cm].

    Raises:
        NotInGeneralPosition: two edges meet at a vertex, or they touch without crossing.
    """
    volume, error = _volume(pairs), _volume_error(pairs)
    number = np.flatnonzero((volume <= error).any(axis=1) & (volume >= -error).any(axis=1))
    turning = pairs.some(number)
    place_error = _place_error(turning)[:, None]
    found, undecided = _isolate(volume[number], _places(turning), error[number], place_error, DOUBLE_HALVINGS)
    whole = turning.some(undecided).in_units(unit)
    no_error = np.zeros((len(undecided), 1), dtype=object)
    exact, left = _isolate(_volume(whole), _places(whole), no_error, no_error[:, None], WHOLE_HALVINGS)
    if len(left):
        raise NotInGeneralPosition(f"{len(left)} pairs of moving edges meet at a vertex, or touch without crossing")
    return EdgeCrossings(
        number[np.concatenate([found.pair, undecided[exact.pair]])],
        np.concatenate([found.time, exact.time]),
        np.concatenate([found.sign, exact.sign]),
    )


def _volume(pairs: EdgePairs) -> NDArray[Any]:
    """Bernstein coefficients of 3 f, shape (n, 4)."""
    cubic = _product(_dot, _product(np.cross, list(pairs.u), list(pairs.v)), list(pairs.w))
    return np.stack([c * k for c, k in zip(cubic, (3, 1, 1, 3), strict=True)], axis=-1)


def _places(pairs: EdgePairs) -> NDArray[Any]:
    """Bernstein coefficients of 12 times the four quartics, shape (n, 4, 5)."""
    u, v, w = list(pairs.u), list(pairs.v), list(pairs.w)
    normal = _product(np.cross, u, v)
    square = _product(_dot, normal, normal)
    first, second = (_product(_dot, _product(np.cross, w, other), normal) for other in (v, u))
    quartics = [part for one in (first, second) for part in (one, [a - b for a, b in zip(square, one, strict=True)])]
    return np.stack(
        [np.stack([c * k for c, k in zip(one, (12, 3, 2, 3, 12), strict=True)], axis=-1) for one in quartics], axis=1
    )


def _product(times: Callable[..., NDArray[Any]], a: list[NDArray[Any]], b: list[NDArray[Any]]) -> list[NDArray[Any]]:
    """Product of two polynomials, by Bernstein coefficients times binomial coefficients (Farouki and Rajan 1988)."""
    terms: list[Any] = [0] * (len(a) + len(b) - 1)
    for i, one in enumerate(a):
        for j, two in enumerate(b):
            terms[i + j] = terms[i + j] + times(one, two)
    return terms


def _dot(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    """Scalar products of vectors, by operations that also exist for whole numbers of any size."""
    result: NDArray[Any] = a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]
    return result


def _volume_error(pairs: EdgePairs) -> FloatArray:
    """Bound of the rounding errors of ``_volume``, shape (n, 1)."""
    u, v, w = pairs.lengths()
    return ROUNDING * (3.0 * u * v * w)[:, None]


def _place_error(pairs: EdgePairs) -> FloatArray:
    """Bound of the rounding errors of ``_places``, shape (n, 1)."""
    u, v, w = pairs.lengths()
    return ROUNDING * (12.0 * u * v * (u * v + w * np.maximum(u, v)))[:, None]


def _isolate(
    f: NDArray[Any], g: NDArray[Any], f_error: NDArray[Any], g_error: NDArray[Any], halvings: int
) -> tuple[EdgeCrossings, IntArray]:
    """Find intervals of time with exactly one crossing each.

    Args:
        f: coefficients of the cubics, shape (n, 4).
        g: coefficients of the quartics, shape (n, 4, 5).
        f_error: bounds of the errors of ``f``, shape (n, 1).
        g_error: bounds of the errors of ``g``, shape (n, 1, 1).
        halvings: largest number of halvings.

    Returns:
        The crossings, and the numbers of the pairs that are not decided after these halvings.
    """
    pair: IntArray = np.arange(len(f))
    begin, duration = np.zeros(len(f)), 1.0
    found, undecided = [], []
    for _ in range(halvings + 1):
        sign = (f > f_error).astype(np.int64) - (f < -f_error)
        outside, inside = np.less(g, -g_error).all(axis=2).any(axis=1), np.greater(g, g_error).all(axis=(1, 2))
        empty = (np.abs(sign.sum(axis=1)) == 4) | outside
        from_first = sign * sign[:, :1]
        changes_once = (from_first[:, 3] < 0) & ((from_first[:, 1] > 0) | (from_first[:, 2] < 0))
        one = ~empty & changes_once & inside
        found.append((pair[one], begin[one] + duration * _root(f[one]), sign[one, 3]))
        lost = ~empty & (sign == 0).all(axis=1)  # more halvings would not decide them
        undecided.append(pair[lost])
        rest = np.flatnonzero(~empty & ~one & ~lost)
        pair, duration = np.tile(pair[rest], 2), duration / 2.0
        begin = np.concatenate([begin[rest], begin[rest] + duration])
        f, g = _halves(f[rest]), _halves(g[rest])
        f_error, g_error = np.tile(f_error[rest] * 8, (2, 1)), np.tile(g_error[rest] * 16, (2, 1, 1))
        if len(pair) == 0:
            break
    left: IntArray = np.unique(np.concatenate([*undecided, pair]))
    pair, time, sign = (np.concatenate(column) for column in zip(*found, strict=True))
    decided = ~np.isin(pair, left)
    return EdgeCrossings(pair[decided], time[decided], sign[decided]), left


def _halves(c: NDArray[Any]) -> NDArray[Any]:
    """Coefficients on both halves of the time, by de Casteljau's algorithm, times 2^degree.

    The result has all first halves, and then all second halves.
    """
    degree = c.shape[-1] - 1
    rows = [c]
    for _ in range(degree):
        rows.append(rows[-1][..., 1:] + rows[-1][..., :-1])
    left = np.stack([rows[k][..., 0] * 2 ** (degree - k) for k in range(degree + 1)], axis=-1)
    right = np.stack([rows[degree - k][..., k] * 2**k for k in range(degree + 1)], axis=-1)
    return np.concatenate([left, right])


def _root(f: NDArray[Any]) -> FloatArray:
    """Time from 0 to 1 at which each cubic is zero, shape (n, 4) to (n,); the cubic has opposite signs at 0 and 1."""
    if len(f) == 0:
        return np.zeros(0)
    b = (f / np.abs(f).max(axis=1, keepdims=True)).astype(np.float64)
    low, high = np.zeros(len(b)), np.ones(len(b))
    # Number of halvings that determine the time of a crossing after the crossing has been found.
    for _ in range(44):
        t = (low + high) / 2.0
        s = 1.0 - t
        value = s**3 * b[:, 0] + 3 * s * s * t * b[:, 1] + 3 * s * t * t * b[:, 2] + t**3 * b[:, 3]
        before = (value > 0.0) == (b[:, 0] > 0.0)
        low, high = np.where(before, t, low), np.where(before, high, t)
    return (low + high) / 2.0
