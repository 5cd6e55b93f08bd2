# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy of B-spline yarns as a term of the mixed system: stretch, length, bending and contact of ``yarnrelax``.

    E = sum over segments s of  alpha_s (stretch + length + bending)_s
      + sum over pairs of contact samples p, q of  (alpha_p alpha_q)^(1/2) contact_pq        [erg]

alpha_s is the weight of a segment (``spline_pieces``) and of its samples. The weight of a pair is the geometric mean of
the weights of its two samples. It differs from alpha at the centroid by the square of their difference, and each sample
carries its own part of it. Control points are nodes, or they lie beside the region and triangles carry them
(``carried_points``).

No move lets a yarn pass through another one. Each control point has a step budget around the place where the candidate
lists were made. The budget is less than half the clearance of the yarn that the point shapes
(``yarnrelax.collision.step_limit``). A move of the mixed system is one direction for all nodes. It is shortened until
every control point keeps its budget, relative to the mean motion of all points, which changes no distance.
Where a direction leads beyond the remaining budgets, the lists are made again first.

*Units.* The yarn model measures lengths in yarn radii r from an origin o: q = (p - o) / r (``yarnrelax.model``). Forces
on p are forces on q over r, and second derivatives by p are second derivatives by q over r^2. The blocks on the
diagonal of the Hessian at a control point are sums over its four segments, where k is its place among the control
points of a segment:

    sum of  (D_k - D_(k-1))' H (D_k - D_(k-1))        H by the three legs, D_j the part of leg j
    sum of  B_k(s_i)^2 (a a^T - b I)                  over the samples s_i and the pairs that touch them

The second sum leaves out pairs whose two samples both depend on the control point. They are rare, and the blocks serve
only as a metric.

*Moves.* ``longest_move`` finds the longest move along a direction on which each control point stays within its step
budget. With the displacement d since the lists were made, the motion u and the budget R of a control point, the move t
u leaves the ball |d + t u| <= R at

    t = (R^2 - d^2) / (d.u + ((d.u)^2 + u^2 (R^2 - d^2))^(1/2))

in the form of the root without cancellation where d.u > 0.

Distances between yarns do not change when all yarns move alike. Displacements and motions are therefore relative to
their means over all control points.
"""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import Mat33, Scalar, ScalarType, Vec3, Vec4, vector
from stitchmesh.compute.reduction import minimum
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.splines.carried_points import Carrier
from stitchmesh.mixed.splines.spline_pieces import SplineMaterial, SplinePieces
from stitchmesh.mixed.term import MixedTerm, keep_share
from stitchmesh.yarnrelax.collision.captured_search import ContactSearch
from stitchmesh.yarnrelax.collision.narrow_phase import WIDEST_MARGIN, make_candidates
from stitchmesh.yarnrelax.energies.by_term import contact_energies, segment_energies
from stitchmesh.yarnrelax.energies.evaluation import force_launches
from stitchmesh.yarnrelax.hessian.hessian_product import Hessian
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.spline import place_contact_samples, weight_row
from stitchmesh.yarnrelax.model.state import State, make_state
from stitchmesh.yarnrelax.model.upload import put_model


@kernel
def place_points(
    # model
    node: wp.array[wp.int32],
    origin: Vec3,
    per_unit: Scalar,
    # state in
    nodes: wp.array[Vec3],
    # state out
    points: wp.array[Vec3],
) -> None:
    """The control points of the yarn model that are nodes; with an origin of zero also directions."""
    k = wp.tid()
    if node[k] >= 0:
        points[k] = (nodes[node[k]] - origin) * per_unit


@kernel
def add_to_nodes(
    # model
    node: wp.array[wp.int32],
    factor: Scalar,
    # state in
    values: wp.array[Vec3],
    # state in and out
    nodes: wp.array[Vec3],
) -> None:
    """Add a multiple of the vector of each control point to its node; no node occurs twice."""
    k = wp.tid()
    if node[k] >= 0:
        nodes[node[k]] = nodes[node[k]] + values[k] * factor


@wp.func
def leg_block(leg_hessian: wp.array2d[Mat33], s: int, slot: int) -> Any:
    """Second derivative of the energy of a segment by the control point in a slot."""
    block = leg_hessian[0, s]
    if slot == 1:
        block = leg_hessian[0, s] + leg_hessian[3, s] - leg_hessian[1, s] - wp.transpose(leg_hessian[1, s])
    if slot == 2:
        block = leg_hessian[3, s] + leg_hessian[5, s] - leg_hessian[4, s] - wp.transpose(leg_hessian[4, s])
    if slot == 3:
        block = leg_hessian[5, s] + leg_hessian[5, s] * type(leg_hessian[5, s][0, 0])(0.0)
    return block


@kernel
def add_point_blocks(
    # model
    model: YarnConstants,
    node: wp.array[wp.int32],
    factor: Scalar,
    # state in
    leg_hessian: wp.array2d[Mat33],
    touching_count: wp.array[wp.int32],
    stiffness: wp.array2d[Vec4],
    # state in and out
    blocks: wp.array[Mat33],
) -> None:
    """Add a multiple of the block of each control point to that of its node."""
    i = wp.tid()
    if node[i] < 0:
        return
    slots = model.point_segments[i]
    total = blocks[node[i]] * (factor - factor)
    identity = wp.identity(n=3, dtype=type(factor))
    for slot in range(4):
        s = slots[slot]
        if s >= 0:
            total += leg_block(leg_hessian, s, slot)
            first = model.sample_start[s]
            count = model.sample_start[s + 1] - first
            row = weight_row(model, count, 0)
            for k in range(count):
                weight = model.sample_basis[row + k][slot]
                for c in range(touching_count[first + k]):
                    pair = stiffness[first + k, c]
                    apart = wp.vector(pair[0], pair[1], pair[2])
                    total += (wp.outer(apart, apart) - identity * pair[3]) * (weight * weight)
    blocks[node[i]] = blocks[node[i]] + total * factor


@kernel
def moves_within_budgets(
    # model
    mean_displacement: Vec3,
    mean_motion: Vec3,
    # state in
    points: wp.array[Vec3],
    listed_points: wp.array[Vec3],
    budget: wp.array[Scalar],
    motion: wp.array[Vec3],
    # state out
    limit: wp.array[Scalar],
) -> None:
    """The part of the motion of each control point that keeps its budget, at most 1."""
    i = wp.tid()
    d, u = points[i] - listed_points[i] - mean_displacement, motion[i] - mean_motion
    radius = budget[i] * type(budget[i])(1.0)
    zero, one = radius - radius, type(radius)(1.0)
    room = wp.max(radius * radius - wp.dot(d, d), zero)
    along, square = wp.dot(d, u), wp.dot(u, u)
    longest = one
    if square > zero:
        root = wp.sqrt(along * along + square * room)
        if along > zero:
            longest = room / (along + root)
        else:
            longest = (root - along) / square
    limit[i] = wp.min(longest, one)


def longest_move(model: Model, state: State, motion: wp.array[Any]) -> float:
    """The part of a motion, in [0, 1], on which all control points stay within their budgets.

    Args:
        model: the yarns.
        state: the yarns' control points, the points for which contacts were listed, and the budgets.
        motion: displacement of the control points for a part of 1 [units], shape (N, 3).
    """
    limit = model.empty(model.point_count)
    points, listed = (_mean(places) for places in (state.points, state.listed_points))
    means = [model.numbers(*mean) for mean in (points - listed, _mean(motion))]
    inputs = [*means, state.points, state.listed_points, state.budget, motion]
    model.launch(moves_within_budgets, model.point_count, inputs, [limit])
    return minimum(limit)


def _mean(vectors: wp.array[Any]) -> NDArray[np.float64]:
    """Mean of vectors, shape (3,)."""
    mean: NDArray[np.float64] = vectors.numpy().mean(axis=0, dtype=np.float64)
    return mean


class SplineTerm(MixedTerm):
    """Yarns as B-splines in contact, on a device."""

    name = "yarns"

    def __init__(
        self, pieces: SplinePieces, material: SplineMaterial, scalar: ScalarType, device: wp.Device, *,
        carrier: Carrier | None = None,
    ) -> None:  # fmt: skip
        """Send the pieces to the device, and list their contacts at their present places.

        Args:
            pieces: the yarns of the model, with their weights; they must have at least one segment.
            material: stiffnesses and sampling.
            scalar: Warp's floating-point type.
            device: where the kernels run.
            carrier: the control points that are not nodes, which triangles carry.

        Raises:
            ParameterError: there is no segment.
            SolverError: two yarns are too close to one another.
        """
        if pieces.curves is None:
            raise ParameterError("spline yarns: got no segment; expected at least one")
        self.model = _weighted_model(pieces, material, scalar, device)
        self.state = make_state(self.model)
        self._carrier = carrier
        self._node = self.model.integers(pieces.node)
        self._launch = partial(launch, device=device)
        self._motion, self._product = self.model.empty(len(pieces.node), 3), self.model.empty(len(pieces.node), 3)
        self._no_stiffness = self.model.empty(self.model.point_count)
        counts = [*(3 * [self.model.segment_count]), self.model.sample_count]
        ends = np.cumsum([0, *counts]).tolist()
        self._energy = self.model.empty(ends[-1])
        self._energies = [self._energy[a:b] for a, b in pairwise(ends)]
        """Stretch, length and bending of segments, and contact of samples: parts of ``_energy``."""
        self._hessian: tuple[int, Hessian] | None = None
        self._candidates = make_candidates(self.model, WIDEST_MARGIN)
        self._search = ContactSearch(self.model, self.state, self._candidates)
        self._list_contacts()

    @property
    def generation(self) -> int:
        """Number of times that the candidate lists have grown."""
        return self._search.generation

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launches that find the weighted energy of each element, and the array of the energies.

        The candidate lists are complete within the limit of ``step_limit``.
        """
        model, points = self.model, self.state.points
        made = self._place(state, launcher)
        made.append(place_contact_samples(model, self.state, launcher))
        inputs = [model.constants, self.state.samples, self._candidates.count, self._candidates.lists]
        made.append(launcher(segment_energies, model.segment_count, [model.constants, points], self._energies[:3]))
        made.append(launcher(contact_energies, model.sample_count, inputs, [self._energies[3]]))
        return made, self._energy

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that place control points and samples, find the forces, and add them."""
        model = self.model
        made = self._place(state, launcher)
        made += force_launches(model, self.state, self._candidates, (), self._no_stiffness, launcher)
        return made + self._add(self.state.force, force, launcher)

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that find the blocks of all segments and the stiffness of all pairs that touch."""
        share, kept = self.model.number(self.exact), [self._whole_hessian.exact]
        made = [launcher(keep_share, self.model.segment_count, [share], kept), *self._place(state, launcher)]
        made.append(place_contact_samples(self.model, self.state, launcher))
        return made + self._whole_hessian.find_launches(launcher)

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add H d."""
        made = self._find_motion(direction, launcher)
        made += self._whole_hessian.product_launches(self._motion, self._product, launcher)
        return made + self._add(self._product, product, launcher)

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launch that adds the blocks of the nodes."""
        model, hessian = self.model, self._whole_hessian
        inputs = [model.constants, self._node, model.number(model.unit**-2), hessian.leg_hessian,
                  hessian.touching.count, hessian.touching.stiffness]  # fmt: skip
        return [launcher(add_point_blocks, model.point_count, inputs, [blocks.nodes])]

    def begin_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Turn the offsets of carried points with their triangles, and list the contacts."""
        if self._carrier is not None:
            self._carrier.turn(state.vertices)
        self._list_contacts_at(state)

    def step_limit(self, state: MixedVector, direction: MixedVector) -> float:
        """The part of a direction along which no yarn can pass through another one."""
        limit = self._limit(state, direction)
        if limit < 1.0:
            self._list_contacts_at(state)
            limit = self._limit(state, direction)
        return limit

    @property
    def _whole_hessian(self) -> Hessian:
        """The matrices of the Hessian, with room for all listed pairs."""
        if self._hessian is None or self._hessian[0] != self.generation:
            self._hessian = self.generation, Hessian(self.model, self.state, self._candidates)
        return self._hessian[1]

    def _place(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that set control points to the positions of their nodes, or where triangles carry them."""
        model, points = self.model, self.state.points
        origin, per_unit = vector(3, model.scalar)(*model.cells[0].origin.tolist()), self._per_unit
        made = [launcher(place_points, model.point_count, [self._node, origin, per_unit, state.nodes], [points])]
        if self._carrier is not None:
            made.append(self._carrier.place(state.vertices, points, origin, per_unit, launcher))
        return made

    def _find_motion(self, direction: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that find how a direction moves the control points."""
        model, origin, per_unit = self.model, vector(3, self.model.scalar)(), self._per_unit
        inputs = [self._node, origin, per_unit, direction.nodes]
        made = [launcher(place_points, model.point_count, inputs, [self._motion])]
        if self._carrier is not None:
            made.append(self._carrier.move(direction.vertices, self._motion, per_unit, launcher))
        return made

    def _add(self, values: wp.array[Any], target: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add forces on the control points to nodes and vertices."""
        inputs = [self._node, self._per_unit, values]
        made = [launcher(add_to_nodes, self.model.point_count, inputs, [target.nodes])]
        if self._carrier is not None:
            made.append(self._carrier.add(values, target.vertices, self._per_unit, launcher))
        return made

    @property
    def _per_unit(self) -> Any:
        """1 over the unit of the yarn model [1/cm]."""
        return self.model.number(1.0 / self.model.unit)

    def _limit(self, state: MixedVector, direction: MixedVector) -> float:
        self._place(state, self._launch)
        self._find_motion(direction, self._launch)
        return longest_move(self.model, self.state, self._motion)

    def _list_contacts_at(self, state: MixedVector) -> None:
        self._place(state, self._launch)
        self._list_contacts()

    def _list_contacts(self) -> None:
        """Make candidate lists and budgets for the present control points."""
        self._search.run()
        too_close = self._search.too_close()
        if too_close:
            raise SolverError(f"spline yarns: {too_close[0]}")


def _weighted_model(pieces: SplinePieces, material: SplineMaterial, scalar: ScalarType, device: wp.Device) -> Model:
    """The constants of the pieces on a device, with the stiffness of each segment and sample times its weight."""
    assert pieces.curves is not None
    model = put_model(
        pieces.curves,
        material.yarn,
        quadrature_points=material.quadrature_points,
        contact_samples=material.contact_samples,
        scalar=scalar,
        device=device,
    )
    of_sample = np.sqrt(np.repeat(pieces.alpha, np.diff(model.sample_start)))
    constants = model.constants
    constants.segment_stiffness = model.upload(model.segment_stiffness * pieces.alpha[:, None], 3)
    constants.sample_weight = model.upload(constants.sample_weight.numpy() * of_sample)
    constants.sample_stiffness = model.upload(constants.sample_stiffness.numpy() * of_sample)
    return model
