# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What changes during a relaxation, on the device."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import warp as wp

from stitchmesh.yarnrelax.model import Model


@dataclass(frozen=True, eq=False)
class State:
    """Arrays that the kernels of an iteration read and write."""

    points: wp.array[Any]
    """Control points, relative to the origin of the solver [cm], shape (N, 3)."""
    listed_points: wp.array[Any]
    """Control points when the candidate lists were made [cm], shape (N, 3)."""
    good_points: wp.array[Any]
    """Control points of the last state that was found good [cm], shape (N, 3)."""
    step: wp.array[Any]
    """Last move of each control point [cm], shape (N, 3)."""
    limit: wp.array[Any]
    """Largest move of each control point in this iteration [cm], shape (N,)."""
    samples: wp.array[Any]
    """Contact samples [cm], shape (P, 3)."""
    sample_reach: wp.array[Any]
    """How far the curve lies from its sample at most [cm], shape (P,)."""
    segment_force: wp.array[Any]
    """Force of each segment on its four control points [dyn], shape (4 S, 3)."""
    segment_stiffness: wp.array[Any]
    """Row sums of contact stiffness for its four control points [dyn / cm], shape (S, 4)."""
    segment_clearance: wp.array[Any]
    """Smallest clearance of its arcs, where it matters [cm], shape (S,)."""
    point_stiffness: wp.array[Any]
    """Row sums of internal stiffness [dyn / cm], shape (N,)."""
    power: wp.array[Any]
    """Force times last move of each control point [erg], shape (N,)."""
    power_sums: wp.array[Any]
    """First stage of the sum of powers [erg]."""
    momentum: wp.array[Any]
    """Part of the last move that is kept, and the number of iterations since the last restart, shape (2,)."""


def make_state(model: Model, points: wp.array[Any]) -> State:
    """A state at rest at the given control points."""
    n, s = model.point_count, model.segment_count
    return State(
        points=points,
        listed_points=wp.clone(points),
        good_points=wp.clone(points),
        step=model.empty(n, 3),
        limit=model.empty(n),
        samples=model.empty(model.sample_count, 3),
        sample_reach=model.empty(model.sample_count),
        segment_force=model.empty(4 * s, 3),
        segment_stiffness=model.empty(s, 4),
        segment_clearance=model.empty(s),
        point_stiffness=model.empty(n),
        power=model.empty(n),
        power_sums=wp.zeros(256, dtype=wp.float64, device=model.device),
        momentum=wp.zeros(2, dtype=wp.float64, device=model.device),
    )
