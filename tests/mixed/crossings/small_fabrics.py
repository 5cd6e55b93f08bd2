# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Small weaves and single yarns made by hand, and functions that apply terms to NumPy arrays."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.compute.launch import launch
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial, FabricMaterials
from stitchmesh.mixed.crossings.crossing_term import CrossingElements, crossing_elements
from stitchmesh.mixed.layout.crossing_yarns import WARP, WEFT, CrossingYarns
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import MixedTerm

CPU = device_named("cpu")
RUN = partial(launch, device=CPU)
YARN = CrossingMaterial.named("gong-1")


@dataclass(frozen=True)
class Fabric:
    """Yarns as laid out, with the positions of their nodes in space."""

    yarns: CrossingYarns
    position: np.ndarray

    @property
    def sliding(self) -> np.ndarray:
        return self.yarns.rest_sliding

    def elements(self, material: CrossingMaterial = YARN, **changes) -> CrossingElements:
        """The elements with one material; all coordinates are free, unless it is said otherwise."""
        slides = np.asarray(changes.pop("slides", np.ones(len(self.position))), dtype=bool)
        slides = np.repeat(slides[:, None], 2, axis=1)
        return crossing_elements(self.yarns, FabricMaterials.of(material), slides=slides, **changes)


def laid(passages: list[tuple[list[int], int, int]], position: np.ndarray, side, kind="weave", contacts=()) -> Fabric:
    """Yarns through nodes: for each one the nodes, the coordinate as which it passes them, and the family."""
    count = len(position)
    sliding, turn, direction = np.zeros((count, 2)), np.zeros((count, 2)), np.zeros((count, 2, 3))
    for nodes, c, _family in passages:
        coordinate = np.broadcast_to(c, len(nodes))
        places = position[nodes]
        sliding[nodes, coordinate] = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
        a, b = np.diff(places[:-1], axis=0), np.diff(places[1:], axis=0)
        angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))
        turn[nodes[1:-1], coordinate[1:-1]] = np.where(angle < 1e-6, 0.0, angle)
        direction[nodes, coordinate] = np.gradient(places, axis=0)
    along, across = direction[:, 0], direction[:, 1]
    shear = np.arctan2(np.linalg.norm(np.cross(along, across), axis=1), (along * across).sum(axis=1))
    starts = np.concatenate([[0], np.cumsum([len(nodes) for nodes, _c, _family in passages])])
    yarns = CrossingYarns(
        kind=kind,
        panel=np.zeros(count),
        position=position[:, :2],
        triangle=np.zeros(count),
        barycentric=np.full((count, 3), 1 / 3),
        side=side,
        yarn_start=starts,
        yarn_node=np.concatenate([nodes for nodes, _c, _family in passages]),
        yarn_coordinate=np.concatenate([np.broadcast_to(c, len(nodes)) for nodes, c, _family in passages]),
        yarn_family=[family for _nodes, _c, family in passages],
        rest_sliding=sliding,
        rest_turn=turn,
        rest_shear=shear,
        stitch_contacts=np.array(contacts, dtype=int).reshape(-1, 2),
        stitch_left=np.ones(len(contacts), dtype=bool),
    )
    return Fabric(yarns, position)


def plain_weave(columns: int, rows: int, spacing: float = 0.25) -> Fabric:
    """A plain weave; the wefts are u yarns and run along x, the warps are v yarns and run along y."""
    x, y = (part.ravel() for part in np.meshgrid(np.arange(columns), np.arange(rows)))
    number = np.arange(columns * rows).reshape(rows, columns)
    passages = [(list(row), 0, WEFT) for row in number]
    if rows > 1:
        passages += [(list(column), 1, WARP) for column in number.T]
    return laid(passages, np.column_stack([x, y, 0 * x]) * spacing, 1 - 2 * ((x + y) % 2))


def single_yarn(position: np.ndarray) -> Fabric:
    """One yarn through nodes; it is their u yarn."""
    return laid([(list(range(len(position))), 0, WEFT)], position, 1 - 2 * (np.arange(len(position)) % 2))


def vector_of(nodes: np.ndarray, sliding: np.ndarray, scalar=wp.float64) -> MixedVector:
    return MixedVector.from_numpy(np.zeros((0, 3)), nodes, sliding, scalar, CPU)


def flat(nodes: np.ndarray, sliding: np.ndarray) -> np.ndarray:
    return np.concatenate([nodes.ravel(), sliding.ravel()])


def split(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    count = len(values) // 5
    return values[: 3 * count].reshape(-1, 3), values[3 * count :].reshape(-1, 2)


def energy_at(term: MixedTerm, values: np.ndarray, scalar=wp.float64) -> float:
    return term.energy(vector_of(*split(values), scalar))


def force_at(term: MixedTerm, values: np.ndarray, scalar=wp.float64) -> np.ndarray:
    state = vector_of(*split(values), scalar)
    force = state.like()
    term.forces(state, force, RUN)
    return flat(*force.numpy()[1:])


def hessian_at(
    term: MixedTerm, values: np.ndarray, exact: float = 1.0, scalar=wp.float64, of=slice(None)
) -> np.ndarray:
    """The columns ``of`` of the Hessian."""
    state = vector_of(*split(values), scalar)
    term.exact = exact
    term.linearize(state, RUN)
    columns = []
    for unit in np.eye(len(values))[of]:
        product = state.like()
        term.products(vector_of(*split(unit), scalar), product, RUN)
        columns.append(flat(*product.numpy()[1:]))
    return np.stack(columns, axis=1)


def differences(function, values: np.ndarray, step: float) -> np.ndarray:
    """Derivatives of a function by central differences of fourth order; the last axis is that of the values."""
    columns = []
    for unit in np.eye(len(values)) * step:
        near = np.asarray(function(values + unit)) - np.asarray(function(values - unit))
        far = np.asarray(function(values + 2 * unit)) - np.asarray(function(values - 2 * unit))
        columns.append((8 * near - far) / (12 * step))
    return np.stack(columns, axis=-1)


def disturbed(fabric: Fabric, seed: int = 0, size: float = 0.15) -> np.ndarray:
    """Positions and coordinates of a fabric that is bent, stretched and slid at random, by shares of its spacing."""
    random = np.random.default_rng(seed)
    spacing = np.linalg.norm(fabric.position[1] - fabric.position[0])
    nodes = fabric.position + size * spacing * random.normal(size=fabric.position.shape)
    sliding = fabric.sliding + size / 2 * spacing * random.uniform(-1, 1, size=fabric.sliding.shape)
    return flat(nodes, sliding)


def softened(**changes) -> CrossingMaterial:
    return replace(YARN, **changes)


def stitch_contact() -> Fabric:
    """One contact of a knit, seen from the front: the new loop 0 1 2 4 is drawn through the old loop 5 1 2 3.

    The axis runs up from node 1 (P) to node 2 (Q). The new loop comes from the left, behind, and leaves upwards, in
    front; the old loop comes from below and leaves to the right.
    """
    position = 0.1 * np.array([[-1.0, 0.2, 0], [0, 0, 0], [0, 1.0, 0], [1.0, 0.9, 0], [0.1, 2.0, 0], [-0.1, -1.0, 0]])
    passages = [([0, 1, 2, 4], 0, WEFT), ([5, 1, 2, 3], np.array([0, 1, 1, 0]), WEFT)]
    return laid(passages, position, [1, -1, 1, 1, 1, 1], "knit", [[1, 2]])
