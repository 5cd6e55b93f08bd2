# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the choices of the mixed solver are worth: its preconditioner, the blocks of its metric, and weights of stretch.

``preconditioner`` and ``blocks`` count the iterations of conjugate gradients of one linear solve, until the velocities
of all vertices and nodes differ by 1e-4 from those of a solve to 1e-10, relative root mean squares
(``linear_systems.py``). The ratio of masses is that of the heaviest vertex to the lightest node.

``patch`` and ``weights`` compare the weights of stretch that balance uniform tension with the weights of alpha.
``patch`` holds a weave with matched triangles at its border in a uniform deformation, and gives the root mean square
displacement of the full-yarn nodes at its equilibrium, in spacings of yarns for each unit of strain. ``weights`` runs
the regions made by hand of ``benchmarks/scenes/loadings.py`` from two starts each: root mean square distances of the
nodes of the measured part from the run with yarns everywhere from the same start, in yarn spacings, and products.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from functools import cache, partial
from typing import Any
from unittest.mock import patch as patched

import numpy as np
from numpy.typing import NDArray

import stitchmesh as sm
from benchmarks.measures.mixed.linear_systems import (
    Case,
    Hanging,
    Precondition,
    ShakenLoops,
    by_one_number,
    by_projection,
    generalized,
    iterations,
)
from benchmarks.measures.mixed.mixed import End, run_scene, with_rings
from benchmarks.measures.mixed.node_errors import position_error
from benchmarks.scenes.loadings import LOADINGS, Loading
from benchmarks.table import Rows
from stitchmesh.compute.device import device_named
from stitchmesh.mixed.assembly import Loads, MixedFabric, loaded_system, start_positions
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.cloth.seams import cloth_from_panels
from stitchmesh.mixed.contact.motion import Attachment
from stitchmesh.mixed.dynamics.equilibrium import EquilibriumSettings, find_equilibrium
from stitchmesh.mixed.enrichment.region import YARNS, region_around
from stitchmesh.mixed.layout.weave import lay_weave
from stitchmesh.mixed.scene.scene import SceneSolverSection
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, with_region
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial

Numbers = NDArray[np.float64]
Variants = dict[str, Callable[[Case], Precondition]]
PRECONDITIONERS: Variants = {
    "none": partial(generalized, by_mass=False),
    "mass diagonal": partial(generalized, by_mass=True),
    "P": partial(by_projection, stiffness=False),
    "P with stiffness": partial(by_projection, stiffness=True),
}
SWINGING = [
    Hanging("weave", edge=1.0, density=8.0, step=1e-3), Hanging("weave", edge=0.5, density=16.0, step=1e-3),
    Hanging("weave", edge=1.0, density=16.0, step=1e-3), Hanging("weave", edge=1.0, density=16.0, step=1e-4),
    Hanging("weave", edge=1.0, density=32.0, step=1e-4),
]  # fmt: skip
"""Cloths on which preconditioners are compared."""
METRICS: Variants = {"one number": by_one_number, "blocks": partial(by_projection, stiffness=True)}
STIFF: list[Hanging | ShakenLoops] = [
    Hanging("knit", edge=1.0, density=4.0, step=1e-3), Hanging("knit", edge=1.0, density=4.0, step=1e-1),
    Hanging("knit", edge=0.5, density=4.0, step=1e-1), Hanging("weave", edge=1.0, density=16.0, step=1e-3),
    Hanging("weave", edge=1.0, density=16.0, step=1e-1), Hanging("weave", edge=0.5, density=8.0, step=1e-1),
    ShakenLoops(step=1e-3), ShakenLoops(step=1e-1),
]  # fmt: skip
"""Cloths on which metrics are compared."""


def preconditioner() -> Rows:
    """Count iterations with no preconditioner, the mass diagonal, and P."""
    yield "cloth", "step s", "vertices", "nodes", "mass ratio", *PRECONDITIONERS
    for cloth in SWINGING:
        case = cloth.case()
        masses = case.scene.masses
        ratio = f"{masses.vertices.max() / masses.nodes.min():.1e}"
        yield cloth.name, f"{cloth.step:g}", *case.sizes[:2], ratio, *counts(case, PRECONDITIONERS, 3000)


def blocks() -> Rows:
    """Count iterations with blocks in the hybrid region, and with the mean of their diagonal."""
    yield "yarns", "step s", "nodes", "hybrid", "vertices of Sigma", *METRICS
    for cloth in STIFF:
        case = cloth.case()
        yield cloth.name, f"{cloth.step:g}", *case.sizes[1:], *counts(case, METRICS, 8000)


def counts(case: Case, variants: Variants, most: int) -> Iterator[str]:
    """Iterations with each variant, of a solve that ends after ``most``."""
    for variant in variants.values():
        count = iterations(case, variant(case), most)
        yield f"over {most}" if count == most else str(count)


def of_alpha() -> AbstractContextManager[Any]:
    """Make systems whose energies of stretch have the weights alpha and 1 - alpha."""
    return patched("stitchmesh.mixed.assembly._stretch_weights", return_value=None)


WEIGHTS: dict[str, Callable[[], AbstractContextManager[Any]]] = {"alpha": of_alpha, "balanced": nullcontext}
SIDE, EDGE, HALF = 4.8, 0.6, 0.5
"""Side of the cloth of ``patch``, edges of its triangles, and half the side of its region [cm]."""
DEFORMATIONS = {
    "stretch 0.1 %": np.diag([1.001, 1.0005, 1.0]),
    "stretch 5 %": np.diag([1.05, 1.02, 1.0]),
    "shear 1 %": np.array([[1.0, 0.01, 0.0], [0.01, 1.0, 0.0], [0.0, 0.0, 1.0]]),
}
TOLERANCE = 1e-3
"""Largest unbalanced force [dyn]."""


def patch() -> Rows:
    """Compare how uniform deformation passes the hybrid region."""
    yield "yarns /cm", "rings", *(f"{name}, {weight}" for name in DEFORMATIONS for weight in WEIGHTS)
    for density, rings in ((6.0, 1), (6.0, 2), (10.0, 1), (10.0, 2)):
        cells = []
        for deformation in DEFORMATIONS.values():
            strain = np.abs(deformation - np.eye(3)).max()
            for chosen in WEIGHTS.values():
                with chosen():
                    moved = displacements(density, rings, deformation)
                rms = float(np.sqrt(np.mean(np.sum(moved**2, axis=1))))
                cells.append(f"{rms * density / strain:.4f}")
        yield f"{density:g}", rings, *cells


def displacements(density: float, rings: int, deformation: Numbers) -> Numbers:
    """Displacements of the full-yarn nodes from a uniform deformation [cm], shape (n, 3)."""
    outline = SIDE * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    cloth = cloth_from_panels([Panel(name="square", outline=outline)], [], edge_length=EDGE)
    yarns = lay_weave(cloth, np.eye(2, dtype=int), ends=density, picks=density)
    middle = np.abs(cloth.vertices[cloth.triangles].mean(axis=1)[:, :2] - SIDE / 2).max(axis=1) < HALF
    layout = cloth.triangles, len(cloth.vertices), yarns.triangle, yarns.barycentric
    region = region_around(*layout, np.flatnonzero(middle), rings=rings)
    material = sm.FabricMaterials.of(sm.CrossingMaterial.named("gong-1"))
    fabric = MixedFabric(
        cloth=cloth, yarns=yarns, cloth_material=matched(density, material), yarn_materials=material
    )
    border = np.abs(cloth.vertices[:, :2] - SIDE / 2).max(axis=1) > SIDE / 2 - 1e-9
    loads = Loads(gravity=(0.0, 0.0, 0.0), held=[Attachment(np.flatnonzero(border))])
    system = loaded_system(fabric, region, loads, device=device_named("cpu"))
    positions = start_positions(fabric, region, system, cloth.vertices @ deformation.T)
    start = positions.numpy()[1].copy()
    find_equilibrium(system, positions, EquilibriumSettings(force_tolerance=TOLERANCE))
    return (positions.numpy()[1] - start)[region.node_kind[region.nodes] == YARNS]


@cache
def matched(density: float, material: sm.FabricMaterials) -> ClothMaterial:
    """The material of triangles that is fitted to the weave."""
    return sm.match_cloth(sm.weave_cell([[1, 0], [0, 1]], ends=density, picks=density, materials=material)).material


SEEDS = (0, 1)
"""Starts of each loading."""


def weights(loading: tuple[str, ...] = tuple(LOADINGS), /) -> Rows:
    """Compare the weights on cloth that wrinkles or is sheared."""
    products = (f"products, {weight}" for weight in WEIGHTS)
    yield "loading", "region", "rings", "nodes", *WEIGHTS, *products
    for name in loading:
        made = LOADINGS[name](SceneSolverSection(force_tolerance=0.1, most_iterations=2000))
        starts = [made.shaken(seed) for seed in SEEDS]
        everything = np.arange(len(made.prepared.fabric.cloth.triangles))
        full = [run_scene(with_region(start, everything)) for start in starts]
        for width in (1, 2):
            for size in made.sizes:
                chosen = [with_region(with_rings(start, width), made.by_hand(size)) for start in starts]
                yield name, f"{size:.3g} cm", width, len(chosen[0].region.nodes), *compared(made, chosen, full)


def compared(loading: Loading, chosen: list[PreparedScene], full: list[End]) -> list[str]:
    """Distances from both starts with each kind of weights, and the products from the first start."""
    errors, products = [], []
    for weight in WEIGHTS.values():
        with weight():
            ends = [run_scene(prepared) for prepared in chosen]
        near = loading.near
        pairs = zip(ends, full, strict=True)
        found = [position_error(end.nodes[near], one.nodes[near], loading.spacing) for end, one in pairs]
        errors.append(", ".join(f"{error:.3f}" for error in found))
        products.append(f"{ends[0].products:,}")
    return [*errors, *products]


ACTIONS = (preconditioner, blocks, patch, weights)
