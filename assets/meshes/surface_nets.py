# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The surface of a shape as quads: surface nets (Gibson 1998).

Each cell of a lattice that the surface passes has one point, at the mean of where the surface cuts its edges. Each
edge of the lattice that the surface cuts has a quad of the points of the four cells around it.
"""

import numpy as np
from smooth_shapes import Point, Shape

CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
EDGES = [(a, b) for a in range(8) for b in range(a) if np.abs(CORNERS[a] - CORNERS[b]).sum() == 1]


def surface_nets(shape: Shape, low: Point, high: Point, cell: float) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """Return points of shape (n, 3) and quads, anticlockwise seen from outside.

    The box from `low` to `high` holds the shape; `cell` is the side of a lattice cell.
    """
    axes = [np.arange(a, b + cell, cell) for a, b in zip(low, high, strict=True)]
    values = shape(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1))
    size = np.array(values.shape) - 1
    at_corner = np.stack([values[tuple(slice(o, o + n) for o, n in zip(c, size, strict=True))] for c in CORNERS])
    passed = (at_corner < 0.0).any(axis=0) & (at_corner >= 0.0).any(axis=0)
    number = np.full(tuple(size), -1)
    number[passed] = np.arange(passed.sum())
    places = np.argwhere(passed) + cell_points(at_corner[:, passed])
    return np.array(low) + cell * places, lattice_quads(values < 0.0, number)


def cell_points(values: np.ndarray) -> np.ndarray:
    """Return the mean of the cuts on the edges of cells, in cells, from values at corners: (8, n) to (n, 3)."""
    total, count = np.zeros((values.shape[1], 3)), np.zeros(values.shape[1])
    for a, b in EDGES:
        cut = (values[a] < 0.0) != (values[b] < 0.0)
        t = np.where(cut, values[a] / np.where(cut, values[a] - values[b], 1.0), 0.0)[:, None]
        total += cut[:, None] * (CORNERS[a] + t * (CORNERS[b] - CORNERS[a]))
        count += cut
    return total / count[:, None]


def lattice_quads(inside: np.ndarray, number: np.ndarray) -> list[tuple[int, ...]]:
    """Return a quad for each edge of the lattice with one end inside."""
    quads: list[tuple[int, ...]] = []
    for axis in range(3):
        step = np.eye(3, dtype=int)
        one, other = step[(axis + 1) % 3], step[(axis + 2) % 3]
        first = np.moveaxis(inside, axis, 0)
        cut = np.moveaxis(first[:-1] != first[1:], 0, axis)
        for place in np.argwhere(cut):
            around = [place - one - other, place - other, place, place - one]
            quad = tuple(int(number[tuple(cell)]) for cell in around)
            quads.append(quad if inside[tuple(place)] else quad[::-1])
    return quads
