# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact of a cloth with a body, by the signed distance of contact points from its surface (C section 6.1).

Each contact point keeps a distance R from the body, its radius plus the thickness of a layer on the body:

    E = P / 2 sum over points of  R a e        [erg],    a the area of the point times its weight of blending

with e the penalty of ``stitchmesh.simulation.bodies.body_penalty``. With x the distance over R, the penalty over a
flat body is e = 1/x^2 + x^2 - 2, and the pressure is

    p = P (1/x^3 - x)        [dyn / cm^2],

which is 0.47 P at x = 0.9 and 7.5 P at x = 0.5. Below x = 0.5 the stiffness is constant (32 P), through the surface and
down to the depth in which points are found. Outside the body, all features of the surface within R push, so the force
is continuous where the nearest feature changes. Inside, only the nearest feature pushes.

The distance of each point is measured at the beginning of a step, unless the point has moved by less than half of the
distance that was measured last. A point that has since moved by less than the part of its distance beyond R feels no
force, and needs no search; this changes no bit of the result.

No move takes a point deeper than half that depth, or by more than a quarter of it if the point is already near there
(``step_limit``): a point does not meet the surface on a path shorter than its distance. If the body moves by more than
the depth in one step, or overtakes a point by more than the depth, the step raises an error; a shorter step avoids it.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import Mat33, Scalar, ScalarType, Vec3, Vec4, vector
from stitchmesh.compute.reduction import minimum
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.mesh import FloatArray
from stitchmesh.mixed.contact.body import PlacedBody, SolidBody, to_body
from stitchmesh.mixed.contact.contact_points import ContactPoints
from stitchmesh.mixed.contact.point_map import PointMap
from stitchmesh.mixed.contact.self_collision import PRESSURE
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import MixedTerm, keep_share
from stitchmesh.simulation.bodies.body_penalty import (
    body_block,
    outside_block,
    push_of,
    push_outside,
    without_negative,
)
from stitchmesh.simulation.bodies.body_surface import SurfaceArrays, gap_to

DEPTH, DEPTH_SHARE = 1.0, 0.25
"""Default of the depth in which points are found [cm], and its bound as a share of the smallest side of the box around
the body. Behind the middle of a thin body a point would be pushed out on the other side."""


UNKNOWN = 1e15
"""A distance [cm] beyond the distance of any point; its negative stands for a distance that was not measured."""


@wp.func
def least_distance(here: Vec3, measured: Vec4) -> Any:
    """A distance that a point is farther than from the surface, from its distance at another place."""
    moved = wp.length(here - type(here)(measured[0], measured[1], measured[2]))
    return measured[3] - moved * type(moved)(1.001)  # a thousandth allows for rounding


@wp.func
def body_push(surface: SurfaceArrays, here: Vec3, measured: Vec4, reach: Scalar, depth: Scalar) -> tuple[Any, Any]:
    """Minus the gradient of the penalty in the frame of the body [1 / cm], and the penalty."""
    force, energy = here - here, reach - reach
    least = least_distance(here, measured)
    sample = type(measured)(here[0], here[1], here[2], reach)
    if least < reach:
        push, penalty = measured - measured, reach - reach
        if least > reach - reach:  # outside for certain
            push, penalty = push_outside(surface, sample, reach)
        else:
            push, penalty = push_of(surface, sample, reach, depth)
        force = type(here)(push[0], push[1], push[2])
        energy = penalty
    return force, energy


@kernel
def body_forces(
    # model
    surface: SurfaceArrays,
    reach: wp.array[Scalar],
    size: wp.array[Scalar],
    depth: Scalar,
    # state in
    measured: wp.array[Vec4],
    frame: wp.array[Mat33],
    origin: wp.array[Vec3],
    place: wp.array[Vec3],
    # state out
    force: wp.array[Vec3],
) -> None:
    """Force on each point [dyn]."""
    i = wp.tid()
    push, _energy = body_push(surface, to_body(frame[0], origin[0], place[i]), measured[i], reach[i], depth)
    force[i] = frame[0] * push * size[i]


@kernel
def body_energies(
    # model
    surface: SurfaceArrays,
    reach: wp.array[Scalar],
    size: wp.array[Scalar],
    depth: Scalar,
    # state in
    measured: wp.array[Vec4],
    frame: wp.array[Mat33],
    origin: wp.array[Vec3],
    place: wp.array[Vec3],
    # state out
    energy: wp.array[Scalar],
) -> None:
    """Energy of each point [erg]."""
    i = wp.tid()
    _push, penalty = body_push(surface, to_body(frame[0], origin[0], place[i]), measured[i], reach[i], depth)
    energy[i] = penalty * size[i]


@kernel
def body_blocks(
    # model
    surface: SurfaceArrays,
    reach: wp.array[Scalar],
    size: wp.array[Scalar],
    depth: Scalar,
    # state in
    exact: wp.array[Scalar],
    measured: wp.array[Vec4],
    frame: wp.array[Mat33],
    origin: wp.array[Vec3],
    place: wp.array[Vec3],
    # state out
    block: wp.array[Mat33],
) -> None:
    """Hessian of each point by its place [dyn / cm]."""
    i = wp.tid()
    here = to_body(frame[0], origin[0], place[i])
    least = least_distance(here, measured[i])
    if least > reach[i]:
        block[i] = type(block[i])()
        return
    own = block[i] - block[i]
    if least > depth - depth:  # outside for certain
        own = outside_block(surface, here, reach[i])
    else:
        own = body_block(surface, here, reach[i], depth)
    turned = frame[0] * without_negative(own, exact[0]) * wp.transpose(frame[0])
    block[i] = turned * size[i]


@kernel
def block_products(
    # state in
    block: wp.array[Mat33],
    change: wp.array[Vec3],
    # state out
    product: wp.array[Vec3],
) -> None:
    """Blocks times displacements of their points."""
    i = wp.tid()
    product[i] = block[i] * change[i]


@kernel
def measure_distances(
    # model
    surface: SurfaceArrays,
    limit: Scalar,
    # state in
    frame: wp.array[Mat33],
    origin: wp.array[Vec3],
    place: wp.array[Vec3],
    # state in and out
    measured: wp.array[Vec4],
    # state out
    distance: wp.array[Scalar],
) -> None:
    """Signed distance of each point from the surface [cm], also after its place in the body.

    It is measured again, up to ``limit``, where the last one says less than half of the distance then; otherwise it is
    a lower bound.
    """
    i = wp.tid()
    here = to_body(frame[0], origin[0], place[i])
    least = least_distance(here, measured[i])
    if least > limit - limit and least > measured[i][3] * type(limit)(0.5):
        distance[i] = least
        return
    sample = type(measured[i])(here[0], here[1], here[2], limit)
    distance[i] = gap_to(surface, sample, limit)[3]
    measured[i] = type(sample)(here[0], here[1], here[2], distance[i])


@kernel
def body_limits(
    # model
    surface: SurfaceArrays,
    depth: Scalar,
    # state in
    measured: wp.array[Vec4],
    frame: wp.array[Mat33],
    origin: wp.array[Vec3],
    place: wp.array[Vec3],
    move: wp.array[Vec3],
    # state out
    part: wp.array[Scalar],
) -> None:
    """Part of a move, at most 1, after which each point is at most half the depth, or a quarter deeper, inside."""
    i = wp.tid()
    here = to_body(frame[0], origin[0], place[i])
    size = wp.length(move[i])
    gap = least_distance(here, measured[i])
    if gap + depth * type(depth)(0.5) < size:
        limit = size + depth
        gap = gap_to(surface, type(measured[i])(here[0], here[1], here[2], limit), limit)[3]
    room = wp.max(gap + depth * type(depth)(0.5), depth * type(depth)(0.25))
    part[i] = wp.min(type(depth)(1.0), room / wp.max(size, type(depth)(1.0e-18)))


class BodyContact(MixedTerm):
    """The contact of a cloth with one body, on a device.

    A moving body is placed where it will be at the end of the step (``begin_step``).
    """

    def __init__(
        self,
        points: ContactPoints,
        body: SolidBody,
        *,
        thickness: float = 0.0,
        pressure: float = PRESSURE,
        depth: float | None = None,
        scalar: ScalarType,
        device: wp.Device,
    ) -> None:
        """Put contact points and a body on a device.

        Args:
            points: the contact points, with their radii and weights.
            body: the body.
            thickness: thickness of a layer on the body that the cloth stays out of [cm].
            pressure: P, the scale of the pressure [dyn/cm^2].
            depth: depth below the surface down to which points are found and pushed out [cm]; it should be below half
                the thickness of thin parts. By default ``DEPTH``, or ``DEPTH_SHARE`` of the height of a flat body.
            scalar: Warp's floating-point type.
            device: where the term runs.

        Raises:
            ParameterError: a thickness below 0, or a pressure or a depth that is not positive.
        """
        deepest = min(DEPTH, DEPTH_SHARE * float(np.ptp(body.mesh.vertices, axis=0).min())) if depth is None else depth
        for name, value in (("pressure", pressure), ("depth", deepest)):
            if not (np.isfinite(value) and value > 0.0):
                raise ParameterError(f"{body.name}: got a {name} of {value}; expected a positive number")
        if not (np.isfinite(thickness) and thickness >= 0.0):
            raise ParameterError(f"{body.name}: got a thickness of {thickness} cm; expected at least 0")
        self.name = body.name
        self.points = PointMap.of(points, scalar, device)
        self.placed = PlacedBody(body, scalar, device)
        self.depth = deepest
        reach = points.radius + thickness
        self._reach = self.points.scalars(reach)
        self._size = self.points.scalars(0.5 * pressure * reach * points.area)
        self._unknown = vector(4, scalar)(0.0, 0.0, 0.0, -UNKNOWN)
        self._measured = wp.full(len(self.points), self._unknown, dtype=vector(4, scalar), device=device)
        self._exact = wp.ones(1, dtype=scalar, device=device)
        self.place, self.force = self.points.vectors(), self.points.vectors()
        self._move, self._numbers, self._block = self.points.vectors(), self.points.scalars(), self.points.blocks()

    def begin_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Move the body to the end of the step.

        Raises:
            SolverError: a point is inside the body, deeper than points are found, or the body moves by more than this
                depth in the step and could pass over points.
        """
        self._check_motion(time, time_step)
        self.placed.move_to(time + time_step)
        if self.placed.deforms:
            self.forget_distances()
        distance = self._distances(state)
        if minimum(distance) < -self.depth:
            raise SolverError(self._too_deep(distance.numpy()))

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of each point, and the array of the energies."""
        launches = self.points.place(state, self.place, launcher)
        inputs = [*self._inputs(), self.place]
        return [*launches, launcher(body_energies, len(self.points), inputs, [self._numbers])], self._numbers

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add the push of the body."""
        return self.push(state, launcher) + self.points.spread(self.force, force, launcher)

    def push(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that find ``place`` and ``force`` of each contact point."""
        launches = self.points.place(state, self.place, launcher)
        return [*launches, launcher(body_forces, len(self.points), [*self._inputs(), self.place], [self.force])]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that store the Hessian of each point."""
        launches = [launcher(keep_share, 1, [self._number(self.exact)], [self._exact])]
        launches += self.points.place(state, self.place, launcher)
        surface, reach, size, depth, *placed = self._inputs()
        inputs = [surface, reach, size, depth, self._exact, *placed, self.place]
        return [*launches, launcher(body_blocks, len(self.points), inputs, [self._block])]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add H d."""
        launches = self.points.place(direction, self._move, launcher)
        launches.append(launcher(block_products, len(self.points), [self._block, self._move], [self.force]))
        return launches + self.points.spread(self.force, product, launcher)

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that add the diagonal blocks."""
        return self.points.spread_blocks(self._block, blocks, launcher)

    def step_limit(self, state: MixedVector, direction: MixedVector) -> float:
        """The part of a direction along which no point goes so deep that it cannot be found."""
        run = self._launcher()
        self.points.place(state, self.place, run)
        self.points.place(direction, self._move, run)
        inputs = [self.placed.surface, self._number(self.depth), self._measured, self.placed.frame, self.placed.origin]
        run(body_limits, len(self.points), [*inputs, self.place, self._move], [self._numbers])
        return minimum(self._numbers)

    def forget_distances(self) -> None:
        """Declare the measured distances unknown, after the body was deformed."""
        self._measured.fill_(self._unknown)

    def distances(self, state: MixedVector) -> FloatArray:
        """Signed distance of each contact point from the body at its present place [cm], shape (M,)."""
        self.forget_distances()
        found: FloatArray = self._distances(state).numpy().astype(np.float64)
        return found

    def _distances(self, state: MixedVector) -> wp.array[Any]:
        run = self._launcher()
        self.points.place(state, self.place, run)
        inputs = [self.placed.surface, self._number(UNKNOWN), self.placed.frame, self.placed.origin, self.place]
        if len(self.points):
            run(measure_distances, len(self.points), inputs, [self._measured, self._numbers])
        return self._numbers

    def _check_motion(self, time: float, time_step: float) -> None:
        moved = self.placed.largest_motion(time, time + time_step) if self.placed.moves and time_step else 0.0
        if moved > self.depth:
            found = f"got a motion of {moved:.3g} cm in a step of {time_step:.3g} s"
            raise SolverError(f"{self.name}: {found}; expected at most {self.depth:.3g} cm; take shorter steps")

    def _too_deep(self, distance: FloatArray) -> str:
        worst = int(distance.argmin())
        points = self.points.points
        first = int(points.index[worst, points.share[worst].argmax()])
        node = first - points.vertex_count
        place = f"node {node}" if node >= 0 else f"vertex {first}"
        deep = int((distance < -self.depth).sum())
        found = f"{deep} contact points, the deepest at {place}, are up to {-distance[worst]:.3g} cm inside"
        return f"{self.name}: {found}; expected at most {self.depth:.3g}; move the cloth out, or take shorter steps"

    def _inputs(self) -> list[Any]:
        placed = self.placed
        depth = self._number(self.depth)
        return [placed.surface, self._reach, self._size, depth, self._measured, placed.frame, placed.origin]

    def _number(self, value: float) -> Any:
        return self.points.scalar(value)

    def _launcher(self) -> Launcher:
        return partial(launch, device=self.points.device)
