# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mixed system on a device: its terms, masses and unknowns, and the linear systems of Newton's method.

The matrix of a linear system is factor 1 times the Hessian of all terms plus factor 0 times the mass matrix (Casafranca
et al. 2020, equation 11, divided by h^2). Products are matrix-free. The iterations of the solver are captured once, and
again only when the arrays of a term are replaced.

``RepeatedLaunches`` captures other launches when they first run with some vectors, and repeats them after that. A
launch from Python takes about ten microseconds, longer than most kernels of a small system. Forces, energies and the
preparation of products are therefore captured like the iterations of the linear solver: as one graph on a GPU, as one
table on a CPU.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from functools import partial
from itertools import chain
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Branches, CapturedLaunches, CopyArray, Launcher, ZeroArray
from stitchmesh.compute.launch import launch, prepare
from stitchmesh.compute.precision import ScalarType, vector
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.dynamics.conjugate_gradients import ConjugateGradients
from stitchmesh.mixed.dynamics.mass_matrix import BlendedMasses, MassMatrix, NodeMasses
from stitchmesh.mixed.dynamics.vector_sums import ReadSums, choose
from stitchmesh.mixed.enrichment.preconditioner import Preconditioner
from stitchmesh.mixed.enrichment.region import Embedding, FreeUnknowns
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import MixedTerm
from stitchmesh.simulation.captures import Captures
from stitchmesh.simulation.term import Term


class RepeatedLaunches:
    """Captured sequences of launches of one system, with the sums that they find."""

    def __init__(self, device: wp.Device, captures: Captures[Any]) -> None:
        """Begin without any; ``captures`` keeps them until they are stale."""
        self._device, self._captures = device, captures
        self._run: Launcher = partial(prepare, device=device)

    def run(
        self, name: Hashable, vectors: tuple[MixedVector, ...], make: Callable[[Launcher, ReadSums], list[Any]]
    ) -> ReadSums:
        """Run a sequence of launches.

        Args:
            name: name of the work of the sequence; numbers that its launches contain are part of the name.
            vectors: the vectors that the sequence reads and writes.
            make: returns the launches for a launcher; called when the sequence has not run with these vectors yet. It
                may add sums, which are computed after the launches.

        Returns:
            the sums, to be read.
        """
        key = (name, *(id(vector) for vector in vectors))
        captured, sums = self._captures.get(key, lambda: self._capture(make), vectors)
        if captured is not None:
            captured.launch()
        return sums

    def read(
        self, name: Hashable, vectors: tuple[MixedVector, ...], make: Callable[[Launcher, ReadSums], list[Any]]
    ) -> NDArray[np.float64]:
        """Run a sequence and read its sums, with the arguments of ``run``."""
        return self.run(name, vectors, make).read()

    def _capture(
        self, make: Callable[[Launcher, ReadSums], list[Any]]
    ) -> tuple[CapturedLaunches | None, ReadSums]:  # fmt: skip
        sums = ReadSums(self._device)
        launches = make(self._run, sums)
        launches += sums.launches(self._run)
        return CapturedLaunches(launches, self._device) if launches else None, sums


class MixedSystem:
    """Terms, masses and unknowns on a device."""

    def __init__(
        self,
        embedding: Embedding,
        free: FreeUnknowns,
        masses: BlendedMasses,
        terms: Sequence[MixedTerm],
        *,
        node_masses: NodeMasses | None = None,
        scalar: ScalarType = wp.float64,
        device: wp.Device,
    ) -> None:
        """Allocate the arrays of the linear systems.

        Args:
            embedding: how hybrid nodes move with the triangles.
            free: which coordinates are unknown.
            masses: masses of vertices and nodes.
            terms: energies, on the same device and in the same precision.
            node_masses: blocks of the mass matrix at the nodes; by default only the masses, without inertia of the
                Eulerian coordinates.
            scalar: Warp's floating-point type.
            device: where the kernels run.

        Raises:
            ParameterError: counts of vertices or nodes differ, or there is no mass.
        """
        counts = embedding.vertex_count, embedding.node_count
        if (len(masses.vertices), len(masses.yarns)) != counts or (len(free.vertices), len(free.nodes)) != counts:
            found = f"got masses of {len(masses.vertices)} vertices and {len(masses.yarns)} nodes"
            raise ParameterError(f"mixed system: {found}; expected {counts[0]} and {counts[1]}, as in the region")
        if masses.total <= 0.0:
            raise ParameterError("mixed system: got no mass; expected masses of triangles or yarns above 0 g")
        self.embedding, self.free, self.terms = embedding, free, list(terms)
        self.scalar, self.device = scalar, device
        self.mass = MassMatrix(masses, scalar, device, node_masses)
        self._masses = masses.vertices, masses.nodes
        self._preconditioners: dict[bool, Preconditioner] = {}
        self._stiff = False
        self.launch: Launcher = partial(launch, device=device)
        self._factors, self._factors_now = wp.zeros(1, dtype=vector(2, scalar), device=device), (0.0, 0.0)
        self._unit = wp.array([[1.0, 0.0]], dtype=vector(2, scalar), device=device)
        self._blocks = MixedBlocks.zeros(*counts, scalar, device)
        self.moves = wp.array(_moves(free), dtype=wp.int32, device=device)
        self._by_mass = self._new_preconditioner(by_masses=True)
        self._impulse, self._motion = self.zeros(), self.zeros()
        self._captures = Captures(self, MixedSystem._generations)
        self.repeated = RepeatedLaunches(device, self._captures)
        """Launches that are captured once, and again when they are stale."""
        self._set_projection(masses)

    def _generations(self) -> tuple[int, ...]:
        """The generations of the arrays that captured launches name."""
        return tuple(term.generation for term in self.terms)

    def _set_projection(self, masses: BlendedMasses) -> None:
        """Set the constant metric of the masses alone, with the mass of each yarn for its Eulerian coordinate."""
        mass = MassMatrix(masses, self.scalar, self.device)
        self._blocks.clear()
        self._blocks.sliding.assign(masses.yarns[:, :, None] * np.eye(2))
        mass.combine_blocks(self._unit, self._blocks, self.launch)
        self._by_mass.set_metric(self._blocks)

    def update_masses(self, state: MixedVector) -> None:
        """Compute the blocks of the mass matrix at the nodes, at the beginning of a step."""
        self.repeated.run("masses", (state,), lambda run, _: self.mass.nodes.update_launches(state, run))

    def step_limit(self, state: MixedVector, direction: MixedVector) -> float:
        """The longest part of a direction, at most 1, that all terms allow a line search to try."""
        vectors = state, direction
        limits = self.repeated.read("limits", vectors, lambda run, sums: self.limit_launches(*vectors, run, sums))
        return self.least_limit(limits, *vectors)

    def limit_launches(self, state: MixedVector, direction: MixedVector, run: Launcher, sums: ReadSums) -> list[Any]:
        """The launches that find the limits of elements; their minima are added to ``sums``."""
        launches: list[Any] = []
        for term in self.terms:
            found = term.element_limits(state, direction, run)
            if found is not None:
                launches += found[0]
                sums.add_minimum(found[1])
        return launches

    def least_limit(self, limits: Iterable[float], state: MixedVector, direction: MixedVector) -> float:
        """The smallest of the limits of elements and of the limits that terms compute on the host, at most 1."""
        by_themselves = (term for term in self.terms if type(term).step_limit is not Term.step_limit)
        return min([1.0, *map(float, limits), *(term.step_limit(state, direction) for term in by_themselves)])

    def add(self, term: MixedTerm) -> None:
        """Add a term, for example the weight of ``mass``."""
        self.terms.append(term)  # one more generation, so that all launches are captured again

    def zeros(self) -> MixedVector:
        """A vector of zeros."""
        return MixedVector.zeros(self.embedding.vertex_count, self.embedding.node_count, self.scalar, self.device)

    def energies(self, state: MixedVector) -> dict[str, float]:
        """Energy of each term [erg] by name; the energies of terms with the same name are added up."""
        found = self.repeated.read("energies", (state,), lambda run, sums: self.energy_launches(state, run, sums))
        return self.named_energies(found)

    def energy_launches(self, state: MixedVector, run: Launcher, sums: ReadSums) -> list[Any]:
        """The launches that find the energies of all elements; their sums are added to ``sums``, one for each term."""
        launches: list[Any] = []
        for term in self.terms:
            own, energies = term.element_energies(state, run)
            launches += own
            sums.add_sum(energies)
        return launches

    def named_energies(self, found: Iterable[float]) -> dict[str, float]:
        """The energies of all terms [erg] by name, in the order of ``energy_launches``."""
        result: dict[str, float] = {}
        for term, energy in zip(self.terms, found, strict=True):
            result[term.name] = result.get(term.name, 0.0) + float(energy)
        return result

    def set_forces(self, state: MixedVector, force: MixedVector) -> None:
        """Set ``force`` to the forces of all terms [dyn]."""
        self.repeated.run("forces", (state, force), lambda run, _: self.force_launches(state, force, run))

    def force_launches(self, state: MixedVector, force: MixedVector, run: Launcher) -> list[Any]:
        """The launches that set ``force`` to the forces of all terms."""
        return [ZeroArray(force.values), *self._beside(lambda term: term.forces(state, force, run))]

    def linearize(self, state: MixedVector, exact: float, damped: float = 0.0) -> None:
        """Store the values that the products of all terms need.

        Args:
            state: where the Hessian is linearized.
            exact: share of the exact Hessian in the stored matrix.
            damped: share of the damping by stiffness in it.
        """
        name = "linearize", exact, damped
        self.repeated.run(name, (state,), lambda run, _: self.linear_launches(state, exact, run, damped))

    def linear_launches(self, state: MixedVector, exact: float, run: Launcher, damped: float = 0.0) -> list[Any]:
        """The launches of ``linearize``."""
        for term in self.terms:
            term.exact, term.damped = exact, damped
        return self._beside(lambda term: term.linearize(state, run))

    def set_mass_product(self, direction: MixedVector, product: MixedVector) -> None:
        """Set ``product`` to M d."""
        vectors = direction, product
        self.repeated.run("mass product", vectors, lambda run, _: self.mass_launches(*vectors, run))

    def mass_launches(self, direction: MixedVector, product: MixedVector, run: Launcher) -> list[Any]:
        """The launches that set ``product`` to M d."""
        return [ZeroArray(product.values), *self.mass.combine_products(self._unit, direction, product, run)]

    def hessian_launches(self, direction: MixedVector, product: MixedVector, run: Launcher) -> list[Any]:
        """The launches that set ``product`` to H d of the last ``linearize``."""
        return [ZeroArray(product.values), *self._beside(lambda term: term.products(direction, product, run))]

    def dot(self, first: MixedVector, second: MixedVector) -> float:
        """Dot product of two vectors, computed in a fixed order and read back to the host."""

        def make(_run: Launcher, sums: ReadSums) -> list[Any]:
            sums.add_dot(first.values, second.values)
            return []

        return float(self.repeated.read("dot", (first, second), make)[0])

    def make_motion(self, motion: MixedVector) -> None:
        """Change a motion to the nearest p = B v + F x in the metric of the masses; fixed coordinates stay."""
        self.repeated.run("motion", (motion,), lambda run, _: self.motion_launches(motion, run))

    def motion_launches(self, motion: MixedVector, run: Launcher) -> list[Any]:
        """The launches of ``make_motion``."""
        return self._by_mass.project_launches(motion, run)

    def set_filtered(self, force: MixedVector, filtered: MixedVector) -> None:
        """Set ``filtered`` to the part of a force that can move something, which is zero at an equilibrium."""

        def make(run: Launcher, _sums: ReadSums) -> list[Any]:
            copy = CopyArray(force.values, filtered.values)
            return [copy, *self._by_mass.launches(filtered, self._motion, run), ZeroArray(self._motion.values)]

        self.repeated.run("filter", (force, filtered), make)
        choose(filtered, self.moves, filtered, self._motion)

    def velocity_rms(self, impulse: MixedVector) -> float:
        """Root mean square velocity [cm/s] that an impulse [dyn s] gives to the masses, without stiffness."""

        def make(run: Launcher, sums: ReadSums) -> list[Any]:
            sums.add_dot(self._impulse.values, self._motion.values)
            copy = CopyArray(impulse.values, self._impulse.values)
            return [copy, *self._by_mass.launches(self._impulse, self._motion, run)]

        (square,) = self.repeated.read("velocity", (impulse,), make)
        return float(np.sqrt(max(float(square), 0.0) / self.mass.total))

    def set_factors(self, of_mass: float, of_hessian: float, at: MixedVector, *, stiffness_in_metric: bool) -> None:
        """Set the factors of the matrix, and the metric of the preconditioner.

        The Eulerian coordinates have little inertia of their own. Their blocks of the metric therefore always contain
        the diagonal of the Hessian that is never negative.

        Args:
            of_mass: factor 0 [1/s^2].
            of_hessian: factor 1.
            at: positions at which the Hessian of the metric is linearized.
            stiffness_in_metric: whether the metric of positions contains the diagonal of that Hessian too, and its
                blocks between positions and Eulerian coordinates. Otherwise it is the metric of the masses alone, as in
                Casafranca et al.
        """
        self._stiff = stiffness_in_metric
        if (of_mass, of_hessian) != self._factors_now:
            self._factors.assign([[of_mass, of_hessian]])
            self._factors_now = of_mass, of_hessian
        self.linearize(at, 0.0)
        self.repeated.run(("metric", stiffness_in_metric), (), lambda run, _: self._block_launches(run))
        self.preconditioner.set_metric(self._blocks, of_mass)

    def _block_launches(self, run: Launcher) -> list[Any]:
        """The launches that find the diagonal blocks of the metric."""
        blocks = self._blocks
        of_positions = [blocks.vertices, blocks.nodes, blocks.coupling_u, blocks.coupling_v]
        without = [] if self._stiff else [ZeroArray(part) for part in of_positions]
        return [
            *(ZeroArray(part) for part in (*of_positions, blocks.sliding)),
            *self._beside(lambda term: term.diagonal(blocks, run) if self._stiff or term.acts_on != "vertices" else []),
            *without,
            *self.mass.combine_blocks(self._factors, blocks, run),
        ]

    @property
    def preconditioner(self) -> Preconditioner:
        """The preconditioner for the metric that ``set_factors`` set last; each kind of metric has one."""
        if self._stiff not in self._preconditioners:
            self._preconditioners[self._stiff] = self._new_preconditioner(by_masses=not self._stiff)
        return self._preconditioners[self._stiff]

    def _new_preconditioner(self, *, by_masses: bool) -> Preconditioner:
        return Preconditioner(
            self.embedding, self.free, self._masses, self.scalar, self.device, by_masses=by_masses
        )

    @property
    def solver(self) -> ConjugateGradients:
        """The solver for the matrix of the last ``set_factors`` and ``linearize``; each kind of metric has one."""
        return self._captures.get(
            ("solver", self._stiff), lambda: ConjugateGradients(self.zeros(), self._products, self.preconditioner)
        )

    def _beside(self, launches_of: Callable[[MixedTerm], list[Any]]) -> list[Any]:
        """The launches of all terms. Terms that act on nodes alone run beside terms that act on vertices alone."""
        kinds: dict[str, list[list[Any]]] = {"nodes": [], "vertices": [], "all": []}
        for term in self.terms:
            kinds[term.acts_on].append(launches_of(term))
        nodes, vertices = _overlapped(kinds["nodes"]), _overlapped(kinds["vertices"])
        beside = [Branches(nodes, vertices)] if nodes and vertices else [*nodes, *vertices]
        return [*beside, *chain.from_iterable(kinds["all"])]

    def _products(
        self, direction: MixedVector, product: MixedVector, parts: wp.array[Any], launcher: Launcher
    ) -> list[Any]:
        """The launches of a product with the matrix, and of the parts of the dot product of both."""
        of_terms = self._beside(lambda term: term.products(direction, product, launcher))
        mass = self.mass.combine_products(self._factors, direction, product, launcher, parts)
        return [ZeroArray(product.values), *of_terms, *mass]


def _overlapped(of_terms: list[list[Any]]) -> list[Any]:
    """The launches of terms that act on the same part: the longest row runs beside the others, up to its last launch.

    All launches of a term but the last one write only memory of that term.
    """
    longest = max(of_terms, key=len, default=[])
    others = [launch for row in of_terms if row is not longest for launch in row]
    beside = [Branches(longest[:-1], others)] if len(longest) > 1 and others else [*others, *longest[:-1]]
    return [*beside, *longest[-1:]]


def _moves(free: FreeUnknowns) -> NDArray[np.int32]:
    """1 for each scalar of a vector that is unknown, and 0 for the others."""
    points = [np.repeat(each, 3) for each in (free.vertices, free.nodes)]
    return np.concatenate([*points, free.sliding.reshape(-1)]).astype(np.int32)
