# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checks that a quad mesh is valid and can be knitted, so that every quad belongs to one row.

Opposite edges of a quad have the same label, and adjacent edges have different labels. 'Course'
edges are parallel to the rows of knitting, 'wale' edges are across the rows. A row is a strip of
quads that are joined by wale edges.
"""

from collections import defaultdict, deque
from dataclasses import dataclass

import numpy as np
from quad_mesh import Garment, QuadMesh

Edge = tuple[int, int]
COURSE, WALE = 0, 1


@dataclass(frozen=True)
class Border:
    """One border loop: its name, vertices in order, length [cm] and number of course edges."""

    name: str
    loop: list[int]
    length: float
    course_edges: int


@dataclass(frozen=True)
class Report:
    """Figures of a checked garment; lengths are in cm."""

    faces: int
    vertices: int
    rows: int
    columns: int
    borders: list[Border]
    shortest_edge: float
    longest_edge: float


def edge(a: int, b: int) -> Edge:
    """Return an undirected edge: its two vertices in ascending order."""
    return (a, b) if a < b else (b, a)


def quad_edges(quad: tuple[int, ...]) -> list[Edge]:
    """Return the edges of a quad in order; opposite edges are two places apart."""
    return [edge(quad[i], quad[(i + 1) % 4]) for i in range(4)]


def edge_lengths(mesh: QuadMesh) -> dict[Edge, float]:
    """Return the length of every edge [cm]."""
    edges = {e for quad in mesh.quads for e in quad_edges(quad)}
    return {(a, b): float(np.linalg.norm(mesh.points[a] - mesh.points[b])) for a, b in edges}


def check_manifold(mesh: QuadMesh) -> None:
    """Raise unless the mesh is an oriented manifold.

    Raises:
        ValueError: faces have opposite orientations, an edge has more than two faces, a vertex is
            isolated, or the faces around a vertex form more than one fan.
    """
    directed = [(q[i], q[(i + 1) % 4]) for q in mesh.quads for i in range(4)]
    if len(set(directed)) != len(directed):
        raise ValueError("two faces pass an edge in the same direction")
    used = {v for quad in mesh.quads for v in quad}
    if used != set(range(len(mesh.points))):
        raise ValueError("the mesh has isolated vertices")
    for vertex, corners in corner_fans(mesh).items():
        if not is_single_fan(corners):
            raise ValueError(f"the faces at vertex {vertex} do not form one fan")


def corner_fans(mesh: QuadMesh) -> dict[int, dict[int, int]]:
    """Return, for each vertex, the map from the next to the previous neighbour in each face."""
    fans: dict[int, dict[int, int]] = defaultdict(dict)
    for quad in mesh.quads:
        for i in range(4):
            fans[quad[i]][quad[(i + 1) % 4]] = quad[i - 1]
    return fans


def is_single_fan(turns: dict[int, int]) -> bool:
    """Return whether the faces around one vertex form one closed or open fan."""
    starts = set(turns) - set(turns.values())
    first = next(iter(starts), next(iter(turns)))
    at, steps = turns[first], 1
    while at != first and at in turns:
        at, steps = turns[at], steps + 1
    return steps == len(turns)


def check_shapes(mesh: QuadMesh) -> None:
    """Raise if two vertices are in the same place, or if a quad is degenerate or not convex."""
    points = np.array(mesh.points)
    if len(np.unique(np.round(points, 4), axis=0)) != len(points):
        raise ValueError("two vertices are in the same place")
    corners = points[np.array(mesh.quads)]
    ahead, behind = np.roll(corners, -1, 1) - corners, np.roll(corners, 1, 1) - corners
    turns = np.cross(ahead, behind)
    normals = turns.sum(axis=1)
    if np.linalg.norm(normals, axis=1).min() < 1e-3:
        raise ValueError("a quad has no area")
    bad = np.flatnonzero((np.einsum("qcx,qx->qc", turns, normals) <= 0).any(axis=1))
    if len(bad):
        raise ValueError(f"quads {bad.tolist()} are not convex")


def check_outward(mesh: QuadMesh, loops: list[list[int]]) -> None:
    """Raise unless the normals point outward.

    The criterion is that the volume of the mesh with closed borders is not negative.
    """
    points = np.array(mesh.points)
    triangles = [points[[q[0], q[i], q[i + 1]]] for q in mesh.quads for i in (1, 2)]
    for loop in loops:
        ring = points[loop]
        centre, following = ring.mean(axis=0), np.roll(ring, -1, axis=0)
        triangles += [np.array([centre, p, q]) for p, q in zip(ring, following, strict=True)]
    if np.linalg.det(np.array(triangles)).sum() < -1e-6:
        raise ValueError("the faces have inward normals")


def border_loops(mesh: QuadMesh) -> list[list[int]]:
    """Return the border loops; each has the orientation of an outward face that would fill it."""
    directed = {(q[i], q[(i + 1) % 4]) for q in mesh.quads for i in range(4)}
    following = {b: a for a, b in directed if (b, a) not in directed}
    loops = []
    while following:
        loop = [next(iter(following))]
        while loop[-1] in following:
            loop.append(following.pop(loop[-1]))
        loops.append(loop[:-1])
    return loops


def loop_edges(loop: list[int]) -> list[Edge]:
    """Return the edges of a closed loop of vertices."""
    return [edge(a, b) for a, b in zip(loop, loop[1:] + loop[:1], strict=True)]


def label_edges(mesh: QuadMesh, course: list[Edge]) -> dict[Edge, int]:
    """Label every edge as course or wale, starting from known course edges.

    Raises:
        ValueError: the mesh is not connected, or the labels contradict each other.
    """
    faces: dict[Edge, list[list[Edge]]] = defaultdict(list)
    for quad in mesh.quads:
        edges = quad_edges(quad)
        for e in edges:
            faces[e].append(edges)
    labels, queue = {course[0]: COURSE}, deque([course[0]])
    while queue:
        e = queue.popleft()
        for edges in faces[e]:
            spread_labels(edges, e, labels, queue)
    if len(labels) != len(faces):
        raise ValueError("the mesh is not connected")
    if any(labels[e] != COURSE for e in course):
        raise ValueError("some edges of the first border are not course edges")
    return labels


def spread_labels(
    edges: list[Edge], known: Edge, labels: dict[Edge, int], queue: deque[Edge]
) -> None:
    """Label the edges of one quad from one known edge; raise if the labels contradict."""
    place = edges.index(known)
    for turn in range(1, 4):
        e, label = edges[(place + turn) % 4], (labels[known] + turn) % 2
        if e not in labels:
            labels[e] = label
            queue.append(e)
        if labels[e] != label:
            raise ValueError(f"edge {e} would be both course and wale")


def count_strips(mesh: QuadMesh, labels: dict[Edge, int], joint: int) -> int:
    """Return the number of strips of quads that are joined by edges with the label ``joint``."""
    parent = list(range(len(mesh.quads)))

    def root(i: int) -> int:
        while parent[i] != i:
            i = parent[i]
        return i

    seen: dict[Edge, int] = {}
    for number, quad in enumerate(mesh.quads):
        for e in quad_edges(quad):
            if labels[e] == joint:
                parent[root(number)] = root(seen.setdefault(e, number))
    return sum(parent[i] == i for i in range(len(parent)))


def check_garment(garment: Garment) -> Report:
    """Run all checks, and return the figures of the garment.

    Raises:
        ValueError: a check has failed.
    """
    mesh = garment.mesh
    check_manifold(mesh)
    check_shapes(mesh)
    loops = border_loops(mesh)
    check_outward(mesh, loops)
    lengths = edge_lengths(mesh)
    longest = max(loops, key=lambda loop: sum(lengths[e] for e in loop_edges(loop)))
    course = garment.first_course or loop_edges(longest)
    labels = label_edges(mesh, [edge(*e) for e in course])
    return Report(
        len(mesh.quads),
        len(mesh.points),
        count_strips(mesh, labels, WALE),
        count_strips(mesh, labels, COURSE),
        name_borders(garment, loops, labels, lengths),
        min(lengths.values()),
        max(lengths.values()),
    )


def name_borders(
    garment: Garment, loops: list[list[int]], labels: dict[Edge, int], lengths: dict[Edge, float]
) -> list[Border]:
    """Match the borders of the mesh with the named borders of the garment."""
    if len(loops) != len(garment.borders):
        raise ValueError(f"{len(loops)} borders instead of {len(garment.borders)}")
    found = []
    for name, vertex in garment.borders.items():
        (loop,) = (loop for loop in loops if vertex in loop)
        edges = loop_edges(loop)
        courses = sum(labels[e] == COURSE for e in edges)
        found.append(Border(name, loop, sum(lengths[e] for e in edges), courses))
    return found
