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
from stitchmesh.mixed.crossings.crossing_elements import CrossingElements, crossing_elements
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import Term

CPU = device_named("cpu")
RUN = partial(launch, device=CPU)
YARN = CrossingMaterial.named("gong-1")


@dataclass(frozen=True)
class Fabric:
    """Nodes as laid out."""

    link: np.ndarray
    position: np.ndarray
    sliding: np.ndarray
    side: np.ndarray

    def elements(self, material: CrossingMaterial = YARN, **changes) -> CrossingElements:
        return crossing_elements(self.link, self.sliding, self.position, self.side, (material, material), **changes)


def plain_weave(columns: int, rows: int, spacing: float = 0.25) -> Fabric:
    """A plain weave; the u yarns run along x, the v yarns along y."""
    x, y = (part.ravel() for part in np.meshgrid(np.arange(columns), np.arange(rows)))
    number = x + columns * y
    link = np.full((len(x), 4), -1)
    for k, (dx, dy) in enumerate([(1, 0), (-1, 0), (0, 1), (0, -1)]):
        inside = (x + dx >= 0) & (x + dx < columns) & (y + dy >= 0) & (y + dy < rows)
        link[inside, k] = 2 * (number + dx + columns * dy)[inside] + k // 2
    position = np.column_stack([x, y, 0 * x]) * spacing
    return Fabric(link, position, position[:, :2].copy(), 1 - 2 * ((x + y) % 2))


def single_yarn(position: np.ndarray, sliding: np.ndarray) -> Fabric:
    """One yarn through nodes with the given coordinates; it is the u yarn."""
    count = len(position)
    link = np.full((count, 4), -1)
    link[:-1, 0] = 2 * np.arange(1, count)
    link[1:, 1] = 2 * np.arange(count - 1)
    return Fabric(link, position, np.column_stack([sliding, 0 * sliding]), 1 - 2 * (np.arange(count) % 2))


def vector_of(nodes: np.ndarray, sliding: np.ndarray, scalar=wp.float64) -> MixedVector:
    return MixedVector.from_numpy(np.zeros((0, 3)), nodes, sliding, scalar, CPU)


def flat(nodes: np.ndarray, sliding: np.ndarray) -> np.ndarray:
    return np.concatenate([nodes.ravel(), sliding.ravel()])


def split(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    count = len(values) // 5
    return values[: 3 * count].reshape(-1, 3), values[3 * count :].reshape(-1, 2)


def energy_at(term: Term, values: np.ndarray, scalar=wp.float64) -> float:
    return term.energy(vector_of(*split(values), scalar))


def force_at(term: Term, values: np.ndarray, scalar=wp.float64) -> np.ndarray:
    state = vector_of(*split(values), scalar)
    force = state.like()
    term.forces(state, force, RUN)
    return flat(*force.numpy()[1:])


def hessian_at(term: Term, values: np.ndarray, exact: float = 1.0, scalar=wp.float64, of=slice(None)) -> np.ndarray:
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
