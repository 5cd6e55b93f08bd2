# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Equilibrium of a periodic cell of yarns at a given strain and curvature.

The unknowns are the displacement w and the two sliding coordinates of each node of the repeat, and the free parameters
of the shape, such as the width of a strip that is pulled along its length. The mean of w is zero, so that the curvature
belongs to the middle of the yarns. The energy has its minimum at the equilibrium. Newton's method finds it with a dense
matrix from differences of the gradient; the eigenvalues of the matrix are replaced by their absolute values, so that
every step goes downhill (Dauphin et al. 2014). At an equilibrium the derivatives of the energy by the parameters of the
shape are exact tensions and moments: the unknowns contribute nothing, because the energy does not change with them to
first order.

Yarns slide without friction, or friction holds them where they are laid out. The loops of a knit without friction open
at nearly no tension until they are tight; with friction they are stiff from the beginning.

A flat fabric of flat yarns is an equilibrium by symmetry, also under compression, where it is not stable. Such a state
is kept, because the triangles that are fitted to it are flat too: buckling belongs to their positions, not to their
law.

``CellShape`` is the shape of a fabric of uniform strain and curvature, on which a periodic cell of yarns lies (Sperl et
al. 2020).

A point X of the flat fabric is first stretched in its plane, Y = U X, and then rolled on a cylinder of curvature kappa
whose axis is across a direction d: with s = d . Y, e the coordinate of Y across d, and theta = kappa s,

    c(X) = (s sinc theta) d + e d' + (kappa s^2 / 2 sinc^2(theta / 2)) n

A node of the cell that has moved by w in the flat fabric lies at c(X) + R(theta) w, where R turns the plane of d and
the normal n by theta. All copies of a node have the same w, so forces and energy belong to an endless fabric. Without
curvature the fabric is flat and x = U X + w.

``shape_derivatives`` differentiates by steps of imaginary numbers, which has no error of cancellation: for real x,
dx/dm = Im x(m + i h) / h with h = 1e-30.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.linalg import eigh

from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.launch import launch
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.mixed.crossings.crossing_term import CrossingTerm
from stitchmesh.mixed.crossings.stitch_term import StitchTerm
from stitchmesh.mixed.matching.yarn_cell import OUTSIDE, YarnCell
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import MixedTerm

Numbers = NDArray[np.float64]
PARAMETERS = ("stretch_course", "stretch_wale", "skew", "curvature")
"""Names of the parameters of a shape, in the order of derivatives."""
MOST_ITERATIONS = 150


@dataclass(frozen=True)
class CellShape:
    """Uniform strain and curvature of a fabric; axis 1 along courses (wefts), axis 2 along wales (warps)."""

    stretch_course: Any = 1.0
    """U_11."""
    stretch_wale: Any = 1.0
    """U_22."""
    skew: Any = 0.0
    """U_12 = U_21."""
    curvature: Any = 0.0
    """Curvature kappa of the cylinder [1/cm]."""
    direction: float = 0.0
    """Angle between axis 1 and the direction d along which the fabric is curved [rad]."""

    def changed(self, name: str, change: Any) -> CellShape:
        """The shape with a number added to one parameter."""
        return replace(self, **{name: getattr(self, name) + change})


def place_nodes(shape: CellShape, flat: Numbers, moved: Numbers) -> Any:
    """Positions of nodes [cm], shape (P, 3).

    Args:
        shape: strain and curvature of the fabric; complex parameters give complex positions.
        flat: X of each node [cm], shape (P, 2).
        moved: w of each node [cm], shape (P, 3).
    """
    c, s = np.cos(shape.direction), np.sin(shape.direction)
    x = shape.stretch_course * flat[:, 0] + shape.skew * flat[:, 1]
    y = shape.skew * flat[:, 0] + shape.stretch_wale * flat[:, 1]
    along, across = c * x + s * y, c * y - s * x
    angle = shape.curvature * along
    sine, cosine = np.sin(angle), np.cos(angle)
    moved_along, moved_across = c * moved[:, 0] + s * moved[:, 1], c * moved[:, 1] - s * moved[:, 0]
    on_axis = along * np.sinc(angle / np.pi) + moved_along * cosine - moved[:, 2] * sine
    height = shape.curvature * along**2 / 2.0 * np.sinc(angle / (2.0 * np.pi)) ** 2
    height = height + moved_along * sine + moved[:, 2] * cosine
    beside = across + moved_across
    return np.stack([c * on_axis - s * beside, s * on_axis + c * beside, height], axis=1)


def turned_back(shape: CellShape, flat: Numbers, vectors: Numbers) -> Numbers:
    """R^T times a vector at each node, shape (P, 3): the derivative by w of a function with these derivatives by x."""
    c, s = np.cos(shape.direction), np.sin(shape.direction)
    x = shape.stretch_course * flat[:, 0] + shape.skew * flat[:, 1]
    y = shape.skew * flat[:, 0] + shape.stretch_wale * flat[:, 1]
    angle = shape.curvature * (c * x + s * y)
    along, across = c * vectors[:, 0] + s * vectors[:, 1], c * vectors[:, 1] - s * vectors[:, 0]
    back = along * np.cos(angle) + vectors[:, 2] * np.sin(angle)
    up = vectors[:, 2] * np.cos(angle) - along * np.sin(angle)
    return np.stack([c * back - s * across, s * back + c * across, up], axis=1)


def shape_derivatives(shape: CellShape, flat: Numbers, moved: Numbers) -> Numbers:
    """Derivatives of the positions by each of the ``PARAMETERS``, shape (4, P, 3)."""
    step = 1e-30
    stepped = (shape.changed(name, 1j * step) for name in PARAMETERS)
    return np.stack([place_nodes(each, flat, moved).imag / step for each in stepped])


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
    """Derivatives of ``energy`` by the ``PARAMETERS``: tension along courses and along wales [dyn/cm], derivative by
    the skew [dyn/cm], and moment [dyn]; shape (4,)."""


class CellSolver:
    """Equilibria of one cell."""

    def __init__(self, cell: YarnCell, *, sliding: bool = True) -> None:
        """Put the energies of the cell on the CPU, because a cell has few nodes.

        Args:
            cell: the repeat.
            sliding: whether yarns slide through their crossings without friction; otherwise friction holds them where
                they are laid out.
        """
        self.cell, self.device = cell, device_named("cpu")
        self.kept = np.array([True, True, True, sliding, sliding])
        self.size = float(np.sqrt(cell.area))
        self.terms: list[MixedTerm] = [CrossingTerm(cell.elements, wp.float64, self.device)]
        if len(cell.stitches.nodes):
            self.terms.append(StitchTerm(cell.stitches, cell.elements.count, wp.float64, self.device))
        self._known = np.flatnonzero(cell.copy_of != OUTSIDE)

    @alone()
    def equilibrium(
        self,
        shape: CellShape,
        start: Numbers | None = None,
        *,
        free: Sequence[str] = (),
        load: Numbers | None = None,
        held: bool = False,
    ) -> CellState:
        """Find the equilibrium.

        Args:
            shape: strain and curvature.
            start: ``CellState.moved`` of a nearby state, shape (n, 5); the layout if it is None.
            free: names of the parameters of the shape that are unknown; the search begins at their values in ``shape``.
            load: tension along courses, tension along wales, and load on the skew, which act on the fabric [dyn/cm],
                shape (3,).
            held: whether the nodes keep their places ``start`` in the fabric.

        Raises:
            ParameterError: a name is not a parameter of the shape.
            SolverError: forces do not balance after many iterations.
        """
        wrong = [name for name in free if name not in PARAMETERS]
        if wrong:
            raise ParameterError(f"yarn cell: free: got {wrong[0]!r}; expected names of {', '.join(PARAMETERS)}")
        moved = np.zeros((self.cell.node_count, 5)) if start is None else np.array(start)
        search = _Search(self, shape, moved, tuple(free), np.zeros(3) if load is None else np.asarray(load), held)
        return search.run()

    def energy(self, shape: CellShape, moved: Numbers) -> tuple[float, Numbers, Numbers]:
        """Energy of the repeat [erg], and its derivatives by the positions and the sliding coordinates of the patch.

        Args:
            shape: strain and curvature.
            moved: as ``CellState.moved``.
        """
        by_node = self._by_node(moved)
        positions = place_nodes(shape, self.cell.flat, by_node[:, :3])
        sliding = self.cell.sliding + by_node[:, 3:]
        state = MixedVector.from_numpy(np.zeros((0, 3)), positions, sliding, wp.float64, self.device)
        force = state.like()
        for term in self.terms:
            term.forces(state, force, partial(launch, device=self.device))
        _vertices, nodes, slides = force.numpy()
        return sum(term.energy(state) for term in self.terms), -nodes, -slides

    def of_repeat(self, shape: CellShape, by_positions: Numbers, by_sliding: Numbers) -> Numbers:
        """Derivatives by the movements of the repeat, shape (n, 5), from the derivatives by the nodes of the patch."""
        result = np.zeros((self.cell.node_count, 5))
        back = turned_back(shape, self.cell.flat, by_positions)
        np.add.at(result, self.cell.copy_of[self._known], np.concatenate([back, by_sliding], axis=1)[self._known])
        return result

    def slopes(self, shape: CellShape, moved: Numbers, by_positions: Numbers) -> Numbers:
        """Derivatives of the energy of the repeat by the ``PARAMETERS``, shape (4,)."""
        derivatives = shape_derivatives(shape, self.cell.flat, self._by_node(moved)[:, :3])
        result: Numbers = np.einsum("kpd,pd->k", derivatives, by_positions)
        return result

    def _by_node(self, moved: Numbers) -> Numbers:
        """Movements of all nodes of the patch, shape (P, 5)."""
        by_node = np.zeros((len(self.cell.flat), 5))
        by_node[self._known] = moved[self.cell.copy_of[self._known]]
        return by_node


@dataclass(frozen=True, eq=False)
class _Search:
    """The search for one equilibrium; unknowns are movements of nodes, and free parameters times ``solver.size``."""

    solver: CellSolver
    shape: CellShape
    start: Numbers
    free: tuple[str, ...]
    load: Numbers
    held: bool

    def run(self) -> CellState:
        """Iterate until forces balance."""
        bound = 1e-8 * self.solver.cell.stiffness
        unknown = np.zeros((0 if self.held else self.start.size) + len(self.free))
        force = 0.0
        for _ in range(MOST_ITERATIONS):
            energy, gradient = self._value(unknown)
            force = float(np.abs(gradient).max(initial=0.0))
            if force <= bound:
                return self._state(unknown)
            unknown = unknown + self._step(unknown, energy, gradient)
        raise SolverError(
            f"yarn cell: the largest unbalanced force is {force:.3g} dyn after {MOST_ITERATIONS} iterations at "
            f"{self.shape}; expected at most {bound:.3g}; take smaller strains"
        )

    def _step(self, unknown: Numbers, energy: float, gradient: Numbers) -> Numbers:
        """A step that decreases the energy."""
        values, vectors = eigh(self._hessian(unknown))
        curvature = np.abs(values)
        # some motions cost no energy, such as yarns that slide as a whole
        curvature = np.maximum(curvature, 1e-9 * curvature.max())
        direction: Numbers = -vectors @ ((vectors.T @ gradient) / curvature)
        direction *= min(1.0, 0.1 * self.solver.size / np.abs(direction).max())  # a tenth of the repeat at most
        slope, rounding = float(gradient @ direction), 1e-14 * abs(energy)
        for halving in range(40):
            part = 0.5**halving
            # a step reaches a part of the decrease that the linear model predicts (Armijo)
            if self._value(unknown + part * direction)[0] <= energy + 1e-4 * part * slope + rounding:
                return part * direction
        raise SolverError(f"yarn cell: no step decreases the energy at {self.shape}; take smaller strains")

    def _hessian(self, unknown: Numbers) -> Numbers:
        """The matrix of second derivatives, by differences."""
        step = 1e-6 * self.solver.size
        columns = []
        for unit in np.eye(len(unknown)) * step:
            after, before = (self._value(unknown + sign * unit)[1] for sign in (1.0, -1.0))
            columns.append((after - before) / (2.0 * step))
        hessian = np.stack(columns)
        result: Numbers = (hessian + hessian.T) / 2.0
        return result

    def _shaped(self, unknown: Numbers) -> tuple[CellShape, Numbers]:
        """The shape with its free parameters, and the movements of the nodes."""
        shape, count = self.shape, len(unknown) - len(self.free)
        for name, value in zip(self.free, unknown[count:], strict=True):
            shape = shape.changed(name, float(value) / self.solver.size)
        return shape, self._allowed(self.start + unknown[:count].reshape(self.start.shape)) if count else self.start

    def _value(self, unknown: Numbers) -> tuple[float, Numbers]:
        """Energy of the repeat without the work of the load [erg], and its gradient [dyn]."""
        solver = self.solver
        shape, moved = self._shaped(unknown)
        energy, by_positions, by_sliding = solver.energy(shape, moved)
        parts = [np.zeros(0)]
        if not self.held:
            parts.append(self._allowed(solver.of_repeat(shape, by_positions, by_sliding)).ravel())
        if self.free:
            pull = np.append(self.load, 0.0) * solver.cell.area
            slopes = (solver.slopes(shape, moved, by_positions) - pull) / solver.size
            parts.append(np.array([slopes[PARAMETERS.index(name)] for name in self.free]))
            energy -= float(sum(pull[k] * getattr(shape, name) for k, name in enumerate(PARAMETERS)))
        return energy, np.concatenate(parts)

    def _allowed(self, moved: Numbers) -> Numbers:
        """Movements without their mean displacement, and without sliding where friction holds the yarns."""
        mean = moved.mean(axis=0)
        mean[3:] = 0.0
        result: Numbers = (moved - mean) * self.solver.kept
        return result

    def _state(self, unknown: Numbers) -> CellState:
        shape, moved = self._shaped(unknown)
        energy, by_positions, _by_sliding = self.solver.energy(shape, moved)
        area = self.solver.cell.area
        return CellState(shape, moved.copy(), energy / area, self.solver.slopes(shape, moved, by_positions) / area)
