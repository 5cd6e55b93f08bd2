# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Collision with a body: a surface that supports yarns.

Each contact sample keeps a distance R from the surface, its reach: the yarn radius plus the thickness of a layer on the
body. The energy is

    E = k_body sum over samples of  w e        [erg],    w = l / samples of the segment

with e the penalty of ``body_penalty``; over a flat body e = 1/x^2 + x^2 - 2 with x the distance over R. A yarn under a
load of q per length is at rest on it where q = k_body (2/x^3 - 2x) / R.

k_body = 2 r k_contact stiffness. A sample in contact with a parallel piece of yarn one thickness long has the energy
k_contact w 2r (1/x^2 + x^2 - 2), so a body of stiffness 1 pushes as hard as a yarn at the same distance. A whole
parallel yarn, whose parts are at different distances, is softer, by a factor below three while x < 0.9.

Each sample stores a measured distance and a list of near triangles. Both are updated only after the sample has moved
out of their range. This changes no bit of the result: a distance changes by no more than the motion of the sample, the
lists contain all triangles within reach, and other triangles add nothing.

A sample deeper than ``DEPTH`` reaches is not found and feels no force. Forces do not move a sample that deep, because
the penalty would be about a thousand. A sample that starts there in a closed body is an error.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec4, Vec6, load_vector, store_vector, vector
from stitchmesh.compute.reduction import minimum
from stitchmesh.errors import LARGEST_NUMBER, ParameterError, SolverError, check_positive
from stitchmesh.mesh import BORDER, Mesh
from stitchmesh.simulation.bodies.body_penalty import (
    body_block,
    near_triangles,
    push_listed,
    push_of,
    without_negative,
)
from stitchmesh.simulation.bodies.body_surface import BodySurface, SurfaceArrays, from_triangle, gap_to, surface_of
from stitchmesh.simulation.bodies.mesh_features import enclosed_volume, mesh_features
from stitchmesh.simulation.pair_lists import allocate_lists
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.collision.step_limit import yarn_place
from stitchmesh.yarnrelax.energies.pair_stiffness import SampleStiffness
from stitchmesh.yarnrelax.energies.term import YarnChoice, YarnTerm
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.state import State, YarnForces

DEPTH = wp.constant(4.0)
"""Largest depth below the surface, in reaches, at which a sample is found."""
MARGIN = wp.constant(0.25)
"""A list is made again after the sample has moved by this, in reaches."""
LIST = 12
"""Capacity of a list; if more triangles are near, they are searched in each iteration."""
NOWHERE = 1e15
"""A coordinate, and a distance, that no sample ever has [units]."""


@wp.func
def list_triangles(surface: SurfaceArrays, sample: Vec4, reach: Scalar, p: int, listed: wp.array2d[wp.int32]) -> int:
    """List the triangles that a sample may touch before the next search; their number, -1 if there are too many."""
    count = int(0)
    place = type(surface.corners[0])(sample[0], sample[1], sample[2])
    query = near_triangles(surface, place, reach)
    t = wp.int32(0)
    while wp.mesh_query_aabb_next(query, t):
        if wp.length(from_triangle(surface, t, place)) < reach:
            if count < listed.shape[1]:
                listed[p, count] = t
            count += 1
    if count > listed.shape[1]:
        count = -1
    return count


@kernel
def body_forces(
    # model
    model: YarnConstants,
    surface: SurfaceArrays,
    thickness: Scalar,
    stiffness: Scalar,
    # state in
    samples: wp.array[Vec4],
    # state out
    measured: wp.array[Vec4],
    list_count: wp.array[wp.int32],
    listed: wp.array2d[wp.int32],
    sample_force: wp.array[Vec4],
) -> None:
    """Add the push of the body on each sample, and the row sum of its stiffness."""
    p = wp.tid()
    here = load_vector(samples, p)
    reach = here[3] + thickness
    wide = reach * type(reach)(1.0 + MARGIN)
    last = load_vector(measured, p)
    moved = wp.length(type(surface.corners[0])(here[0] - last[0], here[1] - last[1], here[2] - last[2]))
    # a thousandth allows for rounding
    if (moved + reach) * type(reach)(1.001) < last[3]:
        return
    count = list_count[p]
    if (moved + reach) * type(reach)(1.001) > wide:
        moved = reach - reach
        last = gap_to(surface, here, reach * type(reach)(DEPTH))
        count = 0
        if last[3] < wide:
            count = list_triangles(surface, here, wide, p, listed)
        list_count[p] = count
        store_vector(measured, p, type(here)(here[0], here[1], here[2], last[3]))
    push = type(here)()
    if count >= 0 and moved < last[3]:
        push = push_listed(surface, listed, p, count, here, reach)
    else:
        push, _energy = push_of(surface, here, reach, reach * type(reach)(DEPTH))
    scale = stiffness * here[3] * model.sample_weight[p]
    store_vector(sample_force, p, load_vector(sample_force, p) + push * scale)


@kernel
def body_energies(
    # model
    model: YarnConstants,
    surface: SurfaceArrays,
    thickness: Scalar,
    stiffness: Scalar,
    # state in
    samples: wp.array[Vec4],
    # state out
    sample_energy: wp.array[Scalar],
) -> None:
    """Energy [erg] of each sample."""
    p = wp.tid()
    here = load_vector(samples, p)
    reach = here[3] + thickness
    _push, energy = push_of(surface, here, reach, reach * type(reach)(DEPTH))
    sample_energy[p] = energy * stiffness * here[3] * model.sample_weight[p]


@kernel
def body_gaps(
    # model
    surface: SurfaceArrays,
    thickness: Scalar,
    limit: Scalar,
    # state in
    samples: wp.array[Vec4],
    # state out
    gap: wp.array[Scalar],
) -> None:
    """Signed distance of each sample over its reach."""
    p = wp.tid()
    here = load_vector(samples, p)
    gap[p] = gap_to(surface, here, limit)[3] / (here[3] + thickness)


@kernel
def body_stiffness(
    # model
    model: YarnConstants,
    surface: SurfaceArrays,
    thickness: Scalar,
    stiffness: Scalar,
    # state in
    exact: wp.array[Scalar],
    samples: wp.array[Vec4],
    # state out
    found: wp.array[Vec6],
) -> None:
    """The second derivatives by the place of each sample, as six numbers."""
    p = wp.tid()
    here = load_vector(samples, p)
    reach = here[3] + thickness
    place = type(surface.corners[0])(here[0], here[1], here[2])
    block = body_block(surface, place, reach, reach * type(reach)(DEPTH))
    scale = stiffness * here[3] * model.sample_weight[p]
    if wp.ddot(block, block) > scale - scale:
        block = without_negative(block, exact[model.sample_segment[p]]) * scale
    found[p] = type(found[0])(block[0, 0], block[1, 1], block[2, 2], block[0, 1], block[0, 2], block[1, 2])


@dataclass(frozen=True, eq=False)
class Body(YarnChoice):
    """A surface that yarns cannot enter; its faces are oriented outwards, and it may be open (a floor).

    Raises:
        ParameterError: a thickness below 0, a stiffness that is not positive, a mesh on a lattice, or a closed mesh
            whose faces are oriented inwards.
    """

    mesh: Mesh
    """The surface [cm]."""
    thickness: float = 0.0
    """Distance from the body at which the surface of a yarn begins to feel a force [cm]."""
    stiffness: float = 1.0
    """Stiffness over the stiffness of a yarn."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.thickness <= LARGEST_NUMBER:
            found = f"body: got a thickness of {self.thickness}"
            raise ParameterError(f"{found}; expected at least 0 cm and at most {LARGEST_NUMBER:g} cm")
        check_positive("body: stiffness", self.stiffness)
        if self.mesh.lattice is not None:
            raise ParameterError("body: got a mesh on a lattice; expected one without")
        if self.closed and enclosed_volume(self.mesh) < 0.0:
            raise ParameterError("body: the faces of its closed mesh look inwards; reverse them")

    @property
    def closed(self) -> bool:
        """Whether the surface has no border."""
        return not (self.mesh.twin == BORDER).any()

    def on(self, model: Model) -> YarnTerm:
        """Return the body on a model's device.

        Raises:
            ParameterError: the yarns are on a lattice, or do not resist contact.
        """
        self.check_fits(model)
        return _Collision(model, self)

    def check_fits(self, model: Model) -> None:
        """Check that a body can be put beside a model's yarns.

        Raises:
            ParameterError: the yarns are on a lattice, or do not resist contact.
        """
        if model.yarns.lattice is not None:
            raise ParameterError("body: got yarns on a lattice; a body does not repeat, take yarns without one")
        if model.material.k_contact == 0.0:
            raise ParameterError("body: got a material of k_contact 0, from which its stiffness comes; raise it")


class _Collision(YarnTerm):
    """A body on a device."""

    name = "body"
    gives_hessian = True

    def __init__(self, model: Model, body: Body) -> None:
        self.model = model
        self.closed = body.closed
        self.surface = put_surface(model, body.mesh)
        self.thickness = model.number(body.thickness / model.unit)
        stiffness = model.number(2.0 * model.material.k_contact * body.stiffness)
        self.inputs = [model.constants, self.surface.constants, self.thickness, stiffness]
        self.measured = model.empty(model.sample_count, 4)
        self.measured.fill_(NOWHERE)
        self.found_stiffness = wp.zeros(model.sample_count, dtype=vector(6, model.scalar), device=model.device)
        self._energy = model.empty(model.sample_count)
        self.list_count = model.integers(np.zeros(model.sample_count))
        self.listed = allocate_lists(model.sample_count, LIST, model.device)

    def forces(self, state: State, force: YarnForces, launcher: Launcher) -> list[Any]:
        """Add the push on each sample to the samples."""
        outputs = [self.measured, self.list_count, self.listed, force.samples]
        return [launcher(body_forces, self.model.sample_count, [*self.inputs, state.samples], outputs)]

    def sample_stiffness(self, state: State, exact: wp.array[Any], launcher: Launcher) -> SampleStiffness:
        """Return the second derivatives of the penalty of each sample (``body_penalty``)."""
        inputs = [*self.inputs, exact, state.samples]
        launch = launcher(body_stiffness, self.model.sample_count, inputs, [self.found_stiffness])
        return SampleStiffness(self.found_stiffness, [launch])

    def element_energies(self, state: State, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """Return the launch that finds the energy of each sample, and the array of the energies."""
        inputs = [*self.inputs, state.samples]
        return [launcher(body_energies, len(self._energy), inputs, [self._energy])], self._energy

    def renew(self, state: State, candidates: Candidates, cells: NDArray[np.bool_] | None = None) -> None:
        """Check that no sample is too deep in a closed body to be found.

        Raises:
            SolverError: a sample is too deep; the message names the yarn and the stitch face.
        """
        if not self.closed:
            return
        gap = self.model.empty(self.model.sample_count)
        inputs = [self.surface.constants, self.thickness, self.model.number(1e30), state.samples]
        self.model.launch(body_gaps, self.model.sample_count, inputs, [gap])
        if minimum(gap) < -DEPTH:
            raise SolverError(self._too_deep(gap.numpy()))

    def _too_deep(self, gap: NDArray[Any]) -> str:
        model = self.model
        sample = int(gap.argmin())
        segment = int(np.searchsorted(model.sample_start, sample, side="right") - 1)
        place = yarn_place(model.yarns, int(model.yarns.segment_points[segment, 1]))
        reach = float(model.radius[model.yarns.segment_yarn[segment]] + self.thickness) * model.unit
        depth, most = -float(gap[sample]) * reach, DEPTH * reach
        found = f"{place}: {depth:.3g} cm inside the body; expected at most {most:.3g}"
        return f"{found}; give the fabric of the yarns, with which they are moved out first, or move the body"


def put_surface(model: Model, mesh: Mesh) -> BodySurface:
    """Send a mesh to the device of a model."""
    features = mesh_features(mesh)
    corners = model.to_device(features.corners.reshape(-1, 3)).reshape(-1, 3, 3)
    return surface_of(replace(features, corners=corners), model.scalar, model.device)
