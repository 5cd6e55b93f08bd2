# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Self-collision: layers of cloth keep a distance by spheres at contact points (C section 6.1).

The distance is the thickness, or the distance of neighbouring points where the points are coarser (``layer_radius``).
The energy of ``pair_penalty`` is summed over all pairs of points that touch and are not neighbours at rest. Each point
sums its own list, in ascending order, so the forces of a pair are computed twice and are opposite up to rounding.

No move may bring a pair nearer than ``STOP`` times its contact distance, or ``APPROACH`` times its present distance if
that is less (``step_limit``). With points as dense as the thickness, a sphere that passes through a layer in the middle
of a hole comes nearer than that to the points around the hole, so no move jumps through a layer, however fast it is.
From move to move, layers approach only against the force. A pressure of more than about P / 2 (points one thickness
apart) or 2 P (points half a thickness apart) still pushes a layer slowly through another one.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import Mat33, Scalar, ScalarType, Vec3
from stitchmesh.compute.reduction import minimum
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.contact.contact_points import ContactPoints, SeamLinks
from stitchmesh.mixed.contact.pair_lists import PairLists, seam_neighbours
from stitchmesh.mixed.contact.pair_penalty import (
    distance_of,
    pair_energy,
    pair_size,
    pair_slope,
    pair_stiffness,
    times_stiffness,
)
from stitchmesh.mixed.contact.point_map import PointMap
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import MixedTerm, keep_share

PRESSURE = 2000.0
"""Default of P [dyn/cm^2]; the pressure at 0.7 thicknesses, 740 dyn/cm^2, is the weight of 25 layers of 30 mg/cm^2."""
MARGIN = 0.5
"""Distance beyond contact that the lists of pairs reach, as a part of the distance of contact."""
STOP = wp.constant(0.7)
"""Part of the contact distance below which no single move brings a pair that approaches."""
APPROACH = wp.constant(0.8)
"""Part of its present distance to which a single move may bring a pair that is already nearer than ``STOP``."""


@kernel
def pair_energies(
    # model
    radius: wp.array[Scalar],
    area: wp.array[Scalar],
    pressure: Scalar,
    # state in
    place: wp.array[Vec3],
    count: wp.array[wp.int32],
    lists: wp.array2d[wp.int32],
    # state out
    energy: wp.array[Scalar],
) -> None:
    """Half of the energy of the pairs of each point [erg]."""
    i = wp.tid()
    total = pressure - pressure
    for k in range(count[i]):
        j = lists[i, k]
        reach = radius[i] + radius[j]
        x = wp.length(place[i] - place[j]) / reach
        if x < type(x)(1.0):
            total += pair_size(pressure, reach, area[i], area[j]) * pair_energy(x)
    energy[i] = total * type(total)(0.5)


@kernel
def pair_forces(
    # model
    radius: wp.array[Scalar],
    area: wp.array[Scalar],
    pressure: Scalar,
    # state in
    place: wp.array[Vec3],
    count: wp.array[wp.int32],
    lists: wp.array2d[wp.int32],
    # state out
    force: wp.array[Vec3],
) -> None:
    """Force on each point [dyn]."""
    i = wp.tid()
    total = type(place[i])()
    for k in range(count[i]):
        j = lists[i, k]
        reach = radius[i] + radius[j]
        apart = place[i] - place[j]
        distance = distance_of(apart)
        if distance < reach:
            size = pair_size(pressure, reach, area[i], area[j])
            total -= apart * (size * pair_slope(distance / reach) / (reach * distance))
    force[i] = total


@kernel
def pair_products(
    # model
    radius: wp.array[Scalar],
    area: wp.array[Scalar],
    pressure: Scalar,
    # state in
    exact: wp.array[Scalar],
    place: wp.array[Vec3],
    count: wp.array[wp.int32],
    lists: wp.array2d[wp.int32],
    change: wp.array[Vec3],
    # state out
    product: wp.array[Vec3],
) -> None:
    """Product of the Hessian with displacements of the points [dyn]."""
    i = wp.tid()
    total = type(place[i])()
    for k in range(count[i]):
        j = lists[i, k]
        reach = radius[i] + radius[j]
        apart = place[i] - place[j]
        distance = distance_of(apart)
        if distance < reach:
            size = pair_size(pressure, reach, area[i], area[j])
            along, across = pair_stiffness(size, distance, reach, exact[0])
            total += times_stiffness(apart, distance, along, across, change[i] - change[j])
    product[i] = total


@kernel
def pair_blocks(
    # model
    radius: wp.array[Scalar],
    area: wp.array[Scalar],
    pressure: Scalar,
    # state in
    exact: wp.array[Scalar],
    place: wp.array[Vec3],
    count: wp.array[wp.int32],
    lists: wp.array2d[wp.int32],
    # state out
    block: wp.array[Mat33],
) -> None:
    """Diagonal block of the Hessian of each point [dyn / cm]."""
    i = wp.tid()
    total = type(block[i])()
    for k in range(count[i]):
        j = lists[i, k]
        reach = radius[i] + radius[j]
        apart = place[i] - place[j]
        distance = distance_of(apart)
        if distance < reach:
            size = pair_size(pressure, reach, area[i], area[j])
            along, across = pair_stiffness(size, distance, reach, exact[0])
            normal = apart / distance
            total += wp.identity(n=3, dtype=type(reach)) * across + wp.outer(normal, normal) * (along - across)
    block[i] = total


@kernel
def pair_limits(
    # model
    radius: wp.array[Scalar],
    # state in
    place: wp.array[Vec3],
    move: wp.array[Vec3],
    count: wp.array[wp.int32],
    lists: wp.array2d[wp.int32],
    # state out
    part: wp.array[Scalar],
) -> None:
    """Part of a move, at most 1, after which the first pair of each point reaches its least distance."""
    i = wp.tid()
    least = type(part[i])(1.0)
    for k in range(count[i]):
        j = lists[i, k]
        apart, closing = place[i] - place[j], move[i] - move[j]
        nearest = wp.min((radius[i] + radius[j]) * type(least)(STOP), wp.length(apart) * type(least)(APPROACH))
        square, along = wp.dot(closing, closing), wp.dot(apart, closing)
        rest = along * along - square * (wp.dot(apart, apart) - nearest * nearest)
        if along < least - least and rest > least - least:
            # the smaller root of |apart + t closing| = nearest, in the form without cancellation
            least = wp.min(least, (wp.dot(apart, apart) - nearest * nearest) / (wp.sqrt(rest) - along))
    part[i] = least


class SelfCollision(MixedTerm):
    """The contact of a cloth with itself, on a device.

    Prepared launches are stale after ``generation`` has changed, because lists have grown. ``begin_step`` and
    ``step_limit`` make lists where they are needed. If a solver does not call ``step_limit``, no point may move farther
    in a step than the margin times its radius.
    """

    name = "self-collision"

    def __init__(
        self,
        points: ContactPoints,
        links: SeamLinks | None,
        *,
        pressure: float = PRESSURE,
        scalar: ScalarType,
        device: wp.Device,
    ) -> None:
        """Put contact points on a device.

        Args:
            points: the contact points, with the thickness of the cloth and their weights.
            links: where panels meet (``points_on_triangles``); None for a cloth without seams.
            pressure: P, the scale of the pressure between layers [dyn / cm^2].
            scalar: Warp's floating-point type.
            device: where the term runs.

        Raises:
            ParameterError: the pressure is not positive.
        """
        if not (np.isfinite(pressure) and pressure > 0.0):
            raise ParameterError(f"self-collision: got a pressure of {pressure}; expected a positive number")
        none = SeamLinks(np.zeros((0, 2), dtype=np.int64), np.zeros((0, 2, 2)))
        seams = seam_neighbours(points, none if links is None else links)
        self.points = PointMap.of(points, scalar, device)
        self.pairs = PairLists(self.points, seams, MARGIN)
        self._model = [self.pairs.radius, self.points.scalars(points.area), scalar(pressure)]
        self._exact = wp.ones(1, dtype=scalar, device=device)
        self._place, self._linear, self._move = (self.points.vectors() for _ in range(3))
        self._force, self._numbers = self.points.vectors(), self.points.scalars()
        self._block = self.points.blocks()

    @property
    def generation(self) -> int:
        """How often the lists have grown."""
        return self.pairs.generation

    def begin_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """List the pairs that may touch near a state.

        Raises:
            SolverError: the state is not finite, or there are too many pairs.
        """
        self._place_now(state)
        self._move.zero_()
        self.pairs.cover(self._place, self._move)

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of the pairs of each point, and the array of the energies."""
        launches = self.points.place(state, self._place, launcher)
        inputs = [*self._model, self._place, *self._lists]
        return [*launches, launcher(pair_energies, len(self.points), inputs, [self._numbers])], self._numbers

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add the forces of all pairs."""
        launches = self.points.place(state, self._place, launcher)
        launches.append(launcher(pair_forces, len(self.points), self.inputs(self._place), [self._force]))
        return launches + self.points.spread(self._force, force, launcher)

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that store the places of the points."""
        share = launcher(keep_share, 1, [self.points.scalar(self.exact)], [self._exact])
        return [share, *self.points.place(state, self._linear, launcher)]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add H d."""
        launches = self.points.place(direction, self._move, launcher)
        radius, area, pressure = self._model
        inputs = [radius, area, pressure, self._exact, self._linear, *self._lists, self._move]
        launches.append(launcher(pair_products, len(self.points), inputs, [self._force]))
        return launches + self.points.spread(self._force, product, launcher)

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that add diagonal blocks; pairs whose points share a vertex lack their coupling there."""
        inputs = [*self._model, self._exact, self._linear, *self._lists]
        launches = [launcher(pair_blocks, len(self.points), inputs, [self._block])]
        return launches + self.points.spread_blocks(self._block, blocks, launcher)

    def step_limit(self, state: MixedVector, direction: MixedVector) -> float:
        """The part of a direction along which no pair comes nearer than a single move may bring it.

        Raises:
            SolverError: the state or the direction is not finite, or there are too many pairs.
        """
        if len(self.points) < 2:
            return 1.0
        self._place_now(state)
        run = self._launcher()
        self.points.place(direction, self._move, run)
        part = self.pairs.cover(self._place, self._move)
        inputs = [self._model[0], self._place, self._move, *self._lists]
        self._launch(pair_limits, inputs, [self._numbers])
        return min(part, minimum(self._numbers))

    def inputs(self, place: wp.array[Any]) -> list[Any]:
        """The inputs of kernels over pairs: radii, areas, pressure, the given places, and the lists."""
        return [*self._model, place, *self._lists]

    @property
    def _lists(self) -> list[wp.array[Any]]:
        return [self.pairs.count, self.pairs.lists]

    def _place_now(self, state: MixedVector) -> None:
        self.points.place(state, self._place, self._launcher())

    def _launcher(self) -> Launcher:
        return partial(launch, device=self.points.device)

    def _launch(self, kernel: wp.Kernel, inputs: list[Any], outputs: list[Any]) -> None:
        launch(kernel, len(self.points), inputs, outputs, self.points.device)
