# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How uniform deformation passes the hybrid region.

A weave with triangles that are matched to its yarns is held at its border in a uniform stretch of 0.1 % or 5 %, or a
shear of 1 %, and comes to its equilibrium. The root mean square displacement of the full-yarn nodes is given in
spacings of yarns for each unit of strain.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

import stitchmesh as sm
from benchmarks.table import Rows
from stitchmesh.compute.device import device_named
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.cloth.seams import cloth_from_panels
from stitchmesh.mixed.dynamics.cloth_system import ClothModel, cloth_system
from stitchmesh.mixed.dynamics.equilibrium import EquilibriumSettings, find_equilibrium
from stitchmesh.mixed.enrichment.region import YARNS, region_around
from stitchmesh.mixed.layout.weave import lay_weave
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial

Numbers = NDArray[np.float64]
SIDE, EDGE, HALF = 4.8, 0.6, 0.5
"""Side of the cloth, edges of the triangles, and half the side of the region [cm]."""
DEFORMATIONS = {
    "stretch 0.1 %": np.diag([1.001, 1.0005, 1.0]),
    "stretch 5 %": np.diag([1.05, 1.02, 1.0]),
    "shear 1 %": np.array([[1.0, 0.01, 0.0], [0.01, 1.0, 0.0], [0.0, 0.0, 1.0]]),
}
TOLERANCE = 1e-3
"""Largest unbalanced force [dyn]."""


def displacements(density: float, rings: int, deformation: Numbers) -> Numbers:
    """Displacements of the full-yarn nodes from a uniform deformation [cm], shape (n, 3)."""
    outline = SIDE * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    cloth = cloth_from_panels([Panel(name="square", outline=outline)], [], edge_length=EDGE)
    yarns = lay_weave(cloth, np.eye(2, dtype=int), ends=density, picks=density)
    middle = np.abs(cloth.vertices[cloth.triangles].mean(axis=1)[:, :2] - SIDE / 2).max(axis=1) < HALF
    layout = cloth.triangles, len(cloth.vertices), yarns.triangle, yarns.barycentric
    region = region_around(*layout, np.flatnonzero(middle), rings=rings)
    material = sm.FabricMaterials.of(sm.CrossingMaterial.named("gong-1"))
    model = ClothModel(matched(density, material), material, acceleration=(0, 0, 0))
    border = np.abs(cloth.vertices[:, :2] - SIDE / 2).max(axis=1) > SIDE / 2 - 1e-9
    made = cloth_system(
        cloth, yarns, region, model, fixed_vertices=np.flatnonzero(border), vertices=cloth.vertices @ deformation.T,
        device=device_named("cpu"),
    )  # fmt: skip
    start = made.positions.numpy()[1].copy()
    find_equilibrium(made.system, made.positions, EquilibriumSettings(force_tolerance=TOLERANCE))
    return (made.positions.numpy()[1] - start)[region.node_kind[region.nodes] == YARNS]


@cache
def matched(density: float, material: sm.FabricMaterials) -> ClothMaterial:
    """The material of triangles that is fitted to the weave."""
    return sm.match_cloth(sm.weave_cell([[1, 0], [0, 1]], ends=density, picks=density, materials=material)).material


def row(density: float, rings: int) -> tuple[object, ...]:
    """A row of the table."""
    cells = []
    for deformation in DEFORMATIONS.values():
        strain = np.abs(deformation - np.eye(3)).max()
        cells.append(f"{rms(displacements(density, rings, deformation)) * density / strain:.4f}")
    return f"{density:g}", rings, *cells


def rms(vectors: Numbers) -> float:
    """Root mean square length."""
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))


def mixed_patch_test() -> Rows:
    """Yield the table."""
    yield "yarns /cm", "rings", *DEFORMATIONS
    for density, rings in ((6.0, 1), (6.0, 2), (10.0, 1), (10.0, 2)):
        yield row(density, rings)
