# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact and friction of yarns with a body that moves.

The contact has the energy of a body at rest (``energies.body``) at the place of the surface. Friction is Coulomb's law
for each contact sample. The anchor moves with a triangle of the surface, so that slip is measured against the body:

    F = -mu N (phi'(s) / s) u_t,    s = |u_t|,    N = |push|

u_t is the displacement from the anchor in the plane across the push, and phi the law of ``simulation.friction_law``:
the force is mu N beyond a slip length e. An anchor farther away is dragged along until s = e. A sample that slides
therefore feels mu N against its velocity relative to the body, and a sample that sticks returns to where it stuck. N,
n and the anchor belong to the present step, which an explicit solver (``solvers.dynamics``) can use.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec2, Vec3, Vec4, load_vector, store_vector, vector
from stitchmesh.errors import ParameterError, check_positive
from stitchmesh.mesh.vertex_motion import MovingMesh
from stitchmesh.simulation.bodies.body_penalty import push_listed, push_of
from stitchmesh.simulation.bodies.body_surface import NO_ANCHOR, SurfaceArrays, anchor_at, anchor_place, gap_to, single
from stitchmesh.simulation.friction_law import LARGEST_COEFFICIENT, slip_slope, within
from stitchmesh.simulation.pair_lists import allocate_lists
from stitchmesh.yarnrelax.constraints.pins import Pins
from stitchmesh.yarnrelax.energies.body import (
    DEPTH,
    LIST,
    MARGIN,
    NOWHERE,
    Body,
    body_gaps,
    list_triangles,
)
from stitchmesh.yarnrelax.energies.term import YarnChoice, YarnTerm
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.state import State, YarnForces
from stitchmesh.yarnrelax.motion.follow_defaults import BODY_FRICTION
from stitchmesh.yarnrelax.motion.moving_surface import MovingSurface


@wp.func
def nearest_face(surface: Any, place: Any, depth: Any, otherwise: int) -> int:
    """The triangle that is nearest to a place; another one if none is within the depth."""
    query = wp.mesh_query_point_no_sign(surface.tree, single(place), float(depth))
    if query.result:
        return query.face
    return otherwise


@wp.func
def friction_on(
    surface: Any, law: Any, place: Any, push: Any, depth: Any, p: int, face: wp.array[wp.int32], anchor: wp.array[Any]
) -> Any:
    """Friction on a sample and the row sum of its stiffness, by the push of the body; the anchor is renewed."""
    pressing = wp.length(type(place)(push[0], push[1], push[2]))
    none = pressing - pressing
    if pressing == none or law[0] == none:
        face[p] = NO_ANCHOR
        return push - push
    normal = type(place)(push[0], push[1], push[2]) / pressing
    slip = place - place
    if face[p] == NO_ANCHOR:
        face[p] = nearest_face(surface, place, depth, 0)
        anchor[p] = anchor_at(surface, face[p], place)
    else:
        slip = within(place - anchor_place(surface, face[p], anchor[p]), normal)
    measure = wp.length(slip)
    if measure > law[1]:
        slip = slip * (law[1] / measure)
        measure = law[1]
        face[p] = nearest_face(surface, place, depth, face[p])
        anchor[p] = anchor_at(surface, face[p], place - slip)
    size = law[0] * pressing * slip_slope(measure, law[1])
    return type(push)(-slip[0] * size, -slip[1] * size, -slip[2] * size, size)


@kernel
def moving_body_forces(
    # model
    model: YarnConstants,
    surface: SurfaceArrays,
    travel: wp.array[Scalar],
    thickness: Scalar,
    stiffness: Scalar,
    law: Vec2,
    # state in
    samples: wp.array[Vec4],
    # state out
    measured: wp.array[Vec4],
    measured_travel: wp.array[Scalar],
    list_count: wp.array[wp.int32],
    listed: wp.array2d[wp.int32],
    face: wp.array[wp.int32],
    anchor: wp.array[Vec3],
    sample_force: wp.array[Vec4],
) -> None:
    """Add push and friction of the body on each sample, and the row sums of their stiffness.

    The law is mu and the slip length.
    """
    p = wp.tid()
    here = load_vector(samples, p)
    place = type(surface.corners[0])(here[0], here[1], here[2])
    reach = here[3] + thickness
    wide = reach * type(reach)(1.0 + MARGIN)
    last = load_vector(measured, p)
    moved = wp.length(place - type(place)(last[0], last[1], last[2])) + travel[0] - measured_travel[p]
    # a thousandth allows for rounding
    if (moved + reach) * type(reach)(1.001) < last[3]:
        face[p] = NO_ANCHOR
        return
    count = list_count[p]
    if (moved + reach) * type(reach)(1.001) > wide:
        moved = reach - reach
        last = gap_to(surface, here, reach * type(reach)(DEPTH))
        count = 0
        if last[3] < wide:
            count = list_triangles(surface, here, wide, p, listed)
        list_count[p] = count
        measured_travel[p] = travel[0]
        store_vector(measured, p, type(here)(here[0], here[1], here[2], last[3]))
    push = type(here)()
    if count >= 0 and moved < last[3]:
        push = push_listed(surface, listed, p, count, here, reach)
    else:
        push, _energy = push_of(surface, here, reach, reach * type(reach)(DEPTH))
    push = push * (stiffness * here[3] * model.sample_weight[p])
    push += friction_on(surface, law, place, push, reach * type(reach)(DEPTH), p, face, anchor)
    store_vector(sample_force, p, load_vector(sample_force, p) + push)


@dataclass(frozen=True, eq=False)
class MovingBody(YarnChoice):
    """A body that moves and has friction with yarns, for the solver ``dynamics`` (``follow_body``).

    Raises:
        ParameterError: ``Body`` refuses a value, or the coefficient is negative or above ``LARGEST_COEFFICIENT``.
    """

    moving: MovingMesh
    """The surface in motion; its faces are oriented outwards."""
    friction: float = BODY_FRICTION
    """Coefficient of friction with the body."""
    thickness: float = 0.0
    """Distance from the body at which the surface of a yarn begins to feel a force [cm]."""
    stiffness: float = 1.0
    """Stiffness over the stiffness of a yarn."""
    slip_length: float = 0.05
    """Slip from which on friction is full, in mean yarn radii."""
    carried: Pins | None = None
    """Control points that move with the body, for example the points of a waistband."""

    def __post_init__(self) -> None:
        Body(self.moving.mesh, self.thickness, self.stiffness)
        if not 0.0 <= self.friction <= LARGEST_COEFFICIENT:
            expected = f"expected a number from 0 to {LARGEST_COEFFICIENT:g}, for yarn on skin 0.2 to 0.6"
            raise ParameterError(f"moving body: got a coefficient of friction of {self.friction}; {expected}")
        check_positive("moving body: slip length", self.slip_length)

    def on(self, model: Model) -> MovingBodyTerm:
        """Return the body on a model's device, at its first time.

        Raises:
            ParameterError: the yarns are on a lattice, or do not resist contact.
        """
        Body(self.moving.mesh, self.thickness, self.stiffness).check_fits(model)
        return MovingBodyTerm(model, self)


class MovingBodyTerm(YarnTerm):
    """A moving body on a device."""

    name = "moving body"

    def __init__(self, model: Model, body: MovingBody) -> None:
        """Put the body on the device at its first time, without contacts."""
        self.model = model
        self.closed = Body(body.moving.mesh).closed
        self.surface = MovingSurface(model, body.moving)
        self.thickness = model.number(body.thickness / model.unit)
        stiffness = model.number(2.0 * model.material.k_contact * body.stiffness)
        law = vector(2, model.scalar)(body.friction, body.slip_length)
        self.inputs = [model.constants, self.surface.constants, self.surface.travel, self.thickness, stiffness, law]
        count = model.sample_count
        self.measured, self.measured_travel = model.empty(count, 4), model.empty(count)
        self.list_count = model.integers(np.zeros(count))
        self.listed = allocate_lists(count, LIST, model.device)
        self._no_energy = model.empty(1)
        self.face = wp.full(count, NO_ANCHOR, dtype=wp.int32, device=model.device)
        self.anchor = model.empty(count, 3)
        self.forget_distances()

    def forget_distances(self) -> None:
        """Measure all distances again in the next forces; a resumed run begins in the same way."""
        self.measured.fill_(NOWHERE)

    def forces(self, state: State, force: YarnForces, launcher: Launcher) -> list[Any]:
        """Place the surface, and add push and friction on each sample."""
        kept = [self.measured, self.measured_travel, self.list_count, self.listed, self.face, self.anchor]
        outputs = [*kept, force.samples]
        inputs = [*self.inputs, state.samples]
        placed = self.surface.launches(launcher)
        return [*placed, launcher(moving_body_forces, self.model.sample_count, inputs, outputs)]

    def element_energies(self, state: State, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """Return no launch and a zero, because the body does work and friction loses energy."""
        return [], self._no_energy

    def arrays(self) -> dict[str, wp.array[Any]]:
        """Return the anchors."""
        return {"face": self.face, "anchor": self.anchor}

    def gaps(self, state: State) -> NDArray[np.float64]:
        """Return the signed distance of each sample from the surface over its reach, (P,), for up-to-date samples."""
        gap = self.model.empty(self.model.sample_count)
        inputs = [self.surface.constants, self.thickness, self.model.number(1e30), state.samples]
        self.model.launch(body_gaps, self.model.sample_count, inputs, [gap])
        return np.asarray(gap.numpy(), dtype=np.float64)
