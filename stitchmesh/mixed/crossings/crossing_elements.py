# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The elements of crossing yarns: which nodes they join, their rest values, and their stiffness times weight."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial
from stitchmesh.mixed.crossings.merging import MERGING_SHARE

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
QUADRANTS = ((0, 2), (0, 3), (1, 2), (1, 3))
"""Legs of the four quadrants of a node; the rest angles of the second and the third one are supplements."""


@dataclass(frozen=True, eq=False)
class CrossingElements:
    """The elements of N crossing nodes, sorted by the node that they have their middle or their beginning in.

    Column 0 of a (N, 2) array belongs to the u yarn of a node and column 1 to its v yarn. A segment belongs to its first
    node. Stiffness is zero where an element does not exist.
    """

    link: Integers
    """Neighbour after and before along the u yarn, after and before along the v yarn, as 2 j + c for the coordinate c of
    node j, or -1; shape (N, 4)."""
    slides: NDArray[np.bool_]
    """Whether each Eulerian coordinate is free, shape (N, 2)."""
    rest_length: Floats
    """Length of the segment after each node in the layout [cm], 0 without one; shape (N, 2)."""
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
    """Change of curvature beyond which bending stays [1/cm], shape (N, 2)."""
    shear: Floats
    """k_x L of the four ``QUADRANTS`` [dyn cm], shape (N, 4)."""
    rest_shear: Floats
    """Angle between the first legs of u yarn and v yarn in the layout, shape (N,)."""
    density: Floats
    """Linear density of the segment times its weight [g/cm], shape (N, 2)."""

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
        distance: Floats = MERGING_SHARE * np.minimum(self.rest_length, np.where(self.contact > 0, self.contact_distance, np.inf))
        return distance


def crossing_elements(
    link: ArrayLike,
    rest_sliding: ArrayLike,
    rest_position: ArrayLike,
    side: ArrayLike,
    materials: tuple[CrossingMaterial, CrossingMaterial],
    *,
    weight: ArrayLike | None = None,
    slides: ArrayLike | None = None,
    touches: ArrayLike | None = None,
    shears: bool = True,
) -> CrossingElements:
    """The elements of yarns as they are laid out.

    Args:
        link: as ``CrossingElements.link``, shape (N, 4).
        rest_sliding: Eulerian coordinates in the layout, the rest lengths of yarn from its beginning [cm], shape (N, 2).
        rest_position: positions of the nodes in the layout [cm], shape (N, 2) or (N, 3).
        side: +1 where the u yarn lies above the v yarn, -1 where it lies below; shape (N,).
        materials: of all u yarns and of all v yarns.
        weight: alpha of each node; an element has the mean of its nodes as weight. Shape (N,); 1 if it is None.
        slides: whether the Eulerian coordinates of each node are free, shape (N,) or (N, 2); all if it is None.
        touches: whether the segment after each node has yarns beside it that it holds apart, shape (N, 2); all segments
            if it is None. The segments within a stitch contact of a knit have none.
        shears: whether quadrants resist shear, as in a weave.

    Raises:
        ParameterError: an array has another shape, a link is not the number of a coordinate or has no opposite, or a
            rest length is not positive.
    """
    links = np.asarray(link, dtype=np.int64)
    count = len(links)
    coordinates = _shaped("rest_sliding", rest_sliding, count, 2)
    position = _flat_positions(rest_position, count)
    alpha = np.ones(count) if weight is None else np.asarray(weight, dtype=np.float64)
    free = np.ones(count, dtype=bool) if slides is None else np.asarray(slides, dtype=bool)
    touching = np.ones((count, 2), dtype=bool) if touches is None else np.asarray(touches, dtype=bool)
    _check_links(links)
    rest = _rest_lengths(links, coordinates)
    exists = rest > 0.0
    turning = exists & (links[:, 1::2] >= 0)
    after, before = _neighbours(links[:, 0::2]), _neighbours(links[:, 1::2])
    segment_weight = (alpha[:, None] + alpha[after]) / 2 * exists
    bend_weight = (alpha[:, None] + alpha[after] + alpha[before]) / 3 * turning
    distance = _contact_distances(np.asarray(side), after, materials, rest)
    return CrossingElements(
        link=links,
        slides=np.array(np.broadcast_to(free if free.ndim == 2 else free[:, None], (count, 2))),
        rest_length=rest,
        stretch=segment_weight * [m.stretch_stiffness for m in materials],
        contact=segment_weight * touching * rest * [m.contact for m in materials],
        contact_distance=distance,
        bending=bend_weight * [m.bending_stiffness for m in materials],
        rest_turn=_turns(position, before, after) * turning,
        yield_curvature=np.broadcast_to([m.yield_curvature for m in materials], (count, 2)).copy(),
        shear=_shear_stiffness(links, alpha, rest, materials) * shears,
        rest_shear=_rest_shear(links, position),
        density=segment_weight * [m.density for m in materials],
    )


def _shaped(name: str, values: ArrayLike, count: int, width: int) -> Floats:
    array = np.asarray(values, dtype=np.float64)
    if array.shape != (count, width):
        raise ParameterError(f"crossing elements: {name} has the shape {array.shape}; expected ({count}, {width})")
    return array


def _flat_positions(position: ArrayLike, count: int) -> Floats:
    """Positions in three dimensions."""
    array = np.asarray(position, dtype=np.float64)
    if array.shape == (count, 2):
        array = np.column_stack([array, np.zeros(count)])
    return _shaped("rest_position", array, count, 3)


def _check_links(links: Integers) -> None:
    """Refuse links that do not lead back."""
    if links.ndim != 2 or links.shape[1] != 4:
        raise ParameterError(f"crossing elements: link has the shape {links.shape}; expected (N, 4)")
    wrong = np.argwhere((links < -1) | (links >= 2 * len(links)))
    if len(wrong):
        i, k = wrong[0]
        raise ParameterError(f"crossing elements: link {k} of node {i} is {links[i, k]}; expected -1 to {2 * len(links) - 1}")
    i, k = np.nonzero(links >= 0)
    code = links[i, k]
    back = links[code // 2, 2 * (code % 2) + 1 - k % 2]
    wrong = np.flatnonzero(back != 2 * i + k // 2)
    if len(wrong):
        at, leg = i[wrong[0]], k[wrong[0]]
        found = f"node {at} has node {links[at, leg] // 2} on leg {leg}, which has another neighbour there"
        raise ParameterError(f"crossing elements: {found}; expected links that lead back")


def _neighbours(links: Integers) -> Integers:
    """Nodes of links; the node itself without one."""
    own = np.arange(len(links))[:, None]
    return np.where(links >= 0, links // 2, own)


def _rest_lengths(links: Integers, coordinates: Floats) -> Floats:
    """Rest length of the segment after each node, 0 without one."""
    after = links[:, 0::2]
    length = np.where(after >= 0, coordinates.reshape(-1)[np.maximum(after, 0)] - coordinates, 0.0)
    wrong = np.argwhere((after >= 0) & ~(length > 0.0))
    if len(wrong):
        i, c = wrong[0]
        found = f"the segment after node {i} along yarn {'uv'[c]} has the rest length {length[i, c]:g} cm"
        raise ParameterError(f"crossing elements: {found}; expected coordinates that increase along a yarn")
    return length


def _contact_distances(side: NDArray[Any], after: Integers, materials: tuple[CrossingMaterial, ...], rest: Floats) -> Floats:
    """4 R where the yarn changes its side and 2 R where it does not, at most the rest length."""
    changes = side[:, None] != side[after]
    radius = np.array([materials[1].radius, materials[0].radius])  # the yarns that touch are those that are crossed
    bound: Floats = np.minimum(np.where(changes, 4.0, 2.0) * radius, rest)
    return bound


def _turns(position: Floats, before: Integers, after: Integers) -> Floats:
    """Angle by which each yarn turns at each node in the layout."""
    return _angles(position[:, None] - position[before], position[after] - position[:, None])


def _angles(a: Floats, b: Floats) -> Floats:
    """Angle between vectors; 0 where one has no length."""
    angle: Floats = np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.einsum("...i,...i", a, b))
    return np.where(angle < 1e-6, 0.0, angle)  # a straight line of rounded positions has no rest angle


def _shear_stiffness(links: Integers, alpha: Floats, rest: Floats, materials: tuple[CrossingMaterial, ...]) -> Floats:
    """k_x L of the quadrants; L is the mean length of both segments and S R^2 that of the two yarns."""
    modulus = 0.5 * (materials[0].shear + materials[1].shear) * materials[0].radius * materials[1].radius
    result = np.zeros(links.shape)
    lengths, ends = _leg_lengths(links, rest), _neighbours(links)
    for q, (u, v) in enumerate(QUADRANTS):
        exists = (links[:, u] >= 0) & (links[:, v] >= 0)
        weight = (alpha + alpha[ends[:, u]] + alpha[ends[:, v]]) / 3
        result[:, q] = exists * weight * modulus * (lengths[:, u] + lengths[:, v]) / 2
    return result


def _leg_lengths(links: Integers, rest: Floats) -> Floats:
    """Rest length of each leg, shape (N, 4)."""
    lengths = np.repeat(rest, 2, axis=1)
    lengths[:, 1::2] = np.where(links[:, 1::2] >= 0, rest.reshape(-1)[np.maximum(links[:, 1::2], 0)], 0.0)
    return lengths


def _rest_shear(links: Integers, position: Floats) -> Floats:
    """Angle between the direction of the u yarn and that of the v yarn in the layout; a right angle without one."""
    ends = position[_neighbours(links)]
    along, across = ends[:, 0] - ends[:, 1], ends[:, 2] - ends[:, 3]
    flat = (np.linalg.norm(along, axis=1) > 0.0) & (np.linalg.norm(across, axis=1) > 0.0)
    return np.where(flat, _angles(along, across), np.pi / 2)
