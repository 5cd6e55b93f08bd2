# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Control points that a moving body carries: each keeps its place relative to the nearest triangle.

The body takes the whole force on such a point, and the step of the point leads to its place on the body. A waistband or
a seam that is sewn on holds yarn in this way.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.yarnrelax.collision.budget import shortened
from stitchmesh.yarnrelax.constraints.pins import held_coordinates, hold
from stitchmesh.yarnrelax.energies.body_surface import single
from stitchmesh.yarnrelax.energies.term import Constraint, Coupling
from stitchmesh.yarnrelax.friction.surface_anchor import anchor_at, anchor_place
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import State
from stitchmesh.yarnrelax.motion.moving_surface import MovingSurface

FARTHEST = wp.constant(1.0e6)
"""Distance within which the nearest triangle is searched [units]."""


@kernel
def attach(
    # model
    surface: Any,
    carried: wp.array[wp.int32],
    # state in
    points: wp.array[Any],
    # state out
    face: wp.array[wp.int32],
    local: wp.array[Any],
) -> None:
    """Find the nearest triangle of each carried point, and the coordinates of the point on it."""
    k = wp.tid()
    place = points[carried[k]]
    query = wp.mesh_query_point_no_sign(surface.tree, single(place), FARTHEST)
    face[k] = query.face
    local[k] = anchor_at(surface, query.face, place)


@kernel
def carry(
    # model
    surface: Any,
    carried: wp.array[wp.int32],
    face: wp.array[wp.int32],
    local: wp.array[Any],
    # state in
    points: wp.array[Any],
    limit: wp.array[Any],
    # state out
    step: wp.array[Any],
) -> None:
    """Step of each carried point to its place on the body, no longer than its limit."""
    k = wp.tid()
    i = carried[k]
    step[i] = shortened(anchor_place(surface, face[k], local[k]) - points[i], limit[i])


class CarriedPoints(Constraint):
    """Control points that a body carries, on a device."""

    def __init__(self, model: Model, surface: MovingSurface, points: NDArray[np.int64]) -> None:
        """Attach the control points where the yarns were given; the surface is at its first time."""
        self.surface, self.carried = surface, model.integers(points)
        self._coupling = held_coordinates(self.carried, model.point_count)
        self.face, self.local = model.integers(np.zeros(len(points))), model.empty(len(points), 3)
        given = model.upload(model.to_device(model.yarns.points), 3)
        model.launch(attach, len(points), [surface.constants, self.carried, given], [self.face, self.local])

    def filter_forces(self, force: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Return the launch that sets the forces on carried points to zero."""
        return [launcher(hold, len(self.carried), [self.carried], [force])]

    def coupling(self) -> Coupling:
        """Return a row for each coordinate of the carried points."""
        return self._coupling

    def filter_steps(self, state: State, step: wp.array[Any], limit: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Return the launch that leads carried points to their places on the body."""
        inputs = [self.surface.constants, self.carried, self.face, self.local, state.points, limit]
        return [launcher(carry, len(self.carried), inputs, [step])]
