# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The elastic energy of crossing yarns as a term of the mixed system: stretch, contact, bending and shear.

Products with the Hessian come from the blocks of each star, which are computed once for a state and stored.

*The longest step.* Along a direction, no segment of yarn may lose more than a share of its rest length. A line search
starts with this step. Nodes that slide towards one another then come closer by a bounded factor and never pass:
D + t dD >= (1 - share) D. If a segment is already shorter than its merging distance e, it may lose the share of e
(``crossing_energies``).

*Yield of bending.* A yarn that is bent too far keeps a part of the bend. At a node with the angle t, the rest angle r
and the span D, the change of curvature from rest is 2 (t - r) / D (``crossing_energies``). Beyond the yield curvature
kappa_y the rest angle follows (ideal plasticity):

    r <- t - max(-y, min(t - r, y)),    y = kappa_y D / 2

The rest angle changes once a step, after the step is accepted, so that a step has one elastic energy.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import vector
from stitchmesh.mixed.crossings.crossing_elements import CrossingElements
from stitchmesh.mixed.crossings.energies.crossing_energies import angle_of, place_of
from stitchmesh.mixed.crossings.star.star import (
    add_star_diagonal,
    add_star_slots,
    coordinate_of,
    find_star_blocks,
    find_star_energies,
    find_star_forces,
    leg_of,
    multiply_star_blocks,
)
from stitchmesh.mixed.crossings.star.star_memory import BLOCK_NUMBERS, LEG_NUMBERS, numbers_of
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import MixedTerm


@dataclass(frozen=True, eq=False)
class CrossingModel:
    """Constants of N crossing nodes on a device; ``CrossingElements`` defines the values."""

    link: wp.array[wp.int32]
    """Neighbours as 2 j + c, or -1; shape (N, 4)."""
    slides: wp.array[Any]
    """1 for each free Eulerian coordinate and 0 for each fixed one, two-vectors; shape (N,)."""
    segment: wp.array[Any]
    """k_s, k_c L, contact distance and merging distance of each segment, four-vectors; shape (N, 2)."""
    bend: wp.array[Any]
    """k_b and the merging distance of both segments together, two-vectors; shape (N, 2)."""
    shear: wp.array[Any]
    """k_x L of the quadrants, four-vectors; shape (N,)."""
    shear_rest: wp.array[Any]
    """Rest angle of the first quadrant, shape (N,)."""
    count: int
    """Number N of nodes."""

    @staticmethod
    def of(elements: CrossingElements, scalar: Any, device: wp.Device) -> CrossingModel:
        """The constants of elements, in the precision of ``scalar``."""
        merging = elements.merging_distance
        before = elements.link[:, 1::2]
        span = merging + np.where(before >= 0, merging.reshape(-1)[np.maximum(before, 0)], 0.0)
        segment = [elements.stretch, elements.contact, elements.contact_distance, merging]

        def upload(values: Any, size: int = 1) -> wp.array[Any]:
            return wp.array(values, dtype=scalar if size == 1 else vector(size, scalar), device=device)

        return CrossingModel(
            link=wp.array(elements.link.astype(np.int32), dtype=wp.int32, device=device),
            slides=upload(elements.slides.astype(np.float64), 2),
            segment=upload(np.stack(segment, axis=-1), 4),
            bend=upload(np.stack([elements.bending, span], axis=-1), 2),
            shear=upload(elements.shear, 4),
            shear_rest=upload(elements.rest_shear),
            count=elements.count,
        )

    @property
    def constants(self) -> list[Any]:
        """The first arguments of the kernels over stars."""
        return [self.link, self.segment, self.bend, self.shear, self.shear_rest]


@kernel
def find_step_limits(
    # model
    link: wp.array2d[wp.int32],
    slides: wp.array[Any],
    segment: wp.array2d[Any],
    share: Any,
    # state in
    sliding: wp.array[Any],
    direction: wp.array[Any],
    # state out
    limit: wp.array[Any],
) -> None:
    """Longest step of the segments after each node, at most 1."""
    i = wp.tid()
    one = type(share)(1.0)
    longest = type(share)(1.0)
    for c in range(2):
        after = link[i, 2 * c]
        if after >= 0:
            rest = coordinate_of(after, sliding, one) - sliding[i][c]
            ahead = coordinate_of(after, direction, one) * coordinate_of(after, slides, one)
            loss = direction[i][c] * slides[i][c] - ahead
            allowed = share * wp.max(rest, segment[i, c][3])
            if loss * longest > allowed:
                longest = allowed / loss
    limit[i] = longest


@kernel
def turn_after_yield(
    # model
    link: wp.array2d[wp.int32],
    yield_curvature: wp.array2d[Any],
    # state in
    nodes: wp.array[Any],
    sliding: wp.array[Any],
    # state out
    turn: wp.array2d[Any],
) -> None:
    """Let the rest angles of both yarns of each node follow the angles beyond their limits."""
    i = wp.tid()
    n = int(2)
    for c in range(n):
        after, before = link[i, 2 * c], link[i, 2 * c + 1]
        if after >= 0 and before >= 0:
            leg, other = leg_of(link, nodes, sliding, i, 2 * c), leg_of(link, nodes, sliding, i, 2 * c + 1)
            angle, span = angle_of(-place_of(other), place_of(leg)), leg[3] - other[3]
            most = yield_curvature[i, c] * span * type(span)(0.5)
            turn[i, c] = angle - wp.clamp(angle - turn[i, c], -most, most)


class CrossingTerm(MixedTerm):
    """Stretch, contact of parallel yarns, bending and shear of crossing yarns on a device.

    The rest angles of bending last from step to step; yield changes them at the end of a step.
    """

    name = "crossing yarns"
    acts_on = "nodes"

    def __init__(
        self,
        elements: CrossingElements,
        scalar: Any,
        device: wp.Device,
        *,
        block_scalar: Any = wp.float32,
    ) -> None:
        """Put the elements on a device.

        Args:
            elements: the yarns.
            scalar: Warp's floating-point type.
            device: where the term lies.
            block_scalar: floating-point type of the blocks of the Hessian, which take 160 scalars for each node.
                Newton's method does not need more than single precision: the forces that it brings to zero have the
                precision of ``scalar``.
        """
        self.model = CrossingModel.of(elements, scalar, device)
        count, self.device = elements.count, device
        self.turn = wp.array(elements.rest_turn, dtype=scalar, device=device)
        self._yields = bool(np.isfinite(elements.yield_curvature[elements.bending > 0.0]).any())
        self._yield_curvature = wp.array(elements.yield_curvature, dtype=scalar, device=device)
        places = numbers_of(count, LEG_NUMBERS)
        self._slots = wp.zeros(places, dtype=scalar, device=device)
        self._product_slots = wp.zeros(places, dtype=block_scalar, device=device)
        self._limits = wp.zeros(count, dtype=scalar, device=device)
        self._energy = wp.zeros(count, dtype=wp.float64, device=device)
        self._block = wp.zeros(numbers_of(count, BLOCK_NUMBERS), dtype=block_scalar, device=device)
        self._scalar = scalar

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of each star, and the array of the energies."""
        inputs = [*self.model.constants, self.turn, state.nodes, state.sliding]
        return [launcher(find_star_energies, self.model.count, inputs, [self._energy])], self._energy

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The forces of all stars, and their sums at the nodes."""
        inputs = [*self.model.constants, self.turn, state.nodes, state.sliding]
        own = launcher(find_star_forces, self.model.count, inputs, [self._slots])
        return [own, self._gather(self._slots, force, launcher)]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that finds the blocks."""
        exact = self._scalar(self.exact)
        inputs = [*self.model.constants, exact, self.turn, state.nodes, state.sliding]
        return [launcher(find_star_blocks, self.model.count, inputs, [self._block])]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The products of all stars, and their sums at the nodes."""
        given = [direction.nodes, direction.sliding]
        inputs = [self.model.link, self.model.slides, self.model.shear, self._block, *given]
        own = launcher(multiply_star_blocks, self.model.count, inputs, [self._product_slots])
        return [own, self._gather(self._product_slots, product, launcher)]

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launch that adds the diagonal blocks."""
        inputs = [self.model.link, self.model.slides, self._block]
        outputs = [blocks.nodes, blocks.sliding, blocks.coupling_u, blocks.coupling_v]
        return [launcher(add_star_diagonal, self.model.count, inputs, outputs)]

    def element_limits(
        self, state: MixedVector, direction: MixedVector, launcher: Launcher
    ) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the part of a direction along which no segment loses half of its rest length."""
        model, half = self.model, state.scalar(0.5)
        inputs = [model.link, model.slides, model.segment, half, state.sliding, direction.sliding]
        return [launcher(find_step_limits, model.count, inputs, [self._limits])], self._limits

    def end_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Let the yarns yield."""
        if self._yields:
            inputs = [self.model.link, self._yield_curvature, state.nodes, state.sliding]
            launch(turn_after_yield, self.model.count, inputs, [self.turn], self.device)

    def arrays(self) -> dict[str, Any]:
        """The rest angles of bending."""
        return {"yarn rest angles": self.turn}

    def _gather(self, slots: wp.array[Any], target: MixedVector, launcher: Launcher) -> Any:
        """The launch that adds up the slots of each node."""
        inputs = [self.model.link, self.model.slides, slots]
        return launcher(add_star_slots, self.model.count, inputs, [target.nodes, target.sliding])
