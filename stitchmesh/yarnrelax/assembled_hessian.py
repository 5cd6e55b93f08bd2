# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The exact Hessian of the energy as a sparse matrix, for the control points and the strains of cells.

The matrices of segments and of pairs of contact samples (``segment_hessian``, ``PairStiffness``) become blocks of 3 x 3
between control points. Let g be a leg or the gap of a pair, that is, the vector between two places. It changes by
du + E g, with the motion du of the places and the strain E of the cell,

    E g = e1 (a g1 + c g2) + e2 (b g2)

(``cell_strain``). With the basis vectors E_m of strains, the change of g by the m-th strain is E_m g, so that a matrix
K of a leg or of a pair adds

    du^T K (E_m g)  and  (E_m g)^T K (E_n g)

to the borders of the matrix. The place x of a control point changes by (I + E) (x + du) - x. If its internal force f is
not zero, the derivative of E du adds - f^T E_m du, which the Gauss-Newton matrix leaves out. At rest f is the opposite
of the push of the planes, which has no part along the periods.

The pairs are the pairs in contact and the pairs of terms, such as friction, whose anchors are places in space that do
not follow the strains. The forces of pairs are internal forces. The samples without a partner are the samples beside
bodies.

The coordinates have the order of the solver: the coordinates of the control points, and then the strains of each cell
times ``STRAIN_UNIT``. Held coordinates have their rows and columns too.

The work has three steps. The kernels of forces, of matrices and of the lists of touching segments run first. If
segments touch whose entries have no places yet, the places of all entries are found (``touching_segments``,
``matrix_pattern``). The entries are summed last (``segment_sums``, ``matrix_entries``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.sparse import csc_array

from stitchmesh.compute.captured import ZeroArray
from stitchmesh.compute.cudss import factors_on
from stitchmesh.compute.precision import matrix
from stitchmesh.yarnrelax.energies.pair_stiffness import PairStiffness, SampleStiffness
from stitchmesh.yarnrelax.energies.term import Coupling
from stitchmesh.yarnrelax.hessian.cell_matrices import CellMatrices, Owners
from stitchmesh.yarnrelax.hessian.contact_hessian import TouchingPairs
from stitchmesh.yarnrelax.hessian.couplings import CouplingRows, joined
from stitchmesh.yarnrelax.hessian.dense_cells import DenseCells, MatricesOfSmallCells
from stitchmesh.yarnrelax.hessian.matrices_on_host import MatricesOnHost
from stitchmesh.yarnrelax.hessian.matrix_entries import block_launches, entry_launches
from stitchmesh.yarnrelax.hessian.matrix_pattern import MatrixPattern
from stitchmesh.yarnrelax.hessian.segment_hessian import leg_hessian_launch
from stitchmesh.yarnrelax.hessian.segment_sums import SegmentSums
from stitchmesh.yarnrelax.hessian.touching_segments import TouchingSegments

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.hessian.matrices_on_gpu import PatternOnGpu
    from stitchmesh.yarnrelax.simulation import YarnSimulation

LARGEST_GROUP = 32_768
"""Largest number of coordinates of a group of several cells that a GPU factors at once."""


class HessianAssembly:
    """The arrays from which the Hessians of the states of a simulation are assembled."""

    def __init__(self, simulation: YarnSimulation) -> None:
        """Allocate the arrays; the first matrix finds the pattern.

        Args:
            simulation: the yarns, with candidate lists for their current state. A term is left out if it is no constant
                force and gives no blocks of points, pairs or samples (``YarnTerm``).
        """
        model, strain = simulation.model, simulation.strain
        self._simulation = simulation
        self._exact = model.empty(model.segment_count)
        self._leg_hessian = wp.zeros((6, model.segment_count), dtype=matrix(3, model.scalar), device=model.device)
        self._pairs_in_contact = TouchingPairs(model, simulation.candidates)
        self._touching = TouchingSegments(model)
        self._sums = SegmentSums(model, None if strain is None else strain.host_frame)
        self._pattern: MatrixPattern | None = None
        self._values = wp.empty(0, dtype=wp.float64, device=model.device)
        self._on_gpu: tuple[MatrixPattern, PatternOnGpu] | None = None
        self._coupled = CouplingRows([])
        own, strains = 3 * np.diff(model.point_start), 3 if self._sums.relaxes else 0
        self._groups = _groups(own, strains)
        self._dense = DenseCells(own, strains, model.device) if self._are_dense(own + strains) else None

    def _are_dense(self, sizes: NDArray[np.int64]) -> bool:
        """Whether the matrices of cells with these numbers of coordinates are factored as dense ones."""
        model = self._simulation.model
        return model.on_lattice and DenseCells.suit(sizes, model.device)

    def matrix(
        self, exact: NDArray[np.float64] | None = None, *, forces_are_found: bool = False
    ) -> csc_array:  # fmt: skip
        """Return the Hessian of the current state [erg / unit^2], shape (3 E, 3 E).

        E is the number of control points, plus the number of cells if their periods relax. While the same segments
        touch, all matrices share ``indices`` and ``indptr``, which nobody may change. Cells that rest
        (``Model.resting``) keep their last matrices of legs and contacts.

        Args:
            exact: share of the exact Hessian in each segment, shape (S,); the rest is the Gauss-Newton matrix, which is
                positive semidefinite. All segments of a cell whose periods relax have the same share. None for 1
                everywhere.
            forces_are_found: whether the simulation already has the samples and forces of the current state, so that
                their launches can be left out.
        """
        entries, pattern = self._entries(exact, forces_are_found)
        size = len(pattern.column_start) - 1
        found = csc_array((entries.numpy().copy(), pattern.host_rows, pattern.column_start), shape=(size, size))
        found.has_canonical_format = True
        return found

    def cell_matrices(
        self, exact: NDArray[np.float64], owners: Owners, couplings: Sequence[Coupling], *, forces_are_found: bool
    ) -> CellMatrices:  # fmt: skip
        """Return the Hessians of the current states of some cells, on the device that factors them.

        A GPU factors small cells by itself, and others with cuDSS. Without cuDSS, the processor factors these.

        Args:
            exact: share of the exact Hessian in each segment (``matrix``).
            owners: the coordinates of the cells.
            couplings: couplings of many coordinates; only a piece of its own has them.
            forces_are_found: whether the simulation already has the samples and forces of the current state.
        """
        device = self._simulation.model.device
        if not self._coupled.are_of(couplings):
            self._coupled, self._on_gpu = CouplingRows(couplings), None
        if self._dense is not None and not couplings:
            entries, pattern = self._entries(exact, forces_are_found)
            return MatricesOfSmallCells.of(self._dense, pattern, wp.clone(entries), owners)
        if not factors_on(device):
            host = MatricesOnHost(self.matrix(exact, forces_are_found=forces_are_found), owners)
            return replace(host, couplings=joined(couplings, self._coupled, host.diagonal()))
        from stitchmesh.yarnrelax.hessian.matrices_on_gpu import MatricesOnGpu, PatternOnGpu

        entries, pattern = self._entries(exact, forces_are_found)
        if self._on_gpu is None or self._on_gpu[0] is not pattern:
            column_start = wp.array(pattern.column_start, dtype=wp.int32, device=device)
            former = None if self._on_gpu is None else self._on_gpu[1]
            self._on_gpu = pattern, PatternOnGpu(column_start, pattern.rows, self._groups, self._coupled, former)
        found = MatricesOnGpu(self._on_gpu[1], wp.clone(entries), owners)
        return replace(found, couplings=joined(couplings, self._coupled, found.diagonal()))

    def _entries(
        self, exact: NDArray[np.float64] | None, forces_are_found: bool
    ) -> tuple[wp.array[Any], MatrixPattern]:  # fmt: skip
        """Return the entries of the matrix on the device, which the next call overwrites, and their places."""
        self._exact.assign(np.ones(self._simulation.model.segment_count) if exact is None else exact)
        pattern = self._find(forces_are_found)
        simulation = self._simulation
        model, state = simulation.model, simulation.state
        if len(self._values) != len(pattern.rows):
            self._values = wp.empty(len(pattern.rows), dtype=wp.float64, device=model.device)
        entries = self._values
        blocks = [own for term in simulation.yarn_terms if (own := term.point_blocks(state)) is not None]

        def launches() -> list[Any]:
            """Return the launches that sum all entries."""
            launcher, (pairs, samples) = model.prepare, self._pairs()
            found = self._sums.launches(
                state.points, state.samples, self._leg_hessian, pairs, samples, pattern, launcher
            )  # fmt: skip
            found += entry_launches(
                state, self._exact, self._leg_hessian, self._touching, pattern, self._sums, entries, launcher
            )  # fmt: skip
            return [ZeroArray(entries), *found, *block_launches(pattern, blocks, entries, launcher)]

        simulation.captured("Hessian", launches, of=pattern).launch()
        return entries, pattern

    def _pairs(self) -> tuple[list[PairStiffness], list[SampleStiffness]]:
        """Return the pairs in contact and the pairs of terms, and the samples of terms."""
        simulation = self._simulation
        model, state, launcher = simulation.model, simulation.state, simulation.model.prepare
        if self._pairs_in_contact.entries.shape != simulation.candidates.lists.shape:
            self._pairs_in_contact = TouchingPairs(model, simulation.candidates)
        given = [self._pairs_in_contact.pair_stiffness(self._exact, state.samples, launcher)]
        given += [own for term in simulation.yarn_terms if (own := term.pair_stiffness(state, launcher)) is not None]
        alone = [term.sample_stiffness(state, self._exact, launcher) for term in simulation.yarn_terms]
        return given, [own for own in alone if own is not None]

    def _find(self, forces_are_found: bool) -> MatrixPattern:
        """Find the matrices of segments, pairs and samples, and return the places of the entries."""
        simulation = self._simulation
        model, state = simulation.model, simulation.state
        if not forces_are_found:
            simulation.captured("balance", simulation.balance_launches).launch()

        def launches() -> list[Any]:
            """Return the launches that find the matrices and the touching segments."""
            launcher, (given, alone) = model.prepare, self._pairs()
            legs = leg_hessian_launch(model, self._exact, state.points, self._leg_hessian, launcher)
            further = [own.launches for own in given] + [own.launches for own in alone]
            return [legs, *chain(*further), *self._touching.launches(given, launcher)]

        simulation.captured("stiffnesses", launches, of=self._touching.segments).launch()
        while self._touching.make_room():
            simulation.captured("stiffnesses", launches, of=self._touching.segments).launch()
        lasts = model.on_lattice and (self._dense is not None or factors_on(model.device))
        candidates = simulation.candidates if lasts else None
        if self._touching.keep(candidates) or self._pattern is None:
            self._pattern = MatrixPattern(model, self._sums.relaxes, self._touching)
        return self._pattern


def _groups(coordinates: NDArray[np.int64], strains: int) -> NDArray[np.int64]:
    """Return the group in which a GPU factors each coordinate: first for the points, then for the strains.

    Args:
        coordinates: number of coordinates of the points of each cell, shape (C,).
        strains: number of coordinates of the strain of each cell.
    """
    group, filled = np.zeros(len(coordinates), dtype=np.int64), 0
    for cell, own in enumerate((coordinates + strains).tolist()):
        is_full = filled > 0 and filled + own > LARGEST_GROUP
        group[cell] = group[cell - 1] + is_full if cell else 0
        filled = own if is_full else filled + own
    return np.concatenate([np.repeat(group, coordinates), np.repeat(group, strains)])
