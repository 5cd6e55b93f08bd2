# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact points: the spheres that represent a cloth in contact (Casafranca et al. 2020, section 6.1).

A contact point lies on a triangle, where its position is a weighted mean of three vertices, or at a yarn node:

    c = sum over k of  share_k x_k,    x = (vertices v, nodes p)

It stands for an area of cloth. The area is multiplied by the weight of blending, 1 - alpha on triangles and alpha at
nodes, so that a hybrid region, which has points of both kinds, counts once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray, frozen_array


@dataclass(frozen=True, eq=False)
class ContactPoints:
    """M contact points of a cloth with V vertices and N simulated nodes.

    Raises:
        ParameterError: arrays of other shapes, an index out of range, an area or a radius that is not positive, or a
            number that is not finite.
    """

    vertex_count: int
    """Number V of triangle vertices."""
    node_count: int
    """Number N of yarn nodes."""
    index: IntArray
    """The three positions whose mean a point is: vertex j is j, node i is V + i; shape (M, 3)."""
    share: FloatArray
    """Weights of the three positions, which sum to 1; shape (M, 3)."""
    area: FloatArray
    """Area of cloth that each point stands for, times its weight of blending [cm^2]; shape (M,)."""
    radius: FloatArray
    """Distance that each point keeps from a body, half the thickness of the cloth [cm]; shape (M,)."""
    layer_radius: FloatArray
    """Radius of the sphere at each point in contact with other layers [cm]: half the thickness, or half the distance of
    neighbouring points where this is larger, so that no layer fits through the holes of another one; shape (M,)."""
    panel: IntArray
    """Panel of each point; shape (M,)."""
    rest: FloatArray
    """Place of each point in its panel at rest [cm]; shape (M, 2)."""

    def __post_init__(self) -> None:
        for name in ("index", "panel"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.int64))
        for name in ("share", "area", "radius", "layer_radius", "rest"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.float64))
        self._check_shapes()
        self._check_numbers()

    def _check_shapes(self) -> None:
        count = len(self.area)
        flat = dict.fromkeys(("radius", "layer_radius", "panel"), (count,))
        expected = {"index": (count, 3), "share": (count, 3), "rest": (count, 2), **flat}
        for name, shape in expected.items():
            found = getattr(self, name).shape
            if found != shape:
                raise ParameterError(f"contact points: {name}: got shape {found}; expected {shape}")

    def _check_numbers(self) -> None:
        most = self.vertex_count + self.node_count
        wrong = np.flatnonzero(((self.index < 0) | (self.index >= most)).any(axis=1))
        if len(wrong):
            found = f"got the positions {self.index[wrong[0]].tolist()}"
            raise ParameterError(f"contact points: point {int(wrong[0])}: {found}; expected 0 to {most - 1}")
        for name in ("area", "radius", "layer_radius"):
            values = getattr(self, name)
            wrong = np.flatnonzero(~((values > 0.0) & np.isfinite(values)))
            if len(wrong):
                found = f"point {int(wrong[0])}: got {float(values[wrong[0]])}"
                raise ParameterError(f"contact points: {name} of {found}; expected a positive number")
        if not (np.isfinite(self.share).all() and np.isfinite(self.rest).all()):
            raise ParameterError("contact points: got shares or rest places that are not finite; expected numbers")

    def __len__(self) -> int:
        return len(self.area)

    def places(self, vertices: FloatArray, nodes: FloatArray) -> FloatArray:
        """Positions of the points [cm], shape (M, 3), from those of vertices, (V, 3), and nodes, (N, 3)."""
        positions = np.concatenate([np.reshape(vertices, (-1, 3)), np.reshape(nodes, (-1, 3))])
        return np.einsum("mk,mkd->md", self.share, positions[self.index])


def points_at_nodes(
    vertex_count: int,
    *,
    panel: ArrayLike,
    rest: ArrayLike,
    area: ArrayLike,
    weight: ArrayLike,
    thickness: float,
) -> ContactPoints:
    """One contact point at each yarn node that has a weight.

    Args:
        vertex_count: number V of triangle vertices, after which nodes are numbered.
        panel: panel of each node, shape (N,).
        rest: place of each node in its panel [cm], shape (N, 2).
        area: area of cloth that each node stands for [cm^2], shape (N,) or one number.
        weight: weight of blending of each node, alpha, shape (N,) or one number.
        thickness: thickness of the cloth [cm].

    Raises:
        ParameterError: as ``ContactPoints``, or a thickness that is not positive.
    """
    panels = np.asarray(panel, dtype=np.int64)
    count = len(panels)
    areas = np.broadcast_to(np.asarray(area, dtype=np.float64) * np.asarray(weight, dtype=np.float64), count)
    kept = np.flatnonzero(areas != 0.0)
    return ContactPoints(
        vertex_count,
        count,
        np.repeat(vertex_count + kept, 3).reshape(-1, 3),
        np.tile([1.0, 0.0, 0.0], (len(kept), 1)),
        areas[kept],
        np.full(len(kept), 0.5 * checked_thickness(thickness)),
        np.full(len(kept), 0.5 * thickness),
        panels[kept],
        np.reshape(rest, (-1, 2))[kept],
    )


def join_points(parts: Sequence[ContactPoints]) -> ContactPoints:
    """All points of several sets for the same vertices and nodes, in the given order.

    Raises:
        ParameterError: there is no set, or the sets are for different numbers of vertices.
    """
    if len({part.vertex_count for part in parts}) != 1:
        found = [part.vertex_count for part in parts]
        raise ParameterError(f"contact points: got sets for {found} vertices; expected sets for one cloth")
    arrays = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in ("index", "share", "area", "radius", "layer_radius", "panel", "rest")
    }
    return ContactPoints(parts[0].vertex_count, max(part.node_count for part in parts), **arrays)


def checked_thickness(thickness: float) -> float:
    """A thickness, if it is a positive number.

    Raises:
        ParameterError: it is not.
    """
    if not (np.isfinite(thickness) and thickness > 0.0):
        raise ParameterError(f"contact: got a thickness of {thickness} cm; expected a positive number")
    return float(thickness)
