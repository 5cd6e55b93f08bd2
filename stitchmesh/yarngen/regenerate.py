# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns of an edited fabric, placed by the relaxed yarns of the fabric before the edit.

In the program of Leaf et al. 2018 an edit discards the relaxation; they name this as their first limitation. Here the
yarns are generated twice, from the fabric before the edit and from the edited fabric. A new control point that
coincides with an old one belongs to a stitch that the edit did not change; the point takes the relaxed position of the
old one. All other new control points follow the displacement field of the unchanged ones. The displacement u(x) from
generated to relaxed positions is known at the unchanged points. A changed point x takes

    u(x) = the value at x of the affine map that fits u best at its nearest unchanged neighbours x_k,
    with weights w_k = exp(-|x_k - x|^2 / h^2) / (|x_k - x|^2 / h^2 + 1e-2)

(moving least squares; h is the mean stitch width). The field is smooth and the same for all yarns, so interlocked yarns
stay interlocked, and it continues the displacement of the unchanged points without a jump.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.spatial import cKDTree

from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.finish import DEFAULT_FINISH, YarnFinish
from stitchmesh.yarngen.generate import generate_yarns, mean_stitch_width, trace_yarn_routes, yarns_along_routes

NEIGHBOURS = 64
"""Number of unchanged control points from which the displacement of a changed one is computed."""
RIDGE = 1e-3
"""Weight of a constant displacement field, over the weight of the neighbours. It determines the fit where the
neighbours lie in a plane."""


@dataclass(frozen=True, eq=False)
class WarmStart:
    """Yarns of an edited fabric, and the positions from which their relaxation starts."""

    generated: YarnSet
    """The yarns as generated, with the rest lengths, natural curvatures and mass of the relaxed yarns before
    the edit."""
    start: YarnSet | None
    """The same yarns with all unchanged stitches at their relaxed positions; None if hardly any stitch is unchanged."""
    warm: float
    """Part of the control points that start from relaxed positions, 0 to 1; 0 if there is no start."""


def regenerate_yarns(
    relaxed: YarnSet, before: StitchMesh, after: StitchMesh, *, quality: str | Quality = DEFAULT_QUALITY,
    finish: YarnFinish = DEFAULT_FINISH,
) -> tuple[YarnSet, YarnSet]:
    """Yarns of an edited fabric: as generated, and at the positions at which a new relaxation starts.

    Pass both results to ``relax_yarns(generated, keep_shape=after, run=Run(start=blended))``. ``relax_edited`` does so,
    and also relaxes a fabric if hardly any of its stitches is unchanged.

    Args:
        relaxed: relaxed yarns of the fabric before the edit.
        before: the stitch mesh before the edit.
        after: the edited stitch mesh.
        quality: the quality with which the relaxed yarns were generated.
        finish: the finish with which the relaxed yarns were generated.

    Returns:
        The yarns of ``after`` as generated, with the rest lengths and natural curvatures of ``relaxed`` for unchanged
        stitches; and the same yarns with all unchanged stitches at their relaxed positions.

    Raises:
        ParameterError: the relaxed yarns were not generated from ``before`` with this quality, or hardly any stitch is
            unchanged.
        YarnError: as for ``generate_yarns``.

    Source: Leaf et al. 2018 (the limitation). Moving least squares is described by Levin 1998.
    """
    made = warm_start(relaxed, before, after, quality=quality, finish=finish)
    if made.start is None:
        raise ParameterError("edit: leaves next to no stitch as it was; relax the edited fabric anew")
    return made.generated, made.start


def warm_start(
    relaxed: YarnSet, before: StitchMesh, after: StitchMesh, *, evened: StitchMesh | None = None,
    quality: str | Quality = DEFAULT_QUALITY, finish: YarnFinish = DEFAULT_FINISH,
) -> WarmStart:  # fmt: skip
    """Generate the yarns of an edited fabric, and place them by the relaxed yarns before the edit if that is possible.

    Args:
        relaxed: relaxed yarns of the fabric before the edit.
        before: the stitch mesh before the edit.
        after: the edited stitch mesh.
        evened: the edited stitch mesh with other positions of its vertices, whose yarns are generated instead of those
            of ``after``. Yarns start as generated in the stitches that the edit has changed. Elsewhere they start with
            the displacement from generated to relaxed positions before the edit, which fades towards the changes.
        quality: the quality with which the relaxed yarns were generated.
        finish: the finish with which the relaxed yarns were generated.

    Raises:
        ParameterError: the relaxed yarns were not generated from ``before`` with this quality.
        YarnError: as for ``generate_yarns``.
    """
    check_kind("relaxed yarns", relaxed, YarnSet)
    check_kind("fabric before the edit", before, StitchMesh)
    check_kind("fabric after the edit", after, StitchMesh)
    # the mean of equal radii could differ by rounding
    generate: Callable[[StitchMesh], YarnSet] = partial(
        generate_yarns, quality=quality, yarn_radius=float(relaxed.radius[0]),
        drawn_radius=float(relaxed.drawn_radius[0]), finish=finish,
    )  # fmt: skip
    old = generate(before)
    if not np.array_equal(old.start, relaxed.start):
        raise ParameterError(
            f"relaxed yarns: got {len(relaxed.points)} control points; this fabric and quality give {len(old.points)}; "
            "give the fabric and the quality with which the yarns were generated"
        )
    new = generate(after if evened is None else evened)
    # Largest distance between a new control point and the old control point that it continues, over the yarn
    # radius.
    within = 0.02 * float(relaxed.radius[0])
    old_number = unchanged_points(old, _as_edited(new, after, evened, quality, finish), within)
    # generated yarn is straight without load
    natural = np.where(old_number >= 0, relaxed.natural_curvature[old_number], 0.0)
    new = replace(
        new, rest_length=_rest_lengths(relaxed, old, new, old_number), natural_curvature=natural,
        mass_per_length=np.full(new.yarn_count, relaxed.mass_per_length[0]), made_of=relaxed.made_of,
    )  # fmt: skip
    known, moved = np.flatnonzero(old_number >= 0), np.flatnonzero(old_number < 0)
    if len(known) < NEIGHBOURS:
        return WarmStart(new, None, 0.0)
    points, width = new.points.copy(), mean_stitch_width(after)
    if evened is None:
        points[known] = relaxed.points[old_number[known]]
        shift = points[known] - new.points[known]
        points[moved] += _interpolated(new.points[known], shift, new.points[moved], width)
    else:
        shift = (relaxed.points - old.points)[old_number[known]]
        # Distance from changed stitches, in stitch widths, at which yarns start with their whole displacement.
        points[known] += _faded(new.points[known], shift, new.points[moved], 3.0 * width)
    return WarmStart(new, replace(new, points=points), len(known) / len(new.points))


def _as_edited(
    new: YarnSet, after: StitchMesh, evened: StitchMesh | None, quality: str | Quality, finish: YarnFinish
) -> YarnSet:
    """Return the yarns of the edited fabric before its stitches were evened out, whose points coincide with old ones.

    These yarns may be too close together for a relaxation. If evening out has changed the number of points, for example
    of a float, the result is the new yarns.
    """
    if evened is None:
        return new
    radius = float(new.radius[0])
    routes = trace_yarn_routes(after, radius, quality_named(quality).control_points_per_stitch, finish)
    edited = yarns_along_routes(routes, radius)
    return edited if np.array_equal(edited.start, new.start) else new


def unchanged_points(old: YarnSet, new: YarnSet, within: float) -> IntArray:
    """Number of the old control point that coincides with each new one, -1 where there is none, shape (N,).

    Args:
        old: yarns generated before the edit.
        new: yarns generated after the edit.
        within: largest distance between coinciding points [cm].
    """
    distance, nearest = cKDTree(old.points).query(new.points, distance_upper_bound=within)
    return np.where(np.isfinite(distance), nearest, -1)


def _interpolated(known: FloatArray, shift: FloatArray, points: FloatArray, width: float) -> FloatArray:
    """Displacement [cm] at points by moving least squares of known displacements, shape (n, 3).

    Args:
        known: positions with a known displacement [cm], shape (m, 3).
        shift: displacements of these positions [cm], shape (m, 3).
        points: positions at which the displacement is computed [cm], shape (n, 3).
        width: mean stitch width [cm].
    """
    if len(points) == 0:
        return np.zeros((0, 3))
    nearest = cKDTree(known).query(points, k=NEIGHBOURS)[1]
    offset = (known[nearest] - points[:, None, :]) / width
    squares = np.sum(offset**2, axis=2)
    nearest_square = squares.min(axis=1)
    squares -= nearest_square[:, None]  # the weights do not vanish where all neighbours are far away
    weight = np.exp(-squares) / (squares + 1e-2)
    weight /= weight.sum(axis=1, keepdims=True)
    basis = np.concatenate([np.ones((*squares.shape, 1)), offset], axis=2)
    normal = np.einsum("pk,pki,pkj->pij", weight, basis, basis)
    # Far from the known points the fit is a constant: a slope would be extrapolated over many widths.
    normal[:, [1, 2, 3], [1, 2, 3]] += (RIDGE + nearest_square**2)[:, None]
    right = np.einsum("pk,pki,pkd->pid", weight, basis, shift[nearest])
    return np.linalg.solve(normal, right)[:, 0]


def _faded(points: FloatArray, shift: FloatArray, changed: FloatArray, width: float) -> FloatArray:
    """Displacements that fade to zero towards changed points [cm], shape (m, 3).

    Args:
        points: positions of the unchanged points [cm], shape (m, 3).
        shift: their displacements [cm], shape (m, 3).
        changed: positions of the changed points [cm], shape (n, 3).
        width: distance from the changed points at which displacements are whole [cm].
    """
    if len(changed) == 0:
        return shift
    part = np.minimum(cKDTree(changed).query(points)[0] / width, 1.0)
    faded: FloatArray = shift * (part**2 * (3.0 - 2.0 * part))[:, None]
    return faded


def _rest_lengths(relaxed: YarnSet, old: YarnSet, new: YarnSet, old_number: IntArray) -> FloatArray:
    """Rest lengths of the new yarns [cm], shape (S,).

    The generated rest lengths are multiplied by the ratio of relaxed to generated rest length before the edit. An
    unchanged segment takes its own ratio, every other segment the median of all ratios.
    """
    factor = relaxed.rest_length / old.rest_length
    segment_of = np.full(len(old.points), -1)
    segment_of[old.segment_points[:, 1]] = np.arange(len(factor))
    before = np.where(old_number[new.segment_points[:, 1]] >= 0, segment_of[old_number[new.segment_points[:, 1]]], -1)
    return new.rest_length * np.where(before >= 0, factor[before], np.median(factor))
