# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Strips of triangles at rest: a catenary, heavy cantilevers, and the load under which a strip buckles."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp
from scipy.linalg import eigh

from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.dynamics.mass_matrix import BlendedMasses, MassMatrix
from stitchmesh.mixed.dynamics.weight import Weight
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.membrane import Membrane
from stitchmesh.mixed.triangles.shell_bending import ShellBending
from tests.mixed.triangles.derivatives import CPU, hessian_of
from tests.mixed.triangles.equilibrium import equilibrium
from tests.mixed.triangles.flat_cloths import FloatArray, rectangle
from tests.nightly import at_night

STRIP = ClothMaterial.isotropic("strip", 2e4, 0.0, 1.0, 0.02)
"""Stiff against stretch, but not so stiff that triangles across the rulings of a bend, which cannot follow it without
strains of (curvature times edge)^2 / 8, resist it by their stretch."""
TAUT = ClothMaterial.isotropic("taut", 2e6, 0.0, 1.0, 0.02)
GRAVITY = (0.0, 0.0, -981.0)


def terms_of(cloth: Cloth, material: ClothMaterial, density: float, *, bends: bool) -> list:
    """Membrane and weight of a cloth of that mass per area, and its bending."""
    lumped = np.bincount(cloth.triangles.ravel(), np.repeat(cloth.rest_area * density / 3.0, 3))
    weight = Weight(MassMatrix(BlendedMasses(lumped, np.zeros((0, 2))), wp.float64, CPU), GRAVITY)
    terms = [Membrane(cloth, material, wp.float64, CPU), weight]
    return [*terms, ShellBending(cloth, material, wp.float64, CPU)] if bends else terms


@pytest.mark.parametrize(("ratio", "sag"), [(1.5, 0.502633), *at_night((1.1, 0.200301))])
def test_a_limp_strip_hangs_as_a_catenary(ratio, sag):
    """Sag over span of a strip whose length is a multiple of the span."""
    errors = []
    for columns in (8, 16):
        cloth = rectangle("diagonals", columns, 1, ratio, 0.1)
        x = cloth.vertices[:, 0] / ratio
        start = np.column_stack([x, cloth.vertices[:, 1], -4.0 * sag * x * (1.0 - x)])
        free = np.ones(start.shape, dtype=bool)
        free[(x == 0.0) | (x == 1.0)] = False
        rest = equilibrium(terms_of(cloth, TAUT, 0.02, bends=False), start, free)
        errors.append(-rest[:, 2].min() / sag - 1.0)
    # the sag of a polygon differs by the square of the length of its edges
    assert 0.0 < errors[1] < 3e-3 and 3.7 < errors[0] / errors[1] < 4.5


@pytest.mark.parametrize(
    ("kind", "load", "drop"),
    [("irregular", 4.0, 0.425159), *at_night(("diagonals", 1.0, 0.123471), ("alternating", 8.0, 0.640631))],
)
def test_a_heavy_cantilever(kind, load, drop):
    """Drop of the end over length for G = w L^3 / B, with the weight w per area and the rigidity B of a strip."""
    columns = 12
    edge = 1.0 / (columns - 0.5)
    cloth = rectangle(kind, columns, 2, columns * edge, 2.0 * edge)
    x = cloth.vertices[:, 0] - 0.5 * edge  # the strip is clamped half-way between two columns that are held
    free = np.ones(cloth.vertices.shape, dtype=bool)
    held = np.argsort(x, kind="stable")[:6]
    free[held] = False
    start = np.column_stack([x, cloth.vertices[:, 1], -0.1 * np.maximum(x, 0.0) ** 2])
    start[held, 2] = 0.0
    density = load * STRIP.bending_course / 981.0
    rest = equilibrium(terms_of(cloth, STRIP, density, bends=True), start, free)
    # errors of the square of an edge, 1 / 130; irregular triangles are held along an uneven line too
    assert -rest[x > 1.0 - 1e-9, 2].mean() == pytest.approx(drop, rel=0.03 if kind == "irregular" else 0.01)


@pytest.mark.parametrize("kind", ["diagonals", "alternating", "irregular"])
def test_the_load_under_which_a_strip_buckles(kind):
    """Euler: pi^2 B / L^2 per width between pinned ends."""
    cloth = rectangle(kind, 24, 2, 1.0, 0.1)
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
