# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flat sheets of triangles, states and derivatives for the tests of contact."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, cast

import numpy as np
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import scalar_named
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth, signed_areas
from stitchmesh.mixed.contact.contact_points import ContactPoints, SeamLinks, points_on_triangles
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import MixedTerm


@dataclass(frozen=True)
class Sheets:
    """Flat rectangular panels of triangles, with the arrays of a ``Cloth`` that contact reads."""

    vertices: FloatArray
    triangles: IntArray
    rest: FloatArray
    panel: IntArray

    def points(self, thickness: float, **options: Any) -> tuple[ContactPoints, SeamLinks]:
        """Contact points on the triangles."""
        return points_on_triangles(cast(Cloth, self), thickness=thickness, **options)

    def masses(self, density: float) -> FloatArray:
        """Lumped masses of the vertices [g]."""
        areas = np.abs(signed_areas(self.rest))
        return np.bincount(self.triangles.ravel(), weights=np.repeat(density * areas / 3.0, 3))


def sheet(count: int, size: float, *, height: float = 0.0, shift: float = 0.0) -> Sheets:
    """A square sheet in the plane z = height, around the origin, with ``count`` squares along each side."""
    x, y = (grid.ravel() for grid in np.meshgrid(*[np.linspace(-0.5, 0.5, count + 1) * size] * 2, indexing="ij"))
    vertices = np.column_stack([x + shift, y + shift, np.full(len(x), height)])
    i, j = (grid.ravel() for grid in np.mgrid[:count, :count])
    a = i * (count + 1) + j
    b, c, d = a + count + 1, a + count + 2, a + 1
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Sheets(vertices, triangles, vertices[triangles][:, :, :2], np.zeros(len(triangles), dtype=np.int64))


def together(*sheets: Sheets) -> Sheets:
    """Several sheets as panels of one cloth."""
    first = np.cumsum([0, *(len(one.vertices) for one in sheets)])
    return Sheets(
        np.concatenate([one.vertices for one in sheets]),
        np.concatenate([one.triangles + start for one, start in zip(sheets, first, strict=False)]),
        np.concatenate([one.rest for one in sheets]),
        np.concatenate([np.full(len(one.triangles), number) for number, one in enumerate(sheets)]),
    )


def state_of(vertices: FloatArray, nodes: FloatArray | None = None, precision: str = "float64") -> MixedVector:
    """A state with Eulerian coordinates of zero."""
    p = np.zeros((0, 3)) if nodes is None else nodes
    return MixedVector.from_numpy(vertices, p, np.zeros((len(p), 2)), scalar_named(precision), cpu())


def cpu() -> wp.Device:
    """The device of the tests."""
    return device_named("cpu")


def launcher() -> Any:
    """A launcher that runs kernels immediately."""
    return partial(launch, device=cpu())


def forces_of(term: MixedTerm, state: MixedVector) -> FloatArray:
    """Forces on vertices and nodes, shape (V + N, 3)."""
    force = state.like()
    term.forces(state, force, launcher())
    v, p, _ = force.numpy()
    return np.concatenate([v, p])


def products_of(term: MixedTerm, state: MixedVector, direction: MixedVector, exact: float = 1.0) -> FloatArray:
    """H d on vertices and nodes, shape (V + N, 3)."""
    term.exact = exact
    term.linearize(state, launcher())
    product = state.like()
    term.products(direction, product, launcher())
    v, p, _ = product.numpy()
    return np.concatenate([v, p])


def blocks_of(term: MixedTerm, state: MixedVector, exact: float = 1.0) -> FloatArray:
    """Diagonal blocks of vertices, shape (V, 3, 3)."""
    term.exact = exact
    term.linearize(state, launcher())
    blocks = MixedBlocks.zeros(state.vertex_count, state.node_count, state.scalar, state.device)
    term.diagonal(blocks, launcher())
    return blocks.vertices.numpy()


def moved(state: MixedVector, direction: MixedVector, step: float) -> MixedVector:
    """A state after a step along a direction."""
    parts = [a + step * b for a, b in zip(state.numpy(), direction.numpy(), strict=True)]
    return MixedVector.from_numpy(*parts, state.scalar, state.device)


def random_direction(state: MixedVector, seed: int = 0) -> MixedVector:
    """A random direction of vertices and nodes."""
    rng = np.random.default_rng(seed)
    return state_of(rng.normal(size=(state.vertex_count, 3)), rng.normal(size=(state.node_count, 3)))


def derivative_errors(term: MixedTerm, state: MixedVector, step: float, seed: int = 0) -> tuple[float, float]:
    """Relative errors of the forces and of the exact products against central differences of energy and forces."""
    direction = random_direction(state, seed)
    ahead, back = moved(state, direction, step), moved(state, direction, -step)
    slope = (term.energy(ahead) - term.energy(back)) / (2 * step)
    v, p, _ = direction.numpy()
    along = np.concatenate([v, p])
    expected = -(forces_of(term, ahead) - forces_of(term, back)) / (2 * step)
    product = products_of(term, state, direction)
    force = forces_of(term, state)
    return (
        abs(slope + (force * along).sum()) / np.abs(force * along).sum(),
        float(np.abs(product - expected).max() / np.abs(expected).max()),
    )
