# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Strips of triangles at rest: a catenary, heavy cantilevers, and the load under which a strip buckles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import warp as wp
from scipy.linalg import eigh

from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.dynamics.mass_matrix import BlendedMasses, FabricPoints
from stitchmesh.mixed.term import MixedTerm
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.membrane import Membrane
from stitchmesh.mixed.triangles.shell_bending import ShellBending
from stitchmesh.simulation.dead_load import Gravity
from tests.mixed.triangles.derivatives import CPU, energy_of, forces_of, hessian_of
from tests.mixed.triangles.flat_cloths import FloatArray, rectangle

STRIP = ClothMaterial.isotropic("strip", 2e4, 0.0, 1.0, 0.02)
"""Stiff against stretch, but not so stiff that triangles across the rulings of a bend, which cannot follow it without
strains of (curvature times edge)^2 / 8, resist it by their stretch."""
TAUT = ClothMaterial.isotropic("taut", 2e6, 0.0, 1.0, 0.02)
GRAVITY = (0.0, 0.0, -981.0)


def equilibrium(terms: Sequence[MixedTerm], vertices: FloatArray, free: np.ndarray, steps: int = 100) -> FloatArray:
    """The vertices at rest.

    Args:
        terms: energies in double precision.
        vertices: start, shape (V, 3).
        free: whether each coordinate may move, shape (V, 3).
        steps: largest number of Newton steps.
    """
    index, part = np.flatnonzero(free.ravel()), 0.0
    for _step in range(steps):
        force = sum(forces_of(term, vertices) for term in terms).ravel()[index]
        size = max(float(np.abs(forces_of(term, vertices)).max()) for term in terms)
        if np.abs(force).max() < 1e-9 * size:
            return vertices
        matrix = sum(hessian_of(term, vertices, part) for term in terms)[np.ix_(index, index)]
        move = np.zeros(vertices.size)
        move[index] = np.linalg.solve(matrix + 1e-12 * np.abs(matrix).max() * np.eye(len(index)), force)
        if move[index] @ force <= 0.0:
            part = 0.0
            continue
        vertices, length = _lowered(terms, vertices, move.reshape(-1, 3))
        part = 1.0 if length == 1.0 else 0.0
    raise AssertionError(f"no equilibrium in {steps} steps: the largest force is {np.abs(force).max():g}")


def _lowered(terms: Sequence[MixedTerm], vertices: FloatArray, move: FloatArray) -> tuple[FloatArray, float]:
    """The vertices moved by the largest halved step that lowers the energy, and the part of the step."""
    before, length = sum(energy_of(term, vertices) for term in terms), 1.0
    while length > 1e-6 and sum(energy_of(term, vertices + length * move) for term in terms) > before:
        length /= 2.0
    return vertices + length * move, length


def terms_of(cloth: Cloth, material: ClothMaterial, density: float, *, bends: bool) -> list:
    """Membrane and weight of a cloth of that mass per area, and its bending."""
    lumped = np.bincount(cloth.triangles.ravel(), np.repeat(cloth.rest_area * density / 3.0, 3))
    weight = Gravity(GRAVITY).on(FabricPoints(BlendedMasses(lumped, np.zeros((0, 2))), 1.0, wp.float64, CPU))
    terms = [Membrane(cloth, material, wp.float64, CPU), weight]
    return [*terms, ShellBending(cloth, material, wp.float64, CPU)] if bends else terms


def test_a_limp_strip_hangs_as_a_catenary():
    """Sag over span of a strip that is half as long again as the span."""
    ratio, sag = 1.5, 0.502633
    errors = []
    for columns in (6, 12):
        cloth = rectangle("diagonals", columns, 1, ratio, 0.1)
        x = cloth.vertices[:, 0] / ratio
        start = np.column_stack([x, cloth.vertices[:, 1], -4.0 * sag * x * (1.0 - x)])
        free = np.ones(start.shape, dtype=bool)
        free[(x == 0.0) | (x == 1.0)] = False
        rest = equilibrium(terms_of(cloth, TAUT, 0.02, bends=False), start, free)
        errors.append(-rest[:, 2].min() / sag - 1.0)
    # the sag of a polygon differs by the square of the length of its edges
    assert 0.0 < errors[1] < 6e-3 and 3.7 < errors[0] / errors[1] < 4.5


@pytest.mark.nightly
def test_a_heavy_cantilever():
    """Drop of the end over length for w L^3 / B = 4, with the weight w per area and the rigidity B of a strip."""
    columns, load, drop = 12, 4.0, 0.425159
    edge = 1.0 / (columns - 0.5)
    cloth = rectangle("irregular", columns, 2, columns * edge, 2.0 * edge)
    x = cloth.vertices[:, 0] - 0.5 * edge  # the strip is clamped half-way between two columns that are held
    free = np.ones(cloth.vertices.shape, dtype=bool)
    held = np.argsort(x, kind="stable")[:6]
    free[held] = False
    start = np.column_stack([x, cloth.vertices[:, 1], -0.1 * np.maximum(x, 0.0) ** 2])
    start[held, 2] = 0.0
    density = load * STRIP.bending_course / 981.0
    rest = equilibrium(terms_of(cloth, STRIP, density, bends=True), start, free)
    # errors of the square of an edge, 1 / 130; irregular triangles are held along an uneven line too
    assert -rest[x > 1.0 - 1e-9, 2].mean() == pytest.approx(drop, rel=0.03)


def test_the_load_under_which_a_strip_buckles():
    """Euler: pi^2 B / L^2 per width between pinned ends."""
    cloth = rectangle("irregular", 24, 2, 1.0, 0.1)
    free = (cloth.vertices[:, 0] > 1e-9) & (cloth.vertices[:, 0] < 1.0 - 1e-9)
    bending = heights_of(hessian_of(ShellBending(cloth, STRIP, wp.float64, CPU), cloth.vertices), free)
    strain = 1e-6
    pressed = cloth.vertices * [1.0 - strain, 1.0, 1.0]
    pressing = heights_of(hessian_of(Membrane(cloth, STRIP, wp.float64, CPU), pressed), free) / (2e4 * strain)
    load = 1.0 / eigh(-pressing, bending, eigvals_only=True)[-1]
    assert load == pytest.approx(np.pi**2, rel=0.01)


def heights_of(matrix: FloatArray, free: np.ndarray) -> FloatArray:
    """The rows and columns of the heights of the free vertices."""
    index = 3 * np.flatnonzero(free) + 2
    return matrix[np.ix_(index, index)]
