# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A prepared scene as it runs: step by step in time, or from equilibrium to equilibrium.

When an attachment is released the unknowns change. The system is then made again, and goes on with the positions,
velocities and anchors that it had.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.mixed.assembly import Loads, held_in_state, loaded_system
from stitchmesh.mixed.contact.prescribed_motion import PrescribedMotion
from stitchmesh.mixed.dynamics.backward_euler import Dynamics, DynamicsSettings
from stitchmesh.mixed.dynamics.equilibrium import EquilibriumSettings, find_equilibrium
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.dynamics.kept_momentum import keep_momentum
from stitchmesh.mixed.dynamics.vector_sums import choose, set_sum
from stitchmesh.mixed.enrichment.region import Region
from stitchmesh.mixed.mixed_vector import MixedVector, Parts
from stitchmesh.mixed.placement.carried_terms import RegionChange, carry_terms
from stitchmesh.mixed.region_change import moved_vector, place_held, region_change
from stitchmesh.mixed.scene.scene_fabric import PreparedScene


@dataclass(frozen=True)
class SimulationStep:
    """What one step did."""

    time: float
    """Time at its end [s]."""
    newton_iterations: int
    """Newton iterations."""
    solve_iterations: int
    """Products with the matrix."""
    halvings: int
    """Attempts that were repeated with half the time step."""
    error: float
    """Error of the velocities [cm/s], or the largest unbalanced force [dyn]."""
    converged: bool
    """Whether the error is within the tolerance."""


class Simulation(ABC):
    """A scene that runs on a device."""

    tolerance: float
    """Bound of the error of a step."""

    def __init__(self, prepared: PreparedScene, scalar: Any, device: wp.Device) -> None:
        """Begin at time 0.

        Args:
            prepared: what is simulated.
            scalar: Warp's floating-point type.
            device: where it runs.
        """
        self.prepared, self.scalar, self.device = prepared, scalar, device
        self.start = prepared.vertices, prepared.nodes

    @property
    @abstractmethod
    def time(self) -> float:
        """Present time [s]."""

    @property
    @abstractmethod
    def positions(self) -> Parts:
        """Vertices, simulated nodes and Eulerian coordinates [cm]."""

    @abstractmethod
    def step(self) -> SimulationStep:
        """Go one step further.

        Raises:
            SolverError: no time step is small enough.
        """

    @abstractmethod
    def change_region(self, region: Region) -> None:
        """Go on with yarns in another region of the same cloth and layout.

        Positions, velocities and what terms remember stay where nodes stay. A motion keeps its momentum; a static run
        finds its last equilibrium again.

        Args:
            region: the new region.

        Raises:
            ParameterError: the region belongs to another layout, or a term cannot be carried over.
        """

    @abstractmethod
    def energies(self) -> dict[str, float]:
        """Energy of each term [erg], by name."""

    @abstractmethod
    def arrays(self) -> dict[str, NDArray[Any]]:
        """All that the rest of the run depends on, by name."""

    @abstractmethod
    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the contents of ``arrays``."""

    @property
    def done(self) -> bool:
        """Whether the run has reached its end."""
        return self.time >= self.prepared.scene.duration * (1.0 - 1e-12)

    def begin(self) -> MixedVector:
        """Return the positions at the start, on the device."""
        vertices, nodes = self.start
        return MixedVector.from_numpy(vertices, nodes, self.prepared.sliding, self.scalar, self.device)

    def take_region(self, region: Region) -> RegionChange:
        """Take a region for what is made from now on; return the change."""
        old = self.prepared.region
        self.prepared = replace(self.prepared, region=region)
        self.start = self.prepared.vertices, self.prepared.nodes
        return region_change(self.prepared.fabric, old, region, self.prepared.loads(self.time))

    def loads_at(self, time: float) -> Loads:
        """Return what acts at a time [s]."""
        return self.prepared.loads(time)

    def system_at(self, time: float) -> tuple[MixedSystem, PrescribedMotion]:
        """Return the system with the attachments at a time, and their motion."""
        loads = self.loads_at(time)
        prepared, (vertices, _nodes) = self.prepared, self.start
        system = loaded_system(
            prepared.fabric, prepared.region, loads, vertices, scalar=self.scalar, device=self.device
        )
        return system, PrescribedMotion(held_in_state(self.prepared.region, loads.held), *self.start)


class DynamicSimulation(Simulation):
    """A motion in time."""

    def __init__(self, prepared: PreparedScene, scalar: Any, device: wp.Device) -> None:
        """Begin at rest."""
        super().__init__(prepared, scalar, device)
        self.tolerance = prepared.scene.solver.velocity_tolerance
        self._dynamics = self._dynamics_at(0.0, self.begin())

    @property
    def time(self) -> float:
        """Present time [s]."""
        return self._dynamics.time

    @property
    def positions(self) -> Parts:
        """Vertices, simulated nodes and Eulerian coordinates [cm]."""
        return self._dynamics.positions.numpy()

    def step(self) -> SimulationStep:
        """Advance by one time step; attachments whose time is over are released first."""
        if any(self._built < release <= self.time for release in self.prepared.releases):
            self._renew(self.time, self._dynamics.arrays())
        made = self._dynamics.step()
        return SimulationStep(
            made.time, made.newton_iterations, made.solve_iterations, made.halvings, made.velocity_error, True
        )

    def change_region(self, region: Region) -> None:
        """Go on with another region; the momentum stays."""
        old, rest = self._dynamics, self.prepared.fabric.yarns.rest_sliding
        change = self.take_region(region)
        self._dynamics = new = self._dynamics_at(old.time, moved_vector(change, old.positions, rest))
        new.velocities.assign(moved_vector(change, old.velocities, np.zeros_like(rest)))
        new.time, new.time_step, new.calm_steps = old.time, old.time_step, old.calm_steps
        place_held(new.system, self._motion, new.positions, new.time)
        before, after = [(each.system, each.positions, each.velocities) for each in (old, new)]
        keep_momentum(before, after)
        carry_terms(old.system.terms, new.system.terms, change)

    def energies(self) -> dict[str, float]:
        """Energy of each term and kinetic energy [erg]."""
        return self._dynamics.energies()

    def arrays(self) -> dict[str, NDArray[Any]]:
        """All that the rest of the run depends on."""
        return self._dynamics.arrays() | {"built": np.array([self._built])}

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the contents of ``arrays``."""
        self._renew(float(arrays["built"][0]), arrays)

    def _renew(self, time: float, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Make the system with the attachments at a time, in the state of ``arrays``."""
        self._dynamics = self._dynamics_at(time, self.begin())
        self._dynamics.resume(arrays)

    def _dynamics_at(self, time: float, positions: MixedVector) -> Dynamics:
        scene, material = self.prepared.scene, self.prepared.fabric.yarn_materials.weft
        system, self._motion = self.system_at(time)
        self._built = time
        settings = DynamicsSettings(
            time_step=scene.largest_step,
            damping_mass=material.damping_mass,
            damping_stiffness=material.damping_stiffness,
            velocity_tolerance=scene.solver.velocity_tolerance,
            solve_tolerance=scene.solver.solve_tolerance,
        )
        return Dynamics(system, positions, settings, prescribed=self._motion.displacements)


class StaticSimulation(Simulation):
    """A path of equilibria."""

    def __init__(self, prepared: PreparedScene, scalar: Any, device: wp.Device) -> None:
        """Begin before the first equilibrium."""
        super().__init__(prepared, scalar, device)
        self.tolerance = prepared.scene.solver.force_tolerance
        self._done, self._positions = 0, self.begin()
        self._system, self._motion = self.system_at(0.0)
        self._built = 0.0
        self._moves = any(len(each.body.motion.times) > 1 for each in prepared.bodies)

    def loads_at(self, time: float) -> Loads:
        """Return what acts at a time [s]; bodies stand where they are then."""
        loads = super().loads_at(time)
        return replace(loads, bodies=[each.at(time) for each in loads.bodies])

    @property
    def time(self) -> float:
        """Time of the last equilibrium [s]."""
        scene = self.prepared.scene
        return scene.duration * self._done / scene.load_steps

    @property
    def positions(self) -> Parts:
        """Vertices, simulated nodes and Eulerian coordinates [cm]."""
        return self._positions.numpy()

    def step(self) -> SimulationStep:
        """Move attachments and bodies to their next places, and find the equilibrium."""
        scene, begin = self.prepared.scene, self.time
        end = scene.duration * (self._done + 1) / scene.load_steps
        if self._moves or any(self._built < release <= end for release in self.prepared.releases):
            self._renew(end, self.arrays())
        self._move(begin, end)
        settings = EquilibriumSettings(
            force_tolerance=scene.solver.force_tolerance,
            most_iterations=scene.solver.most_iterations,
            solve_tolerance=min(scene.solver.solve_tolerance, EquilibriumSettings.solve_tolerance),
        )
        made = find_equilibrium(self._system, self._positions, settings)
        self._done += 1
        return SimulationStep(end, made.iterations, made.solve_iterations, 0, made.unbalanced_force, made.converged)

    def change_region(self, region: Region) -> None:
        """Go on with another region; the last equilibrium is found again."""
        terms, positions, time = self._system.terms, self._positions, self.time
        change = self.take_region(region)
        self._positions = moved_vector(change, positions, self.prepared.fabric.yarns.rest_sliding)
        self._system, self._motion = self.system_at(time)
        self._built, self._done = time, self._done - 1
        place_held(self._system, self._motion, self._positions, time)
        carry_terms(terms, self._system.terms, change)

    def energies(self) -> dict[str, float]:
        """Energy of each term [erg]."""
        return self._system.energies(self._positions)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """All that the rest of the run depends on."""
        found = {"positions": self._positions.values.numpy(), "clock": np.array([self._done, self._built])}
        for number, term in enumerate(self._system.terms):
            found |= {f"term {number} {name}": array.numpy() for name, array in term.arrays().items()}
        return found

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the contents of ``arrays``."""
        self._renew(float(arrays["clock"][1]), arrays)

    def _renew(self, time: float, arrays: Mapping[str, NDArray[Any]]) -> None:
        self._system, self._motion = self.system_at(time)
        self._built, self._done = time, int(arrays["clock"][0])
        self._positions.values.assign(arrays["positions"])
        for number, term in enumerate(self._system.terms):
            prefix = f"term {number} "
            own = {name[len(prefix) :]: array for name, array in arrays.items() if name.startswith(prefix)}
            term.resume(own)

    def _move(self, begin: float, end: float) -> None:
        """Move what is held, and what is hybrid with it."""
        v, p, s = self._motion.displacements(begin, end)
        fixed = MixedVector.from_numpy(v, p, s, self.scalar, self.device)
        move = fixed.like()
        choose(move, self._system.moves, move.like(), fixed)
        self._system.make_motion(move)
        set_sum(self._positions, 1.0, self._positions, 1.0, move)


def begin_simulation(prepared: PreparedScene, scalar: Any, device: wp.Device) -> Simulation:
    """Return the simulation of a scene at its start."""
    kind = DynamicSimulation if prepared.scene.mode == "dynamic" else StaticSimulation
    return kind(prepared, scalar, device)
