# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Friction of yarns that slide through crossings: a spring to an anchor, and Coulomb slip (Cirio et al. 2014).

Each Eulerian coordinate u of a crossing has an anchor a. With the limit m = mu N of the crossing (``normal_forces``)
and the stiffness k of the spring, friction follows the law of everything that rubs (``simulation.friction_law``). At
the distance s = |u - a| the force has the amount

    F = m phi'(s) = m (s / e) (2 - s / e)  for s < e,   else  m,       e = max(2 m / k, SLIP_SHARE R)

A yarn sticks at distances below e and slips beyond. The published law is k s, cut off at m. Newton's method does not
settle at its corner, nor where a step moves yarns by many slip lengths. The corner is therefore rounded here, with the
slope k at s = 0, and weakly pressed crossings have softer springs, so that e is never below a share of the radius R.
Within a time step anchor, limit and slip length are constant, and the force has the convex energy m phi(s). The solver
therefore finds the force at the end of the step, and this force is never above the limit.
After the step a yarn that slipped drags its anchor along to the distance e. Where the yarn stuck, the anchor stays, so
a load below the limit never makes a yarn creep. Only the move of the anchor loses work to friction. A yarn that was
pulled beyond its limits does not return: a snag stays, an elastic mark does not.

The second derivative falls from 2 m / e to zero at s = e. With damping by stiffness, Newton's matrix contains the
second derivative at the beginning of the step, which in short steps weighs many times more than the present one. With
the present one in its place, the iteration overshoots again and again where a yarn begins to slip.

Anchors last from step to step. Limits follow from the state at the beginning of a step. Where N changes, m and e change
too, and with them the force at a distance from the anchor: a yarn that a spring holds would be partly released, slide,
and change N again. The anchor therefore moves to the place where the force stays as it was, or is the new limit if that
is lower,

    a -> u + sign(F) e x    with  x (2 - x) = min(|F| / m, 1),

so that only yarns beyond their limit slip. Anchors of yarns without a limit stay.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches, Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch, prepare
from stitchmesh.compute.precision import Mat22, Scalar, Vec2, vector
from stitchmesh.mixed.crossings.crossing_term import CrossingElements, CrossingTerm
from stitchmesh.mixed.crossings.friction.normal_forces import NormalForces
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import MixedTerm
from stitchmesh.simulation.friction_law import slip_energy, slip_second_derivative, slip_slope

SLIP_SHARE = 0.05
"""Smallest slip length as a share of the radius of the yarn. A smaller share costs Newton's method more iterations."""


@wp.func
def friction_energy(slip: Scalar, length: Scalar, limit: Scalar) -> Any:
    """E [erg] at the signed distance ``slip`` from the anchor; ``length`` is e."""
    return limit * slip_energy(wp.abs(slip), length)


@wp.func
def friction_force(slip: Scalar, length: Scalar, limit: Scalar) -> Any:
    """Force [dyn] on a coordinate at the signed distance ``slip`` from its anchor."""
    return -limit * slip * slip_slope(wp.abs(slip), length)


@wp.func
def friction_slope(slip: Scalar, length: Scalar, limit: Scalar) -> Any:
    """Second derivative of the energy [dyn/cm]."""
    return limit * slip_second_derivative(wp.abs(slip), length)


@wp.func
def dragged(anchor: Scalar, place: Scalar, length: Scalar) -> Any:
    """The anchor [cm] after a step that ended at ``place``."""
    result = anchor
    if wp.abs(place - anchor) > length:
        result = place - wp.sign(place - anchor) * length
    return result


@kernel
def find_friction_energies(
    # state in
    anchor: wp.array[Vec2],
    length: wp.array[Vec2],
    limit: wp.array[Vec2],
    sliding: wp.array[Vec2],
    # state out
    energy: wp.array[wp.float64],
) -> None:
    """Energy of the two springs of each crossing [erg]."""
    i = wp.tid()
    s, e, m = sliding[i] - anchor[i], length[i], limit[i]
    energy[i] = wp.float64(friction_energy(s[0], e[0], m[0]) + friction_energy(s[1], e[1], m[1]))


@kernel
def add_friction_forces(
    # state in
    anchor: wp.array[Vec2],
    length: wp.array[Vec2],
    limit: wp.array[Vec2],
    sliding: wp.array[Vec2],
    # state out
    on_sliding: wp.array[Vec2],
) -> None:
    """Add the friction on both coordinates of each crossing."""
    i = wp.tid()
    s, e, m = sliding[i] - anchor[i], length[i], limit[i]
    on_sliding[i] += type(on_sliding[0])(friction_force(s[0], e[0], m[0]), friction_force(s[1], e[1], m[1]))


@kernel
def find_sticking(
    # model
    damped: Scalar,
    # state in
    anchor: wp.array[Vec2],
    length: wp.array[Vec2],
    limit: wp.array[Vec2],
    sliding: wp.array[Vec2],
    before: wp.array[Vec2],
    # state out
    sticking: wp.array[Vec2],
) -> None:
    """Second derivatives of the energy, the stiffness of the springs that stick, of which a part is that ``before``."""
    i = wp.tid()
    s, e, m = sliding[i] - anchor[i], length[i], limit[i]
    present = type(sticking[0])(friction_slope(s[0], e[0], m[0]), friction_slope(s[1], e[1], m[1]))
    sticking[i] = present + damped * (before[i] - present)


@kernel
def add_friction_products(
    # state in
    sticking: wp.array[Vec2],
    direction: wp.array[Vec2],
    # state out
    product: wp.array[Vec2],
) -> None:
    """Add the products of the diagonal Hessian."""
    i = wp.tid()
    product[i] += wp.cw_mul(sticking[i], direction[i])


@kernel
def add_friction_blocks(
    # state in
    sticking: wp.array[Vec2],
    # state out
    blocks: wp.array[Mat22],
) -> None:
    """Add the Hessian to the diagonal blocks of the coordinates."""
    i = wp.tid()
    blocks[i] += wp.diag(sticking[i])


@wp.func
def anchored_again(
    place: Scalar, anchor: Scalar, length: Scalar, limit: Scalar, new_length: Scalar, new_limit: Scalar
) -> Any:
    """The anchor [cm] from which a spring of another length and limit has the same force, or the new limit."""
    one = type(place)(1.0)
    result = anchor * one
    if wp.min(limit, new_limit) > one - one:
        force = friction_force(place - anchor, length, limit)
        share = wp.min(wp.abs(force) / new_limit, one)
        x = share / (one + wp.sqrt(one - share))  # x (2 - x) = share
        result = place + wp.sign(force) * x * new_length
    return result


@kernel
def find_friction_limits(
    # model
    coefficient: wp.array[Scalar],
    stiffness: wp.array[Vec2],
    shortest: wp.array[Vec2],
    # state in
    pressing: wp.array[Scalar],
    sliding: wp.array[Vec2],
    # state in and out
    length: wp.array[Vec2],
    limit: wp.array[Vec2],
    anchor: wp.array[Vec2],
) -> None:
    """M = mu N and e of both coordinates, no limit without a spring; anchors move so that the forces stay."""
    i = wp.tid()
    u, a, e, m = sliding[i], anchor[i], length[i], limit[i]
    k, most, least = stiffness[i], coefficient[i] * pressing[i], shortest[i]
    zero, two = most - most, type(most)(2.0)
    first, second = zero, zero
    near, far = least[0], least[1]
    if k[0] > zero:
        first = most * type(most)(1.0)
        near = wp.max(two * most / k[0], near)
    if k[1] > zero:
        second = most * type(most)(1.0)
        far = wp.max(two * most / k[1], far)
    own = anchored_again(u[0], a[0], e[0], m[0], near, first)
    other = anchored_again(u[1], a[1], e[1], m[1], far, second)
    anchor[i] = type(anchor[0])(own, other)
    limit[i] = type(limit[0])(first, second)
    length[i] = type(length[0])(near, far)


@kernel
def drag_anchors(
    # state in
    length: wp.array[Vec2],
    sliding: wp.array[Vec2],
    # state out
    anchor: wp.array[Vec2],
) -> None:
    """Drag the anchors of yarns that slipped to the distance of the slip length."""
    i = wp.tid()
    place, e, old = sliding[i], length[i], anchor[i]
    anchor[i] = type(anchor[0])(dragged(old[0], place[0], e[0]), dragged(old[1], place[1], e[1]))


class SlidingFriction(MixedTerm):
    """Friction between the yarns of each crossing on a device."""

    name = "sliding friction"
    acts_on = "nodes"

    def __init__(self, elements: CrossingElements, yarns: CrossingTerm) -> None:
        """Anchor all yarns where they are laid out.

        Args:
            elements: the yarns.
            yarns: the term of the elasticity of the yarns; its rest angles enter the normal forces.
        """
        scalar, device = yarns.turn.dtype, yarns.device
        self.count, self.device, self._yarns = elements.count, device, yarns
        self.normal_forces = NormalForces.of(elements, scalar, device)
        two, self._scalar = vector(2, scalar), scalar
        self._stiffness = wp.array(elements.slides * elements.friction_stiffness, dtype=two, device=device)
        self._shortest = wp.array(SLIP_SHARE * elements.radius, dtype=two, device=device)
        self._coefficient = wp.array(elements.friction, dtype=scalar, device=device)
        self.anchor = wp.array(elements.rest_sliding, dtype=two, device=device)
        """a of both coordinates of each crossing [cm], shape (N,)."""
        self.limit = wp.zeros(elements.count, dtype=two, device=device)
        """m of both coordinates of each crossing [dyn], shape (N,)."""
        self.slip_length = wp.array(SLIP_SHARE * elements.radius, dtype=two, device=device)
        """e of both coordinates of each crossing [cm], shape (N,)."""
        self._sticking, self._before = (wp.zeros(elements.count, dtype=two, device=device) for _ in range(2))
        self._energy = wp.zeros(elements.count, dtype=wp.float64, device=device)
        self._outdated = True
        self._limits: tuple[MixedVector, CapturedLaunches] | None = None

    def begin_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Find the limits of friction and the Hessian at the beginning of the step.

        A search for an equilibrium calls this in each of its iterations. Limits then stay until ``end_step``: with
        other limits each time, the iterations would not settle.
        """
        if time_step > 0.0 or self._outdated:
            self._outdated = False
            self._limits_at(state).launch()

    def _limits_at(self, state: MixedVector) -> CapturedLaunches:
        """The launches that find the limits at a state, captured for the last given state."""
        if self._limits is None or self._limits[0] is not state:
            launcher = partial(prepare, device=self.device)
            model = [self._coefficient, self._stiffness, self._shortest]
            inputs = [*model, self.normal_forces.pressing, state.sliding]
            outputs = [self.slip_length, self.limit, self.anchor]
            launches = [
                *self.normal_forces.launches(self._yarns.model, self._yarns.turn, state, launcher),
                launcher(find_friction_limits, self.count, inputs, outputs),
                *self._slopes(state, 0.0, self._before, launcher),
            ]
            self._limits = state, CapturedLaunches(launches, self.device)
        return self._limits[1]

    def end_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Drag the anchors of the yarns that slipped."""
        self._outdated = True
        launch(drag_anchors, self.count, [self.slip_length, state.sliding], [self.anchor], self.device)

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of the two springs of each crossing, and the array of the energies."""
        return [launcher(find_friction_energies, self.count, self._inputs(state), [self._energy])], self._energy

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that adds the friction."""
        return [launcher(add_friction_forces, self.count, self._inputs(state), [force.sliding])]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that finds which springs stick, now and at the beginning of the step; never negative."""
        return self._slopes(state, self.damped, self._sticking, launcher)

    def _slopes(self, state: MixedVector, damped: float, result: wp.array[Any], launcher: Launcher) -> list[Any]:
        inputs = [self._scalar(damped), *self._inputs(state), self._before]
        return [launcher(find_sticking, self.count, inputs, [result])]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that adds the products."""
        return [launcher(add_friction_products, self.count, [self._sticking, direction.sliding], [product.sliding])]

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launch that adds the Hessian, which is diagonal."""
        return [launcher(add_friction_blocks, self.count, [self._sticking], [blocks.sliding])]

    def arrays(self) -> dict[str, Any]:
        """Anchors, limits (which last as long as a search for an equilibrium), and whether these are outdated."""
        outdated = wp.array([int(self._outdated)], dtype=wp.int32, device="cpu")
        limits = {"friction limits": self.limit, "slip lengths": self.slip_length}
        return {"friction anchors": self.anchor, **limits, "friction outdated": outdated}

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore anchors and limits."""
        super().resume(arrays)
        self._outdated = bool(arrays["friction outdated"][0])

    def carried_arrays(self) -> dict[str, Any]:
        """The anchors with the limits and slip lengths, which together define the forces."""
        return {"friction anchors": self.anchor, "friction limits": self.limit, "slip lengths": self.slip_length}

    def _inputs(self, state: MixedVector) -> list[Any]:
        return [self.anchor, self.slip_length, self.limit, state.sliding]
