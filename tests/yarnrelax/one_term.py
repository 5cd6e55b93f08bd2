# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Energy and forces of one term alone, on control points that a test sets directly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.compute.device import device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates, make_candidates
from stitchmesh.yarnrelax.energies import evaluation
from stitchmesh.yarnrelax.energies.term import OnYarns, YarnChoice
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.spline import place_contact_samples
from stitchmesh.yarnrelax.model.state import State, make_state
from stitchmesh.yarnrelax.model.upload import put_model


def on_device(
    yarns: YarnSet, material: YarnMaterial | None = None, *, precision: str = "float64", contact_samples: int = 3
) -> Model:
    """The yarns on the processor."""
    return put_model(
        yarns, material or YarnMaterial.named("leaf"), quadrature_points=3, contact_samples=contact_samples,
        scalar=scalar_named(precision), device=device_named("cpu"),
    )  # fmt: skip


@dataclass(frozen=True)
class OneTerm:
    """A term of some yarns on the processor; lengths in cm, forces in dyn."""

    model: Model
    term: OnYarns
    state: State
    candidates: Candidates

    @classmethod
    def of(cls, model: Model, choice: YarnChoice) -> OneTerm:
        """The term of the yarns where they are."""
        return cls(model, choice.on(model), make_state(model, external=True), make_candidates(model, 0.1))

    def place(self, points: np.ndarray | None = None) -> None:
        """Set the control points, which are those of the yarns if none are given."""
        given = self.model.yarns.points if points is None else points
        self.state.points.assign(self.model.to_device(given))
        place_contact_samples(self.model, self.state, self.model.launch)

    def energy(self, points: np.ndarray | None = None) -> float:
        """Energy [erg]."""
        self.place(points)
        return self.term.energy(self.state)

    def forces(self, points: np.ndarray | None = None) -> np.ndarray:
        """Forces on the control points [dyn], shape (N, 3)."""
        self.place(points)
        model, state = self.model, self.state
        for forces in (state.external_force, state.leg_force, state.sample_force):
            forces.zero_()
        self.term.forces(state, state.forces, model.launch)
        evaluation.gather_launch(model, state, model.empty(model.point_count), model.launch)
        return state.force.numpy().astype(np.float64) / model.unit

    def slope(self, points: np.ndarray, direction: np.ndarray, step: float) -> float:
        """Derivative of the energy along a motion, by central differences [erg]."""
        ends = [self.energy(points + side * step * direction) for side in (1.0, -1.0)]
        return (ends[0] - ends[1]) / (2 * step)
