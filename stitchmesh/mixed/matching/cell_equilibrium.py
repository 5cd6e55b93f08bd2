# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Equilibrium of a periodic cell of yarns at a given strain and curvature.

Unknown are the displacement w and the two sliding coordinates of each node of the repeat, and those parameters of the
shape that are free, such as the width of a strip that is pulled along its length. The mean of w is
zero, so that the curvature is that of the middle of the yarns. The energy has its minimum at the equilibrium, found by
Newton's method with a dense matrix: differences of the gradient, and a multiple of the unit matrix that makes the
matrix positive. At an equilibrium the derivatives of the energy by the parameters of the shape are exact tensions
and moments: unknowns contribute nothing, because the energy does not change with them to first order.

A flat fabric of flat yarns is an equilibrium by symmetry, also under compression, where it is not stable. Such a state
is kept, because the triangles that are fitted to it are flat too: buckling belongs to their positions, not to their
law.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.launch import launch
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.mixed.crossings.crossing_term import CrossingTerm
from stitchmesh.mixed.matching.cell_shape import PARAMETERS, CellShape, place_nodes, shape_derivatives, turned_back
from stitchmesh.mixed.matching.yarn_cell import OUTSIDE, YarnCell
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import Term

Numbers = NDArray[np.float64]
TOLERANCE = 1e-9
"""Largest unbalanced force, over the stretch stiffness of a yarn."""
MOST_ITERATIONS = 200
STEP = 1e-6
"""Step of the differences of the gradient, in sizes of the repeat."""
SMALLEST_SHIFT, LARGEST_SHIFT = 1e-9, 1e3
"""Bounds of the multiple of the unit matrix, over the largest diagonal entry. The smallest one removes the motions that
cost nothing: translations, and yarns that slide as a whole."""
MOST_HALVINGS = 30
LARGEST_MOVE = 0.1
"""Largest change of an unknown in one iteration, in sizes of the repeat."""


@dataclass(frozen=True, eq=False)
class CellState:
    """A cell in equilibrium."""

    shape: CellShape
    """Strain and curvature; free parameters have their values at equilibrium."""
    moved: Numbers
    """Displacement w and change of both sliding coordinates of each node of the repeat [cm], shape (n, 5)."""
    energy: float
    """Energy for each area of the flat fabric [erg/cm^2]."""
    slopes: Numbers
    """Derivatives of ``energy`` by the ``PARAMETERS``: tension along courses and along wales [dyn/cm], the same of the
    skew, and moment [dyn]; shape (4,)."""


class CellSolver:
    """Equilibria of one cell."""

    def __init__(self, cell: YarnCell, terms: Sequence[Term] | None = None) -> None:
        """Put the energies of the cell on the CPU: a cell has few nodes.

        Args:
            cell: the repeat.
            terms: its energies in float64 on the CPU, by default those of its elements.
        """
        self.cell, self.device = cell, device_named("cpu")
        self.terms = [CrossingTerm(cell.elements, wp.float64, self.device)] if terms is None else list(terms)
        self._known = np.flatnonzero(cell.copy_of != OUTSIDE)
        self._size = float(np.sqrt(cell.area))

    @alone()
    def equilibrium(self, shape: CellShape, start: Numbers | None = None, *, free: Sequence[str] = ()) -> CellState:
        """Find the equilibrium.

        Args:
            shape: strain and curvature.
            start: ``CellState.moved`` of a state nearby, shape (n, 5); the layout if it is None.
            free: names of the parameters of the shape that are unknown; the search begins at their values in ``shape``.

        Raises:
            ParameterError: a name is not that of a parameter.
            SolverError: forces do not balance after many iterations.
        """
        wrong = [name for name in free if name not in PARAMETERS]
        if wrong:
            raise ParameterError(f"yarn cell: free: got {wrong[0]!r}; expected names of {', '.join(PARAMETERS)}")
        moved = np.zeros((self.cell.node_count, 5)) if start is None else np.array(start)
        unknown = np.concatenate([moved.ravel(), np.zeros(len(free))])
        for _ in range(MOST_ITERATIONS):
            energy, gradient = self._value(shape, unknown, free)
            if np.abs(gradient).max() <= TOLERANCE * self.cell.stiffness:
                return self._state(shape, unknown, free)
            unknown = unknown + self._step(shape, unknown, free, energy, gradient)
        raise SolverError(
            f"yarn cell: the largest unbalanced force is {np.abs(gradient).max():.3g} dyn after {MOST_ITERATIONS} "
            f"iterations at {shape}; expected at most {TOLERANCE * self.cell.stiffness:.3g}; take smaller strains"
        )

    def _step(
        self, shape: CellShape, unknown: Numbers, free: Sequence[str], energy: float, gradient: Numbers
    ) -> Numbers:
        """A step that decreases the energy."""
        hessian = self._hessian(shape, unknown, free)
        largest = float(np.abs(hessian.diagonal()).max())
        shift = SMALLEST_SHIFT
        while shift <= LARGEST_SHIFT:
            direction = _solved(hessian + shift * largest * np.eye(len(hessian)), -gradient)
            if direction is not None:
                direction *= min(1.0, LARGEST_MOVE * self._size / np.abs(direction).max())
                for halving in range(MOST_HALVINGS):
                    step = direction * 0.5**halving
                    rounding = 1e-14 * abs(energy)
                    if self._value(shape, unknown + step, free)[0] <= energy + 1e-4 * (gradient @ step) + rounding:
                        return step
            shift *= 10.0
        raise SolverError(f"yarn cell: no step decreases the energy at {shape}; take smaller strains")

    def _hessian(self, shape: CellShape, unknown: Numbers, free: Sequence[str]) -> Numbers:
        """The matrix of second derivatives, by differences."""
        step = STEP * self._size
        columns = []
        for unit in np.eye(len(unknown)) * step:
            after, before = (self._value(shape, unknown + sign * unit, free)[1] for sign in (1.0, -1.0))
            columns.append((after - before) / (2.0 * step))
        hessian = np.stack(columns)
        result: Numbers = (hessian + hessian.T) / 2.0
        return result

    def _shaped(self, shape: CellShape, unknown: Numbers, free: Sequence[str]) -> tuple[CellShape, Numbers]:
        """The shape with its free parameters, which are in units of 1 / size, and the movements of the nodes."""
        count = 5 * self.cell.node_count
        for name, value in zip(free, unknown[count:], strict=True):
            shape = shape.changed(name, float(value) / self._size)
        return shape, _centred(unknown[:count].reshape(-1, 5))

    def _value(self, shape: CellShape, unknown: Numbers, free: Sequence[str]) -> tuple[float, Numbers]:
        """Energy of the repeat [erg] and its gradient [dyn]."""
        shape, moved = self._shaped(shape, unknown, free)
        energy, of_positions, of_sliding = self._energy(shape, moved)
        of_moved = np.zeros((self.cell.node_count, 5))
        cell, known = self.cell, self._known
        back = turned_back(shape, cell.flat, of_positions)
        np.add.at(of_moved, cell.copy_of[known], np.concatenate([back, of_sliding], axis=1)[known])
        parts = [_centred(of_moved).ravel()]
        if free:
            slopes = self._slopes(shape, moved, of_positions)
            parts.append(np.array([slopes[PARAMETERS.index(name)] for name in free]) / self._size)
        return energy, np.concatenate(parts)

    def _energy(self, shape: CellShape, moved: Numbers) -> tuple[float, Numbers, Numbers]:
        """Energy of the repeat, and its derivatives by positions and by sliding coordinates."""
        by_node = self._by_node(moved)
        positions = place_nodes(shape, self.cell.flat, by_node[:, :3])
        sliding = self.cell.sliding + by_node[:, 3:]
        state = MixedVector.from_numpy(np.zeros((0, 3)), positions, sliding, wp.float64, self.device)
        force = state.like()
        for term in self.terms:
            term.forces(state, force, partial(launch, device=self.device))
        _vertices, nodes, slides = force.numpy()
        return sum(term.energy(state) for term in self.terms), -nodes, -slides

    def _by_node(self, moved: Numbers) -> Numbers:
        """Movements of all nodes of the patch, shape (P, 5)."""
        by_node = np.zeros((len(self.cell.flat), 5))
        by_node[self._known] = moved[self.cell.copy_of[self._known]]
        return by_node

    def _slopes(self, shape: CellShape, moved: Numbers, of_positions: Numbers) -> Numbers:
        """Derivatives of the energy of the repeat by the parameters of the shape."""
        derivatives = shape_derivatives(shape, self.cell.flat, self._by_node(moved)[:, :3])
        result: Numbers = np.einsum("kpd,pd->k", derivatives, of_positions)
        return result

    def _state(self, shape: CellShape, unknown: Numbers, free: Sequence[str]) -> CellState:
        shape, moved = self._shaped(shape, unknown, free)
        energy, of_positions, _of_sliding = self._energy(shape, moved)
        slopes = self._slopes(shape, moved, of_positions) / self.cell.area
        return CellState(shape, moved.copy(), energy / self.cell.area, slopes)


def _centred(moved: Numbers) -> Numbers:
    """Movements without the mean displacement."""
    mean = np.zeros(5)
    mean[:3] = moved[:, :3].mean(axis=0)
    return moved - mean


def _solved(matrix: Numbers, right: Numbers) -> Numbers | None:
    """The solution of a linear system with a positive matrix; None if it is not positive."""
    try:
        solution: Numbers = cho_solve(cho_factor(matrix), right)
    except LinAlgError:
        return None
    return solution
