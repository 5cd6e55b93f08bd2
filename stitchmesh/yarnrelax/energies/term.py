# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a relaxation may have beyond stretch, bending and contact: terms and constraints, only when asked for.

A term is chosen by a value (``Gravity(...)``, ``Friction(...)``) that knows nothing of the device; ``on`` puts it there
for one model. A term that is not chosen launches nothing, allocates nothing and compiles nothing.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import State

Launcher = Callable[..., Any]
"""``Model.launch`` or ``Model.prepare``."""


class Term(ABC):
    """One more energy, on the device of a model; lengths in ``model.unit``, energies in erg."""

    name: str
    """Its name in reports."""
    lags: bool = False
    """Whether it is to be renewed each time the yarns have come to rest, until that changes nothing."""

    @abstractmethod
    def forces(self, state: State, candidates: Candidates, launcher: Launcher) -> list[Any]:
        """Add its force to ``state.sample_force``, ``state.external_force`` or ``state.leg_force``.

        The fourth component of ``state.sample_force`` is the row sum of stiffness.
        """

    @abstractmethod
    def energy(self, state: State, candidates: Candidates) -> float:
        """Its energy [erg] for the points and samples as they are."""

    @abstractmethod
    def stiffness(self) -> NDArray[np.float64]:
        """Row sums of its stiffness at the control points [erg / unit^2], shape (N,); zero for what ``forces`` adds."""

    def renew(self, state: State, candidates: Candidates) -> None:  # noqa: B027 - most terms lag behind nothing
        """Bring what lags behind up to date; called when a load step begins, outside any recorded launch."""

    def arrays(self) -> dict[str, wp.array[Any]]:
        """What it carries from one iteration to the next and the first ``renew`` does not make again, by name."""
        return {}

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Take back what ``arrays`` gave."""
        for name, array in self.arrays().items():
            array.assign(arrays[name])


class TermChoice(ABC):
    """A term that a caller asks for."""

    @abstractmethod
    def on(self, model: Model) -> Term:
        """The term on a model's device.

        Raises:
            ParameterError: it does not fit the yarns.
        """


class Constraint(ABC):
    """Something that holds control points."""

    @abstractmethod
    def filter_forces(self, force: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Take from forces on the control points what the constraint carries."""

    @abstractmethod
    def filter_steps(self, state: State, step: wp.array[Any], limit: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Change steps so that they keep the constraint; none may become longer than its limit."""


class ConstraintChoice(ABC):
    """A constraint that a caller asks for."""

    @abstractmethod
    def on(self, model: Model) -> Constraint:
        """The constraint on a model's device.

        Raises:
            ParameterError: it does not fit the yarns.
        """
