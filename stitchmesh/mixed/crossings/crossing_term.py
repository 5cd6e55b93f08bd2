# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The elastic energy of crossing yarns as a term of the mixed system: stretch, contact, bending and shear.

``CrossingElements`` say which nodes the elements join, their rest values, and their stiffness times weight.

Products with the Hessian come from the blocks of each star, which are computed once for a state and stored.

*The longest step.* Along a direction, no segment of yarn may lose more than a share of its rest length. A line search
starts with this step. Nodes that slide towards one another then come closer by a bounded factor and never pass:
D + t dD >= (1 - share) D. If a segment is already shorter than its merging distance e, it may lose the share of e
(``crossing_energies``).

*Yield of bending.* A yarn that is bent too far keeps a part of the bend. At a node with the angle t, the rest angle r
and the span D, the change of curvature from rest is 2 (t - r) / D (``crossing_energies``). Beyond the yield curvature
kappa_y the rest angle follows (ideal plasticity):

    r <- t - max(-y, min(t - r, y)),    y = kappa_y D / 2

The rest angle changes once a step, after the step is accepted, so that a step has one elastic energy.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import Scalar, ScalarType, Vec2, Vec3, Vec4, vector
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.crossings.crossing_material import FabricMaterials
from stitchmesh.mixed.crossings.energies.crossing_energies import MERGING_SHARE, angle_of, place_of
from stitchmesh.mixed.crossings.star.star import (
    add_star_diagonal,
    add_star_slots,
    coordinate_of,
    find_star_blocks,
    find_star_energies,
    find_star_forces,
    leg_of,
    multiply_star_blocks,
)
from stitchmesh.mixed.crossings.star.star_memory import BLOCK_NUMBERS, LEG_NUMBERS, numbers_of
from stitchmesh.mixed.layout.crossing_yarns import NO_NODE, CrossingYarns
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import FULL, MixedTerm, element_weight

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Truths = NDArray[np.bool_]
QUADRANTS = ((0, 2), (0, 3), (1, 2), (1, 3))
"""The two legs of each of the four quadrants of a node; the rest angles of the second and third are supplements."""


@dataclass(frozen=True, eq=False)
class CrossingElements:
    """The elements of the N simulated nodes. An element belongs to the node at its middle, or at its beginning.

    Column 0 of a (N, 2) array belongs to the u yarn of a node and column 1 to its v yarn. A segment belongs to its
    first node. Stiffness is zero where an element does not exist.
    """

    nodes: Integers
    """Number of each node in the layout, shape (N,)."""
    link: Integers
    """Neighbours after and before along the u yarn, then after and before along the v yarn, shape (N, 4). A neighbour
    is 2 j + c, for the coordinate c of node j, or -1."""
    side: Integers
    """1 where the u yarn lies above the v yarn, -1 where it lies below, 0 where both are joined; shape (N,)."""
    slides: Truths
    """Whether each Eulerian coordinate is free, shape (N, 2)."""
    rest_sliding: Floats
    """Eulerian coordinates in the layout [cm], shape (N, 2)."""
    rest_length: Floats
    """Rest length of the segment after each node in the layout [cm], shape (N, 2); 0 without a segment."""
    stretch: Floats
    """k_s of the segment [dyn], shape (N, 2)."""
    contact: Floats
    """k_c L of the segment [dyn/cm], shape (N, 2)."""
    contact_distance: Floats
    """d of the segment [cm], shape (N, 2)."""
    bending: Floats
    """k_b at the node [dyn cm^2], shape (N, 2)."""
    rest_turn: Floats
    """Angle by which the yarn turns at the node in the layout, shape (N, 2)."""
    yield_curvature: Floats
    """Change of curvature beyond which a bend becomes permanent [1/cm], shape (N, 2)."""
    shear: Floats
    """k_x L of each of the four ``QUADRANTS`` [dyn cm], shape (N, 4)."""
    rest_shear: Floats
    """Angle between the u yarn and the v yarn in the layout, shape (N,)."""
    density: Floats
    """Linear density of the segment times its weight [g/cm], shape (N, 2)."""
    radius: Floats
    """Radius of the yarn [cm], shape (N, 2)."""
    friction: Floats
    """Coefficient of friction of the crossing, shape (N,)."""
    friction_stiffness: Floats
    """k_f of each coordinate along which a yarn slides through a crossing [dyn/cm], shape (N, 2)."""

    def __post_init__(self) -> None:
        for field in fields(self):
            getattr(self, field.name).flags.writeable = False

    @property
    def count(self) -> int:
        """Number N of nodes."""
        return len(self.link)

    @property
    def merging_distance(self) -> Floats:
        """Rest length of each segment below which its energies continue without singularity [cm], shape (N, 2)."""
        touch = np.where(self.contact > 0.0, self.contact_distance, np.inf)
        distance: Floats = MERGING_SHARE * np.minimum(self.rest_length, touch)
        return distance


def crossing_elements(
    yarns: CrossingYarns,
    materials: FabricMaterials,
    *,
    nodes: ArrayLike | None = None,
    alpha: ArrayLike | None = None,
    full: ArrayLike | None = None,
    slides: ArrayLike | None = None,
) -> CrossingElements:
    """The elements of yarns as they are laid out.

    Args:
        yarns: the layout.
        materials: materials of the families of yarns.
        nodes: layout numbers of the simulated nodes, ascending, shape (N,); all nodes if it is None. Elements with
            other nodes are left out.
        alpha: blending field at the simulated nodes, in [0, 1], shape (N,); 1 if it is None. The weight of an element
            is the mean over its nodes.
        full: nodes of the full-yarn region, whose elements have the weight 1 (``term``), shape (N,); none by default.
        slides: whether Eulerian coordinates are free, shape (N, 2). If it is None, a coordinate is free if its node
            lies between two simulated neighbours of the yarn, all three nodes have alpha = 1, and no rod is there. The
            ends of yarns hold their yarn, and so do nodes at the border of a region without Eulerian coordinates.

    Raises:
        ParameterError: nodes are not ascending numbers of the layout, or an array has the wrong shape.
    """
    chosen = _checked_nodes(nodes, yarns.node_count)
    count = len(chosen)
    blend = _shaped("alpha", np.ones(count) if alpha is None else alpha, (count,))
    links = _links_among(yarns.links[chosen], chosen, yarns.node_count)
    family = np.where(yarns.node_yarn < 0, 0, yarns.yarn_family[yarns.node_yarn])[chosen]
    after, before = _neighbours(links[:, 0::2]), _neighbours(links[:, 1::2])
    rest = _rest_lengths(links, yarns.rest_sliding[chosen])
    bends = (links[:, 0::2] >= 0) & (links[:, 1::2] >= 0)
    whole = np.zeros(count, dtype=bool) if full is None else _shaped("full", full, (count,)).astype(bool)
    of_segment = _weights(blend, whole, links[:, 0::2] >= 0, after)
    of_bend = _weights(blend, whole, bends, after, before)
    free = _sliding(links, blend, yarns.side[chosen]) if slides is None else np.asarray(slides, dtype=bool)
    crossed = (yarns.node_yarn[chosen] >= 0).all(axis=1) & (yarns.side[chosen] != 0)
    return CrossingElements(
        nodes=chosen,
        link=links,
        side=yarns.side[chosen].copy(),
        slides=_shaped("slides", free, (count, 2)).astype(bool),
        rest_sliding=yarns.rest_sliding[chosen].copy(),
        rest_length=rest,
        stretch=of_segment * _values(materials, family, "stretch_stiffness"),
        contact=of_segment * _touches(yarns, chosen) * rest * _values(materials, family, "contact"),
        contact_distance=_contact_distances(yarns.side[chosen], after, materials, family, rest),
        bending=of_bend * _values(materials, family, "bending_stiffness"),
        rest_turn=yarns.rest_turn[chosen] * bends,
        yield_curvature=_values(materials, family, "yield_curvature"),
        shear=_shear_stiffness(links, (blend, whole), rest, materials, family)
        * ((yarns.kind == "weave") & crossed)[:, None],
        rest_shear=yarns.rest_shear[chosen].copy(),
        density=of_segment * _values(materials, family, "density"),
        radius=_values(materials, family, "radius"),
        friction=_values(materials, family, "friction").mean(axis=1),
        friction_stiffness=_values(materials, family, "friction_stiffness") * crossed[:, None],
    )


def _checked_nodes(nodes: ArrayLike | None, count: int) -> Integers:
    """The simulated nodes."""
    chosen = np.arange(count) if nodes is None else np.array(nodes, dtype=np.int64)
    if chosen.ndim != 1 or (len(chosen) and (chosen[0] < 0 or chosen[-1] >= count or (np.diff(chosen) <= 0).any())):
        raise ParameterError(f"crossing elements: nodes: expected ascending numbers from 0 to {count - 1}")
    return chosen


def _shaped(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Floats:
    array = np.array(values, dtype=np.float64)
    if array.shape != shape:
        raise ParameterError(f"crossing elements: {name} has the shape {array.shape}; expected {shape}")
    return array


def _links_among(links: Integers, chosen: Integers, count: int) -> Integers:
    """Links in the numbers of the simulated nodes, without links to other nodes."""
    number = np.full(count + 1, NO_NODE)
    number[chosen] = np.arange(len(chosen))
    node = number[np.where(links < 0, count, links // 2)]
    return np.where(node < 0, NO_NODE, 2 * node + links % 2)


def _neighbours(links: Integers) -> Integers:
    """The node of each link, or the node itself where there is no link."""
    own = np.arange(len(links))[:, None]
    return np.where(links >= 0, links // 2, own)


def _rest_lengths(links: Integers, coordinates: Floats) -> Floats:
    """Rest length of the segment after each node, 0 without one."""
    after = links[:, 0::2]
    return np.where(after >= 0, coordinates.reshape(-1)[np.maximum(after, 0)] - coordinates, 0.0)


def _weights(alpha: Floats, full: Truths, exists: Truths, *others: Integers) -> Floats:
    """Weights of the elements that join each node to others, with the shape of ``exists``; 0 where there is none."""
    own = np.arange(len(alpha)).reshape(-1, *[1] * (exists.ndim - 1))
    nodes = np.stack(np.broadcast_arrays(own, *others), axis=-1).reshape(-1, 1 + len(others))
    weight = element_weight(alpha[nodes], np.ones(nodes.shape, dtype=bool), full[nodes])
    return np.where(exists, weight.reshape(exists.shape), 0.0)


def _sliding(links: Integers, alpha: Floats, side: Integers) -> Truths:
    """Whether a coordinate lies between two neighbours of its yarn, and all three nodes have Eulerian coordinates."""
    full = alpha >= FULL
    neighbours = full[_neighbours(links)] & (links >= 0)
    free: Truths = (full & (side != 0))[:, None] & neighbours[:, 0::2] & neighbours[:, 1::2]
    return free


def _values(materials: FabricMaterials, family: Integers, name: str) -> Floats:
    """A field of the material of each yarn at each node, shape (N, 2)."""
    values: Floats = np.array([getattr(material, name) for material in materials.by_family], dtype=np.float64)[family]
    return values


def _touches(yarns: CrossingYarns, chosen: Integers) -> Truths:
    """Whether the segment after each node keeps the yarns at its ends apart, as all do outside of stitch contacts."""
    within = np.zeros((yarns.node_count, 2), dtype=bool)
    if len(yarns.stitch_contacts):
        pairs = np.concatenate([yarns.stitch_contacts, yarns.stitch_contacts[:, ::-1]])
        partner = np.full(yarns.node_count, NO_NODE)
        partner[pairs[:, 0]] = pairs[:, 1]
        within = (partner[:, None] == yarns.neighbours[:, 0::2]) & (partner >= 0)[:, None]
    return ~within[chosen]


def _contact_distances(
    side: Integers, after: Integers, materials: FabricMaterials, family: Integers, rest: Floats
) -> Floats:
    """Contact distances: 4 R where the yarn changes its side and 2 R where it does not, at most the rest length."""
    changes = side[:, None] != side[after]
    radius = _values(materials, family, "radius")[:, ::-1]  # the crossed yarns touch one another
    bound: Floats = np.minimum(np.where(changes, 4.0, 2.0) * radius, rest)
    return bound


def _shear_stiffness(
    links: Integers, blend: tuple[Floats, Truths], rest: Floats, materials: FabricMaterials, family: Integers
) -> Floats:
    """k_x L of the quadrants; L is the mean length of both segments, and S R^2 comes from the two yarns."""
    modulus = _values(materials, family, "shear").mean(axis=1)
    stiffness = modulus * _values(materials, family, "radius").prod(axis=1)
    result = np.zeros(links.shape)
    lengths, ends = _leg_lengths(links, rest), _neighbours(links)
    for q, (u, v) in enumerate(QUADRANTS):
        exists = (links[:, u] >= 0) & (links[:, v] >= 0)
        weight = _weights(*blend, exists, ends[:, u], ends[:, v])
        result[:, q] = weight * stiffness * (lengths[:, u] + lengths[:, v]) / 2
    return result


def _leg_lengths(links: Integers, rest: Floats) -> Floats:
    """Rest length of each leg, shape (N, 4)."""
    lengths = np.repeat(rest, 2, axis=1)
    lengths[:, 1::2] = np.where(links[:, 1::2] >= 0, rest.reshape(-1)[np.maximum(links[:, 1::2], 0)], 0.0)
    return lengths


@dataclass(frozen=True, eq=False)
class CrossingModel:
    """Constants of N crossing nodes on a device; ``CrossingElements`` defines the values."""

    link: wp.array[wp.int32]
    """Neighbours as 2 j + c, or -1; shape (N, 4)."""
    slides: wp.array[Any]
    """1 for each free Eulerian coordinate and 0 for each fixed one, two-vectors; shape (N,)."""
    segment: wp.array[Any]
    """k_s, k_c L, contact distance and merging distance of each segment, four-vectors; shape (N, 2)."""
    bend: wp.array[Any]
    """k_b and the merging distance of both segments together, two-vectors; shape (N, 2)."""
    shear: wp.array[Any]
    """k_x L of the quadrants, four-vectors; shape (N,)."""
    shear_rest: wp.array[Any]
    """Rest angle of the first quadrant, shape (N,)."""
    count: int
    """Number N of nodes."""

    @staticmethod
    def of(elements: CrossingElements, scalar: ScalarType, device: wp.Device) -> CrossingModel:
        """The constants of elements, in the precision of ``scalar``."""
        merging = elements.merging_distance
        before = elements.link[:, 1::2]
        span = merging + np.where(before >= 0, merging.reshape(-1)[np.maximum(before, 0)], 0.0)
        segment = [elements.stretch, elements.contact, elements.contact_distance, merging]

        def upload(values: Any, size: int = 1) -> wp.array[Any]:
            return wp.array(values, dtype=scalar if size == 1 else vector(size, scalar), device=device)

        return CrossingModel(
            link=wp.array(elements.link.astype(np.int32), dtype=wp.int32, device=device),
            slides=upload(elements.slides.astype(np.float64), 2),
            segment=upload(np.stack(segment, axis=-1), 4),
            bend=upload(np.stack([elements.bending, span], axis=-1), 2),
            shear=upload(elements.shear, 4),
            shear_rest=upload(elements.rest_shear),
            count=elements.count,
        )

    @property
    def constants(self) -> list[Any]:
        """The first arguments of the kernels over stars."""
        return [self.link, self.segment, self.bend, self.shear, self.shear_rest]


@kernel
def find_step_limits(
    # model
    link: wp.array2d[wp.int32],
    slides: wp.array[Vec2],
    segment: wp.array2d[Vec4],
    share: Scalar,
    # state in
    sliding: wp.array[Vec2],
    direction: wp.array[Vec2],
    # state out
    limit: wp.array[Scalar],
) -> None:
    """Longest step of the segments after each node, at most 1."""
    i = wp.tid()
    one = type(share)(1.0)
    longest = type(share)(1.0)
    for c in range(2):
        after = link[i, 2 * c]
        if after >= 0:
            rest = coordinate_of(after, sliding, one) - sliding[i][c]
            ahead = coordinate_of(after, direction, one) * coordinate_of(after, slides, one)
            loss = direction[i][c] * slides[i][c] - ahead
            allowed = share * wp.max(rest, segment[i, c][3])
            if loss * longest > allowed:
                longest = allowed / loss
    limit[i] = longest


@kernel
def turn_after_yield(
    # model
    link: wp.array2d[wp.int32],
    yield_curvature: wp.array2d[Scalar],
    # state in
    nodes: wp.array[Vec3],
    sliding: wp.array[Vec2],
    # state out
    turn: wp.array2d[Scalar],
) -> None:
    """Let the rest angles of both yarns of each node follow the angles beyond their limits."""
    i = wp.tid()
    n = int(2)
    for c in range(n):
        after, before = link[i, 2 * c], link[i, 2 * c + 1]
        if after >= 0 and before >= 0:
            leg, other = leg_of(link, nodes, sliding, i, 2 * c), leg_of(link, nodes, sliding, i, 2 * c + 1)
            angle, span = angle_of(-place_of(other), place_of(leg)), leg[3] - other[3]
            most = yield_curvature[i, c] * span * type(span)(0.5)
            turn[i, c] = angle - wp.clamp(angle - turn[i, c], -most, most)


class CrossingTerm(MixedTerm):
    """Stretch, contact of parallel yarns, bending and shear of crossing yarns on a device.

    The rest angles of bending last from step to step; yield changes them at the end of a step.
    """

    name = "crossing yarns"
    acts_on = "nodes"

    def __init__(
        self,
        elements: CrossingElements,
        scalar: ScalarType,
        device: wp.Device,
        *,
        block_scalar: ScalarType = wp.float32,
    ) -> None:
        """Put the elements on a device.

        Args:
            elements: the yarns.
            scalar: Warp's floating-point type.
            device: where the term lies.
            block_scalar: floating-point type of the blocks of the Hessian, which take 160 scalars for each node.
                Newton's method does not need more than single precision: the forces that it brings to zero have the
                precision of ``scalar``.
        """
        self.model = CrossingModel.of(elements, scalar, device)
        count, self.device = elements.count, device
        self.turn = wp.array(elements.rest_turn, dtype=scalar, device=device)
        self._yields = bool(np.isfinite(elements.yield_curvature[elements.bending > 0.0]).any())
        self._yield_curvature = wp.array(elements.yield_curvature, dtype=scalar, device=device)
        places = numbers_of(count, LEG_NUMBERS)
        self._slots = wp.zeros(places, dtype=scalar, device=device)
        self._product_slots = wp.zeros(places, dtype=block_scalar, device=device)
        self._limits = wp.zeros(count, dtype=scalar, device=device)
        self._energy = wp.zeros(count, dtype=wp.float64, device=device)
        self._block = wp.zeros(numbers_of(count, BLOCK_NUMBERS), dtype=block_scalar, device=device)
        self._scalar = scalar

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of each star, and the array of the energies."""
        inputs = [*self.model.constants, self.turn, state.nodes, state.sliding]
        return [launcher(find_star_energies, self.model.count, inputs, [self._energy])], self._energy

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The forces of all stars, and their sums at the nodes."""
        inputs = [*self.model.constants, self.turn, state.nodes, state.sliding]
        own = launcher(find_star_forces, self.model.count, inputs, [self._slots])
        return [own, self._gather(self._slots, force, launcher)]

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launch that finds the blocks."""
        exact = self._scalar(self.exact)
        inputs = [*self.model.constants, exact, self.turn, state.nodes, state.sliding]
        return [launcher(find_star_blocks, self.model.count, inputs, [self._block])]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The products of all stars, and their sums at the nodes."""
        given = [direction.nodes, direction.sliding]
        inputs = [self.model.link, self.model.slides, self.model.shear, self._block, *given]
        own = launcher(multiply_star_blocks, self.model.count, inputs, [self._product_slots])
        return [own, self._gather(self._product_slots, product, launcher)]

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launch that adds the diagonal blocks."""
        inputs = [self.model.link, self.model.slides, self._block]
        outputs = [blocks.nodes, blocks.sliding, blocks.coupling_u, blocks.coupling_v]
        return [launcher(add_star_diagonal, self.model.count, inputs, outputs)]

    def element_limits(
        self, state: MixedVector, direction: MixedVector, launcher: Launcher
    ) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the part of a direction along which no segment loses half of its rest length."""
        model, half = self.model, state.scalar(0.5)
        inputs = [model.link, model.slides, model.segment, half, state.sliding, direction.sliding]
        return [launcher(find_step_limits, model.count, inputs, [self._limits])], self._limits

    def end_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Let the yarns yield."""
        if self._yields:
            inputs = [self.model.link, self._yield_curvature, state.nodes, state.sliding]
            launch(turn_after_yield, self.model.count, inputs, [self.turn], self.device)

    def arrays(self) -> dict[str, Any]:
        """The rest angles of bending."""
        return {"yarn rest angles": self.turn}

    def _gather(self, slots: wp.array[Any], target: MixedVector, launcher: Launcher) -> Any:
        """The launch that adds up the slots of each node."""
        inputs = [self.model.link, self.model.slides, slots]
        return launcher(add_star_slots, self.model.count, inputs, [target.nodes, target.sliding])
