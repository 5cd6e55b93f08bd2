# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Extremes of mixed yarns and triangles: each run is finite and valid, or ends with one line of error.

A square weave of 3 cm with yarns in its middle hangs from its upper side, swings for 20 ms, and each case changes one
thing: masses, alpha, stiffness, time steps, the region, the yarns on a triangle, precision, bodies and bad input. A run
is valid if all numbers are finite, p = B v + F x holds for its hybrid nodes, no two nodes of a yarn have merged or
changed their order, and energy has not grown where nothing moves the cloth.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.table import Rows
from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.mixed.cloth.panels import Panel, PanelPosition
from stitchmesh.mixed.cloth.seams import PanelBorder, PanelSeam
from stitchmesh.mixed.enrichment.region import embed, region_around
from stitchmesh.mixed.memory import check_scene_memory
from stitchmesh.mixed.scene.motion_section import AttachmentSection, BodySection, Keyframe
from stitchmesh.mixed.scene.region_section import BoxSection, RegionSection
from stitchmesh.mixed.scene.scene import ClothSection, Scene, SceneSolverSection, YarnsSection
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, prepare
from stitchmesh.mixed.simulation import Simulation, begin_simulation
from tests.extremes.outcome import FAILED, VALID, Outcome, ended, table

SIDE = 3.0
TOP = AttachmentSection(boxes=(BoxSection(low=(-9.0, SIDE - 0.2, -9.0), high=(9.0, 9.0, 9.0)),))
SCENE = Scene(
    cloth=ClothSection(rectangle=(SIDE, SIDE), edge_length=0.6),
    yarns=YarnsSection(weave="plain", ends=5.0, picks=5.0),
    region=RegionSection(boxes=(BoxSection(low=(1.0, 1.0, -1.0), high=(2.0, 2.0, 1.0)),)),
    mode="dynamic",
    duration=0.02,
    largest_step=2e-3,
    gravity=(0.0, -900.0, 400.0),
    attachments=(TOP,),
)
KNIT = YarnsSection(knit=("k",), wales=4.0, courses=5.0)


@dataclass(frozen=True)
class Case:
    """One extreme."""

    name: str
    make: Callable[[], PreparedScene]
    """Function that makes the scene."""
    moved: bool = False
    """Whether attachments or bodies work on the cloth, so that its energy may grow."""


def scene(**changes: object) -> PreparedScene:
    """The scene with other fields, prepared."""
    return prepare(replace(SCENE, **changes))  # type: ignore[arg-type]


def masses(ratio: float) -> PreparedScene:
    """Triangles with ``ratio`` times the mass of the same cloth of yarns."""
    made = scene()
    cloth = made.fabric.cloth_material
    heavy = replace(cloth, density=ratio * cloth.density)
    return replace(made, fabric=replace(made.fabric, cloth_material=heavy))


def stiffness(ratio: float) -> PreparedScene:
    """Triangles with ``ratio`` times the stiffness of the same cloth of yarns."""
    made = scene()
    cloth = made.fabric.cloth_material
    names = ("stretch_course", "stretch_wale", "shear", "bending_course", "bending_wale", "twist")
    stiff = replace(cloth, **{name: ratio * getattr(cloth, name) for name in names})
    return replace(made, fabric=replace(made.fabric, cloth_material=stiff))


def around(made: PreparedScene, chosen: object, *, rings: int = 1, smallest_alpha: float = 0.01) -> PreparedScene:
    """A prepared scene with other full-yarn triangles."""
    cloth, yarns = made.fabric.cloth, made.fabric.yarns
    region = region_around(
        cloth.triangles, len(cloth.vertices), yarns.triangle, yarns.barycentric, np.asarray(chosen, dtype=np.int64),
        rings=rings, smallest_alpha=smallest_alpha,
    )  # fmt: skip
    return replace(made, region=region)


def chosen(made: PreparedScene, *points: tuple[float, float], size: float = 0.45) -> list[int]:
    """Triangles whose middle is near one of some points."""
    middle = made.fabric.cloth.vertices[made.fabric.cloth.triangles].mean(axis=1)[:, :2]
    near = [np.abs(middle - np.array(point)).max(axis=1) < size for point in points]
    return [int(triangle) for triangle in np.flatnonzero(np.any(near, axis=0))]


def regions() -> list[Case]:
    """Regions of all shapes."""
    middle = (0.5 * SIDE, 0.5 * SIDE)

    def at(*points: tuple[float, float], rings: int = 1, size: float = 0.45) -> PreparedScene:
        made = scene()
        return around(made, chosen(made, *points, size=size), rings=rings)

    return [
        Case("region: none", lambda: scene(region=RegionSection(yarns="none"))),
        Case("region: all", lambda: scene(region=RegionSection(yarns="all"))),
        Case("region: one triangle", lambda: around(scene(), [0])),
        Case("region: one triangle inside", lambda: around(scene(), chosen(scene(), middle)[:1])),
        Case("region: all but one triangle", lambda: around(scene(), np.arange(1, len(scene().region.triangles)))),
        Case("region: at the corner", lambda: at((0.0, 0.0))),
        Case("region: at the held border", lambda: at((0.5 * SIDE, SIDE))),
        Case("region: two that meet", lambda: at((0.6, 1.5), (2.1, 1.5), size=0.5)),
        Case("region: two that merge", lambda: at((1.2, 1.5), (1.8, 1.5))),
        Case("region: two at one vertex", at_one_vertex),
        Case("region: 3 rings", lambda: at(middle, rings=3)),
        Case("region: rings beyond the cloth", lambda: at(middle, rings=40)),
        Case("region: at a seam", at_a_seam),
    ]


def at_one_vertex() -> PreparedScene:
    """Two full-yarn triangles that share a single vertex."""
    made = scene()
    corners = made.fabric.cloth.triangles
    vertex = int(np.argmin(np.abs(made.fabric.cloth.vertices[:, :2] - 0.5 * SIDE).max(axis=1)))
    around_it = np.flatnonzero((corners == vertex).any(axis=1))
    others = [t for t in around_it if len(np.intersect1d(corners[t], corners[around_it[0]])) == 1]
    return around(made, [around_it[0], others[0]])


def at_a_seam() -> PreparedScene:
    """A region across the seam of two panels."""
    half, high = 0.5 * SIDE, SIDE
    outline = ((0.0, 0.0), (half, 0.0), (half, high), (0.0, high))
    right = Panel(name="right", outline=outline, position=PanelPosition(origin=(half, 0.0, 0.0)))
    seam = PanelSeam(first=PanelBorder(panel="left", start=1, end=2), second=PanelBorder(panel="right", start=3, end=0))
    panels = Panel(name="left", outline=outline), right
    return scene(cloth=ClothSection(panels=panels, seams=(seam,), edge_length=0.6))


def dragged(depth: float, *, held: bool = False) -> PreparedScene:
    """The upper and lower border of the cloth are drawn over a ball, or all of it into the ball."""
    low = AttachmentSection(
        boxes=(BoxSection(low=(-9.0, -9.0, -9.0), high=(9.0, 9.0 if held else 0.2, 9.0)),),
        keyframes=(Keyframe(time=0.0), Keyframe(time=0.02, displacement=(0.0, 0.0, -depth))),
    )
    upper = replace(low, boxes=TOP.boxes)
    ball = BodySection(shape="ball", centre=(0.5 * SIDE, 0.5 * SIDE, -0.9), size=(0.6,))
    return scene(attachments=(low,) if held else (low, upper), bodies=(ball,), gravity=(0.0, 0.0, 0.0))


def pressed(share: float, disturbance: float) -> PreparedScene:
    """The lower border is moved towards the upper one, so that the nodes of the warps come near to one another."""
    boxes = (BoxSection(low=(-9.0, -9.0, -9.0), high=(9.0, 0.2, 9.0)),)
    moves = Keyframe(time=0.0), Keyframe(time=0.02, displacement=(0.0, share * SIDE, 0.0))
    return scene(attachments=(TOP, AttachmentSection(boxes=boxes, keyframes=moves)), disturbance=disturbance)


def cases() -> list[Case]:
    """All cases."""
    made = [Case(f"mass of triangles x {10.0**power:g}", lambda power=power: masses(10.0**power)) for power in
            (-6, -3, 0, 3, 6)]  # fmt: skip
    made += [Case(f"stiffness of triangles x {10.0**power:g}", lambda power=power: stiffness(10.0**power)) for power in
             (-4, -2, 2, 4)]  # fmt: skip
    made += [
        Case(f"smallest alpha {least:g}", lambda least=least: around(
            scene(), chosen(scene(), (0.5 * SIDE, 0.5 * SIDE)), smallest_alpha=least)) for least in (1e-3, 0.1, 1.0)
    ]  # fmt: skip
    made += [
        Case(f"time step {step:g} s", lambda step=step: scene(largest_step=step, duration=min(10.0 * step, 0.4)))
        for step in (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
    ]
    made += regions()
    made += [
        Case(f"{density:g} yarns for each cm", lambda density=density: scene(
            yarns=YarnsSection(weave="plain", ends=density, picks=density))) for density in (0.7, 1.5, 20.0)
    ]  # fmt: skip
    made += [
        Case("yarns of 1 um", lambda: scene(yarns=replace(SCENE.yarns, radius=1e-4))),
        Case("yarns thicker than their distance", lambda: scene(yarns=replace(SCENE.yarns, radius=0.3))),
        Case("single precision", lambda: scene(solver=SceneSolverSection(precision="float32"))),
        Case("1 m from the origin", lambda: far(100.0)),
        Case("10 km from the origin", lambda: far(1e6)),
        Case("gravity x 1000", lambda: scene(gravity=(0.0, -9e5, 4e5))),
        Case("pressed together to a third", lambda: pressed(0.67, 0.01), moved=True),
        Case("pressed together to a third in its plane", lambda: pressed(0.67, 0.0), moved=True),
        Case("a static run", static),
        Case("a static run, stiffness of triangles x 0.0001", lambda: static(1e-4)),
        Case("a static run, stiffness of triangles x 10000", lambda: static(1e4)),
        Case("a knit", lambda: scene(yarns=KNIT)),
        Case("a knit with yarns on one triangle", lambda: around(scene(yarns=KNIT), [20])),
        Case("a knit with yarns everywhere", lambda: scene(yarns=KNIT, region=RegionSection(yarns="all"))),
        Case("drawn over a ball", lambda: dragged(0.5), moved=True),
        Case("drawn far over a ball", lambda: dragged(3.0), moved=True),
        Case("dragged through a ball", lambda: dragged(1.0, held=True), moved=True),
        Case("more yarns than memory", lambda: scene(yarns=YarnsSection(weave="plain", ends=1e6, picks=1e6))),
        Case("a larger region than memory", without_memory),
        Case("region outside of the cloth", lambda: scene(
            region=RegionSection(boxes=(BoxSection(low=(8.0, 8.0, 8.0), high=(9.0, 9.0, 9.0)),)))),
        Case("a panel that crosses itself", lambda: scene(cloth=ClothSection(
            panels=(Panel(name="bow", outline=((0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0))),)))),
    ]  # fmt: skip
    return made


def static(ratio: float = 1.0) -> PreparedScene:
    """The equilibrium of the scene with triangles of ``ratio`` times the stiffness."""
    made = stiffness(ratio)
    solver = SceneSolverSection(force_tolerance=0.1)
    return replace(made, scene=replace(made.scene, mode="static", duration=1.0, solver=solver))


def far(distance: float) -> PreparedScene:
    """The cloth far from the origin."""
    made = scene()
    shift = np.array([distance, 0.0, 0.0])
    cloth = replace(made.fabric.cloth, vertices=made.fabric.cloth.vertices + shift)
    held = scene(attachments=(replace(TOP, boxes=(BoxSection(low=(-1e9, SIDE - 0.2, -9.0), high=(1e9, 9.0, 9.0)),)),))
    fabric = replace(made.fabric, cloth=cloth)
    return replace(held, fabric=fabric, vertices=made.vertices + shift)


def without_memory() -> PreparedScene:
    """Yarns everywhere, where 400 MB are free."""
    made = scene(yarns=YarnsSection(weave="plain", ends=60.0, picks=60.0), region=RegionSection(yarns="all"))
    check_scene_memory(made.region, 4e8, contact=False)
    return made


def outcome(case: Case, device: str) -> Outcome:
    """Run a case."""
    return ended(lambda: _run(case, device))


def _run(case: Case, device: str) -> Outcome:
    prepared = case.make()
    with alone():
        scalar = scalar_named(prepared.scene.solver.precision)
        simulation = begin_simulation(prepared, scalar, device_named(device))
        energy = sum(simulation.energies().values())
        steps = halvings = products = 0
        at_rest = True
        while not simulation.done:
            made = simulation.step()
            steps, halvings, products = steps + 1, halvings + made.halvings, products + made.solve_iterations
            at_rest &= made.converged
        shortest = shortest_segment(simulation)
        wrong = fault(simulation, energy, case.moved, shortest)
    figures = {"steps": steps, "halvings": halvings, "products": products, "shortest": shortest, "at_rest": at_rest}
    return Outcome(FAILED if wrong else VALID, wrong, figures)


def fault(simulation: Simulation, energy: float, moved: bool, shortest: float) -> str:
    """What is wrong with a state, in words; empty if it is valid."""
    prepared = simulation.prepared
    v, p, s = simulation.positions
    after = sum(simulation.energies().values())
    if not (all(np.isfinite(part).all() for part in (v, p, s)) and np.isfinite(after)):
        return "a number is not finite"
    size = float(np.abs(v).max())
    precise = prepared.scene.solver.precision == "float64"
    drift = constraint_error(prepared, v, p)
    if drift > (1e-6 if precise else 1e-3) * max(size, 1.0):
        return f"p = B v + F x is missed by {drift:.1e} cm"
    if shortest <= 0.0:
        return "two nodes of a yarn have merged"
    # the error of the velocities that a step may have, times the momentum of the cloth at 10 cm/s
    mass = prepared.fabric.cloth_material.density * float(prepared.fabric.cloth.rest_area.sum())
    allowed = simulation.tolerance * 10.0 * max(mass, 1.0) * 100.0 + 1e-6 * abs(energy)
    if not moved and after > energy + allowed:
        return f"the energy grew from {energy:.6g} to {after:.6g} erg"
    return ""


def constraint_error(prepared: PreparedScene, v: np.ndarray, p: np.ndarray) -> float:
    """Largest part of p - B v of the hybrid nodes that the filter would remove [cm]."""
    embedding = embed(prepared.region)
    own = embedding.independent
    if own.shape[1] == 0:
        return 0.0
    detail = p[embedding.nodes] - embedding.basis @ v
    part = np.linalg.lstsq(own.toarray(), detail, rcond=None)[0]
    return float(np.abs(own @ part).max(initial=0.0))


def shortest_segment(simulation: Simulation) -> float:
    """Shortest yarn between two simulated nodes over its length in the layout."""
    yarns, region = simulation.prepared.fabric.yarns, simulation.prepared.region
    node, c = np.nonzero(yarns.links[:, 0::2] >= 0)
    after = yarns.links[node, 2 * c]
    number = region.node_number
    both = (number[node] >= 0) & (number[after // 2] >= 0)
    node, c, after = node[both], c[both], after[both]
    now = simulation.positions[2]
    length = now[number[after // 2], after % 2] - now[number[node], c]
    rest = yarns.rest_sliding[after // 2, after % 2] - yarns.rest_sliding[node, c]
    return float((length / rest).min(initial=1.0))


def row_of(case: Case, found: Outcome) -> tuple[str, str]:
    """A row of the table of docs/stability.md."""
    if found.kind != VALID:
        return case.name, f"{found.kind}: {found.words}"
    own = found.report
    each = own["products"] / max(own["steps"], 1)
    words = f"valid: {own['steps']} steps, {own['halvings']} halvings, {each:.0f} products a step"
    words += "" if own["at_rest"] else ", not yet at rest"
    if own["shortest"] < 0.99:
        words += f", shortest segment {own['shortest']:.2f}"
    return case.name, words


def cloths(*, device: str = "cpu", only: str = "") -> Rows:
    """Run extreme cloths.

    Args:
        only: cases whose name contains this
    """

    def found() -> Iterator[tuple[Outcome, tuple[object, ...]]]:
        for case in cases():
            if only in case.name:
                end = outcome(case, device)
                yield end, (*row_of(case, end), f"{end.seconds:.1f}")

    return (yield from table(("extreme", "outcome", "s"), found()))
