# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The common interface of all energies of the mixed system: membrane, bending, yarns, contact, weight.

A term is an energy of the positions v of the triangle vertices, the world positions p of the yarn nodes and their
Eulerian coordinates s. It does not know how p follows from the unknowns of the enriched region (``enrichment``). When a
term is made, each of its elements gets a blending weight, alpha for yarns and 1 - alpha for triangles
(Casafranca et al. 2020, section 4.1).

Functions that return launches may be called with a launcher that runs each kernel immediately (``launch``) or with one
that prepares it (``prepare``), so that a solver can capture the launches. A prepared launch has at least one thread:
where a term would have no elements, it is not made.

The weight of a yarn element is the mean of alpha at its nodes, alpha at its centroid. An element with a node of the
full-yarn region has the weight 1. No gradient of alpha then acts on such nodes, which have no triangles that could take
up its forces.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, Literal

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.reduction import minimum, ordered_sum
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector

EARTH = (0.0, -981.0, 0.0)
"""Acceleration on Earth [cm/s^2]; y points up."""
FULL = 1.0 - 1e-12
"""Alpha from which on a node belongs to the full-yarn region; slightly below 1 because of rounding."""


def element_weight(
    alpha: NDArray[np.float64], given: NDArray[np.bool_], full: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Weights of elements, shape (E,); 0 for an element without nodes.

    Args:
        alpha: blending field at the nodes of each element, shape (E, K).
        given: whether the element has each of these nodes, shape (E, K).
        full: whether each of these nodes belongs to the full-yarn region, shape (E, K).
    """
    mean = np.where(given, alpha, 0.0).sum(axis=1) / np.maximum(given.sum(axis=1), 1)
    weight: NDArray[np.float64] = np.where((given & full).any(axis=1), 1.0, mean)
    return weight


class MixedTerm(ABC):
    """An energy of the mixed system on a device."""

    name: str
    """Name of the term in reports."""
    exact: float = 1.0
    """Share of the exact Hessian in the products, in [0, 1]: 1 for the exact Hessian, 0 for the Hessian that is never
    negative (Gauss-Newton). ``linearize`` reads it."""
    damped: float = 0.0
    """Share of damping by stiffness in the products, in [0, 1), with the never-negative Hessian at the beginning of the
    step. A term whose Hessian changes little within a step uses the present Hessian. ``linearize`` reads it."""

    def energy(self, state: MixedVector) -> float:
        """Energy [erg] at a state, summed in a fixed order."""
        _launches, energies = self.element_energies(state, partial(launch, device=state.device))
        return ordered_sum(energies)

    @abstractmethod
    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launches that find the energy of each element [erg] at a state, and the array of the energies.

        The array is always the same, so that a solver can capture the launches and the sums.
        """

    @abstractmethod
    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add minus the gradient of the energy [dyn] at ``state`` to ``force``."""

    acts_on: Literal["all", "vertices", "nodes"] = "all"
    """Where the forces, products and blocks of the term act: on vertices alone, on nodes and their Eulerian coordinates
    alone, or on all. Launches of terms of the first two kinds may run side by side. Apart from state and direction,
    only the last launch of such a term reads or writes memory that does not belong to the term."""

    @abstractmethod
    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that store the values for the products at ``state``; none for a constant Hessian."""

    @abstractmethod
    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add H d to ``product``, with the Hessian H [dyn / cm] of the last ``linearize``."""

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that add the diagonal blocks of H of the last ``linearize``; none where H has none."""
        return []

    def begin_step(self, state: MixedVector, time: float, time_step: float) -> None:  # noqa: B027 - most terms do not lag
        """Prepare values that stay constant within a time step: contact pairs, friction limits, places of bodies.

        A step that fails begins again from the same state with a shorter time step. This function must therefore not
        change the arrays that ``arrays`` names.

        Args:
            state: positions at the beginning of the step.
            time: time at the beginning of the step, or of the equilibrium [s].
            time_step: length of the step [s]; 0 for a static equilibrium.
        """

    def end_step(self, state: MixedVector, time: float, time_step: float) -> None:  # noqa: B027 - most terms keep nothing
        """Update lasting values, for example friction anchors, after an accepted step.

        Args:
            state: positions at the end of the step.
            time: time at the end of the step, or of the equilibrium [s].
            time_step: length of the step [s]; 0 for a static equilibrium.
        """

    def element_limits(
        self, state: MixedVector, direction: MixedVector, launcher: Launcher
    ) -> tuple[list[Any], wp.array[Any]] | None:
        """The launches that find the limit of each element for ``step_limit``, and the array of the limits.

        It is None for a term without limits, and for a term whose ``step_limit`` does more than take the smallest
        limit.
        """
        return None

    def step_limit(self, state: MixedVector, direction: MixedVector) -> float:
        """The part of a direction, in [0, 1], along which nothing passes what it must not pass; 1 without a limit.

        A solver calls this function before it moves along a direction, also for a first guess, and moves by at most
        this part. A contact term lists its pairs again here if the direction leads beyond the listed pairs.

        Args:
            state: positions at the start of the move.
            direction: the move, as displacements.
        """
        found = self.element_limits(state, direction, partial(launch, device=state.device))
        return minimum(found[1]) if found else 1.0

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
        """Take over ``carried_arrays`` of another region before the first step; other lasting values are made anew."""
        for name, array in self.carried_arrays().items():
            array.assign(np.asarray(arrays[name]))


def term_arrays(terms: Sequence[MixedTerm]) -> dict[str, NDArray[Any]]:
    """Return all arrays of terms that last from step to step, by the number of the term and the name."""
    return {
        f"term {number} {name}": array.numpy()
        for number, term in enumerate(terms)
        for name, array in term.arrays().items()
    }


def resume_terms(terms: Sequence[MixedTerm], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Restore the contents of ``term_arrays``, which ``arrays`` holds among others.

    Raises:
        ParameterError: an array is missing or has another shape.
    """
    check_arrays(term_arrays(terms), arrays)
    for number, term in enumerate(terms):
        term.resume({name: arrays[f"term {number} {name}"] for name in term.arrays()})


def check_arrays(expected: Mapping[str, NDArray[Any]], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Check that ``arrays`` holds all expected arrays in their shapes.

    Raises:
        ParameterError: an array is missing or has another shape.
    """
    for name, array in expected.items():
        if name not in arrays or arrays[name].shape != array.shape:
            found = "is missing" if name not in arrays else f"has the shape {arrays[name].shape}"
            raise ParameterError(
                f"resume: array {name!r} of the checkpoint {found}; expected the shape {array.shape}; begin without it"
            )


@kernel
def keep_share(
    # state in
    exact: Any,
    # state out
    share: wp.array[Any],
) -> None:
    """Keep the share of the exact Hessian."""
    share[wp.tid()] = exact
