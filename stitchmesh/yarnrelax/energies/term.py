# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Terms and constraints: what a relaxation may have beyond stretch, bending and contact, only on request.

A caller chooses a term by a value (``Gravity(...)``, ``Friction(...)``). ``on`` creates the term on the device of a
model. Newton's method factors the assembled Hessian of the yarns, so a term with a Hessian is a ``YarnTerm``, which
gives its entries. A load whose force is constant acts on yarns as on anything else (``simulation.dead_load``).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.sparse import csr_array

from stitchmesh.compute.captured import Launcher
from stitchmesh.errors import ParameterError, described
from stitchmesh.simulation.term import Term, TermChoice
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.energies.pair_stiffness import PairStiffness, SampleStiffness
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import State, YarnForces

INPUTS = ("loop_length", "radius", "planes", "k_len", "k_length", "k_bend", "k_contact")
"""All rest lengths together, all radii, the distance between the planes of a confinement, and stiffnesses."""


@dataclass(frozen=True, eq=False)
class InputPowers:
    """Constants on the device that are proportional to powers of inputs, for derivatives by the inputs (``INPUTS``).

    A factor of one input changes such a constant in its place, by a power of this factor.
    """

    constants: wp.array[Any]
    """Scalars, or vectors, on the device."""
    powers: Sequence[Mapping[str, float]]
    """The powers of the inputs in a scalar, or in each component of a vector; 0 for an input that is missing."""

    def factors(self, name: str, factor: float) -> Any:
        """Return the factors of the components that result from a factor of an input, shape (1,) or (k,)."""
        return np.array([factor ** own.get(name, 0.0) for own in self.powers])


@dataclass(frozen=True, eq=False)
class Coupling:
    """A stiffness V^T C^-1 V that couples many coordinates."""

    rows: csr_array
    """V, shape (m, n)."""
    compliance: csr_array | None = None
    """C, shape (m, m); None for a constraint."""


OnYarns = Term[State, YarnForces]
"""A term that acts on yarns."""
YarnChoice = TermChoice[Model]
"""A term on yarns that a caller requests."""


class YarnTerm(OnYarns):
    """A term that gives the entries of the assembled Hessian, or that lags; lengths in ``model.unit``.

    The fourth component of ``YarnForces.samples`` is the row sum of stiffness. A term that acts in relaxing cells also
    adds to ``YarnForces.virial`` for its samples, and to ``YarnForces.leg_virial`` for its legs, if these are not
    empty.
    """

    keeps_stitches: bool = False
    """Whether the term keeps each stitch of a piece, and with it the ends of open yarns, near its place."""
    lags: bool = False
    """Whether the term is renewed each time the yarns have come to rest, until the renewal changes nothing."""

    def stiffness(self) -> NDArray[np.float64] | float:
        """Row sums of stiffness at the control points [erg / unit^2], shape (N,), without what ``forces`` adds."""
        return 0.0

    def point_blocks(self, state: State) -> wp.array[Any] | None:
        """Second derivatives by the coordinates of each control point [erg / unit^2], matrices (N,); None for zero.

        Each call returns the same array, with the matrices of the present state. The assembled Hessian has these
        blocks, and the blocks of pairs and samples, also without ``gives_hessian``.
        """
        return None

    def pair_stiffness(self, state: State, launcher: Launcher) -> PairStiffness | None:
        """Second derivatives of the energies of pairs of contact samples; None for none.

        The forces on the strains of relaxing cells must follow from the forces of the pairs, as in contact.
        """
        return None

    def sample_stiffness(self, state: State, exact: wp.array[Any], launcher: Launcher) -> SampleStiffness | None:
        """Second derivatives by the place of each contact sample; None for zero.

        Args:
            state: the current state.
            exact: share of the exact Hessian in each segment, shape (S,); the rest may leave out what is negative.
            launcher: how launches are made.
        """
        return None

    def coupling(self, state: State) -> Coupling | None:
        """The part of the Hessian that couples many control points, over their coordinates; None for zero.

        It is called only if ``gives_hessian``, in the state of the last forces.
        """
        return None

    def input_powers(self) -> list[InputPowers]:
        """How the constants of the term depend on the inputs of a relaxation, for the derivatives of a state of rest.

        Raises:
            ParameterError: the dependence is not known.
        """
        raise no_derivatives(self)

    def has_moved(self, state: State) -> NDArray[np.bool_]:
        """Whether the yarns of each cell have moved since a term that ``lags`` was renewed, shape (C,).

        The samples of ``state`` must be up to date.
        """
        raise NotImplementedError(self.name)

    def renew(self, state: State, candidates: Candidates, cells: NDArray[np.bool_] | None = None) -> None:
        """Renew a lagging term in some cells, shape (C,), or in all."""


def no_derivatives(term: OnYarns) -> ParameterError:
    """Return the error of a term whose dependence on the inputs of a relaxation is not known."""
    return ParameterError(f"derivatives at rest: got the term {term.name}, which has none; leave it out")


class Constraint(ABC):
    """A constraint on control points."""

    @abstractmethod
    def filter_forces(self, force: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Subtract the reaction of the constraint from forces on the control points."""

    @abstractmethod
    def coupling(self) -> Coupling:
        """Return the rows that sum the coordinates whose sums the constraint holds."""

    @abstractmethod
    def filter_steps(self, state: State, step: wp.array[Any], limit: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Change steps so that they satisfy the constraint; no step may become longer than its limit."""


class ConstraintChoice(ABC):
    """A constraint that a caller requests."""

    @abstractmethod
    def on(self, model: Model) -> Constraint:
        """Return the constraint on a model's device.

        Raises:
            ParameterError: the choice does not fit the yarns.
        """


Choice = YarnChoice | ConstraintChoice
"""A term or a constraint, which acts on yarns beyond stretch, bending and contact."""


def terms_and_constraints(choices: Sequence[Choice]) -> tuple[list[YarnChoice], list[ConstraintChoice]]:
    """Return the terms and the constraints among choices, each in their order.

    Raises:
        ParameterError: a choice is neither.
    """
    terms = [choice for choice in choices if isinstance(choice, TermChoice)]
    constraints = [choice for choice in choices if isinstance(choice, ConstraintChoice)]
    for choice in choices:
        if not isinstance(choice, TermChoice | ConstraintChoice):
            expected = "expected energies, such as Gravity(), and constraints, such as Pins(points=[0])"
            raise ParameterError(f"terms: got {described(choice)}; {expected}")
    return terms, constraints


def refuse_in_free_cells(terms: Sequence[YarnChoice], constraints: Sequence[ConstraintChoice]) -> None:
    """Refuse choices that do not act on the strains of a relaxing cell.

    Raises:
        ParameterError: there is a constraint, or a term that does not act on strains.
    """
    for choice in [*(term for term in terms if not term.in_free_cells), *constraints]:
        found = f"got {type(choice).__name__} beside it, which does not act on a cell that deforms"
        raise ParameterError(f"relax cell: {found}; leave it out, or keep the periods")
