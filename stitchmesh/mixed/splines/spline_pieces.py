# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The material of B-spline yarns, and the pieces of them whose control points are simulated.

A segment of a yarn exists in the mixed system if its four control points are simulated. A piece is a run of consecutive
existing segments: an open yarn of its own, or the whole yarn. Where a yarn leaves the region its pieces end freely;
alpha is small there, and only F x holds the ends. The weight of a segment is alpha at its centroid (Casafranca et al.
2020, section 4.1).

Control points that belong to no segment have neither mass nor energy, like crossings without neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray, frozen_array
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.model.material import DEFAULT_MATERIAL, YarnMaterial


@dataclass(frozen=True)
class SplineMaterial:
    """Stiffnesses and sampling.

    Raises:
        ParameterError: the yarn has no mass, or a count is below 1.
    """

    yarn: YarnMaterial
    """Stiffness and mass of the yarn, for its radius."""
    quadrature_points: int = 3
    """Gauss points for each segment."""
    contact_samples: int = 4
    """Contact samples for each segment; long segments have more. A segment may become 2.6 radii long for each
    sample."""

    def __post_init__(self) -> None:
        if not self.yarn.mass_per_length > 0.0:
            raise ParameterError(f"spline yarns: got a mass of {self.yarn.mass_per_length} g/cm; expected more than 0")
        for name in ("quadrature_points", "contact_samples"):
            if getattr(self, name) < 1:
                raise ParameterError(f"spline yarns: {name}: got {getattr(self, name)}; expected at least 1")

    @staticmethod
    def named(name: str = DEFAULT_MATERIAL, *, radius: float) -> SplineMaterial:
        """A named material of ``YarnMaterial`` for yarn of a radius [cm].

        Raises:
            ParameterError: there is no material of that name, or the radius is not positive.
        """
        return SplineMaterial(YarnMaterial.named(name).of_radius(radius))

    @property
    def density(self) -> float:
        """Mass per length of yarn [g/cm]."""
        return self.yarn.mass_per_length


@dataclass(frozen=True, eq=False, kw_only=True)
class SplinePieces:
    """Pieces of yarns with K control points and S segments."""

    curves: YarnSet | None
    """The pieces; None if no segment exists."""
    node: IntArray
    """The simulated node of each control point, shape (K,); no node occurs twice."""
    alpha: FloatArray
    """Weight of each segment, shape (S,)."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "node", frozen_array(self.node, np.int64))
        object.__setattr__(self, "alpha", frozen_array(self.alpha, np.float64))


def spline_pieces(curves: YarnSet, *, nodes: ArrayLike | None = None, alpha: ArrayLike | None = None) -> SplinePieces:
    """Return the pieces of yarns.

    Args:
        curves: all yarns, laid out everywhere.
        nodes: numbers of the simulated control points, ascending; all by default.
        alpha: weight of each segment of the curves, 0 where it does not exist (``Region.element_alpha``), shape (S,);
            1 by default.

    Raises:
        ParameterError: alpha has the wrong shape, or an existing segment has a control point that is not simulated.
    """
    chosen = np.arange(len(curves.points)) if nodes is None else np.asarray(nodes, dtype=np.int64)
    count = len(curves.rest_length)
    weight = np.ones(count) if alpha is None else np.asarray(alpha, dtype=np.float64)
    if weight.shape != (count,):
        raise ParameterError(f"spline pieces: got alpha of shape {weight.shape}; expected ({count},)")
    number = np.full(len(curves.points), -1)
    number[chosen] = np.arange(len(chosen))
    exists = weight > 0.0
    wrong = np.flatnonzero(exists & (number[curves.segment_points] < 0).any(axis=1))
    if len(wrong):
        raise ParameterError(f"spline pieces: segment {wrong[0]}: has a weight; expected 0 where a node is missing")
    runs = [run for yarn in range(curves.yarn_count) for run in _runs(curves, yarn, exists)]
    if not runs:
        return SplinePieces(curves=None, node=np.zeros(0, dtype=np.int64), alpha=np.zeros(0))
    points = [_points_of_run(curves, segments, closed) for _yarn, segments, closed in runs]
    segments = np.concatenate([segments for _yarn, segments, _closed in runs])
    cut = _cut(curves, [yarn for yarn, _segments, _closed in runs], points, segments, [run[2] for run in runs])
    return SplinePieces(curves=cut, node=number[np.concatenate(points)], alpha=weight[segments])


def _runs(curves: YarnSet, yarn: int, exists: NDArray[np.bool_]) -> list[tuple[int, IntArray, bool]]:
    """Runs of existing segments of one yarn, in its order, and whether each run is a whole closed yarn."""
    first, last = curves.segment_start[yarn], curves.segment_start[yarn + 1]
    own = exists[first:last]
    closed = bool(curves.closed[yarn])
    if own.all():
        return [(yarn, np.arange(first, last), closed)] if len(own) else []
    # a closed yarn begins after a missing segment, so that no run passes from the last segment to the first one
    turn = int(np.argmin(own)) if closed else 0
    order = first + np.roll(np.arange(len(own)), -turn)
    present = np.flatnonzero(exists[order])
    breaks = np.flatnonzero(np.diff(present) > 1) + 1
    return [(yarn, order[run], False) for run in np.split(present, breaks) if len(run)]


def _points_of_run(curves: YarnSet, segments: IntArray, closed: bool) -> IntArray:
    """The control points of a run of segments, in its order."""
    firsts = curves.segment_points[segments, 0]
    return firsts if closed else np.concatenate([firsts, curves.segment_points[segments[-1], 1:]])


def _cut(curves: YarnSet, yarns: list[int], points: list[IntArray], segments: IntArray, closed: list[bool]) -> YarnSet:
    """The yarns of the runs; ``row`` and ``face`` are taken from the whole yarns."""
    point, of = np.concatenate(points), np.array(yarns)
    return YarnSet(
        points=curves.points[point],
        start=np.concatenate([[0], np.cumsum([len(run) for run in points])]),
        closed=np.array(closed),
        radius=curves.radius[of],
        rest_length=curves.rest_length[segments],
        row=curves.row[point],
        face=curves.face[point],
        part=curves.part[point],
        colour=curves.colour[of],
        natural_curvature=curves.natural_curvature[point],
    )
