# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The elastic energy of crossing yarns as a term of the mixed system: stretch, contact, bending and shear.

Products with the Hessian come from the blocks of each star, which are found once for a state and stored.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.launch import launch
from stitchmesh.mixed.crossings.bending_yield import turn_after_yield
from stitchmesh.mixed.crossings.crossing_elements import CrossingElements
from stitchmesh.mixed.crossings.crossing_model import CrossingModel
from stitchmesh.mixed.crossings.star.star_hessian import (
    add_star_diagonal,
    find_star_blocks,
    multiply_star_blocks,
)
from stitchmesh.mixed.crossings.star.star_kernels import add_star_slots, find_star_energies, find_star_forces
from stitchmesh.mixed.crossings.star.star_memory import BLOCK_NUMBERS, LEG_NUMBERS, numbers_of
from stitchmesh.mixed.crossings.step_limit import sliding_limits
from stitchmesh.mixed.mixed_blocks import MixedBlocks
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import MixedTerm


class CrossingTerm(MixedTerm):
    """Stretch, contact of parallel yarns, bending and shear of crossing yarns on a device.

    Rest angles of bending change by yield at the end of a step; they last from step to step.
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
        """The launch that finds the energy of each star, and where it is."""
        if self.model.count == 0:
            return [], self._energy
        inputs = [*self.model.constants, self.turn, state.nodes, state.sliding]
        return [launcher(find_star_energies, self.model.count, inputs, [self._energy])], self._energy

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The forces of all stars, and their sums at the nodes."""
        if self.model.count == 0:
            return []
        inputs = [*self.model.constants, self.turn, state.nodes, state.sliding]
        own = launcher(find_star_forces, self.model.count, inputs, [self._slots])
        return [own, self._gather(self._slots, force, launcher)]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that finds the blocks."""
        if self.model.count == 0:
            return []
        exact = self._scalar(self.exact)
        inputs = [*self.model.constants, exact, self.turn, state.nodes, state.sliding]
        return [launcher(find_star_blocks, self.model.count, inputs, [self._block])]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The products of all stars, and their sums at the nodes."""
        if self.model.count == 0:
            return []
        given = [direction.nodes, direction.sliding]
        inputs = [self.model.link, self.model.slides, self.model.shear, self._block, *given]
        own = launcher(multiply_star_blocks, self.model.count, inputs, [self._product_slots])
        return [own, self._gather(self._product_slots, product, launcher)]

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launch that adds the diagonal blocks."""
        if self.model.count == 0:
            return []
        inputs = [self.model.link, self.model.slides, self._block]
        outputs = [blocks.nodes, blocks.sliding, blocks.coupling_u, blocks.coupling_v]
        return [launcher(add_star_diagonal, self.model.count, inputs, outputs)]

    def element_limits(
        self, state: MixedVector, direction: MixedVector, launcher: Launcher
    ) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the part of a direction along which no segment loses half of its rest length."""
        return sliding_limits(self.model, state, direction, self._limits, launcher), self._limits

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
