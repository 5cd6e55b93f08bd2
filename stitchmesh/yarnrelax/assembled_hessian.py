# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact Hessian of the energy as a sparse matrix, of the control points and of the strains of cells.

The matrices of segments and of pairs in contact (``segment_hessian``, ``contact_hessian``) become blocks of 3 x 3
between control points. A leg or a gap between two places changes by du + E g, with the motion du of the places, the
strain E of the cell and the vector g between the places (``hessian_product``). With the basis vectors E_m of strains,
the change of g by the m-th strain is E_m g, so that a matrix K of a leg or of a pair adds

    du^T K (E_m g)  and  (E_m g)^T K (E_n g)

to the borders of the matrix. The place x of a control point changes by (I + E) (x + du) - x. Where its internal force f
is not zero, the derivative of E du adds - f^T E_m du. At rest f is the opposite of the push of the planes, which has no
part along the periods.

The order of the coordinates is that of the solver: those of the control points, and then the strains of each cell times
``STRAIN_UNIT``.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_array, bsr_array, csc_array

from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import basis
from stitchmesh.yarnrelax.collision.budget import STRAIN_UNIT
from stitchmesh.yarnrelax.hessian.hessian_product import Hessian
from stitchmesh.yarnrelax.hessian.segment_hessian import LEG_PAIRS
from stitchmesh.yarnrelax.model.constants import Model

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.simulation import YarnSimulation

LEGS_OF_POINTS = np.array([[-1.0, 1.0, 0.0, 0.0], [0.0, -1.0, 1.0, 0.0], [0.0, 0.0, -1.0, 1.0]])
"""The legs of a segment by its control points, shape (3, 4)."""
PAIRS_AT_ONCE = 50_000
"""Pairs in contact whose blocks are summed at the same time: each has 16 blocks of 72 bytes."""


def assembled_hessian(simulation: YarnSimulation) -> csc_array:
    """Return the exact Hessian of the current state [erg / unit^2], shape (3 E, 3 E).

    E is the number of control points, and with it the number of cells if their periods relax. Coordinates that are held
    have their rows and columns too.

    Args:
        simulation: the yarns, with candidate lists for their current state. Terms that are neither constant forces nor
            blocks of single control points (``Term.point_blocks``) are left out.
    """
    model, state, strain = simulation.model, simulation.state, simulation.strain
    found = Hessian(model, state, simulation.candidates, strain)
    found.exact.fill_(1.0)
    launches = [*simulation.balance_launches(), *found.find_launches(model.prepare)]
    CapturedLaunches(launches, model.device).launch()
    points = _PointBlocks(model.point_count)
    strained = None if strain is None else _StrainBlocks(model, strain.host_frame)
    _add_segments(model, found.leg_hessian.numpy(), state.points.numpy(), points, strained)
    _add_contacts(model, found, state.samples.numpy(), points, strained)
    for term in simulation.terms:
        own = term.point_blocks(state)
        if own is not None:
            every = np.arange(model.point_count)
            points.add(every, every, own)
    if strained is None:
        return csc_array(points.matrix)
    internal = state.force.numpy()[: model.point_count].astype(np.float64)
    if len(state.external_force):
        internal -= state.external_force.numpy()
    strained.add_turning(internal)
    border = csc_array(strained.border)
    return csc_array(block_array([[points.matrix, border], [border.T, strained.corner]]))


class _PointBlocks:
    """Blocks between control points, which are summed in the order in which they are added."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._keys: list[IntArray] = []
        self._blocks: list[FloatArray] = []

    def add(self, first: IntArray, second: IntArray, blocks: FloatArray) -> None:
        """Add blocks of shape (n, 3, 3) at the rows of some points and the columns of others."""
        keys, blocks = _summed(first * self._count + second, blocks)
        self._keys.append(keys)
        self._blocks.append(blocks)

    @property
    def matrix(self) -> bsr_array:
        """The sum of all blocks, shape (3 N, 3 N)."""
        keys, blocks = _summed(np.concatenate(self._keys), np.concatenate(self._blocks))
        start = np.searchsorted(keys, np.arange(self._count + 1) * self._count)
        return bsr_array((blocks, keys % self._count, start), shape=(3 * self._count, 3 * self._count))


def _summed(keys: IntArray, blocks: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the keys without repetition, ascending, and the sum of the blocks of each."""
    order = np.argsort(keys, kind="stable")
    own = keys[order]
    first = np.flatnonzero(np.diff(own, prepend=-1))
    return own[first], np.add.reduceat(blocks[order], first, axis=0)


class _StrainBlocks:
    """The part of the matrix in the rows and columns of strains."""

    def __init__(self, model: Model, frame: NDArray[np.float64]) -> None:
        """Begin with zeros, for the frames of all cells, shape (C, 2, 3)."""
        self._frame = frame
        self._cell_of_point = np.repeat(np.arange(model.cell_count), np.diff(model.point_start))
        count = model.cell_count
        self._of_points = np.zeros((model.point_count, 3, 3))
        """Second derivatives by the coordinates of each control point and the strains of its cell."""
        self._of_cells = np.zeros((count, 3, 3))

    def changes(self, gap: FloatArray, cell: IntArray) -> FloatArray:
        """Change of some vectors by each strain of their cells, shape (n, 3, 3); the strains come last."""
        e1, e2 = self._frame[cell, 0], self._frame[cell, 1]
        first, second = (np.einsum("nk,nk->n", gap, along)[:, None] for along in (e1, e2))
        return np.stack([e1 * first, e2 * second, e1 * second], axis=2) / float(STRAIN_UNIT)

    def add(self, points: IntArray, of_points: FloatArray, cells: IntArray, of_cells: FloatArray) -> None:
        """Add derivatives by points and strains, shape (n, 3, 3), and by two strains of cells, shape (m, 3, 3)."""
        for row in range(3):
            for column in range(3):
                self._of_points[:, row, column] += np.bincount(
                    points, of_points[:, row, column], minlength=len(self._of_points)
                )
                self._of_cells[:, row, column] += np.bincount(
                    cells, of_cells[:, row, column], minlength=len(self._of_cells)
                )

    def add_turning(self, force: FloatArray) -> None:
        """Add the derivative of E du, for the internal forces on the control points [erg / unit], shape (N, 3)."""
        e1, e2 = self._frame[self._cell_of_point, 0], self._frame[self._cell_of_point, 1]
        first, second = (np.einsum("nk,nk->n", force, along)[:, None] for along in (e1, e2))
        self._of_points -= np.stack([e1 * first, e2 * second, e2 * first], axis=2) / float(STRAIN_UNIT)

    @property
    def border(self) -> bsr_array:
        """Derivatives by control points and strains, shape (3 N, 3 C)."""
        count = len(self._of_points)
        shape = (3 * count, 3 * len(self._of_cells))
        return bsr_array((self._of_points, self._cell_of_point, np.arange(count + 1)), shape=shape)

    @property
    def corner(self) -> bsr_array:
        """Derivatives by two strains, shape (3 C, 3 C)."""
        count = len(self._of_cells)
        return bsr_array((self._of_cells, np.arange(count), np.arange(count + 1)), shape=(3 * count, 3 * count))


def _add_segments(
    model: Model, leg_hessian: FloatArray, places: FloatArray, points: _PointBlocks, strained: _StrainBlocks | None
) -> None:
    """Add the matrices of segments."""
    corner = model.yarns.segment_points
    count = len(corner)
    of_legs = np.zeros((count, 3, 3, 3, 3))  # segment, leg, leg, and the coordinates of both
    for number, (first, second) in enumerate(LEG_PAIRS):
        of_legs[:, first, second] = leg_hessian[number]
        of_legs[:, second, first] = leg_hessian[number].transpose(0, 2, 1)
    blocks = np.einsum("la,slmxy,mb->sabxy", LEGS_OF_POINTS, of_legs, LEGS_OF_POINTS)
    rows, columns = np.broadcast_arrays(corner[:, :, None], corner[:, None, :])
    points.add(rows.ravel(), columns.ravel(), blocks.reshape(-1, 3, 3))
    if strained is None:
        return
    cell = np.repeat(np.arange(model.cell_count), np.diff(model.segment_start))
    legs = np.diff(places[corner].astype(np.float64) + _corner_shifts(model), axis=1)
    changes = strained.changes(legs.reshape(-1, 3), np.repeat(cell, 3)).reshape(count, 3, 3, 3)
    pull = np.einsum("slmxy,smyk->slxk", of_legs, changes)
    of_points = np.einsum("la,slxk->saxk", LEGS_OF_POINTS, pull)
    strained.add(corner.ravel(), of_points.reshape(-1, 3, 3), cell, np.einsum("slxk,slxj->skj", pull, changes))


def _corner_shifts(model: Model) -> FloatArray:
    """Displacement of the image of each corner of each segment [units], shape (S, 4, 3)."""
    images = model.constants.images
    cell = np.repeat(np.arange(model.cell_count), np.diff(model.segment_start))
    turns = images.image.numpy()[images.corner_image.numpy()].astype(np.float64)
    periods = images.periods.numpy().astype(np.float64).reshape(-1, 2, 3)
    return np.asarray(np.einsum("scb,sbd->scd", turns, periods[cell]))


def _add_contacts(
    model: Model, found: Hessian, samples: FloatArray, points: _PointBlocks, strained: _StrainBlocks | None
) -> None:
    """Add the matrices of pairs in contact; each pair is listed from both of its samples."""
    corner = model.yarns.segment_points
    counts = np.diff(model.sample_start)
    segment = np.repeat(np.arange(model.segment_count), counts)
    weight = basis((np.arange(len(segment)) - model.sample_start[segment] + 0.5) / counts[segment])
    cell_of_segment = np.repeat(np.arange(model.cell_count), np.diff(model.segment_start))
    for p, entry, stiffness in _listed_pairs(found):
        q = entry % model.sample_count
        own, other = corner[segment[p]], corner[segment[q]]
        there = np.einsum("na,nb,nxy->nabxy", weight[p], weight[p], stiffness)
        across = np.einsum("na,nb,nxy->nabxy", weight[p], -weight[q], stiffness)
        for columns, blocks in ((own, there), (other, across)):
            row, column = np.broadcast_arrays(own[:, :, None], columns[:, None, :])
            points.add(row.ravel(), column.ravel(), blocks.reshape(-1, 3, 3))
        if strained is not None:
            cell = cell_of_segment[segment[p]]
            gap = samples[p, :3].astype(np.float64) - samples[q, :3] - _entry_shifts(model, entry, cell)
            changes = strained.changes(gap, cell)
            pull = stiffness @ changes
            of_points = np.einsum("na,nxk->naxk", weight[p], pull).reshape(-1, 3, 3)
            strained.add(own.ravel(), of_points, cell, 0.5 * np.einsum("nxk,nxj->nkj", pull, changes))


def _listed_pairs(found: Hessian) -> Iterator[tuple[IntArray, IntArray, FloatArray]]:
    """Yield some pairs after others: sample, entry of its list, and stiffness, shape (n, 3, 3)."""
    pairs = found.touching
    count, entries, stiffness = pairs.count.numpy(), pairs.entries.numpy(), pairs.stiffness.numpy()
    sample = np.repeat(np.arange(len(count)), count)
    place = np.arange(len(sample)) - np.repeat(np.cumsum(count) - count, count)
    for first in range(0, len(sample), PAIRS_AT_ONCE):
        p, k = sample[first : first + PAIRS_AT_ONCE], place[first : first + PAIRS_AT_ONCE]
        own: NDArray[Any] = stiffness[p, k].astype(np.float64)
        matrix = own[:, :3, None] * own[:, None, :3] - own[:, 3, None, None] * np.eye(3)
        yield p, entries[p, k].astype(np.int64), matrix


def _entry_shifts(model: Model, entry: IntArray, cell: IntArray) -> FloatArray:
    """Displacement of the image of each entry of a list [units], shape (n, 3); zero without a lattice."""
    if not model.on_lattice:
        return np.zeros((len(entry), 3))
    images = model.constants.images
    turns = images.image.numpy()[entry // model.sample_count].astype(np.float64)
    periods = images.periods.numpy().astype(np.float64).reshape(-1, 2, 3)
    return np.asarray(np.einsum("nb,nbd->nd", turns, periods[cell]))
