# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Dry friction between yarns: Coulomb's law, smoothed over a short slip, with a lagged normal force.

Between two renewals (``friction_contacts``) a pair of contact samples has the energy

    E = mu N phi(s),    s^2 = u . A u,    phi(s) = s^2 / e - s^3 / (3 e^2)  for s < e, else s - e / 3        [erg]

(the mollifier f0 of Li et al. 2020, Incremental Potential Contact, without its constant: once differentiable, of slope
1 beyond the slip length e). u is the relative displacement of the samples from their anchors. N is the normal force at
the beginning of the load step. N and everything except u are constants here, so that the force is a gradient:

    F_p = -mu N (phi'(s) / s) A u

The normal n of the contact is the direction of the contact force without its components along the two yarns. These
components cancel in the sum along a yarn, and do not press. N is the remaining contact force. With t_p, t_q the
tangents of both yarns in the plane across n, and mu the larger coefficient,

    A = (mu_across / mu)^2 (1 - n n^T) + ((mu_along / mu)^2 - (mu_across / mu)^2) (t_p t_p^T + t_q t_q^T) / 2

so s is |u_t| if both coefficients are the same. A and N belong to the pair, so the forces on its two samples are
opposite. Slip across one yarn is slip along another yarn that crosses it at a right angle.

On a lattice the other sample of a pair may lie in an image, and u contains the change of the periods. A relaxing cell
therefore slips where its strains carry a yarn along another one. The virial of friction, half of F_p (y_p - y_q)^T at
both samples, adds to the forces on the strains (``cell_strain``). Anchors are places in space and do not follow the
strains.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.kernel_variants import kernel_factory
from stitchmesh.compute.precision import Scalar, Vec3, Vec4, Vec6, Vec9, vector
from stitchmesh.errors import ParameterError, check_positive
from stitchmesh.simulation.friction_law import LARGEST_COEFFICIENT, slip_energy, slip_slope
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.energies.cell_virial import add_friction_virial
from stitchmesh.yarnrelax.energies.pair_stiffness import PairStiffness
from stitchmesh.yarnrelax.energies.term import YarnChoice, YarnTerm
from stitchmesh.yarnrelax.friction.friction_contacts import (
    Contacts,
    empty_lists,
    first_contacts,
    has_moved,
    own_images,
    renewed_contacts,
)
from stitchmesh.yarnrelax.friction.friction_law import (
    resistance_block,
    resisted_slip,
    slip_measure,
    slip_stiffness_block,
    vector_from,
)
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.lattice_images import LatticeImages, sample_number
from stitchmesh.yarnrelax.model.state import State, YarnForces


@wp.func
def slip_of_pair(
    images: LatticeImages, law: Vec4, tangent: Any, samples: Any, p: int, entry: int, anchor: Vec3, force: Vec3
) -> tuple[Any, Any]:
    """Slip of a pair from its anchor, and the part of it that friction resists, weighted by the law."""
    slip = vector_from(images, samples, p, samples[p], entry, force) - anchor
    q = sample_number(images, entry)
    return slip, resisted_slip(slip, wp.normalize(force), tangent[p], tangent[q], law)


@kernel_factory(lambda form: [(relaxes,) for relaxes in form.relaxing])
def friction_forces(cell_relaxes: bool) -> wp.Kernel:
    """Return the kernel of the forces; for relaxing cells it also finds their virial."""

    @kernel
    def friction_forces(
        # model
        images: LatticeImages,
        law: Vec4,
        tangent: wp.array[Vec3],
        contact_count: wp.array[wp.int32],
        contact_entry: wp.array2d[wp.int32],
        anchor: wp.array2d[Vec3],
        press: wp.array2d[Vec3],
        # state in
        samples: wp.array[Vec4],
        # state out
        sample_force: wp.array[Vec4],
        sample_block: wp.array[Vec6],
        sample_virial: wp.array[Vec9],
    ) -> None:
        """Add the friction on each sample, the row sum of its stiffness, and its block where that is read."""
        p = wp.tid()
        push = type(samples[p])()
        block = type(sample_block[0])()
        virial = type(sample_virial[0])()
        for c in range(contact_count[p]):
            force, entry = press[p, c], contact_entry[p, c]
            slip, resisted = slip_of_pair(images, law, tangent, samples, p, entry, anchor[p, c], force)
            stiff = wp.length(force) * slip_slope(slip_measure(slip, resisted), law[3])
            push += type(push)(-resisted[0] * stiff, -resisted[1] * stiff, -resisted[2] * stiff, stiff)
            if sample_block.shape[0] > 0:
                q = sample_number(images, entry)
                block += resistance_block(stiff, wp.normalize(force), tangent[p], tangent[q], law, block)
            if wp.static(cell_relaxes):
                virial = add_friction_virial(virial, images, p, slip + anchor[p, c], resisted * -stiff, stiff)
        sample_force[p] += push * law[0]
        if sample_block.shape[0] > 0:
            sample_block[p] += block * law[0]
        if wp.static(cell_relaxes):
            sample_virial[p] += virial * law[0]

    return friction_forces


@kernel
def friction_stiffness(
    # model
    images: LatticeImages,
    law: Vec4,
    tangent: wp.array[Vec3],
    contact_count: wp.array[wp.int32],
    contact_entry: wp.array2d[wp.int32],
    anchor: wp.array2d[Vec3],
    press: wp.array2d[Vec3],
    # state in
    samples: wp.array[Vec4],
    # state out
    stiffness: wp.array2d[Vec6],
) -> None:
    """The block of each pair, as (xx, yy, zz, xy, xz, yz)."""
    p = wp.tid()
    for c in range(contact_count[p]):
        force, entry = press[p, c], contact_entry[p, c]
        slip = vector_from(images, samples, p, samples[p], entry, force) - anchor[p, c]
        q = sample_number(images, entry)
        stiffness[p, c] = slip_stiffness_block(force, slip, tangent[p], tangent[q], law, type(stiffness[p, c])())


@kernel
def friction_energies(
    # model
    images: LatticeImages,
    law: Vec4,
    tangent: wp.array[Vec3],
    contact_count: wp.array[wp.int32],
    contact_entry: wp.array2d[wp.int32],
    anchor: wp.array2d[Vec3],
    press: wp.array2d[Vec3],
    # state in
    samples: wp.array[Vec4],
    # state out
    sample_energy: wp.array[Scalar],
) -> None:
    """Half of each pair's energy [erg], at both of its samples."""
    p = wp.tid()
    energy = law[0] - law[0]
    for c in range(contact_count[p]):
        force = press[p, c]
        slip, resisted = slip_of_pair(images, law, tangent, samples, p, contact_entry[p, c], anchor[p, c], force)
        energy += wp.length(force) * slip_energy(slip_measure(slip, resisted), law[3])
    sample_energy[p] = energy * law[0] * type(energy)(0.5)


@dataclass(frozen=True)
class Friction(YarnChoice):
    """Dry friction where yarns touch.

    Raises:
        ParameterError: a coefficient is negative or above ``LARGEST_COEFFICIENT``, or the slip length is not a positive
            number.
    """

    mu: float | tuple[float, float]
    """Coefficient of friction, or two: along the yarn and across it."""
    slip_length: float = 0.05
    """Slip from which on friction is full, in mean yarn radii."""
    in_free_cells = True

    def __post_init__(self) -> None:
        if not all(0.0 <= value <= LARGEST_COEFFICIENT for value in self.coefficients):
            expected = f"expected numbers from 0 to {LARGEST_COEFFICIENT:g}, for yarn 0.1 to 0.5"
            raise ParameterError(f"friction: got coefficients {self.coefficients}; {expected}")
        check_positive("friction: slip length", self.slip_length)

    @property
    def coefficients(self) -> tuple[float, float]:
        """Coefficients along the yarn and across it."""
        return self.mu if isinstance(self.mu, tuple) else (self.mu, self.mu)

    def on(self, model: Model) -> YarnTerm:
        """Return the friction between a model's yarns; normal forces are zero before the first ``renew``."""
        return FrictionTerm(model, self)


class FrictionTerm(YarnTerm):
    """Friction on a device."""

    name = "friction"
    gives_hessian = True
    lags = True

    def __init__(self, model: Model, friction: Friction) -> None:
        """Make friction without contacts."""
        largest = max(friction.coefficients)
        along, across = ((value / largest) ** 2 if largest > 0.0 else 1.0 for value in friction.coefficients)
        self.model, self.friction = model, friction
        self.law = vector(4, model.scalar)(largest, along, across, friction.slip_length)
        self.contacts = first_contacts(model)
        self._energy = model.empty(model.sample_count)
        self._generation = 0
        self._stiffness = empty_lists(model, self.contacts, 6)

    def weaken(self, share: float) -> None:
        """Set the coefficients to a share of the chosen ones."""
        before, self.law = self.law, vector(4, self.model.scalar)(
            max(self.friction.coefficients) * share, self.law[1], self.law[2], self.law[3]
        )
        self._generation += bool(self.law != before)

    def forces(self, state: State, force: YarnForces, launcher: Launcher) -> list[Any]:
        """Return the launch that adds the friction to the samples, and its virial if a cell relaxes."""
        outputs = [force.samples, force.blocks, force.virial]
        return [launcher(friction_forces(state.cell_relaxes), self.model.sample_count, self._inputs(state), outputs)]

    def pair_stiffness(self, state: State, launcher: Launcher) -> PairStiffness:
        """Return the pairs that press each other, and the Hessian of each.

        The Hessian belongs to the energy between two renewals: it is symmetric, without negative eigenvalues, and soft
        along a slip (``friction_law``).
        """
        kept, inputs = self.contacts, self._inputs(state)
        if self._stiffness.shape != kept.entry.shape:
            self._stiffness = empty_lists(self.model, kept, 6)
        launch = launcher(friction_stiffness, self.model.sample_count, inputs, [self._stiffness])
        return PairStiffness(inputs[0], kept.count, kept.entry, self._stiffness, [launch])

    def element_energies(self, state: State, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """Return the launch that halves the energy of each pair at both of its samples, and the array of the energies.

        The energy is zero without slip.
        """
        return [launcher(friction_energies, len(self._energy), self._inputs(state), [self._energy])], self._energy

    def has_moved(self, state: State) -> NDArray[np.bool_]:
        """Whether the yarns of each cell have moved since their normal forces were found, shape (C,)."""
        return has_moved(self.model, state, self.contacts)

    def renew(self, state: State, candidates: Candidates, cells: NDArray[np.bool_] | None = None) -> None:
        """Find the normal forces for the current samples, and move the anchors."""
        found = renewed_contacts(self.model, self.law, state, candidates, self.contacts, cells)
        if not found.put_into(self.contacts):
            self.contacts = found
            self._generation += 1

    @property
    def generation(self) -> int:
        """A number that changes when the arrays had no room for the pairs, or the law has changed."""
        return self._generation

    def arrays(self) -> dict[str, wp.array[Any]]:
        """The contacts of the load step."""
        return {field.name: getattr(self.contacts, field.name) for field in fields(Contacts)}

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore contacts; their number may differ from the number of the current contacts."""
        kinds = {name: array.dtype for name, array in self.arrays().items()}
        device = self.model.device
        self.contacts = Contacts(
            **{name: wp.array(arrays[name], dtype=kind, device=device) for name, kind in kinds.items()}
        )
        self._generation += 1

    def _inputs(self, state: State) -> list[Any]:
        kept = self.contacts
        images = own_images(self.model, kept)
        return [images, self.law, kept.tangent, kept.count, kept.entry, kept.anchor, kept.press, state.samples]
