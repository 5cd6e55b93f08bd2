# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The terms of a simulation: energies of a vector of coordinates on a device.

There is one class of terms. The relaxation of yarns (``yarnrelax``) and the mixed system of cloth and yarns (``mixed``)
both sum the forces and energies of their terms. They differ in how they use the Hessian. The mixed system solves by
conjugate gradients, so its terms give products with the Hessian. The relaxation factors an assembled matrix, so its
terms give the entries of this matrix (``yarnrelax.energies.term.YarnTerm``). A term whose force is constant, such as
gravity or wind, has no Hessian. It acts in both without change.

Functions that return launches may be called with a launcher that runs each kernel immediately (``launch``) or with one
that prepares it (``prepare``), so that a solver can capture the launches. A prepared launch has at least one thread:
where a term would have no elements, it is not made.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, Generic, Literal, Protocol, TypeVar

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.launch import launch
from stitchmesh.compute.reduction import minimum, ordered_sum
from stitchmesh.errors import ParameterError


class Coordinates(Protocol):
    """A vector of coordinates on a device: positions, forces or directions."""

    @property
    def parts(self) -> Sequence[wp.array[Any]]:
        """The parts that are points in space, for example vertices and nodes: arrays of three-vectors."""

    @property
    def device(self) -> wp.Device:
        """Where the vector lies."""


StateT_contra = TypeVar("StateT_contra", bound=Coordinates, contravariant=True)
"""The positions of a simulation."""
ForceT_contra = TypeVar("ForceT_contra", contravariant=True)
"""Where its terms add their forces."""


class Term(ABC, Generic[StateT_contra, ForceT_contra]):
    """An energy on a device; energies are in erg."""

    name: str
    """Name of the term in reports."""
    gives_hessian: bool = False
    """Whether the term gives its Hessian, either exactly or nearly, as one that is never negative."""
    exact: float = 1.0
    """Share of the exact Hessian in the products, in [0, 1]: 1 for the exact Hessian, 0 for the Hessian that is never
    negative (Gauss-Newton). ``linearize`` reads it."""
    damped: float = 0.0
    """Share of damping by stiffness in the products, in [0, 1), with the never-negative Hessian at the beginning of the
    step. A term whose Hessian changes little within a step uses the present Hessian. ``linearize`` reads it."""
    is_load: bool = False
    """Whether the term is a load from outside, so that its energy is not stored in the fabric."""
    acts_on: Literal["all", "vertices", "nodes"] = "all"
    """Where the forces, products and blocks of the term act: on vertices of cloth alone, on yarn nodes alone, or on
    all. Launches of terms of the first two kinds may run side by side. Apart from state and direction, only the last
    launch of such a term reads or writes memory that does not belong to the term."""

    def energy(self, state: StateT_contra) -> float:
        """Energy at a state, summed in a fixed order."""
        _launches, energies = self.element_energies(state, partial(launch, device=state.device))
        return ordered_sum(energies)

    @abstractmethod
    def element_energies(self, state: StateT_contra, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launches that find the energy of each element at a state, and the array of the energies.

        The array is always the same, so that a solver can capture the launches and the sums.
        """

    @abstractmethod
    def forces(self, state: StateT_contra, force: ForceT_contra, launcher: Launcher) -> list[Any]:
        """The launches that add minus the gradient of the energy at ``state`` to ``force``."""

    def linearize(self, state: StateT_contra, launcher: Launcher) -> list[Any]:
        """The launches that store the values for the products at ``state``; none for a constant Hessian."""
        return []

    def products(self, direction: StateT_contra, product: ForceT_contra, launcher: Launcher) -> list[Any]:
        """The launches that add H d to ``product``, with the Hessian H of the last ``linearize``; none for zero."""
        return []

    def diagonal(self, blocks: Any, launcher: Launcher) -> list[Any]:
        """The launches that add the diagonal blocks of H of the last ``linearize``; none where H has none."""
        return []

    def begin_step(self, state: StateT_contra, time: float, time_step: float) -> None:
        """Prepare values that stay constant within a time step: contact pairs, friction limits, places of bodies.

        A step that fails begins again from the same state with a shorter time step. This function must therefore not
        change the arrays that ``arrays`` names.

        Args:
            state: positions at the beginning of the step.
            time: time at the beginning of the step, or of the equilibrium [s].
            time_step: length of the step [s]; 0 for a static equilibrium.
        """

    def end_step(self, state: StateT_contra, time: float, time_step: float) -> None:
        """Update lasting values, for example friction anchors, after an accepted step.

        Args:
            state: positions at the end of the step.
            time: time at the end of the step, or of the equilibrium [s].
            time_step: length of the step [s]; 0 for a static equilibrium.
        """

    def element_limits(
        self, state: StateT_contra, direction: StateT_contra, launcher: Launcher
    ) -> tuple[list[Any], wp.array[Any]] | None:
        """The launches that find the limit of each element for ``step_limit``, and the array of the limits.

        It is None for a term without limits, and for a term whose ``step_limit`` does more than take the smallest
        limit.
        """
        return None

    def step_limit(self, state: StateT_contra, direction: StateT_contra) -> float:
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
        """A number that changes when prepared launches of the term are stale, because its arrays were replaced."""
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


def check_arrays(shapes: Mapping[str, tuple[int, ...] | None], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Check that a checkpoint holds arrays of these names and shapes; None stands for any shape.

    Raises:
        ParameterError: an array is missing or has another shape.
    """
    for name, shape in shapes.items():
        if name not in arrays or (shape is not None and arrays[name].shape != shape):
            found = "is missing" if name not in arrays else f"has the shape {arrays[name].shape}, expected {shape}"
            raise ParameterError(f"resume: array {name!r} of the checkpoint {found}; begin without it")


class LoadedPoints(Protocol):
    """Points with mass and area on a device, on which a load acts: the yarns of a relaxation, or a cloth with yarns."""

    @property
    def scalar(self) -> Any:
        """Warp's floating-point type."""

    @property
    def unit(self) -> float:
        """Unit of length of the coordinates [cm]; forces are in erg per unit."""

    def masses(self) -> Sequence[NDArray[np.float64]]:
        """Mass of each point [g], an array for each of the parts of ``Coordinates``.

        Raises:
            ParameterError: a yarn has no mass.
        """

    def areas(self) -> Sequence[NDArray[np.float64]]:
        """Area of each point that meets a wind [cm^2], an array for each of the parts."""

    @property
    def device(self) -> wp.Device:
        """Where the points lie."""


LoadedT_contra = TypeVar("LoadedT_contra", contravariant=True)
"""What a choice acts on: the model of a simulation, or any ``LoadedPoints``."""


class TermChoice(ABC, Generic[LoadedT_contra]):
    """A term that a caller requests, by a value that does not depend on a device.

    A term that is not chosen launches nothing, allocates nothing and compiles nothing.
    """

    in_free_cells: bool = False
    """Whether the term acts on the strains of a relaxing cell, or has no force along the periods."""
    on_any_points: bool = False
    """Whether the choice acts on any ``LoadedPoints``; other choices act on yarns alone."""
    reads_mass: bool = False
    """Whether the term depends on the mass of the yarns; a checkpoint then belongs to this mass only."""

    @abstractmethod
    def on(self, points: LoadedT_contra) -> Term[Any, Any]:
        """Return the term on the device of a model.

        Raises:
            ParameterError: the choice does not fit the yarns.
        """
