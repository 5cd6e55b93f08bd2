# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Friction of yarns that slide through crossings: a spring to an anchor, and Coulomb slip (Cirio et al. 2014).

Each Eulerian coordinate u of a crossing has an anchor a. With the stiffness k of the spring and the limit m = mu N of
the crossing (``normal_forces``), the force on u is -k (u - a) while the yarn sticks, and -m or m while it slips. Within
a time step anchor and limit are constant, and the force has the energy

    E = 1/2 k s^2  for s = |u - a| < m / k,   else  m (s - m / (2 k))

which is convex. The solver therefore finds the force at the end of the step, capped at the limit. After the step a
yarn that slipped drags its anchor to the distance m / k; where it stuck the anchor stays. Work against friction is
lost in this move alone, and a yarn that was pulled beyond its limits does not return: a snag stays, an elastic mark
does not.

Anchors last from step to step. Limits follow from the state at the beginning of a step.
"""

from __future__ import annotations

from typing import Any

import warp as wp

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
def friction_force(slip: Any, stiffness: Any, limit: Any) -> Any:
    """Force [dyn] on a coordinate at the distance ``slip`` from its anchor."""
    return -wp.clamp(stiffness * slip, -limit, limit)


@wp.func
def dragged(anchor: Any, place: Any, stiffness: Any, limit: Any) -> Any:
    """The anchor [cm] after a step that ended at ``place``."""
    slip = place - anchor
    result = anchor
    if wp.abs(slip) * stiffness > limit:
        result = place - wp.sign(slip) * (limit / stiffness)
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
    total = wp.float64(0.0)
    for c in range(2):
        k, most = wp.float64(stiffness[i][c]), wp.float64(limit[i])
        slip = wp.abs(wp.float64(sliding[i][c]) - wp.float64(anchor[i][c]))
        if k * slip < most:
            total += wp.float64(0.5) * k * slip * slip
        elif k > wp.float64(0.0):
            total += most * (slip - wp.float64(0.5) * most / k)
    energy[i] = total


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
    """Second derivatives of the energy: the stiffness of the springs that stick."""
    i = wp.tid()
    slip, k = sliding[i] - anchor[i], stiffness[i]
    first, second = k[0], k[1]
    if wp.abs(slip[0]) * first >= limit[i]:
        first = first - first
    if wp.abs(slip[1]) * second >= limit[i]:
        second = second - second
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

    def begin_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Find the limits of friction at the beginning of the step."""
        if self.count:
            self.normal_forces.launches(self._yarns.model, self._yarns.turn, state, self._run)
            self._run(find_friction_limits, self.count, [self._coefficient, self.normal_forces.pressing], [self.limit])

    def end_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Drag the anchors of the yarns that slipped."""
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

    def _inputs(self, state: MixedVector) -> list[Any]:
        return [self._stiffness, self.anchor, self.limit, state.sliding]

    def _run(self, kernel: wp.Kernel, count: int, inputs: list[Any], outputs: list[Any]) -> None:
        launch(kernel, count, inputs, outputs, self.device)
