# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pins: control points that stay where they are.

A pin carries whatever force acts on its control point, and lets it take no step:

    F_i <- 0,    step_i <- 0        for every pinned i

Pinning four control points in a row holds the segment between them and its direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.energies.term import Constraint, ConstraintChoice
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.point_selection import select_points
from stitchmesh.yarnrelax.model.state import State


@kernel
def hold(
    # model
    pinned: wp.array[wp.int32],
    # state out
    vectors: wp.array[Any],
) -> None:
    """Set the vector of each pinned control point to zero."""
    k = wp.tid()
    vectors[pinned[k]] = type(vectors[0])()


@dataclass(frozen=True, eq=False)
class Pins(ConstraintChoice):
    """Hold control points where they are, chosen by number, by stitch face, or both."""

    points: Sequence[int] | NDArray[np.integer[Any]] = ()
    """Numbers of control points."""
    faces: Sequence[int] | NDArray[np.integer[Any]] = ()
    """Stitch faces all of whose loops are held (``YarnSet.face``)."""

    def on(self, model: Model) -> Constraint:
        """The pins on a model's device.

        Raises:
            ParameterError: a control point or a stitch face is not there, or nothing is pinned.
        """
        return _Held(model, pinned_points(model.yarns, self))


def pinned_points(yarns: YarnSet, pins: Pins) -> NDArray[np.int64]:
    """Numbers of the control points that are held, ascending, shape (n,).

    Raises:
        ParameterError: a control point or a stitch face is not there, or nothing is pinned.
    """
    return select_points("pins", yarns, pins.points, pins.faces)


class _Held(Constraint):
    """Pins on a device."""

    def __init__(self, model: Model, points: NDArray[np.int64]) -> None:
        self.pinned = model.integers(points)

    def filter_forces(self, force: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Take all force from pinned control points."""
        return [launcher(hold, len(self.pinned), [self.pinned], [force])]

    def filter_steps(self, state: State, step: wp.array[Any], limit: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Let pinned control points stay."""
        return [launcher(hold, len(self.pinned), [self.pinned], [step])]
