# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time of the energies of the mixed system: forces, linearization, products of the Hessian and energy of each term.

The cloth is a square of irregular triangles, wavy in space, with a seam along its middle, and a plain weave is laid out
on it. Launches are captured, as a solver repeats them. Each time is the shortest of some runs, because other programs
may use the same cores; the time of an energy contains reading it back to the host. The last column is the time of one
product per element, where an element is a triangle, a hinge, an edge of a seam, a crossing of yarns or a contact point.

The contact points are nodes on two spherical layers of one thickness, 0.7 thicknesses apart, around a ball of triangles
that the inner layer touches with friction. What is done once a step is the search for pairs (self-collision), the
distance of all points (body) and new anchors (friction); what is done once a move is its limit.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import warp as wp
from scipy.spatial import ConvexHull

from benchmarks.scenes.cloths import cells, irregular
from benchmarks.table import Rows
from benchmarks.timing import shortest_mean
from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.compute.device import device_named
from stitchmesh.compute.launch import prepare
from stitchmesh.compute.precision import scalar_named
from stitchmesh.compute.threads import set_threads
from stitchmesh.mesh import Mesh
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.contact.body import SolidBody
from stitchmesh.mixed.contact.body_distance import BodyContact
from stitchmesh.mixed.contact.body_friction import BodyFriction
from stitchmesh.mixed.contact.contact_points import points_at_nodes
from stitchmesh.mixed.contact.self_collision import SelfCollision
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial, FabricMaterials
from stitchmesh.mixed.crossings.crossing_term import CrossingTerm, crossing_elements
from stitchmesh.mixed.crossings.friction.sliding_friction import SlidingFriction
from stitchmesh.mixed.crossings.yarn_mass import YarnGravity
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.layout.embedding import world_positions
from stitchmesh.mixed.layout.weave import lay_weave
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import MixedTerm
from stitchmesh.mixed.triangles.material_file import named_material
from stitchmesh.mixed.triangles.membrane import Membrane
from stitchmesh.mixed.triangles.seam_rod import SeamMaterial, SeamRod
from stitchmesh.mixed.triangles.shell_bending import ShellBending

COLUMNS = ("elements", "forces", "linearize", "product", "energy", "ns/element")


def wavy_cloth(triangles: int, edge: float = 0.5) -> Cloth:
    """A square of about that number of irregular triangles with edges of about ``edge`` [cm], rolled and waved."""
    count = max(round((triangles / 2.0) ** 0.5), 2) // 2 * 2
    plane = cells(count, count)[0]
    x, y = plane.T.copy()
    inner = (x > 0) & (x < count) & (y > 0) & (y < count) & (x != count // 2)
    corners = irregular(plane, inner, 0.2, seed=0)
    plane *= edge
    middle = np.flatnonzero(x == count // 2)
    wave = np.sin(plane[:, 0] / 3.0) * np.cos(plane[:, 1] / 5.0)
    return Cloth(
        vertices=np.column_stack([1.02 * plane[:, 0], 0.99 * plane[:, 1], wave]),
        triangles=corners,
        rest=plane[corners],
        panel=np.zeros(len(corners), dtype=int),
        panel_names=("square",),
        seam_edges=np.column_stack([middle[:-1], middle[1:]]),
        seam_start=np.array([0, count]),
        seam_angle=np.array([0.3]),
    )


def weave_on(cloth: Cloth, nodes: int) -> CrossingYarns:
    """A plain weave of about that number of crossings on a cloth."""
    density = (nodes / cloth.rest_area.sum()) ** 0.5
    return lay_weave(cloth, [[1, 0], [0, 1]], ends=density, picks=density)


def terms_of(cloth: Cloth, yarns: CrossingYarns, scalar: Any, device: wp.Device) -> Iterator[tuple[MixedTerm, int]]:
    """The terms that are measured, with their numbers of elements."""
    material = named_material("interlock")
    yield Membrane(cloth, material, scalar, device), len(cloth.triangles)
    yield ShellBending(cloth, material, scalar, device), len(cloth.hinges)
    yield SeamRod(cloth, SeamMaterial(1e5, 1.0), scalar, device), len(cloth.seam_edges)
    elements = crossing_elements(yarns, FabricMaterials.of(CrossingMaterial.named("gong-1")))
    elasticity = CrossingTerm(elements, scalar, device)
    yield elasticity, elements.count
    yield SlidingFriction(elements, elasticity), elements.count
    weight = YarnGravity(elements, scalar, device)
    weight.name = "weight of yarns"
    yield weight, elements.count


def contact_terms(count: int, scalar: Any, device: wp.Device) -> tuple[MixedVector, list[MixedTerm]]:
    """Layers of about ``count`` contact points around a ball, and the terms of their contact."""
    thickness, half = 0.1, count // 2
    radius = (half / (4.0 * np.pi)) ** 0.5 * thickness  # points one thickness apart
    mesh = ball(radius - 0.035)
    layers = [directions(half) * (radius + height) for height in (0.0, 0.07)]
    points = points_at_nodes(
        0, panel=np.repeat([0, 1], half), rest=1e3 * np.arange(4 * half).reshape(-1, 2), area=thickness**2, weight=1.0,
        thickness=thickness,
    )  # fmt: skip
    body = BodyContact(points, SolidBody(mesh), scalar=scalar, device=device)
    terms = [SelfCollision(points, None, scalar=scalar, device=device), body, BodyFriction(body, 0.4)]
    return MixedVector.from_numpy([], np.concatenate(layers), np.zeros((2 * half, 2)), scalar, device), terms


def directions(count: int) -> np.ndarray:
    """Unit vectors that are evenly distributed, on a spiral (Fibonacci's lattice)."""
    k = np.arange(count) + 0.5
    height, angle = 1.0 - 2.0 * k / count, np.pi * (1.0 + 5.0**0.5) * k
    across = np.sqrt(1.0 - height**2)
    return np.column_stack([across * np.cos(angle), across * np.sin(angle), height])


def ball(radius: float, triangles: int = 20_000) -> Mesh:
    """A ball of triangles, oriented outwards."""
    corners = directions(triangles // 2 + 2)
    faces = ConvexHull(corners).simplices
    a, b, c = (corners[faces[:, k]] for k in range(3))
    inwards = np.einsum("td,td->t", np.cross(b - a, c - a), a) < 0.0
    return Mesh.from_polygons(radius * corners, np.where(inwards[:, None], faces[:, ::-1], faces).tolist())


def measure_contact(count: int, scalar: Any, device: wp.Device, runs: int) -> Rows:
    """Yield the table of contact, and the times of what is done once a step and once a move."""
    state, terms = contact_terms(count, scalar, device)
    for term in terms:
        term.begin_step(state, 0.0, 1e-3)
        yield row_of(term.name, measure(term, state.node_count, state, runs))
    layers, body, friction = terms
    assert isinstance(layers, SelfCollision) and isinstance(body, BodyContact)
    move = state.copy()
    move.values.fill_(1e-3)

    def search() -> None:
        layers.pairs.invalidate()
        layers.begin_step(state, 0.0, 1e-3)

    def measure_again() -> None:
        body.forget_distances()
        body.begin_step(state, 0.0, 1e-3)

    once = {
        "search for pairs": search,
        "distances from the body": measure_again,
        "new anchors": lambda: friction.end_step(state, 1e-3, 1e-3),
        "limit of a move, pairs": lambda: layers.step_limit(state, move),
        "limit of a move, body": lambda: body.step_limit(state, move),
    }
    for name, action in once.items():
        yield name, f"{1e3 * shortest_mean(action, runs, device):.3f}"
    yield f"{int(layers.pairs.count.numpy().sum())} listed pairs of {state.node_count} points"


def row_of(name: str, row: tuple[float, ...]) -> tuple[object, ...]:
    """Return a row of a table."""
    return name, f"{row[0]:.0f}", *(f"{value:.3f}" for value in row[1:-1]), f"{row[-1]:.1f}"


def measure(term: MixedTerm, elements: int, state: MixedVector, runs: int) -> tuple[float, ...]:
    """A row of the table: elements, times [ms] and the time of a product per element [ns]."""
    launcher = partial(prepare, device=state.device)
    term.begin_step(state, 0.0, 1e-3)
    result, direction = state.like(), state.copy()
    groups = [
        term.forces(state, result, launcher),
        term.linearize(state, launcher),
        term.products(direction, result, launcher),
    ]
    times = []
    for launches in groups:
        captured = CapturedLaunches(launches, state.device) if launches else None
        times.append(shortest_mean(captured.launch, runs, state.device) if captured else 0.0)
    times.append(shortest_mean(lambda: term.energy(state), runs, state.device))
    return (elements, *(1e3 * value for value in times), 1e9 * times[2] / elements)


@dataclass(frozen=True)
class Options:
    """What is measured."""

    triangles: tuple[int, ...] = (100000,)
    points: int = 100000
    """contact points"""
    nodes: tuple[int, ...] = (100000,)
    """crossings of yarns; one for each size"""
    precision: str = "float32"
    """float32 or float64"""
    device: str | None = None
    """Warp's name; the first GPU, or the CPU"""
    threads: int = 0
    """threads on a CPU; 0 for all cores"""
    runs: int = 3
    """runs of which the shortest is taken"""


def mixed_terms(arguments: Options) -> Rows:
    """Yield a table for each size."""
    if len(arguments.triangles) != len(arguments.nodes):
        raise SystemExit("--triangles and --nodes: give as many numbers to one as to the other")
    device, scalar = device_named(arguments.device), scalar_named(arguments.precision)
    if arguments.threads:
        set_threads(arguments.threads)
    for triangles, nodes in zip(arguments.triangles, arguments.nodes, strict=True):
        cloth = wavy_cloth(triangles)
        yarns = weave_on(cloth, nodes)
        places = world_positions(cloth, yarns.triangle, yarns.barycentric)
        state = MixedVector.from_numpy(cloth.vertices, places, yarns.rest_sliding, scalar, device)
        counts = f"{len(cloth.triangles)} triangles, {len(places)} crossings"
        yield f"{counts}, {arguments.precision} on {device.name}; times in ms"
        yield "", *COLUMNS
        for term, elements in terms_of(cloth, yarns, scalar, device):
            yield row_of(term.name, measure(term, elements, state, arguments.runs))
        yield from measure_contact(arguments.points, scalar, device, arguments.runs)
