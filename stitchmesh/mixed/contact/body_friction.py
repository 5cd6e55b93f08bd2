# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Dry friction of a cloth with a body: Coulomb's law with anchors on the surface, implicit and symmetric.

The law, the energy and the Hessian stand in ``simulation.friction_law``. Each contact point that touches the body has
an anchor, a point that moves with a triangle of the surface. The normal force N and the normal n are taken from the end
of the step before. After a step the anchor of a point with s > e is dragged along until s = e. Li et al. 2020 measure
slip from the beginning of the step instead, so a cloth at rest creeps at a speed below a threshold. With lasting
anchors it rests under loads up to mu N, within e of the place where it stopped.
Pure anchored springs would need a projection of the force in each Newton iteration, which would make the matrix
unsymmetric.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import Mat33, Scalar, Vec2, Vec3, vector
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.contact.body import to_body
from stitchmesh.mixed.contact.body_distance import BodyContact, block_products
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import MixedTerm
from stitchmesh.simulation.bodies.body_surface import NO_ANCHOR, SurfaceArrays, anchor_at, anchor_place, single
from stitchmesh.simulation.friction_law import slip_block, slip_energy, slip_force, within

SLIP_LENGTH = 0.005
"""Default of e [cm]: the distance from its rest at which the friction of a point reaches its full size."""


@wp.func
def slip_of(surface: SurfaceArrays, here: Vec3, face: int, local: Vec3, normal: Vec3) -> Any:
    """u, in the frame of the body; zero without an anchor."""
    slip = here - here
    if face >= 0:
        slip = within(here - anchor_place(surface, face, local), normal)
    return slip


@kernel
def friction_forces(
    # model
    surface: SurfaceArrays,
    law: Vec2,
    # state in
    face: wp.array[wp.int32],
    local: wp.array[Vec3],
    normal: wp.array[Vec3],
    load: wp.array[Scalar],
    frame: wp.array[Mat33],
    origin: wp.array[Vec3],
    place: wp.array[Vec3],
    # state out
    force: wp.array[Vec3],
) -> None:
    """Force of friction on each point [dyn]; the law is mu and the slip length."""
    i = wp.tid()
    slip = slip_of(surface, to_body(frame[0], origin[0], place[i]), face[i], local[i], normal[i])
    force[i] = frame[0] * slip_force(slip, law[0] * load[i], law[1])


@kernel
def friction_energies(
    # model
    surface: SurfaceArrays,
    law: Vec2,
    # state in
    face: wp.array[wp.int32],
    local: wp.array[Vec3],
    normal: wp.array[Vec3],
    load: wp.array[Scalar],
    frame: wp.array[Mat33],
    origin: wp.array[Vec3],
    place: wp.array[Vec3],
    # state out
    energy: wp.array[Scalar],
) -> None:
    """Energy of each point [erg]."""
    i = wp.tid()
    slip = slip_of(surface, to_body(frame[0], origin[0], place[i]), face[i], local[i], normal[i])
    energy[i] = law[0] * load[i] * slip_energy(wp.length(slip), law[1])


@kernel
def friction_blocks(
    # model
    surface: SurfaceArrays,
    law: Vec2,
    # state in
    face: wp.array[wp.int32],
    local: wp.array[Vec3],
    normal: wp.array[Vec3],
    load: wp.array[Scalar],
    frame: wp.array[Mat33],
    origin: wp.array[Vec3],
    place: wp.array[Vec3],
    # state out
    block: wp.array[Mat33],
) -> None:
    """H of each point by its place [dyn / cm]."""
    i = wp.tid()
    slip = slip_of(surface, to_body(frame[0], origin[0], place[i]), face[i], local[i], normal[i])
    block[i] = frame[0] * slip_block(slip, normal[i], law[1]) * wp.transpose(frame[0]) * (law[0] * load[i])


@kernel
def renew_anchors(
    # model
    surface: SurfaceArrays,
    law: Vec2,
    depth: Scalar,
    # state in
    frame: wp.array[Mat33],
    origin: wp.array[Vec3],
    place: wp.array[Vec3],
    push: wp.array[Vec3],
    # state out
    face: wp.array[wp.int32],
    local: wp.array[Vec3],
    normal: wp.array[Vec3],
    load: wp.array[Scalar],
) -> None:
    """Normal force and contact normal at the end of a step; anchors of new contacts, and of contacts that have slid."""
    i = wp.tid()
    own = wp.transpose(frame[0]) * push[i]
    pressing = wp.length(own)
    load[i] = pressing
    if pressing == pressing - pressing:
        face[i] = NO_ANCHOR
        return
    direction = own / pressing
    normal[i] = direction
    here = to_body(frame[0], origin[0], place[i])
    slip = slip_of(surface, here, face[i], local[i], direction)
    measure = wp.length(slip)
    if face[i] < 0 or measure > law[1]:
        query = wp.mesh_query_point_no_sign(surface.tree, single(here), float(depth))
        if query.result:
            face[i] = query.face
            if measure > law[1]:
                here -= slip * (law[1] / measure)
            local[i] = anchor_at(surface, query.face, here)


class BodyFriction(MixedTerm):
    """Friction of a cloth with the body of a contact term."""

    def __init__(self, contact: BodyContact, coefficient: float, *, slip_length: float = SLIP_LENGTH) -> None:
        """Add friction to the contact with a body.

        Args:
            contact: the contact; it must come before this term in the list of a solver.
            coefficient: mu.
            slip_length: e [cm].

        Raises:
            ParameterError: the coefficient is below 0, or the slip length is not positive.
        """
        self.name = f"{contact.name} friction"
        if not (np.isfinite(coefficient) and coefficient >= 0.0):
            raise ParameterError(f"{self.name}: got a coefficient of {coefficient}; expected at least 0")
        if not (np.isfinite(slip_length) and slip_length > 0.0):
            raise ParameterError(f"{self.name}: got a slip length of {slip_length} cm; expected a positive number")
        self.contact, self.points = contact, contact.points
        device = self.points.device
        self._law = vector(2, self.points.scalar)(coefficient, slip_length)
        self.face = wp.full(len(self.points), NO_ANCHOR, dtype=wp.int32, device=device)
        self.local, self.normal = self.points.vectors(), self.points.vectors()
        self.load = self.points.scalars()
        self._place, self._force = self.points.vectors(), self.points.vectors()
        self._block, self._numbers = self.points.blocks(), self.points.scalars()
        self._begun = False

    def begin_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Move the body to the end of the step; before the first step, find anchors and normal forces."""
        if not self._begun:
            self.contact.placed.move_to(time)
            self.contact.forget_distances()
            self._renew(state)
            self._begun = True
        self.contact.placed.move_to(time + time_step)

    def end_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Find the normal forces of the next step, and drag the anchors of contacts that have slid.

        The body is where ``begin_step`` has put it, at the end of the step.
        """
        self._renew(state)

    def arrays(self) -> dict[str, Any]:
        """Anchors and normal forces."""
        return {"face": self.face, "local": self.local, "normal": self.normal, "load": self.load}

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore anchors and normal forces."""
        super().resume(arrays)
        self._begun = True

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of each point, and the array of the energies."""
        launches = self.points.place(state, self._place, launcher)
        launches.append(launcher(friction_energies, len(self.points), self._inputs(), [self._numbers]))
        return launches, self._numbers

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add friction."""
        launches = self.points.place(state, self._place, launcher)
        launches.append(launcher(friction_forces, len(self.points), self._inputs(), [self._force]))
        return launches + self.points.spread(self._force, force, launcher)

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that store the Hessian of each point."""
        launches = self.points.place(state, self._place, launcher)
        return [*launches, launcher(friction_blocks, len(self.points), self._inputs(), [self._block])]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add H d."""
        launches = self.points.place(direction, self._place, launcher)
        launches.append(launcher(block_products, len(self.points), [self._block, self._place], [self._force]))
        return launches + self.points.spread(self._force, product, launcher)

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that add the diagonal blocks."""
        return self.points.spread_blocks(self._block, blocks, launcher)

    def _renew(self, state: MixedVector) -> None:
        run = partial(launch, device=self.points.device)
        self.contact.push(state, run)
        placed = self.contact.placed
        depth = self.points.scalar(2.0 * self.contact.depth)
        inputs = [placed.surface, self._law, depth, placed.frame, placed.origin, self.contact.place, self.contact.force]
        run(renew_anchors, len(self.points), inputs, [self.face, self.local, self.normal, self.load])

    def _inputs(self) -> list[Any]:
        placed = self.contact.placed
        anchors = [self.face, self.local, self.normal, self.load]
        return [placed.surface, self._law, *anchors, placed.frame, placed.origin, self._place]
