# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What all energies of the mixed system have in common: membrane, bending, yarns, contact, weight.

A term is an energy of the positions v of the triangle vertices, the world positions p of the yarn nodes and their
Eulerian coordinates s. It does not know how p follows from the unknowns of the enriched region (``enrichment``). The
weight of blending of each of its elements, alpha for yarns and 1 - alpha for triangles, is given when it is made
(Casafranca et al. 2020, section 4.1).

Functions that return launches may be called with a launcher that runs each kernel immediately (``launch``) or with one
that prepares it (``prepare``), so that a solver can capture the launches. A term without elements returns none: a
prepared launch has at least one thread.

A yarn element weighs the mean of alpha at its nodes, alpha at its centroid. One that has a node of the full-yarn region
weighs 1: no gradient of alpha then acts on these nodes, which have no triangles that could take up its forces.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import partial
from typing import Any, Literal

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.reduction import minimum, ordered_sum
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector

EARTH = (0.0, -981.0, 0.0)
"""Acceleration on Earth [cm/s^2]; y points up."""
FULL = 1.0 - 1e-12
"""Alpha from which a node belongs to the full-yarn region; less by rounding."""


def element_weight(
    alpha: NDArray[np.float64], given: NDArray[np.bool_], full: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Weights of elements, shape (E,); 0 for an element without nodes.

    Args:
        alpha: blending field at the nodes of each element, shape (E, K).
        given: whether the element has each of them, shape (E, K).
        full: whether each of them belongs to the full-yarn region, shape (E, K).
    """
    mean = np.where(given, alpha, 0.0).sum(axis=1) / np.maximum(given.sum(axis=1), 1)
    weight: NDArray[np.float64] = np.where((given & full).any(axis=1), 1.0, mean)
    return weight


class MixedTerm(ABC):
    """An energy of the mixed system on a device."""

    name: str
    """Name of the term in reports."""
    exact: float = 1.0
    """Part of the exact Hessian in the products, in [0, 1]: 1 for the exact Hessian, 0 for the one that is never
    negative (Gauss-Newton). Read when ``linearize`` is called."""
    damped: float = 0.0
    """Part of damping by stiffness in the products, in [0, 1), with the never-negative Hessian at the beginning of the
    step. A term whose Hessian changes little within a step uses the present one. Read when ``linearize`` is called."""

    def energy(self, state: MixedVector) -> float:
        """Energy [erg] at a state, summed in a fixed order."""
        _launches, energies = self.element_energies(state, partial(launch, device=state.device))
        return ordered_sum(energies) if len(energies) else 0.0

    @abstractmethod
    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launches that find the energy of each element [erg] at a state, and the array that they write it to.

        The array is always the same one, so that a solver can capture the launches and the sums.
        """

    @abstractmethod
    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add minus the gradient of the energy [dyn] at ``state`` to ``force``."""

    acts_on: Literal["all", "vertices", "nodes"] = "all"
    """What the forces, products and blocks of the term are added to: vertices alone, nodes and their Eulerian
    coordinates alone, or any of them. Launches of terms of the first two kinds may run side by side. Of the launches of
    such a term only the last one writes or reads what is not the term's own, apart from state and direction."""

    @abstractmethod
    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that store what the products need at ``state``; none for a constant Hessian."""

    @abstractmethod
    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add H d to ``product``, with the Hessian H [dyn / cm] of the last ``linearize``."""

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that add the diagonal blocks of H of the last ``linearize``; none where H has none."""
        return []

    def begin_step(self, state: MixedVector, time: float, time_step: float) -> None:  # noqa: B027 - most terms do not lag
        """Prepare what stays constant within a time step: contact pairs, friction limits, places of moving bodies.

        A step that fails begins again from the same state with a shorter time step. This function therefore leaves what
        ``arrays`` names unchanged.

        Args:
            state: positions at the beginning of the step.
            time: time at the beginning of the step, or of the equilibrium [s].
            time_step: length of the step [s]; 0 for a static equilibrium.
        """

    def end_step(self, state: MixedVector, time: float, time_step: float) -> None:  # noqa: B027 - most terms keep nothing
        """Update what lasts from step to step, for example friction anchors, after a step that is accepted.

        Args:
            state: positions at the end of the step.
            time: time at the end of the step, or of the equilibrium [s].
            time_step: length of the step [s]; 0 for a static equilibrium.
        """

    def element_limits(
        self, state: MixedVector, direction: MixedVector, launcher: Launcher
    ) -> tuple[list[Any], wp.array[Any]] | None:
        """The launches that find the limit of each element for ``step_limit``, and the array that they write it to.

        None for a term without limits, and for one whose ``step_limit`` does more than to take the smallest one.
        """
        return None

    def step_limit(self, state: MixedVector, direction: MixedVector) -> float:
        """The part of a direction, in [0, 1], along which nothing can pass what it must not pass; 1 where nothing can.

        A solver calls this function before it moves along a direction, also for a first guess, and moves by this part
        at most. A term of contact lists its pairs again here where the direction leads beyond those that are listed.

        Args:
            state: positions at the start of the move.
            direction: the move, as displacements.
        """
        found = self.element_limits(state, direction, partial(launch, device=state.device))
        return minimum(found[1]) if found and len(found[1]) else 1.0

    @property
    def generation(self) -> int:
        """A number that changes when prepared launches of the term are stale, because its arrays have grown."""
        return 0

    def arrays(self) -> dict[str, Any]:
        """Arrays on the device that last from step to step, by name, for stopping and resuming."""
        return {}

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the contents of ``arrays``."""
        for name, array in self.arrays().items():
            array.assign(np.asarray(arrays[name]))

    def carried_arrays(self) -> dict[str, Any]:
        """The part of ``arrays`` that stays when the region of a run changes: one value for each node or point."""
        return self.arrays()

    def carry(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Take over ``carried_arrays`` of another region, before the first step; what else lasts is found again."""
        for name, array in self.carried_arrays().items():
            array.assign(np.asarray(arrays[name]))


@kernel
def keep_share(
    # state in
    exact: Any,
    # state out
    share: wp.array[Any],
) -> None:
    """Keep the share of the exact Hessian."""
    share[wp.tid()] = exact
