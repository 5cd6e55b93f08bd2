# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What changes during a relaxation, on the device; lengths in units (``model``), forces in erg per unit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import warp as wp

from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.model import Model


@dataclass(frozen=True, eq=False)
class State:
    """Arrays that the kernels of an iteration read and write."""

    points: wp.array[Any]
    """Control points, shape (N, 3)."""
    listed_points: wp.array[Any]
    """Control points when the candidate lists were made, shape (N, 3)."""
    budget: wp.array[Any]
    """How far each control point may go from where it was listed (``step_limit``), shape (N,)."""
    samples: wp.array[Any]
    """Contact samples: place and yarn radius, shape (P, 4)."""
    sample_force: wp.array[Any]
    """Force on each sample, and the row sum of its stiffness [erg / unit^2], shape (P, 4)."""
    sample_block: wp.array[Any]
    """Stiffness of contact at each sample as (xx, yy, zz, xy, xz, yz), shape (P, 6); empty where no solver needs it."""
    segment_block: wp.array[Any]
    """Means of t t^T and of (l / |y'|)^4 over each segment, t its unit tangent, shape (S, 7); empty likewise."""
    segment_pull: wp.array[Any]
    """Force on the end of each of a segment's three legs, shape (3, S, 3)."""
    outer_force: wp.array[Any]
    """Force of terms that act on control points, shape (N, 3); empty where a relaxation has none."""
    point_force: wp.array[Any]
    """Sum of all forces on each control point, shape (N, 3)."""
    stiffness: wp.array[Any]
    """Row sum of stiffness at each control point [erg / unit^2], shape (N,)."""


def make_state(
    model: Model, start: FloatArray | None = None, *, outer: bool = False, blocks: bool = False
) -> State:
    """A state at ``start`` [cm], or where the yarns were given; with room for outer forces and blocks if asked for."""
    points = model.upload(model.to_device(model.yarns.points if start is None else start), 3)
    n = model.point_count
    return State(
        points=points,
        listed_points=wp.clone(points),
        budget=model.empty(n),
        samples=model.empty(model.sample_count, 4),
        sample_force=model.empty(model.sample_count, 4),
        sample_block=model.empty(model.sample_count if blocks else 0, 6),
        segment_block=model.empty(model.segment_count if blocks else 0, 7),
        segment_pull=model.empty((3, model.segment_count), 3),
        outer_force=model.empty(n if outer else 0, 3),
        point_force=model.empty(n, 3),
        stiffness=model.empty(n),
    )
