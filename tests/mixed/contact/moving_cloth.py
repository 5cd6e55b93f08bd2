# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The motion of a cloth of springs without yarns, for the tests of contact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import warp as wp

from stitchmesh.mesh import FloatArray
from stitchmesh.mixed.dynamics.backward_euler import Dynamics, DynamicsSettings
from stitchmesh.mixed.dynamics.mass_matrix import BlendedMasses, FabricPoints
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.enrichment.region import FreeUnknowns, embed, region_around
from stitchmesh.mixed.term import MixedTerm
from stitchmesh.simulation.dead_load import Gravity
from tests.mixed.contact.sheets import Sheets, cpu, state_of
from tests.mixed.springs import Springs


def side_springs(cloth: Sheets, stiffness: float) -> Springs:
    """Springs along all sides of the triangles."""
    sides = np.concatenate([cloth.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    ends = np.unique(np.sort(sides, axis=1), axis=0)
    length = np.linalg.norm(np.diff(cloth.vertices[ends], axis=1)[:, 0], axis=1)
    return Springs("vertices", ends, len(cloth.vertices), stiffness, length, wp.float64, cpu())


class MovingCloth:
    """A cloth of springs with further terms, that moves from rest, or from a velocity that is set before it runs."""

    def __init__(
        self,
        cloth: Sheets,
        density: float,
        gravity: FloatArray,
        stiffness: float,
        terms: Sequence[MixedTerm],
        *,
        held: Sequence[int] = (),
    ) -> None:
        """Begin at rest; the vertices of the numbers ``held`` stay where they are."""
        region = region_around(cloth.triangles, len(cloth.vertices), np.zeros(0, dtype=int), np.zeros((0, 3)), [])
        self.mass = cloth.masses(density)
        masses = BlendedMasses(self.mass.copy(), np.zeros((0, 2)))
        springs = side_springs(cloth, stiffness)
        free = FreeUnknowns.of(region, fixed_vertices=held)
        self._system = MixedSystem(
            embed(region), free, masses, [*terms, springs], scalar=wp.float64, device=cpu()
        )
        self._system.add(Gravity(gravity).on(FabricPoints(masses, 1.0, wp.float64, cpu())))
        self.vertices, self.velocity = cloth.vertices, np.zeros_like(cloth.vertices)
        self._run: Dynamics | None = None

    def run(self, steps: int, time_step: float) -> None:
        """Advance by several steps; velocities are found to 1e-6 cm/s."""
        if self._run is None:
            settings = DynamicsSettings(
                time_step=time_step, velocity_tolerance=1e-6, solve_tolerance=1e-4, most_newton_iterations=100
            )
            velocities = state_of(self.velocity)
            self._run = Dynamics(self._system, state_of(self.vertices), settings, velocities=velocities)
        for _ in range(steps):
            end = self._run.time + time_step
            while self._run.time < end - 1e-9 * time_step:
                self._run.time_step = min(self._run.time_step, end - self._run.time)
                self._run.step()
        self.vertices, self.velocity = self._run.positions.numpy()[0], self._run.velocities.numpy()[0]
