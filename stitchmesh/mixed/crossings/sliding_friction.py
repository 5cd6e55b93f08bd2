# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Friction of yarns that slide through crossings: a spring to an anchor, and Coulomb slip (Cirio et al. 2014).

Each Eulerian coordinate u of a crossing has an anchor a. With the stiffness k of the spring, the limit m = mu N of the
crossing (``normal_forces``) and the slip length e = 2 m / k, the force at the distance s = |u - a| has the amount

    F = k s (1 - s / (2 e))  for s < e,   else  m

A yarn sticks at distances below e and slips beyond. The published law is k s, cut off at m; its corner is rounded here,
because Newton's method fails to settle at a corner. Within a time step anchor and limit are constant, and the force has
the energy

    E = 1/2 k s^2 (1 - s / (3 e))  for s < e,   else  m (s - e / 3)

which is convex. The solver therefore finds the force at the end of the step, which is never above the limit. After the
step a yarn that slipped drags its anchor to the distance e; where it stuck the anchor stays, so that a load below the
limit never makes a yarn creep. Work against friction is lost in this move alone, and a yarn that was pulled beyond its
limits does not return: a snag stays, an elastic mark does not.

Anchors last from step to step. Limits follow from the state at the beginning of a step.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import vector
from stitchmesh.compute.reduction import ordered_sum
from stitchmesh.mixed.crossings.crossing_elements import CrossingElements
from stitchmesh.mixed.crossings.crossing_term import CrossingTerm
from stitchmesh.mixed.crossings.normal_forces import NormalForces
from stitchmesh.mixed.mixed_blocks import MixedBlocks
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import Term


@wp.func
def friction_energy(slip: Any, stiffness: Any, limit: Any) -> Any:
    """E [erg] at the signed distance ``slip`` from the anchor."""
    half, two, three = type(slip)(0.5), type(slip)(2.0), type(slip)(3.0)
    distance = wp.abs(slip)
    energy = limit * distance
    if stiffness * distance < two * limit:
        energy = half * stiffness * distance * distance * (three - stiffness * distance / (two * limit)) / three
    elif stiffness > type(slip)(0.0):
        energy -= limit * (two * limit / stiffness) / three
    else:
        energy = type(slip)(0.0)
    return energy


@wp.func
def friction_force(slip: Any, stiffness: Any, limit: Any) -> Any:
    """Force [dyn] on a coordinate at the signed distance ``slip`` from its anchor."""
    one, two = type(slip)(1.0), type(slip)(2.0)
    pull = stiffness * wp.abs(slip)
    amount = limit
    if pull < two * limit:
        amount = pull * (one - pull / (two * two * limit))
    if stiffness <= type(slip)(0.0):
        amount = type(slip)(0.0)
    return -wp.sign(slip) * amount


@wp.func
def friction_stiffness(slip: Any, stiffness: Any, limit: Any) -> Any:
    """Second derivative of the energy [dyn/cm], k (1 - s / e) and not negative."""
    result = type(slip)(0.0)
    pull = stiffness * wp.abs(slip)
    if pull < type(slip)(2.0) * limit:
        result = stiffness * (type(slip)(1.0) - pull / (type(slip)(2.0) * limit))
    return result


@wp.func
def dragged(anchor: Any, place: Any, stiffness: Any, limit: Any) -> Any:
    """The anchor [cm] after a step that ended at ``place``."""
    slip, two = place - anchor, type(place)(2.0)
    result = anchor
    if wp.abs(slip) * stiffness > two * limit:
        result = place - wp.sign(slip) * (two * limit / stiffness)
    return result


@kernel
def find_friction_energies(
    # model
    stiffness: wp.array[Any],
    # state in
    anchor: wp.array[Any],
    limit: wp.array[Any],
    sliding: wp.array[Any],
    # state out
    energy: wp.array[wp.float64],
) -> None:
    """Energy of the two springs of each crossing [erg]."""
    i = wp.tid()
    slip, k = sliding[i] - anchor[i], stiffness[i]
    energy[i] = wp.float64(friction_energy(slip[0], k[0], limit[i]) + friction_energy(slip[1], k[1], limit[i]))


@kernel
def add_friction_forces(
    # model
    stiffness: wp.array[Any],
    # state in
    anchor: wp.array[Any],
    limit: wp.array[Any],
    sliding: wp.array[Any],
    # state out
    on_sliding: wp.array[Any],
) -> None:
    """Add the friction on both coordinates of each crossing."""
    i = wp.tid()
    slip, k = sliding[i] - anchor[i], stiffness[i]
    first, second = friction_force(slip[0], k[0], limit[i]), friction_force(slip[1], k[1], limit[i])
    on_sliding[i] += type(on_sliding[0])(first, second)


@kernel
def find_sticking(
    # model
    stiffness: wp.array[Any],
    # state in
    anchor: wp.array[Any],
    limit: wp.array[Any],
    sliding: wp.array[Any],
    # state out
    sticking: wp.array[Any],
) -> None:
    """Second derivatives of the energy, the stiffness of the springs that stick."""
    i = wp.tid()
    slip, k = sliding[i] - anchor[i], stiffness[i]
    first, second = friction_stiffness(slip[0], k[0], limit[i]), friction_stiffness(slip[1], k[1], limit[i])
    sticking[i] = type(sticking[0])(first, second)


@kernel
def add_friction_products(
    # state in
    sticking: wp.array[Any],
    direction: wp.array[Any],
    # state out
    product: wp.array[Any],
) -> None:
    """Add the products of the diagonal Hessian."""
    i = wp.tid()
    product[i] += wp.cw_mul(sticking[i], direction[i])


@kernel
def add_friction_blocks(
    # state in
    sticking: wp.array[Any],
    # state out
    blocks: wp.array[Any],
) -> None:
    """Add the Hessian to the diagonal blocks of the coordinates."""
    i = wp.tid()
    blocks[i] += wp.diag(sticking[i])


@kernel
def find_friction_limits(
    # model
    coefficient: wp.array[Any],
    # state in
    pressing: wp.array[Any],
    # state out
    limit: wp.array[Any],
) -> None:
    """M = mu N."""
    i = wp.tid()
    limit[i] = coefficient[i] * pressing[i]


@kernel
def drag_anchors(
    # model
    stiffness: wp.array[Any],
    # state in
    limit: wp.array[Any],
    sliding: wp.array[Any],
    # state out
    anchor: wp.array[Any],
) -> None:
    """Drag the anchors of yarns that slipped to the distance at which their springs have the limit."""
    i = wp.tid()
    place, k, old = sliding[i], stiffness[i], anchor[i]
    first, second = dragged(old[0], place[0], k[0], limit[i]), dragged(old[1], place[1], k[1], limit[i])
    anchor[i] = type(anchor[i])(first, second)


class SlidingFriction(Term):
    """Friction between the yarns of each crossing on a device."""

    name = "sliding friction"

    def __init__(self, elements: CrossingElements, yarns: CrossingTerm) -> None:
        """Anchor all yarns where they are laid out.

        Args:
            elements: the yarns.
            yarns: the term of their elasticity, whose rest angles enter the normal forces.
        """
        scalar, device = yarns.turn.dtype, yarns.device
        self.count, self.device, self._yarns = elements.count, device, yarns
        self.normal_forces = NormalForces.of(elements, scalar, device)
        two = vector(2, scalar)
        self._stiffness = wp.array(elements.slides * elements.friction_stiffness, dtype=two, device=device)
        self._coefficient = wp.array(elements.friction, dtype=scalar, device=device)
        self.anchor = wp.array(elements.rest_sliding, dtype=two, device=device)
        self.limit = wp.zeros(elements.count, dtype=scalar, device=device)
        self._sticking = wp.zeros(elements.count, dtype=two, device=device)
        self._outdated = True

    def begin_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Find the limits of friction at the beginning of the step.

        In a search for an equilibrium, which begins again with each of its iterations, limits stay until ``end_step``:
        with other limits each time, iterations would not settle.
        """
        if self.count and (time_step > 0.0 or self._outdated):
            self._outdated = False
            self.normal_forces.launches(self._yarns.model, self._yarns.turn, state, self._run)
            self._run(find_friction_limits, self.count, [self._coefficient, self.normal_forces.pressing], [self.limit])

    def end_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Drag the anchors of the yarns that slipped."""
        self._outdated = True
        self._run(drag_anchors, self.count, [self._stiffness, self.limit, state.sliding], [self.anchor])

    def energy(self, state: MixedVector) -> float:
        """Energy of all springs [erg]."""
        energies = wp.zeros(self.count, dtype=wp.float64, device=self.device)
        self._run(find_friction_energies, self.count, self._inputs(state), [energies])
        return ordered_sum(energies)

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that adds the friction."""
        if self.count == 0:
            return []
        return [launcher(add_friction_forces, self.count, self._inputs(state), [force.sliding])]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that finds which springs stick; the Hessian is never negative."""
        if self.count == 0:
            return []
        return [launcher(find_sticking, self.count, self._inputs(state), [self._sticking])]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that adds the products."""
        if self.count == 0:
            return []
        return [launcher(add_friction_products, self.count, [self._sticking, direction.sliding], [product.sliding])]

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launch that adds the Hessian, which is diagonal."""
        if self.count == 0:
            return []
        return [launcher(add_friction_blocks, self.count, [self._sticking], [blocks.sliding])]

    def arrays(self) -> dict[str, Any]:
        """The anchors."""
        return {"friction anchors": self.anchor}

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the anchors; the limits are found again."""
        super().resume(arrays)
        self._outdated = True

    def _inputs(self, state: MixedVector) -> list[Any]:
        return [self._stiffness, self.anchor, self.limit, state.sliding]

    def _run(self, kernel: wp.Kernel, count: int, inputs: list[Any], outputs: list[Any]) -> None:
        launch(kernel, count, inputs, outputs, self.device)
