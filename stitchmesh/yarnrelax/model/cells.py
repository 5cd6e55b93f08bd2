# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The cells of a relaxation on the host: the elements of each cell, and their lengths in units.

A unit is the mean yarn radius of a cell; coordinates are relative to the middle of its yarns.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.threads import each_block
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.model.material import YarnMaterial

CONTACT = 3
"""Column of contact in ``CellTables.stiffness``."""


@dataclass(frozen=True, eq=False)
class PeriodicCell:
    """A cell, several of which may be relaxed together: yarns on their lattice, or one piece without a lattice."""

    yarns: YarnSet
    """The yarns as they were given [cm]."""
    material: YarnMaterial
    """Stiffnesses for lengths in units."""

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        """Least and largest coordinates of the control points [cm], shape (2, 3)."""
        columns = self.yarns.points.T
        return np.array([[column.min() for column in columns], [column.max() for column in columns]])

    @cached_property
    def origin(self) -> NDArray[np.float64]:
        """Middle of the yarns [cm], the origin of coordinates on the device, shape (3,)."""
        return (self.bounds[0] + self.bounds[1]) / 2

    @cached_property
    def unit(self) -> float:
        """Length unit on the device [cm]: the mean yarn radius."""
        return float(self.yarns.radius.mean())


@dataclass(frozen=True, eq=False)
class CellTables:
    """Tables of the cells that are relaxed together, on the host."""

    yarns: YarnSet
    """All given yarns [cm], cell after cell; without lattices if there are several cells."""
    cells: tuple[PeriodicCell, ...]
    """The cells that are relaxed together."""

    @property
    def material(self) -> YarnMaterial:
        """Stiffnesses of the first cell, for lengths in units."""
        return self.cells[0].material

    @property
    def unit(self) -> float:
        """Length unit of the first cell [cm]."""
        return self.cells[0].unit

    @property
    def on_lattice(self) -> bool:
        """Whether the cells have lattices."""
        return self.cells[0].yarns.lattice is not None

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return len(self.cells)

    @property
    def point_count(self) -> int:
        """Number of control points."""
        return len(self.yarns.points)

    @property
    def segment_count(self) -> int:
        """Number of segments."""
        return len(self.yarns.rest_length)

    @cached_property
    def point_start(self) -> NDArray[np.int64]:
        """Where each cell's control points start, shape (C + 1,)."""
        return starts_of(len(cell.yarns.points) for cell in self.cells)

    @cached_property
    def segment_start(self) -> NDArray[np.int64]:
        """Where each cell's segments start, shape (C + 1,)."""
        return starts_of(len(cell.yarns.rest_length) for cell in self.cells)

    @cached_property
    def yarn_start(self) -> NDArray[np.int64]:
        """Where each cell's yarns start, shape (C + 1,)."""
        return starts_of(cell.yarns.yarn_count for cell in self.cells)

    @cached_property
    def stiffness(self) -> NDArray[np.float64]:
        """Stiffness of stretch, length penalty, bending and contact of each cell for a unit of length, shape (C, 4)."""
        materials = [cell.material for cell in self.cells]
        along = [(m.k_len / m.segment_length, m.k_length / m.segment_length) for m in materials]
        return np.array([[*two, m.k_bend, m.k_contact] for two, m in zip(along, materials, strict=True)])

    @cached_property
    def segment_stiffness(self) -> NDArray[np.float64]:
        """Stiffness of stretch, length penalty and bending of each segment, for a unit of length, shape (S, 3)."""
        return np.repeat(self.stiffness[:, :CONTACT], np.diff(self.segment_start), axis=0)

    @cached_property
    def size(self) -> float:
        """Largest coordinate of the given yarns in units; at least 1."""
        farthest = [np.abs(cell.bounds - cell.origin).max() / cell.unit for cell in self.cells]
        return max(float(np.max(farthest)), 1.0)

    @cached_property
    def radius(self) -> NDArray[np.float64]:
        """Radius of each yarn in units, shape (Y,)."""
        return np.concatenate([cell.yarns.radius / cell.unit for cell in self.cells])

    @cached_property
    def rest_length(self) -> NDArray[np.float64]:
        """Rest length of each segment in units, shape (S,)."""
        return np.concatenate([cell.yarns.rest_length / cell.unit for cell in self.cells])

    @cached_property
    def natural_ends(self) -> NDArray[np.float64]:
        """Natural curvature at both ends of each segment in 1 / units, shape (S, 2), or (0, 2) if all are straight."""
        ends = np.concatenate([cell.yarns.natural_ends * cell.unit for cell in self.cells])
        return ends if ends.any() else ends[:0]

    @cached_property
    def lattice_step(self) -> NDArray[np.int64]:
        """Image from each yarn's last control point to its first, shape (Y, 2)."""
        steps = [cell.yarns.lattice_step for cell in self.cells]
        counts = np.diff(self.yarn_start)
        return np.concatenate([np.zeros((n, 2), dtype=np.int64) if step is None else step
                               for step, n in zip(steps, counts, strict=True)])  # fmt: skip

    @cached_property
    def wrapped(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Corners in another image: their segments and slots, shape (E,) each, and their images, shape (E, 2)."""
        points = self.yarns.segment_points
        rows = np.flatnonzero(points[:, 3] < points[:, 0])
        wraps = np.cumsum(np.diff(points[rows], axis=1) < 0, axis=1)
        image = wraps[:, :, None] * self.lattice_step[self.yarns.segment_yarn[rows]][:, None, :]
        row, leg = np.nonzero(image.any(axis=2))
        return rows[row], leg + 1, image[row, leg]

    @cached_property
    def segment_corners(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Corners of all segments without repetition, cell after cell.

        Returns:
            The first corner of each cell, shape (C + 1,); and the control point, shape (K,), and the image,
            shape (K, 2), of each corner.
        """
        segment, slot, image = self.wrapped
        point = np.concatenate([np.arange(self.point_count), self.yarns.segment_points[segment, slot]])
        cell = np.searchsorted(self.point_start, point, side="right") - 1
        order = np.argsort(cell, kind="stable")
        images = np.concatenate([np.zeros((self.point_count, 2), dtype=np.int64), image])
        return starts_of(np.bincount(cell, minlength=self.cell_count).tolist()), point[order], images[order]

    @cached_property
    def units(self) -> NDArray[np.float64]:
        """Unit of length of each cell [cm], shape (C,)."""
        return np.array([cell.unit for cell in self.cells])

    def to_device(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return positions [cm] of all control points, or any points of the only cell, in units from its origin."""
        if self.cell_count > 1:
            origin, units = self._frames
            return (points - origin) / units
        middle, unit, moved = self.cells[0].origin, self.unit, np.empty(points.shape)

        def move(some: slice) -> None:
            moved[some] = (points[some] - middle) / unit

        each_block(move, len(points))
        return moved

    def from_device(self, points: wp.array[Any]) -> NDArray[np.float64]:
        """Return the positions [cm] of the control points on the device, shape (N, 3)."""
        places = points.numpy()[: self.point_count].astype(np.float64)
        origin, unit = self._frames if self.cell_count > 1 else (self.cells[0].origin, self.unit)
        places *= unit
        places += origin
        return places

    @cached_property
    def _frames(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Origin and unit of each control point."""
        counts = np.diff(self.point_start)
        origin = np.repeat([cell.origin for cell in self.cells], counts, axis=0)
        return origin, np.repeat([cell.unit for cell in self.cells], counts)[:, None]


def starts_of(counts: Iterable[int]) -> NDArray[np.int64]:
    """Return where each of several consecutive groups starts, from their sizes, and where the last one ends."""
    return np.concatenate([[0], np.cumsum(list(counts))]).astype(np.int64)
