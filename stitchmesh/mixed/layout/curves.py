# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarn curves for display, from the nodes of crossing yarns (Cirio et al. 2014: procedural splines).

At a crossing both yarns have the place of the node. For display the upper yarn is displaced along the normal of the
cloth and the lower one against it, each by half the sum of their radii, so that they touch. Between the two nodes of a
stitch contact the yarns of a knit run side by side. Each has one more point there, displaced along the cloth by the
same distance: the point of the new loop to the right as seen along the yarn, the point of the old loop to the left. At
a rod no yarn is displaced. A cubic B-spline passes through all these points; at the ends of a yarn it is straight.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.mixed.cloth.cloth import Cloth, vertex_normals
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.yarn import UNKNOWN_FACE, YarnSet


def yarn_curves(
    cloth: Cloth, yarns: CrossingYarns, *, radius: float | ArrayLike, nodes: ArrayLike | None = None,
    vertices: ArrayLike | None = None, measured: bool = True,
) -> YarnSet:  # fmt: skip
    """Return the yarns as B-splines in space, numbered as the crossing yarns; the colour is the family.

    Args:
        cloth: the cloth on which the yarns are laid out.
        yarns: the yarns.
        radius: radius of all yarns [cm], or of each yarn, shape (Y,).
        nodes: places of the nodes in space [cm], shape (N, 3); on the triangles by default.
        vertices: positions of the vertices [cm], shape (V, 3), which give the normals; by default those of the cloth.
        measured: whether rest lengths are the lengths of the curves; a picture needs none, and measuring them takes
            four fifths of the time.

    Raises:
        ParameterError: the nodes are not N points.
        YarnError: a radius is not a positive number, or a coordinate is not finite.
    """
    corners = cloth.vertices if vertices is None else np.asarray(vertices, dtype=np.float64)
    place = yarns.world(cloth, corners) if nodes is None else np.asarray(nodes, dtype=np.float64)
    if place.shape != (yarns.node_count, 3):
        raise ParameterError(f"yarn curves: nodes: got shape {place.shape}; expected ({yarns.node_count}, 3)")
    thickness = np.broadcast_to(np.asarray(radius, dtype=np.float64), yarns.yarn_count)
    normal = normals_at(cloth, yarns.triangle, yarns.barycentric, corners)
    points, start = _curve_points(yarns, place, normal, thickness)
    control, start = interpolating_points(points, start)
    made = _yarn_set(yarns, control, start, thickness)
    return replace(made, rest_length=made.lengths) if measured else made


def normals_at(cloth: Cloth, triangle: IntArray, barycentric: FloatArray, vertices: FloatArray) -> FloatArray:
    """Return the unit normals of the cloth at points in triangles, interpolated from the vertices, shape (n, 3)."""
    at_vertices = vertex_normals(cloth.triangles, vertices)
    normals: FloatArray = np.einsum("nk,nkd->nd", barycentric, at_vertices[cloth.triangles[triangle]])
    return unit_vectors(normals)


def _curve_points(
    yarns: CrossingYarns, place: FloatArray, normal: FloatArray, radius: FloatArray
) -> tuple[FloatArray, IntArray]:
    """The points that each yarn passes, and the number of the first point of each yarn with the total at the end."""
    node, is_v = yarns.yarn_node, yarns.yarn_coordinate == 1
    pair = yarns.node_yarn
    apart = np.where(pair < 0, 0.0, radius[pair]).sum(axis=1) / 2  # half the distance of the two yarns of each node
    sign = np.where(is_v, -1.0, 1.0)
    points = place[node] + normal[node] * (sign * yarns.side[node] * apart[node])[:, None]
    first = np.flatnonzero(_within_contacts(yarns))
    one, other = node[first], node[first + 1]
    aside = unit_vectors(np.cross(place[other] - place[one], normal[one] + normal[other]))
    between = (place[one] + place[other]) / 2 + aside * (sign[first] * (apart[one] + apart[other]) / 2)[:, None]
    points = np.insert(points, first + 1, between, axis=0)
    return points, yarns.yarn_start + np.searchsorted(first, yarns.yarn_start)


def _within_contacts(yarns: CrossingYarns) -> NDArray[np.bool_]:
    """Whether the yarn runs from each passage to the next one within a stitch contact, shape (M,)."""
    partner = np.full(yarns.node_count, -1)
    partner[yarns.stitch_contacts] = yarns.stitch_contacts[:, ::-1]
    within = np.zeros(len(yarns.yarn_node), dtype=np.bool_)
    same = yarns.passage_yarn[1:] == yarns.passage_yarn[:-1]
    within[:-1] = same & (partner[yarns.yarn_node[:-1]] == yarns.yarn_node[1:])
    return within


def interpolating_points(points: FloatArray, start: IntArray) -> tuple[FloatArray, IntArray]:
    """Return control points of uniform cubic B-splines that pass through points, and straight ends.

    Args:
        points: points of all curves, at least two of each, shape (n, 3).
        start: first point of each curve, and n at the end, shape (Y + 1,).

    Returns:
        The control points, two more for each curve, and their ``start``.
    """
    from scipy.linalg import solve_banded

    first, last = start[:-1], start[1:] - 1
    inside = np.full(len(points), 1.0 / 6.0)
    inside[first] = inside[last] = 0.0  # a curve ends at its last control point; curves do not act on one another
    # the equation of point i has its upper band in column i + 1 and its lower band in column i - 1
    bands = np.stack([np.roll(inside, 1), 1.0 - 2.0 * inside, np.roll(inside, -1)])
    inner = solve_banded((1, 1), bands, points, overwrite_ab=True)
    before, after = 2 * inner[first] - inner[first + 1], 2 * inner[last] - inner[last - 1]
    places, ends = np.stack([first, last + 1], axis=1), np.stack([before, after], axis=1)
    made = np.insert(inner, places.ravel(), ends.reshape(-1, 3), axis=0)
    return made, start + 2 * np.arange(len(start))


def _yarn_set(yarns: CrossingYarns, control: FloatArray, start: IntArray, radius: FloatArray) -> YarnSet:
    return YarnSet(
        points=control,
        start=start,
        closed=np.zeros(yarns.yarn_count, dtype=np.bool_),
        radius=radius,
        rest_length=np.ones(len(control) - 3 * yarns.yarn_count),
        row=np.repeat(np.arange(yarns.yarn_count), np.diff(start)),
        face=np.full(len(control), UNKNOWN_FACE),
        part=np.zeros(len(control), dtype=np.int64),
        colour=yarns.yarn_family,
    )
