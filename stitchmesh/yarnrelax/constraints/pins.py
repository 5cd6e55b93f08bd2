# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pins: control points that do not move.

A pin carries the whole force on its control point and allows no step:

    F_i <- 0,    step_i <- 0        for every pinned i

Pins on four consecutive control points fix the segment between them, and its direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.sparse import csr_array, kron

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Vec3
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.energies.term import Constraint, ConstraintChoice, Coupling
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.point_selection import select_points
from stitchmesh.yarnrelax.model.state import State


@kernel
def hold(
    # model
    pinned: wp.array[wp.int32],
    # state out
    vectors: wp.array[Vec3],
) -> None:
    """Set the vector of each pinned control point to zero."""
    k = wp.tid()
    vectors[pinned[k]] = type(vectors[0])()


@dataclass(frozen=True, eq=False)
class Pins(ConstraintChoice):
    """Control points that do not move, selected by number, by stitch face, or both."""

    points: Sequence[int] | NDArray[np.integer[Any]] = ()
    """Numbers of control points."""
    faces: Sequence[int] | NDArray[np.integer[Any]] = ()
    """Stitch faces, all of whose control points are pinned (``YarnSet.face``)."""

    def on(self, model: Model) -> Constraint:
        """Return the pins on a model's device.

        Raises:
            ParameterError: a control point or a stitch face does not exist, or nothing is pinned.
        """
        return _Held(model, pinned_points(model.yarns, self))


def pinned_points(yarns: YarnSet, pins: Pins) -> NDArray[np.int64]:
    """Return the numbers of the pinned control points, ascending, shape (n,).

    Raises:
        ParameterError: a control point or a stitch face does not exist, or nothing is pinned.
    """
    return select_points("pins", yarns, pins.points, pins.faces)


def held_coordinates(points: wp.array[Any], count: int) -> Coupling:
    """Return a row for each coordinate of the chosen ones among ``count`` control points."""
    held = points.numpy()
    rows = csr_array((np.ones(len(held)), held, np.arange(len(held) + 1)), shape=(len(held), count))
    return Coupling(csr_array(kron(rows, np.eye(3))))


class _Held(Constraint):
    """Pins on a device."""

    def __init__(self, model: Model, points: NDArray[np.int64]) -> None:
        self.pinned = model.integers(points)
        self._coupling = held_coordinates(self.pinned, model.point_count)

    def filter_forces(self, force: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Return the launch that sets the forces on pinned control points to zero."""
        return [launcher(hold, len(self.pinned), [self.pinned], [force])]

    def coupling(self) -> Coupling:
        """Return a row for each coordinate of the pinned control points."""
        return self._coupling

    def filter_steps(self, state: State, step: wp.array[Any], limit: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Return the launch that sets the steps of pinned control points to zero."""
        return [launcher(hold, len(self.pinned), [self.pinned], [step])]
