# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns of an edited fabric that start from those relaxed before the edit.

The loss of relaxation by an edit is the first limitation that Leaf et al. 2018 name. Here the yarns of the fabric are
generated before and after the edit; a control point that lies where one lay before belongs to a stitch that the edit
did not touch, and goes where that one was relaxed to. The others are carried along: the displacement u(x) from
generated to relaxed places is known at all untouched points, and a touched point x takes

    u(x) = the value at x of the affine map that fits u best at its nearest untouched neighbours x_k,
    with weights w_k = exp(-|x_k - x|^2 / h^2) / (|x_k - x|^2 / h^2 + 1e-2)

(moving least squares, h the mean stitch width): one smooth field for all yarns, so that what is interlocked stays so,
which meets the relaxed points without a step.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.quality import DEFAULT_QUALITY, Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.generate import generate_yarns, mean_stitch_width

SAME_POINT_DISTANCE = 0.02
"""Distance over the yarn radius within which a control point is the one that lay there before."""
NEIGHBOURS = 64
"""Untouched control points by which a touched one is carried along."""
RIDGE = 1e-3
"""Weight, over that of the neighbours, of a field that does not vary: where they lie in a plane it decides."""


def regenerate_yarns(
    relaxed: YarnSet, before: StitchMesh, after: StitchMesh, *, quality: str | Quality = DEFAULT_QUALITY, **options: Any
) -> tuple[YarnSet, YarnSet]:
    """Yarns of an edited fabric, as generated, and in the place where to start relaxing them again.

    Give both to ``relax_yarns(generated, start=blended, keep_shape=after)``.

    Args:
        relaxed: yarns of the fabric before the edit, relaxed.
        before: that fabric.
        after: the edited fabric.
        quality: as the relaxed yarns were generated with.
        how: what else ``generate_yarns`` was told then.

    Returns:
        The yarns of ``after`` as generated, with the rest lengths and natural curvatures of ``relaxed`` where they are
        its own, and the same yarns with all untouched stitches as relaxed.

    Raises:
        ParameterError: the relaxed yarns were not generated from ``before`` with this quality.
        YarnError: as for ``generate_yarns``.
    """
    radius = float(relaxed.radius[0])  # a mean would round
    old = generate_yarns(before, yarn_radius=radius, quality=quality, **options)
    if not np.array_equal(old.start, relaxed.start):
        raise ParameterError(
            f"relaxed yarns: got {len(relaxed.points)} control points; this fabric and quality make {len(old.points)}, "
            "give those that the yarns were generated with"
        )
    new = generate_yarns(after, yarn_radius=radius, quality=quality, **options)
    old_number = untouched_points(old, new, SAME_POINT_DISTANCE * radius)
    known = np.flatnonzero(old_number >= 0)
    if len(known) < NEIGHBOURS:
        raise ParameterError("edit: leaves next to no stitch as it was; relax the edited fabric anew")
    points = np.empty_like(new.points)
    points[known] = relaxed.points[old_number[known]]
    new_points = np.flatnonzero(old_number < 0)
    shift = relaxed.points[old_number[known]] - new.points[known]
    points[new_points] = new.points[new_points] + _interpolated(
        new.points[known], shift, new.points[new_points], mean_stitch_width(after)
    )
    natural = np.where(old_number >= 0, relaxed.natural_curvature[old_number], 0.0)  # yarn is drawn straight at rest
    new = replace(new, rest_length=_rest_lengths(relaxed, old, new, old_number), natural_curvature=natural)
    return new, replace(new, points=points)


def untouched_points(old: YarnSet, new: YarnSet, within: float) -> IntArray:
    """Number of the old control point that lay in the place of each new one, -1 where none did, shape (N,)."""
    distance, nearest = cKDTree(old.points).query(new.points, distance_upper_bound=within)
    return np.where(np.isfinite(distance), nearest, -1)


def _interpolated(known: FloatArray, shift: FloatArray, points: FloatArray, width: float) -> FloatArray:
    """Displacement [cm] of points by moving least squares of the known ones, shape (n, 3)."""
    if len(points) == 0:
        return np.zeros((0, 3))
    nearest = cKDTree(known).query(points, k=NEIGHBOURS)[1]
    offset = (known[nearest] - points[:, None, :]) / width
    squares = np.sum(offset**2, axis=2)
    squares -= squares.min(axis=1, keepdims=True)  # far from all, the nearest still count
    weight = np.exp(-squares) / (squares + 1e-2)
    weight /= weight.sum(axis=1, keepdims=True)
    basis = np.concatenate([np.ones((*squares.shape, 1)), offset], axis=2)
    normal = np.einsum("pk,pki,pkj->pij", weight, basis, basis)
    normal[:, [1, 2, 3], [1, 2, 3]] += RIDGE
    right = np.einsum("pk,pki,pkd->pid", weight, basis, shift[nearest])
    return np.linalg.solve(normal, right)[:, 0]


def _rest_lengths(relaxed: YarnSet, old: YarnSet, new: YarnSet, old_number: IntArray) -> FloatArray:
    """Rest lengths [cm]: of an untouched segment its own, of others as generated times what all were changed by."""
    factor = relaxed.rest_length / old.rest_length
    segment_of = np.full(len(old.points), -1)
    segment_of[old.segment_points[:, 1]] = np.arange(len(factor))
    before = np.where(old_number[new.segment_points[:, 1]] >= 0, segment_of[old_number[new.segment_points[:, 1]]], -1)
    return new.rest_length * np.where(before >= 0, factor[before], np.median(factor))
