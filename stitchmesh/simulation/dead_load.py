# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Dead loads: forces that do not follow the fabric. Gravity is one.

Each point i has an amount a_i, and a vector F is common to all points:

    f_i = a_i F,    E = - sum over points of  a_i F . x_i        [erg]

The weight of a fabric has the mass of a point as the amount, and the acceleration as the vector. Places are relative to
the origin of the coordinates, which for yarns is the middle of the given yarns. The Hessian is zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3, vector
from stitchmesh.errors import ParameterError
from stitchmesh.simulation.term import Coordinates, LoadedPoints, Term, TermChoice

EARTH = (0.0, -981.0, 0.0)
"""Acceleration on Earth [cm / s^2]; y points up."""
MOST_ACCELERATION = 1e6
"""Largest acceleration along an axis [cm / s^2], a thousand times the one on Earth; more makes time steps tiny."""


@kernel
def add_dead_load(
    # model
    amount: wp.array[Scalar],
    load: Vec3,
    # state in and out
    force: wp.array[Vec3],
) -> None:
    """Add the load of each point."""
    i = wp.tid()
    force[i] = force[i] + load * amount[i]


@kernel
def dead_load_energies(
    # model
    amount: wp.array[Scalar],
    load: Vec3,
    # state in
    points: wp.array[Vec3],
    # state out
    energy: wp.array[Scalar],
) -> None:
    """Potential energy [erg] of each point."""
    i = wp.tid()
    energy[i] = -amount[i] * wp.dot(load, points[i])


class DeadLoad(Term[Coordinates, Coordinates]):
    """A dead load on a device."""

    gives_hessian = True
    is_load = True

    def __init__(
        self, name: str, points: LoadedPoints, load: ArrayLike, amounts: Sequence[NDArray[np.float64]]
    ) -> None:
        """Send a load to the device of the points.

        Args:
            name: name of the term in reports.
            points: what the load acts on.
            load: force for an amount of 1 [dyn], shape (3,).
            amounts: the amount of each point, an array for each part of the coordinates.
        """
        self.name = name
        scalar, device = points.scalar, points.device
        # dyn times the unit is a force [erg / unit]
        self._load = vector(3, scalar)(*(float(part) * points.unit for part in np.asarray(load)))
        self._amounts = [wp.array(amount, dtype=scalar, device=device) for amount in amounts]
        starts = np.concatenate([[0], np.cumsum([len(amount) for amount in amounts])]).tolist()
        self._energy = wp.zeros(starts[-1], dtype=scalar, device=device)
        self._parts = list(pairwise(starts))

    def forces(self, state: Coordinates, force: Coordinates, launcher: Launcher) -> list[Any]:
        """The launches that add the load to each part."""
        return [
            launcher(add_dead_load, len(amount), [amount, self._load], [part])
            for amount, part in zip(self._amounts, force.parts, strict=True)
            if len(amount)
        ]

    def element_energies(self, state: Coordinates, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launches that find the energy of each point, and the array of the energies."""
        launches = [
            launcher(dead_load_energies, len(amount), [amount, self._load, part], [self._energy[first:last]])
            for amount, part, (first, last) in zip(self._amounts, state.parts, self._parts, strict=True)
            if len(amount)
        ]
        return launches, self._energy


@dataclass(frozen=True)
class Gravity(TermChoice[LoadedPoints]):
    """The weight of yarns, or of a cloth with yarns; on a lattice the weight of one cell.

    Raises:
        ParameterError: the acceleration is not three numbers, or one is above ``MOST_ACCELERATION``.
    """

    on_any_points = True
    reads_mass = True

    acceleration: tuple[float, float, float] = EARTH
    """Acceleration [cm / s^2]; y points up."""

    def __post_init__(self) -> None:
        if np.shape(self.acceleration) != (3,) or not (np.abs(self.acceleration) <= MOST_ACCELERATION).all():
            found = f"gravity: got acceleration {self.acceleration}"
            raise ParameterError(f"{found}; expected three numbers of at most {MOST_ACCELERATION:g} cm/s^2")

    def on(self, points: LoadedPoints) -> DeadLoad:
        """Return the weight of the points.

        Raises:
            ParameterError: a yarn has no mass.
        """
        return DeadLoad("gravity", points, self.acceleration, points.masses())
