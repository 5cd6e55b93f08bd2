# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What changes during a relaxation, on the device."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import warp as wp

from stitchmesh.yarnrelax.damping import LARGEST_EAGERNESS
from stitchmesh.yarnrelax.model import Model
from stitchmesh.yarnrelax.reduction import STRANDS


@dataclass(frozen=True, eq=False)
class State:
    """Arrays that the kernels of an iteration read and write."""

    points: wp.array[Any]
    """Control points, relative to the origin of the solver [cm], shape (N, 3)."""
    listed_points: wp.array[Any]
    """Control points when the candidate lists were made [cm], shape (N, 3)."""
    good_points: wp.array[Any]
    """Control points of the last state that was found good [cm], shape (N, 3)."""
    travel: wp.array[Any]
    """How far control points may go on one candidate list: half its margin [cm], shape (1,)."""
    point_force: wp.array[Any]
    """Force on each control point [dyn], shape (N, 3)."""
    step: wp.array[Any]
    """Last move of each control point [cm], shape (N, 3)."""
    limit: wp.array[Any]
    """Largest move of each control point in this iteration [cm], shape (N,)."""
    mobility: wp.array[Any]
    """Inverse row sum of stiffness at each control point [cm / dyn], shape (N,)."""
    room: wp.array[Any]
    """How far each control point may go before the candidate lists are made again [cm], shape (N,)."""
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
    power: wp.array[Any]
    """Force times last move of each control point [erg], shape (N,)."""
    power_sums: wp.array[Any]
    """First stage of the sum of powers [erg]."""
    pace: wp.array[Any]
    """Momentum kept, iterations since its restart, eagerness (``damping``), shape (3,)."""


def make_state(model: Model) -> State:
    """A state at rest where the yarns were given, relative to the model's origin."""
    points = model.upload(model.yarns.points - model.origin, 3)
    n, s = model.point_count, model.segment_count
    return State(
        points=points,
        listed_points=wp.clone(points),
        good_points=wp.clone(points),
        travel=model.empty(1),
        point_force=model.empty(n, 3),
        step=model.empty(n, 3),
        limit=model.empty(n),
        mobility=model.empty(n),
        room=model.empty(n),
        samples=model.empty(model.sample_count, 3),
        sample_reach=model.empty(model.sample_count),
        segment_force=model.empty(4 * s, 3),
        segment_stiffness=model.empty(s, 4),
        segment_clearance=model.empty(s),
        power=model.empty(n),
        power_sums=wp.zeros(STRANDS, dtype=wp.float64, device=model.device),
        pace=wp.array([0.0, 0.0, LARGEST_EAGERNESS], dtype=wp.float64, device=model.device),
    )
