# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A prepared scene as a run: step by step in time, or from equilibrium to equilibrium.

When an attachment is released, the unknowns change. The system is then made again, and goes on with its positions,
velocities and anchors.

A path of equilibria may begin on the triangles. Its yarns are then placed on an equilibrium of the triangles alone,
with all attachments and bodies at their last places, and only one equilibrium remains to be found (Casafranca et al.
2020, section 6.2).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.precision import ScalarType
from stitchmesh.errors import SolverError
from stitchmesh.mesh import FloatArray
from stitchmesh.mixed.assembly import loaded_system, start_positions
from stitchmesh.mixed.contact.motion import PrescribedMotion, at_simulated_nodes
from stitchmesh.mixed.crossings.crossing_material import FabricMaterials
from stitchmesh.mixed.dynamics.backward_euler import Dynamics, DynamicsSettings
from stitchmesh.mixed.dynamics.equilibrium import AfterIteration, EquilibriumSearch, EquilibriumSettings, unwatched
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.dynamics.vector_sums import choose, set_sum
from stitchmesh.mixed.enrichment.projection import make_consistent
from stitchmesh.mixed.enrichment.region import Region
from stitchmesh.mixed.mixed_vector import MixedVector, Parts
from stitchmesh.mixed.output.report import RunTotals
from stitchmesh.mixed.region_change import (
    SLIDING,
    NodeMemory,
    RegionChange,
    carry_terms,
    keep_momentum,
    moved_positions,
    moved_velocities,
    place_held,
    region_change,
    remember,
    settle_changed,
)
from stitchmesh.mixed.scene.scene_fabric import PreparedScene
from stitchmesh.mixed.splines.spline_term import SplineTerm
from stitchmesh.mixed.term import MixedTerm, resume_terms, term_arrays
from stitchmesh.simulation.term import check_arrays


@dataclass(frozen=True)
class SimulationStep:
    """The report of one step."""

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

    def add_to(self, totals: RunTotals) -> None:
        """Add the step to the sums of a run, except its computing time."""
        totals.steps += 1
        totals.newton_iterations += self.newton_iterations
        totals.solve_iterations += self.solve_iterations
        totals.halvings += self.halvings
        totals.not_converged += not self.converged
        totals.error = self.error


class Simulation(ABC):
    """A scene that runs on a device."""

    tolerance: float
    """Bound of the error of a step, above which it has not converged."""

    def __init__(self, prepared: PreparedScene, scalar: ScalarType, device: wp.Device) -> None:
        """Begin at time 0.

        Args:
            prepared: the scene, prepared.
            scalar: Warp's floating-point type.
            device: where it runs.
        """
        self.prepared, self.scalar, self.device = prepared, scalar, device
        self.start = prepared.vertices, prepared.nodes
        self.memory = NodeMemory()
        """Values of nodes that regions have dropped."""

    @property
    @abstractmethod
    def time(self) -> float:
        """Present time [s]."""

    @property
    @abstractmethod
    def system(self) -> MixedSystem:
        """The system, with the attachments of the present time."""

    @property
    @abstractmethod
    def positions(self) -> Parts:
        """Vertices, simulated nodes and Eulerian coordinates [cm]."""

    @abstractmethod
    def step(self, after_iteration: AfterIteration = unwatched) -> SimulationStep:
        """Go one step further.

        Args:
            after_iteration: called after each iteration of a search for an equilibrium. If it raises an exception, the
                search stays as it is, and the next step goes on with it. Steps in time do not call it.

        Raises:
            SolverError: no time step is small enough.
        """

    @abstractmethod
    def change_region(self, region: Region) -> None:
        """Go on with yarns in another region of the same cloth and layout.

        Where nodes stay, their positions and velocities and the memory of terms stay too. Nodes that were simulated
        before get their marks back. A motion keeps its momentum; a static run finds its last equilibrium again.

        Args:
            region: the new region.

        Raises:
            ParameterError: the region belongs to another layout, or the memory of a term cannot be carried over.
        """

    @abstractmethod
    def energies(self) -> dict[str, float]:
        """Energy of each term [erg], by name."""

    @abstractmethod
    def arrays(self) -> dict[str, NDArray[Any]]:
        """All arrays that the rest of the run depends on, by name."""

    @abstractmethod
    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the contents of ``arrays``.

        Raises:
            ParameterError: an array is missing or has another shape.
        """

    @property
    def done(self) -> bool:
        """Whether the run has reached its end."""
        return self.time >= self.prepared.scene.duration * (1.0 - 1e-12)

    def take_region(self, region: Region, terms: Sequence[MixedTerm]) -> RegionChange:
        """Take a region for all that is made from now on; return the change from the present region with its terms."""
        old = self.prepared.region
        self.memory = remember(self.memory, terms, old).kept(SLIDING, old, self.positions[2])
        self.prepared = replace(self.prepared, region=region)
        self.start = self.prepared.vertices, self.prepared.nodes
        return region_change(self.prepared.fabric, old, region, self.memory, self.prepared.loads(self.time))

    def system_at(self, time: float) -> tuple[MixedSystem, PrescribedMotion]:
        """Return the system with the attachments at a time, and their motion."""
        prepared, loads = self.prepared, self.prepared.loads(time)
        system = loaded_system(prepared.fabric, prepared.region, loads, scalar=self.scalar, device=self.device)
        held = at_simulated_nodes(loads.held, prepared.region.node_number)
        return system, PrescribedMotion(held, *self.start)


class DynamicSimulation(Simulation):
    """A motion in time."""

    def __init__(self, prepared: PreparedScene, scalar: ScalarType, device: wp.Device) -> None:
        """Begin at rest."""
        super().__init__(prepared, scalar, device)
        self.tolerance = prepared.scene.solver.velocity_tolerance
        self._dynamics = self._dynamics_at(0.0, self._at_start())

    @property
    def time(self) -> float:
        """Present time [s]."""
        return self._dynamics.time

    @property
    def system(self) -> MixedSystem:
        """The system, with the attachments of the present time."""
        return self._dynamics.system

    @property
    def positions(self) -> Parts:
        """Vertices, simulated nodes and Eulerian coordinates [cm]."""
        return self._dynamics.positions.numpy()

    def step(self, after_iteration: AfterIteration = unwatched) -> SimulationStep:
        """Advance by one time step; attachments with a release time up to now are released first."""
        if any(self._built < release <= self.time for release in self.prepared.releases):
            self._renew(self.time, self._dynamics.arrays())
        made = self._dynamics.step()
        return SimulationStep(
            made.time, made.newton_iterations, made.solve_iterations, made.halvings, made.velocity_error, True
        )

    def change_region(self, region: Region) -> None:
        """Go on with another region; the momentum stays."""
        old, fabric = self._dynamics, self.prepared.fabric
        change = self.take_region(region, old.system.terms)
        self._dynamics = new = self._dynamics_at(old.time, moved_positions(fabric, change, old.positions))
        new.velocities.assign(moved_velocities(fabric, change, old.velocities))
        new.time, new.time_step, new.calm_steps = old.time, old.time_step, old.calm_steps
        place_held(new.system, self._motion, new.positions, new.time)
        settle_changed(
            fabric, change, self.prepared.loads(self.time), old.system.terms, new.positions, new.time_step
        )
        before, after = [(each.system, each.positions, each.velocities) for each in (old, new)]
        keep_momentum(before, after)
        carry_terms(old.system.terms, new.system.terms, change)

    def energies(self) -> dict[str, float]:
        """Energy of each term and kinetic energy [erg]."""
        return self._dynamics.energies()

    def arrays(self) -> dict[str, NDArray[Any]]:
        """All arrays that the rest of the run depends on."""
        return self._dynamics.arrays() | {"built": np.array([self._built])} | self.memory.arrays()

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the contents of ``arrays``."""
        check_arrays({"built": (1,)}, arrays)
        self.memory = NodeMemory.of(arrays)
        self._renew(float(arrays["built"][0]), arrays)

    def _renew(self, time: float, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Make the system with the attachments at a time, in the state of ``arrays``."""
        self._dynamics = self._dynamics_at(time, self._at_start())
        self._dynamics.resume(arrays)

    def _at_start(self) -> MixedVector:
        vertices, nodes = self.start
        return MixedVector.from_numpy(vertices, nodes, self.prepared.sliding, self.scalar, self.device)

    def _dynamics_at(self, time: float, positions: MixedVector) -> Dynamics:
        scene, materials = self.prepared.scene, self.prepared.fabric.yarn_materials
        assert isinstance(materials, FabricMaterials)  # a scene with B-spline yarns is static
        material = materials.weft
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

    def __init__(self, prepared: PreparedScene, scalar: ScalarType, device: wp.Device) -> None:
        """Begin before the first equilibrium, or before the last one if the yarns begin on the triangles."""
        super().__init__(prepared, scalar, device)
        scene = prepared.scene
        self.tolerance = scene.solver.force_tolerance
        self._settings = EquilibriumSettings(
            force_tolerance=scene.solver.force_tolerance,
            most_iterations=scene.solver.most_iterations,
            most_updates=scene.solver.friction_updates,
            solve_tolerance=min(scene.solver.solve_tolerance, EquilibriumSettings.solve_tolerance),
        )
        on_triangles = prepared.triangle_equilibrium is not None
        self._done = scene.load_steps - 1 if on_triangles else 0
        self._built = self._moved = scene.duration if on_triangles else 0.0
        self._search: EquilibriumSearch | None = None
        self._system, self._motion = self.system_at(self._built)
        self._positions = start_positions(prepared.fabric, prepared.region, self._system, prepared.vertices)
        if prepared.triangle_equilibrium is not None:
            self._place_on(prepared.triangle_equilibrium)

    @property
    def time(self) -> float:
        """Time of the last equilibrium, or of the equilibrium of the present search [s]."""
        scene = self.prepared.scene
        return scene.duration * (self._done + (self._search is not None)) / scene.load_steps

    @property
    def done(self) -> bool:
        """Whether the last equilibrium is found."""
        return self._done >= self.prepared.scene.load_steps

    @property
    def system(self) -> MixedSystem:
        """The system, with the attachments of the present time."""
        return self._system

    @property
    def positions(self) -> Parts:
        """Vertices, simulated nodes and Eulerian coordinates [cm]."""
        return self._positions.numpy()

    def step(self, after_iteration: AfterIteration = unwatched) -> SimulationStep:
        """Move attachments and bodies to their next places, and find the equilibrium."""
        self._search = search = self._search or self._begin_search()
        made = search.run(after_iteration)
        self._search, self._done = None, self._done + 1
        return SimulationStep(
            search.time, made.iterations, made.solve_iterations, 0, made.unbalanced_force, made.converged
        )

    def change_region(self, region: Region) -> None:
        """Go on with another region; the last equilibrium is found again."""
        terms, positions, time = self._system.terms, self._positions, self.time
        change = self.take_region(region, terms)
        self._positions = moved_positions(self.prepared.fabric, change, positions)
        self._system, self._motion = self.system_at(time)
        make_consistent(self._system.embedding, self._system.free, self._positions)
        self._built, self._done = time, self._done - 1
        place_held(self._system, self._motion, self._positions, time)
        carry_terms(terms, self._system.terms, change)

    def energies(self) -> dict[str, float]:
        """Energy of each term [erg]."""
        return self._system.energies(self._positions)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """All arrays that the rest of the run depends on."""
        clock = np.array([self._done, self._built, self._moved])
        found = {"positions": self._positions.values.numpy(), "clock": clock}
        if self._search is not None:
            found["search"] = self._search.numbers()
        return found | term_arrays(self._system.terms) | self.memory.arrays()

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the contents of ``arrays``."""
        check_arrays({"clock": (3,), "positions": self._positions.values.shape}, arrays)
        self.memory = NodeMemory.of(arrays)
        self._done, self._moved = int(arrays["clock"][0]), float(arrays["clock"][2])
        self._renew(float(arrays["clock"][1]), arrays)
        if "search" in arrays:
            self._search = self._new_search()
            self._search.resume(arrays["search"])

    def _begin_search(self) -> EquilibriumSearch:
        """Release and move the attachments, and begin a search from there."""
        end = self._end
        if any(self._built < release <= end for release in self.prepared.releases):
            self._renew(end, self.arrays())
        if self._moved < end:
            self._move_held(self._motion_of(*self._motion.displacements(self._moved, end)))
            self._moved = end
        return self._new_search()

    def _new_search(self) -> EquilibriumSearch:
        return EquilibriumSearch(self._system, self._positions, self._settings, time=self._end)

    @property
    def _end(self) -> float:
        """Time of the next equilibrium [s]."""
        return self.prepared.scene.duration * (self._done + 1) / self.prepared.scene.load_steps

    def _renew(self, time: float, arrays: Mapping[str, NDArray[Any]]) -> None:
        self._system, self._motion = self.system_at(time)
        self._built = time
        self._positions.values.assign(arrays["positions"])
        resume_terms(self._system.terms, arrays)

    def _motion_of(
        self, vertices: FloatArray, nodes: FloatArray, sliding: FloatArray, *, free: Parts | None = None
    ) -> MixedVector:
        """The motion of attachments with the hybrid parts around them; ``free`` are displacements of other parts."""
        fixed = MixedVector.from_numpy(vertices, nodes, sliding, self.scalar, self.device)
        move = fixed.like() if free is None else MixedVector.from_numpy(*free, self.scalar, self.device)
        choose(move, self._system.moves, move, fixed)
        self._system.make_motion(move)
        return move

    def _move_held(self, move: MixedVector) -> None:
        """Move the state in parts so small that no yarn passes through another one.

        Raises:
            SolverError: the parts become too small, because the motion leads one yarn through another one.
        """
        guards = [term for term in self._system.terms if isinstance(term, SplineTerm)]
        left = 1.0
        for _ in range(200):  # smaller parts would take too long
            part = min((term.step_limit(self._positions, move) for term in guards), default=1.0)
            part = min(part, left)
            set_sum(self._positions, 1.0, self._positions, part, move)
            left -= part
            if left <= 0.0:
                return
        raise SolverError(
            f"attachments: the yarns beside them would pass through one another at time {self._end:g} s; expected "
            "shorter ways between two equilibria: take more load_steps"
        )

    def _place_on(self, vertices: FloatArray) -> None:
        """Place the yarns on the triangles, and the attachments at their last places."""
        prepared, start = self.prepared, self._positions.numpy()
        nodes = prepared.fabric.yarns.world(prepared.fabric.cloth, vertices)[prepared.region.nodes]
        free = vertices - start[0], nodes - start[1], prepared.sliding - start[2]
        move = self._motion_of(*self._motion.displacements(0.0, self._moved), free=free)
        set_sum(self._positions, 1.0, self._positions, 1.0, move)


def begin_simulation(prepared: PreparedScene, scalar: ScalarType, device: wp.Device) -> Simulation:
    """Return the simulation of a scene at its start."""
    kind = DynamicSimulation if prepared.scene.mode == "dynamic" else StaticSimulation
    return kind(prepared, scalar, device)
