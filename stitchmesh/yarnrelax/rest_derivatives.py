# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Derivatives of a state of rest by the inputs of the relaxation, and the stiffness of the cell as a membrane.

At rest the forces F on the control points u and on the strains E of a cell vanish. If an input p changes, the state
follows so that they vanish again. The exact Hessian has the blocks K (points), B (between points and strains) and C
(strains), so that

    K du/dp + B dE/dp = dF_u/dp        B^T du/dp + C dE/dp = dF_E/dp

The points follow the strains with du = - K^-1 B dE, so that the energy of the cell has the second derivative

    S = C - B^T K^-1 B                 [erg]

by the strains, with which S dE/dp = dF_E/dp - B^T K^-1 dF_u/dp for the free strains.

K has a null space, the translations of the fabric; planes hold the translation along the normal. All right-hand sides
are orthogonal to the null space. A spring at one control point for each free translation makes K regular, and changes
solutions only by that translation. Unlike in the steps of Newton's method (``newton_system``) there is no other shift:
where yarns slide along themselves, only the roughness of their sampled contacts holds them, and it counts. The last
steps to rest use the same system, because the steps of Newton's method leave such slides out.

The derivatives of the forces are central differences at the state of rest, two evaluations of the forces for each
input. For the stiffnesses they are exact up to rounding, because the forces are linear in them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array

from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.errors import SolverError
from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.assembled_hessian import HessianAssembly
from stitchmesh.yarnrelax.collision.step_limit import STRAIN_UNIT
from stitchmesh.yarnrelax.energies.term import INPUTS, InputPowers, YarnTerm, no_derivatives
from stitchmesh.yarnrelax.hessian.cell_matrices import Owners
from stitchmesh.yarnrelax.hessian.factored_matrix import factored
from stitchmesh.yarnrelax.hessian.matrices_on_host import MatricesOnHost
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.relaxation_inputs import RelaxationInputs
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.newton_system import NewtonSteps, NewtonSystems

NEAR = 1e-6
"""Newton's method brings a state to this residual, and to this estimate of the remaining change of the spacing."""
RESIDUAL, LARGEST_RESIDUAL = 1e-10, 1e-7
"""A state is brought to the first residual before it is differentiated, and refused above the second. Errors of the
derivatives are about the residual over the softness of the fabric, 1e-3."""
MOST_ITERATIONS = 20_000
"""Largest number of iterations of the relaxation."""
WORTH = 0.5
"""If a step leaves more than this part of the residual, further steps of Newton's method do not help."""
STEP = 1e-6
"""Relative change of an input in a central difference of forces. Rounding then leaves 1e-10 of a term's force, and
pairs of samples that begin to touch within the step hardly count."""


@dataclass(frozen=True, eq=False)
class RestDerivatives:
    """Derivatives of a cell at rest."""

    strains: Mapping[str, FloatArray]
    """Strains (course, wale, shear) of the cell over the relative change of each of ``INPUTS``, shape (3,); 0 for
    strains that are held."""
    reactions: Mapping[str, FloatArray]
    """Forces on the three strains over the relative change of each of ``INPUTS``, while all strains are held and the
    points follow [erg], shape (3,)."""
    stiffness: FloatArray
    """Second derivatives of the energy by the three strains while the points follow [erg], shape (3, 3)."""
    negative_eigenvalues: int
    """Number of significant negative eigenvalues of the Hessian of the free coordinates; 0 at a minimum."""


class ForcesByInput:
    """The forces on the control points and the strains of a cell in its state, with a factor of one input."""

    def __init__(self, simulation: YarnSimulation) -> None:
        """Capture the launches.

        Raises:
            ParameterError: a term has no derivatives.
        """
        model, strain = simulation.model, simulation.strain
        assert strain is not None
        launches = simulation.balance_launches()
        launches += strain.force_launches(simulation.state, simulation.candidates, model.prepare)
        self._launches, self._state = CapturedLaunches(launches, model.device), simulation.state
        self._strain, self._held_strains = strain, strain.host_free[0] == 0.0
        self._powers = _powers_of_model(model)
        for term in simulation.terms:
            if not isinstance(term, YarnTerm):
                raise no_derivatives(term)
            self._powers += term.input_powers()
        self._kept = [own.constants.numpy().copy() for own in self._powers]

    def at(self, name: str, factor: float) -> FloatArray:
        """Return the forces [erg / unit] with one input multiplied by a factor near 1, shape (3 N + 3,).

        Held strains have the forces with which the yarns act on them.
        """
        self._multiply(name, factor)
        self._launches.launch()
        found = self._state.force.numpy().astype(np.float64).ravel()
        found[-3:][self._held_strains] = self._strain.totals.numpy()[0, :3][self._held_strains] / float(STRAIN_UNIT)
        self._multiply(name, 1.0)
        return found

    def now(self) -> FloatArray:
        """Return the forces with all inputs as they are."""
        return self.at(INPUTS[0], 1.0)

    def slope(self, name: str) -> FloatArray:
        """Return the derivatives of the forces by the logarithm of an input, shape (3 N + 3,)."""
        return (self.at(name, 1.0 + STEP) - self.at(name, 1.0 - STEP)) / (2.0 * STEP)

    def _multiply(self, name: str, factor: float) -> None:
        for own, values in zip(self._powers, self._kept, strict=True):
            own.constants.assign(values * own.factors(name, factor))


class RestSystem:
    """The linear system of small motions of a cell about a state of rest."""

    def __init__(self, simulation: YarnSimulation, assembly: HessianAssembly) -> None:
        """Factor the Hessian of the current state.

        Raises:
            SolverError: the Hessian has no factors.
        """
        assert simulation.strain is not None
        self.free: NDArray[np.bool_] = simulation.strain.host_free[0] > 0.0
        self.matrix, count = assembly.matrix(), 3 * simulation.model.point_count
        self._points = _held(csc_array(self.matrix[:count, :count]))
        self._factors = factored(self._points)
        self._border = self.matrix[:count, count:].toarray()
        self._following = -self._solved(self._border)
        stiffness = self.matrix[count:, count:].toarray() + self._border.T @ self._following
        self.stiffness = np.asarray(stiffness + stiffness.T) / 2.0
        """S for the strains in the coordinates of the solver [erg / unit^2], shape (3, 3)."""

    def motions(self, forces: FloatArray) -> FloatArray:
        """Return the motions with which the cell gives way to forces, both of shape (3 N + 3, m)."""
        moved, left = self.reactions(forces)
        strains = np.zeros((3, forces.shape[1]))
        strains[self.free] = np.linalg.solve(self.stiffness[np.ix_(self.free, self.free)], left[self.free])
        return np.concatenate([moved + self._following @ strains, strains])

    def reactions(self, forces: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how the points give way to forces while all strains are held, and the forces then on the strains.

        Args:
            forces: forces on the points and the strains, shape (3 N + 3, m).

        Returns:
            The motions of the points, shape (3 N, m), and the forces on the strains, shape (3, m).
        """
        count = len(self._border)
        moved = self._solved(forces[:count])
        return moved, forces[count:] - self._border.T @ moved

    @property
    def negative_eigenvalues(self) -> int:
        """Number of significant negative eigenvalues of the free coordinates, as Newton's method counts them."""
        owner = np.zeros(self.matrix.shape[0], dtype=np.int32)
        owner[-3:] = np.where(self.free, 0, -1)
        own = MatricesOnHost(self.matrix, Owners(owner, 1))
        return int(NewtonSystems(own, np.zeros(len(owner))).negative_count[0])

    def _solved(self, right: FloatArray) -> FloatArray:
        """Return the motions of the control points at held strains, without a motion of the fabric as a whole."""
        found = self._factors.solve(right)
        for _ in range(2):  # refine the solution by its residual
            found = found + self._factors.solve(right - self._points @ found)
        return found


def _held(matrix: csc_array) -> csc_array:
    """Return the stiffness of the control points with springs against the translations that nothing holds."""
    level = float(np.median(matrix.diagonal()))
    springs = np.zeros(matrix.shape[0])
    for axis in range(3):
        whole = np.zeros(matrix.shape[0])
        whole[axis::3] = 1.0
        if np.abs(matrix @ whole).max() < 1e-9 * level:  # nothing holds a translation of the whole fabric
            springs[axis] = level
    return csc_array(matrix + diags_array(springs))


def polished(inputs: RelaxationInputs) -> RelaxationLoop:
    """Bring yarns that are near rest to rest in float64, by Newton's method and then with the exact Hessian.

    Raises:
        ParameterError: a term has no derivatives.
        SolverError: the yarns do not come to rest.
    """
    quality = replace(inputs.quality, precision="float64", solver="quasistatic", tolerance=NEAR, largest_change=NEAR)
    simulation = replace(inputs, quality=quality).start()
    loop = RelaxationLoop(simulation, NEAR, NEAR)
    loop.run(MOST_ITERATIONS)
    simulation.restore()
    simulation.search_contacts()
    if (loop.at_rest | loop.stalled)[0]:
        _end(loop)
    residual = float(loop.last.residual[0])
    if residual > LARGEST_RESIDUAL:
        found = f"derivatives at rest: the yarns come to a residual of {residual:.2g}; expected {LARGEST_RESIDUAL:g}"
        raise SolverError(f"{found}; relax them with another quality")
    return loop


def _end(loop: RelaxationLoop) -> None:
    """Make the last steps to rest: by Newton's method while they help, and then with the exact Hessian.

    Steps with the exact Hessian may raise the residual at first, because yarn that slides along itself leaves its
    curve. The state with the least residual is kept.
    """
    simulation, newton, everyone = loop.simulation, loop.newton, np.ones(1, dtype=bool)
    assert newton is not None
    loop.tolerance = loop.largest_change = RESIDUAL
    before = np.inf
    while RESIDUAL < loop.last.residual[0] < WORTH * before and not loop.stalled[0]:
        before = float(loop.last.residual[0])
        loop.advance()
    forces, assembly = ForcesByInput(simulation), HessianAssembly(simulation)
    for _ in range(8 if loop.last.residual[0] > RESIDUAL else 0):  # steps with the exact Hessian
        force = forces.now()
        motion = RestSystem(simulation, assembly).motions(force[:, None])[:, 0]
        newton.steps = NewtonSteps(motion.reshape(-1, 3), np.array([force @ motion]), everyone, everyone, ~everyone)
        newton.move(everyone, np.ones(1))
        simulation.search_contacts()
        found = simulation.assess_cells()
        if found.residual[0] < loop.last.residual[0]:
            simulation.accept(everyone)
            loop.last = found
        if loop.last.residual[0] <= RESIDUAL:
            break
    simulation.restore()
    simulation.search_contacts()


def rest_derivatives(simulation: YarnSimulation) -> RestDerivatives:
    """Return the derivatives of a state of rest.

    Args:
        simulation: one relaxing cell, at rest, in float64, with candidate lists for its state.

    Raises:
        ParameterError: a term has no derivatives.
        SolverError: the Hessian has no factors.
    """
    system, forces = RestSystem(simulation, HessianAssembly(simulation)), ForcesByInput(simulation)
    slopes = np.column_stack([forces.slope(name) for name in INPUTS])
    unit = float(STRAIN_UNIT)
    strains = dict(zip(INPUTS, system.motions(slopes)[-3:].T / unit, strict=True))
    reactions = dict(zip(INPUTS, system.reactions(slopes)[1].T * unit, strict=True))
    return RestDerivatives(strains, reactions, system.stiffness * unit**2, system.negative_eigenvalues)


def _powers_of_model(model: Model) -> list[InputPowers]:
    """Return the dependence of the constants of a model on the inputs.

    The topology does not change, and neither do the numbers of contact samples nor the neighbours of a segment along
    its yarn.
    """
    constants = model.constants
    of_segments = [{"k_len": 1.0}, {"k_length": 1.0}, {"k_bend": 1.0}]
    return [
        InputPowers(constants.segment_rest_length, [{"loop_length": 1.0}]),
        InputPowers(constants.segment_stiffness, of_segments),
        InputPowers(constants.sample_weight, [{"loop_length": 1.0}]),
        InputPowers(constants.sample_stiffness, [{"loop_length": 1.0, "k_contact": 1.0}]),
        InputPowers(constants.yarn_radius, [{"radius": 1.0}]),
    ]
