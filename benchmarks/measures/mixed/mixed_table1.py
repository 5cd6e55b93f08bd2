# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time of a step of whole garments: yarns everywhere against yarns in a region (Casafranca et al. 2020, table 1).

A woven dress and a knitted shirt, of the panels in ``examples/mixed/panels``, have as many crossings of yarns as in the
table with yarns everywhere, and as many vertices; ``--scale`` multiplies the numbers of crossings. The region of
interest, around a point of the front panel, the chest of the dress and an armpit of the shirt, has as many full-yarn
nodes as in the table. What is in it: all elastic energies, friction of yarns, masses and weight. Garments are held at
the shoulders. Their yarns begin on the result of a run with triangles alone. Contact with a body and of the cloth with
itself is not in it.

Steps of backward Euler bring the error of the velocities below ``TOLERANCE``. Both runs have the same steps: by default
of the length that both take without halving it. The first ``FIRST`` steps are not counted: they load kernels, capture
iterations, and release what the yarns have of other tensions than the triangles. Memory is the peak of Warp's memory
pool on the device. The last lines are the rows of the table in ``docs/mixed-solver.md``.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray
from tyro.conf import Positional

from benchmarks.table import Rows, note
from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.mixed.assembly import Loads, MixedFabric, loaded_system
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.contact.motion import Attachment
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial, FabricMaterials
from stitchmesh.mixed.dynamics.backward_euler import Dynamics, DynamicsSettings
from stitchmesh.mixed.dynamics.equilibrium import EquilibriumSettings, find_equilibrium
from stitchmesh.mixed.enrichment.region import HYBRID, YARNS, Region, region_around
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import ClothSection, ContactSection, Scene, YarnsSection
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, cloth_of_knit, cloth_of_weave, prepare

Numbers = NDArray[np.float64]
TOLERANCE = 1e-2
"""Root mean square error of the velocities of a step [cm/s]; gravity alone adds 0.1 cm/s in a step."""
FIRST = 5
"""Steps at the start that are not counted."""
RELAXING = 100
"""Newton iterations of the run with triangles alone at the start."""
SHOULDERS = 12.0
"""Height below the top of the garment in which the vertices of seams are held, and the triangles around them [cm]."""
LOOP_NODES = 4
"""Crossings of a loop of a plain knit."""


@dataclass(frozen=True)
class Garment:
    """A garment of table 1."""

    panels: str
    """File of its panels."""
    nodes: int
    """Yarn nodes with yarns everywhere."""
    region: int
    """Full-yarn nodes of the mixed garment."""
    vertices: int
    """Vertices of its triangles."""
    panel: str
    """Panel of the region."""
    middle: tuple[float, float]
    """Middle of the region in that panel [cm]."""
    yarns: Callable[[float], YarnsSection]
    """From the crossings for each square cm to the yarns."""
    time_step: float
    """Length of steps that yarns everywhere take without halving it [s]."""


def woven(density: float) -> YarnsSection:
    """Yarns of a plain weave."""
    each = math.sqrt(density)
    return YarnsSection(weave="plain", ends=each, picks=each, radius=0.2 / each)


def knitted(density: float) -> YarnsSection:
    """Yarns of a plain knit, whose loops are 1.3 times as wide as high."""
    courses = math.sqrt(1.3 * density / LOOP_NODES)
    return YarnsSection(knit=("k",), wales=courses / 1.3, courses=courses, radius=0.08 / courses)


GARMENTS = {
    "dress": Garment(
        "examples/mixed/panels/dress.toml", 2_662_944, 83_382, 6_191, "front", (0.0, 66.0), woven, 2.5e-5
    ),
    "shirt": Garment(
        "examples/mixed/panels/shirt.toml", 3_757_255, 88_388, 2_132, "front", (23.0, 41.0), knitted, 3.125e-6
    ),
}


@dataclass(frozen=True)
class Measured:
    """What a run took."""

    cells: tuple[object, ...]
    """Its row of the table, in the order of ``HEAD``."""
    seconds: float
    """Mean time of a step [s]."""
    memory: float
    """Peak of the memory pool [MB]; 0 on a CPU."""


HEAD = (
    "garment", "full-yarn nodes", "hybrid nodes", "vertices", "hybrid vertices", "step ms", "Newton", "products",
    "product us", "s a step", "memory MB",
)  # fmt: skip


@dataclass(frozen=True)
class Options:
    """What is measured."""

    garment: Positional[str]
    steps: int = 10
    """steps that are timed"""
    time_step: float | None = None
    """largest length of a step [s]; by default that of the garment"""
    scale: float = 1.0
    """factor of the numbers of crossings"""
    device: str = "cuda:0"
    precision: str = "float64"


def mixed_table1(options: Options) -> Rows:
    """Run a garment and print its rows."""
    garment = GARMENTS[options.garment]
    began = time.perf_counter()
    prepared = _prepared(garment, options)
    yarns, cloth = prepared.fabric.yarns, prepared.fabric.cloth
    sizes = f"{yarns.node_count:,} crossings, {len(cloth.vertices):,} vertices, {len(cloth.triangles):,} triangles"
    laid_out = f"{cloth.rest_area.sum():,.0f} cm2; laid out in {time.perf_counter() - began:.1f} s"
    yield f"{options.garment}: {sizes}, {laid_out}"
    with alone():
        # The mixed run is the first one, because the peak of the pool does not fall again.
        mixed = _run("mixed", prepared, _around(prepared, garment, options), options)
        full = _run("yarns", prepared, _region(prepared, np.arange(len(cloth.triangles))), options)
    time_ratio, memory_ratio = full.seconds / mixed.seconds, mixed.memory / max(full.memory, 1e-9)
    yield f"full over mixed: {time_ratio:.1f} times the time; mixed over full: {memory_ratio:.3f} of the memory"
    yield HEAD
    yield mixed.cells
    yield full.cells


def _prepared(garment: Garment, options: Options) -> PreparedScene:
    """The garment as a scene, with all its yarns."""
    cloth = _cloth(garment)
    yarns = garment.yarns(garment.nodes * options.scale / float(cloth.rest_area.sum()))
    scene = Scene(
        cloth=ClothSection(file=garment.panels),
        yarns=yarns,
        region=RegionSection(yarns="all"),
        mode="dynamic",
        contact=ContactSection(self_collision=False),
    )
    prepared = prepare(scene, cloth=cloth)
    fabric = replace(prepared.fabric, **_materials(yarns, prepared.fabric))
    prepared = replace(prepared, fabric=fabric)
    return replace(prepared, vertices=_relaxed(prepared, device_named(options.device)))


def _relaxed(prepared: PreparedScene, device: wp.Device) -> Numbers:
    """The triangles without loads after ``RELAXING`` Newton iterations: sewing leaves large strains at the seams."""
    prepared = replace(prepared, region=_region(prepared, np.zeros(0, dtype=np.int64)))
    start = MixedVector.from_numpy(prepared.vertices, prepared.nodes, prepared.sliding, wp.float64, device)
    free = Loads(gravity=(0.0, 0.0, 0.0))
    with alone():
        system = loaded_system(prepared.fabric, prepared.region, free, device=device)
        settings = EquilibriumSettings(force_tolerance=1.0, most_iterations=RELAXING)
        find_equilibrium(system, start, settings)
    return start.numpy()[0]


def _loads(prepared: PreparedScene) -> Loads:
    """Weight, and shoulders that are held."""
    cloth, yarns = prepared.fabric.cloth, prepared.fabric.yarns
    height = cloth.vertices[:, 1]
    sewn = np.unique(cloth.seam_edges)
    vertices = sewn[height[sewn] > height.max() - SHOULDERS]
    held = np.zeros(len(height), dtype=bool)
    held[vertices] = True
    first, second, third = cloth.triangles[yarns.triangle].T
    nodes = np.flatnonzero(held[first] | held[second] | held[third])
    return replace(prepared.loads(0.0), held=[Attachment(vertices, nodes, name="shoulders")])


def _materials(section: YarnsSection, fabric: MixedFabric) -> dict[str, Any]:
    """Materials of yarns and triangles for yarns of the density of the named ones in g/cm^3, whatever their radius."""
    named = CrossingMaterial.named("gong-1")
    radius = float(section.radius or named.radius)
    yarn = replace(named, radius=radius, density=named.density * (radius / named.radius) ** 2)
    of_yarns = FabricMaterials.of(yarn)
    if section.weave:
        return {"yarn_materials": of_yarns, "cloth_material": cloth_of_weave(of_yarns, section.ends, section.picks)}
    yarns = fabric.yarns
    assert isinstance(yarns, CrossingYarns)
    along = yarns.rest_sliding[yarns.yarn_node, yarns.yarn_coordinate]
    length = float(np.sum(along[yarns.yarn_start[1:] - 1] - along[yarns.yarn_start[:-1]]))
    of_triangles = cloth_of_knit(yarn, length / float(fabric.cloth.rest_area.sum()))
    return {"yarn_materials": of_yarns, "cloth_material": of_triangles}


def _cloth(garment: Garment) -> Cloth:
    """The triangles, about as many as wanted: the number of vertices falls with the square of their edges."""
    edge = 2.0
    for _ in range(2):
        made = ClothSection(file=garment.panels, edge_length=edge).cloth()
        edge *= math.sqrt(len(made.vertices) / garment.vertices)
    return ClothSection(file=garment.panels, edge_length=edge).cloth()


def _region(prepared: PreparedScene, chosen: NDArray[np.int64]) -> Region:
    cloth, yarns = prepared.fabric.cloth, prepared.fabric.yarns
    return region_around(cloth.triangles, len(cloth.vertices), yarns.triangle, yarns.barycentric, chosen)


def _around(prepared: PreparedScene, garment: Garment, options: Options) -> Region:
    """The region of the triangles nearest to its middle in space, with as many full-yarn nodes as wanted."""
    cloth, yarns = prepared.fabric.cloth, prepared.fabric.yarns
    own = np.flatnonzero(cloth.panel == cloth.panel_names.index(garment.panel))
    middle = own[np.argmin(np.linalg.norm(cloth.rest[own].mean(axis=1) - garment.middle, axis=1))]
    places = cloth.vertices[cloth.triangles].mean(axis=1)
    order = np.argsort(np.linalg.norm(places - places[middle], axis=1), kind="stable")
    nodes = np.cumsum(np.bincount(yarns.triangle, minlength=len(order))[order])
    count = int(np.searchsorted(nodes, garment.region * options.scale))
    return _region(prepared, np.sort(order[:count]))


def _run(name: str, prepared: PreparedScene, region: Region, options: Options) -> Measured:
    """Make the steps of one run, and return what it took."""
    device = device_named(options.device)
    time_step = options.time_step or GARMENTS[options.garment].time_step
    dynamics = _dynamics(replace(prepared, region=region), time_step, scalar_named(options.precision), device)
    for _ in range(FIRST):
        dynamics.step()
    seconds, reports = [], []
    for _ in range(options.steps):
        wp.synchronize_device(device)
        began = time.perf_counter()
        reports.append(dynamics.step())
        wp.synchronize_device(device)
        seconds.append(time.perf_counter() - began)
    note(f"{name}: {np.mean(seconds):.4f} s a step, at most {max(seconds):.4f}")
    step, newton, products = (
        float(np.mean([getattr(report, field) for report in reports]))
        for field in ("time_step", "newton_iterations", "solve_iterations")
    )
    counts = [int((region.node_kind == kind).sum()) for kind in (YARNS, HYBRID)]
    counts += [int(region.unknown_vertices.sum())]
    counts += [len(np.unique(region.triangles[region.triangle_kind == HYBRID]))]
    memory = wp.get_mempool_used_mem_high(device) / 1e6 if device.is_cuda else 0.0
    cells = (
        f"{options.garment}, {name}", *(f"{count:,}" if count else "" for count in counts), f"{1e3 * step:.3g}",
        f"{newton:.1f}", f"{products:.0f}", f"{1e6 * _product_seconds(dynamics):,.0f}", f"{np.mean(seconds):.4f}",
        f"{memory:,.0f}",
    )  # fmt: skip
    return Measured(cells, float(np.mean(seconds)), memory)


def _dynamics(prepared: PreparedScene, time_step: float, scalar: type, device: wp.Device) -> Dynamics:
    """The motion from rest of a garment that is held at the shoulders."""
    system = loaded_system(prepared.fabric, prepared.region, _loads(prepared), scalar=scalar, device=device)
    materials = prepared.fabric.yarn_materials
    assert isinstance(materials, FabricMaterials)
    material = materials.weft
    settings = DynamicsSettings(
        time_step=time_step,
        damping_mass=material.damping_mass,
        damping_stiffness=material.damping_stiffness,
        velocity_tolerance=TOLERANCE,
    )
    start = MixedVector.from_numpy(prepared.vertices, prepared.nodes, prepared.sliding, scalar, device)
    return Dynamics(system, start, settings)


def _product_seconds(dynamics: Dynamics) -> float:
    """Time of one iteration of the linear solve, of many in a row."""
    solver = dynamics.system.solver
    force = dynamics.system.zeros()
    dynamics.system.set_forces(dynamics.positions, force)
    began = time.perf_counter()
    report = solver.solve(force, tolerance=1e-30, most_iterations=200)
    return (time.perf_counter() - began) / max(report.iterations, 1)
