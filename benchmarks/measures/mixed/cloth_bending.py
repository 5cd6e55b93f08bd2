# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How the bending of triangles depends on their mesh: cylinders, a plate, and a heavy strip.

The first table compares hinges alone (discrete shells, D l^2 theta^2 / (2 A) for each hinge) with coupled hinges
(``stitchmesh/mixed/triangles/curvature.py``): the energy of a cylinder over D kappa^2 / 2 per area, smallest and
largest over the directions of its axis, and the error of the largest deflection of a simply supported square plate for
each number of cells along a side.

The second table shows what triangles across a fold cost: how much less the end of a heavy strip drops (w L^3 / B = 4)
than a strip that is easily stretched, for edges of length h and h^4 Y / (L^2 B) = 1, 10, 100.
"""

from __future__ import annotations

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import spsolve

from benchmarks.scenes.cloths import Kind, rectangle
from benchmarks.table import Rows
from stitchmesh.compute.device import device_named
from stitchmesh.mixed.assembly import triangle_masses
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.dynamics.equilibrium import EquilibriumSettings, find_equilibrium
from stitchmesh.mixed.dynamics.mass_matrix import FabricPoints, blend_masses
from stitchmesh.mixed.dynamics.mixed_system import MixedSystem
from stitchmesh.mixed.enrichment.region import FreeUnknowns, embed, region_around
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.curvature import SideFrames, hinge_stiffness
from stitchmesh.mixed.triangles.membrane import Membrane
from stitchmesh.mixed.triangles.shell_bending import ShellBending
from stitchmesh.simulation.dead_load import Gravity

FloatArray = NDArray[np.float64]
KINDS: tuple[Kind, ...] = ("diagonals", "alternating", "irregular")
DEFLECTION = 0.00406235
"""Largest deflection of the plate, in q a^4 / D."""


def angles_of_heights(cloth: Cloth) -> csc_array:
    """The matrix from heights of vertices to small angles of hinges, shape (H, V)."""
    frames = SideFrames(cloth)
    first, second = cloth.hinge_sides.T
    x2, h2 = frames.apex[first].T
    x3, h3 = frames.apex[second].T
    length = frames.length[first]
    a2, a3 = 0.5 + x2 / length, 0.5 - x3 / length
    rows = np.column_stack([(1.0 - a2) / h2 + (1.0 - a3) / h3, a2 / h2 + a3 / h3, -1.0 / h2, -1.0 / h3])
    number = np.repeat(np.arange(len(first)), 4)
    return csc_array((rows.ravel(), (number, cloth.hinges.ravel())), shape=(len(first), len(cloth.vertices)))


def hinges_alone(cloth: Cloth, weight: FloatArray) -> diags_array:
    """The matrix between the angles of hinges of discrete shells, for D = 1."""
    sides = cloth.hinge_sides
    area = cloth.rest_area[sides // 3].sum(axis=1)
    inside = weight[sides // 3].mean(axis=1)
    return diags_array(inside * SideFrames(cloth).length[sides[:, 0]] ** 2 / area)


def hinges_coupled(cloth: Cloth, weight: FloatArray) -> csc_array:
    """The matrix of the coupled hinges, for D = 1."""
    rigidities = np.broadcast_to(np.diag([1.0, 1.0, 0.5]), (len(cloth.triangles), 3, 3))
    return csc_array(hinge_stiffness(cloth, rigidities, weight))


MODELS = {"hinges alone": hinges_alone, "hinges coupled": hinges_coupled}


def cylinder_costs(kind: Kind, model: str) -> tuple[float, float]:
    """Smallest and largest energy of a cylinder over D kappa^2 / 2 per area, away from the border."""
    cloth = rectangle(kind, 24, 24, 1.0 / 24.0)
    border = ((cloth.rest < 1.5 / 24.0) | (cloth.rest > 1.0 - 1.5 / 24.0)).any(axis=(1, 2))
    weight = np.where(border, 1e-12, 1.0)
    matrix, angles = MODELS[model](cloth, weight), angles_of_heights(cloth)
    costs = []
    for direction in np.arange(0.0, np.pi, np.pi / 24.0):
        along = cloth.vertices[:, :2] @ [np.cos(direction), np.sin(direction)]
        found = angles @ (0.5 * along**2)
        costs.append(float(found @ (matrix @ found)) / float(cloth.rest_area @ weight))
    return min(costs), max(costs)


def plate_error(kind: Kind, model: str, count: int) -> float:
    """Relative error of the largest deflection of a simply supported square plate."""
    cloth = rectangle(kind, count, count, 1.0 / count)
    angles = angles_of_heights(cloth)
    matrix = csc_array(angles.T @ MODELS[model](cloth, np.ones(len(cloth.triangles))) @ angles)
    inner = np.flatnonzero(((cloth.vertices[:, :2] > 1e-9) & (cloth.vertices[:, :2] < 1.0 - 1e-9)).all(axis=1))
    load = np.bincount(cloth.triangles.ravel(), np.repeat(cloth.rest_area / 3.0, 3))
    return float(np.abs(spsolve(matrix[inner][:, inner], load[inner])).max()) / DEFLECTION - 1.0


def drop_of_strip(kind: Kind, modulus: float, columns: int = 12) -> float:
    """Drop of the end of a heavy strip of length 1 that is clamped half-way between its first columns of vertices."""
    edge = 1.0 / (columns - 0.5)
    cloth = rectangle(kind, columns, 2, edge)
    material = ClothMaterial.isotropic("strip", modulus, 0.0, 1.0, 4.0 / 981.0)
    x = cloth.vertices[:, 0] - 0.5 * edge
    held = np.argsort(x, kind="stable")[:6]
    region = region_around(cloth.triangles, len(x), np.zeros(0, dtype=int), np.zeros((0, 3)), [])
    none = np.zeros((0, 2), dtype=int)
    masses = blend_masses(region, none, np.zeros(0), none, triangle_masses(cloth, material))
    device = device_named("cpu")
    points = FabricPoints(masses, float(cloth.rest_area.sum()), wp.float64, device)
    elastic = [kind_of(cloth, material, wp.float64, device) for kind_of in (Membrane, ShellBending)]
    terms = [*elastic, Gravity((0.0, 0.0, -981.0)).on(points)]
    free = FreeUnknowns.of(region, fixed_vertices=held)
    system = MixedSystem(embed(region), free, masses, terms, scalar=wp.float64, device=device)
    start = np.column_stack([x, cloth.vertices[:, 1], np.where(np.isin(np.arange(len(x)), held), 0.0, -0.1 * x**2)])
    state = MixedVector.from_numpy(start, [], [], wp.float64, device)
    report = find_equilibrium(system, state, EquilibriumSettings(force_tolerance=1e-6))
    assert report.converged, report
    return -float(state.numpy()[0][x > 1.0 - 1e-9, 2].mean())


def cloth_bending() -> Rows:
    """Yield both tables."""
    counts = (8, 16, 32)  # cells along a side of the plate
    yield "mesh", "model", "cylinder", *(f"plate of {count}" for count in counts)
    for kind in KINDS:
        for model in MODELS:
            low, high = cylinder_costs(kind, model)
            errors = (f"{100.0 * plate_error(kind, model, count):.2f} %" for count in counts)
            yield kind, model, f"{low:.3f} to {high:.3f}", *errors
    yield ""
    yield "mesh", *(f"h^4 Y/(L^2 B) = {ratio}" for ratio in (1, 10, 100))
    for kind in KINDS:
        easy = drop_of_strip(kind, 2e3)
        drops = [drop_of_strip(kind, ratio * 11.5**4) / easy - 1.0 for ratio in (1.0, 10.0, 100.0)]
        yield kind, *(f"{100.0 * drop:.2f} %" for drop in drops)
