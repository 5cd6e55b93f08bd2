# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A cloth: flat panels of triangles, joined at seams (Casafranca et al. 2020, section 6.1).

Panels that are sewn together share the vertices of their seam. The rest shape belongs to the triangles, not to the
vertices: each triangle has the flat positions of its own three corners. The two borders that meet at a seam may
therefore have different lengths at rest, which is how a seam puckers.

Sides have the same numbers as in ``Mesh``: side ``3 t + k`` runs from corner k of triangle t to the next corner. The
angle of an edge is

    theta = atan2(e . (n_1 x n_2), n_1 . n_2)

with the unit vector e along the edge as the first triangle passes it, and the unit normals n_1 and n_2 of the first and
the second triangle. It is zero where the cloth is flat, and positive on a ridge seen from outside.

``border_sides`` divides the border of a cloth into parts, each of which runs on without a corner. A rectangle has four
parts; the hem of a skirt is one closed part.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from stitchmesh.errors import MeshError, ParameterError, first_few
from stitchmesh.mesh import BORDER, FloatArray, IntArray, extent, frozen_array
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.mesh.connectivity import check_fans, find_twins

SMALLEST_AREA = 1e-9
"""Smallest rest area of a triangle, as a part of the square of its longest edge."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Cloth:
    """A cloth of V vertices and T triangles in panels, with K seams of S edges.

    Raises:
        MeshError: the triangles are not an oriented manifold surface, or a vertex has no triangle.
        ParameterError: a position is not finite, a triangle has no rest area or lies with its back to the front of its
            panel, a seam does not follow edges between two triangles, or an array has the wrong shape.
    """

    vertices: FloatArray
    """Positions of the vertices [cm], shape (V, 3)."""
    triangles: IntArray
    """Vertices of each triangle, anticlockwise seen from outside, shape (T, 3)."""
    rest: FloatArray
    """Flat positions of the corners of each triangle at rest [cm], shape (T, 3, 2), in the coordinates of its panel:
    x along wefts or courses, y along warps or wales; anticlockwise."""
    panel: IntArray
    """Panel of each triangle, shape (T,)."""
    panel_names: tuple[str, ...]
    """Name of each panel."""
    seam_edges: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    """The two vertices of each edge on a seam, shape (S, 2), seam by seam; each edge of a seam begins where the edge
    before it ends."""
    seam_start: IntArray = field(default_factory=lambda: np.zeros(1, dtype=np.int64))
    """Number of the first edge of each seam, and S at the end, shape (K + 1,)."""
    seam_angle: FloatArray = field(default_factory=lambda: np.zeros(0))
    """Angle of the edges of each seam at rest [rad], shape (K,)."""

    def __post_init__(self) -> None:
        kinds = {"vertices": np.float64, "triangles": np.int64, "rest": np.float64, "panel": np.int64,
                 "seam_edges": np.int64, "seam_start": np.int64, "seam_angle": np.float64}  # fmt: skip
        for name, kind in kinds.items():
            object.__setattr__(self, name, frozen_array(getattr(self, name), kind))
        object.__setattr__(self, "panel_names", tuple(self.panel_names))
        self._check_shapes()
        self._check_numbers()
        self._check_rest()
        self._check_surface()
        self._check_seams()

    def __repr__(self) -> str:
        """Return one line: the numbers of triangles, vertices, panels and seams, and the size."""
        counts = f"{len(self.triangles)} triangles, {len(self.vertices)} vertices"
        parts = f"{len(self.panel_names)} panels, {self.seam_count} seams"
        return f"Cloth({counts}, {parts}, {extent(self.vertices)})"

    @property
    def seam_count(self) -> int:
        """Number K of seams."""
        return len(self.seam_start) - 1

    @cached_property
    def rest_area(self) -> FloatArray:
        """Area of each triangle at rest [cm^2], shape (T,)."""
        return signed_areas(self.rest)

    @cached_property
    def twin(self) -> IntArray:
        """Side of the neighbouring triangle along each side, ``BORDER`` on the border of the cloth, shape (3 T,)."""
        return find_twins(3 * np.arange(len(self.triangles) + 1), self.triangles.ravel(), len(self.vertices))

    @cached_property
    def side_vertices(self) -> IntArray:
        """The vertices at which each side starts and ends, shape (3 T, 2)."""
        return np.stack([self.triangles.ravel(), np.roll(self.triangles, -1, axis=1).ravel()], axis=1)

    @cached_property
    def side_rest(self) -> FloatArray:
        """Flat positions of the start and the end of each side at rest [cm], shape (3 T, 2, 2)."""
        return np.stack([self.rest, np.roll(self.rest, -1, axis=1)], axis=2).reshape(-1, 2, 2)

    @cached_property
    def border_sides(self) -> IntArray:
        """Sides on the border of their panel, on a seam or on the border of the cloth, ascending, shape (n,)."""
        on_seam = np.zeros(len(self.twin), dtype=np.bool_)
        on_seam[self.seam_sides.ravel()] = True
        other = self.panel[np.maximum(self.twin, 0) // 3] != self.panel[np.arange(len(self.twin)) // 3]
        return np.flatnonzero((self.twin == BORDER) | other | on_seam)

    @cached_property
    def seam_sides(self) -> IntArray:
        """For each edge of a seam the side that passes it forwards and the side that passes it backwards, (S, 2)."""
        forwards = _sides_with(self.side_vertices, self.seam_edges, len(self.vertices))
        return np.stack([forwards, self.twin[forwards]], axis=1)

    @cached_property
    def hinge_sides(self) -> IntArray:
        """The two sides of each edge between two triangles, the lower number first, shape (H, 2)."""
        first = np.flatnonzero(self.twin > np.arange(len(self.twin)))
        return np.stack([first, self.twin[first]], axis=1)

    @cached_property
    def hinges(self) -> IntArray:
        """Vertices of each hinge, shape (H, 4).

        The start and the end of the edge as its first triangle passes it, the third vertex of the first triangle, and
        the third vertex of the second triangle.
        """
        first, second = self.hinge_sides.T
        opposite = np.roll(self.triangles, -2, axis=1).ravel()
        return np.column_stack([self.side_vertices[first], opposite[first], opposite[second]])

    @cached_property
    def hinge_angle(self) -> FloatArray:
        """Angle of each hinge at rest [rad], shape (H,): the angle of its seam, and zero elsewhere."""
        of_side = np.zeros(len(self.twin))
        of_side[self.seam_sides] = np.repeat(self.seam_angle, np.diff(self.seam_start))[:, None]
        return of_side[self.hinge_sides[:, 0]]

    def deformation_gradients(self, vertices: FloatArray) -> FloatArray:
        """Return F of each triangle with vertices at these positions [cm], shape (V, 3) to (T, 3, 2)."""
        corners = vertices[self.triangles]
        edges = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
        rest = np.swapaxes(self.rest[:, 1:] - self.rest[:, :1], 1, 2)
        gradients: FloatArray = edges @ np.linalg.inv(rest)
        return gradients

    def _check_shapes(self) -> None:
        count, seams = len(self.triangles), len(self.seam_start) - 1
        expected = {"vertices": (len(self.vertices), 3), "triangles": (count, 3), "rest": (count, 3, 2),
                    "panel": (count,), "seam_edges": (len(self.seam_edges), 2), "seam_start": (seams + 1,),
                    "seam_angle": (seams,)}  # fmt: skip
        for name, shape in expected.items():
            found = getattr(self, name).shape
            if found != shape:
                raise ParameterError(f"cloth: {name}: got shape {found}; expected {shape}")
        if seams < 0 or self.seam_start[0] != 0 or self.seam_start[-1] != len(self.seam_edges):
            raise ParameterError(f"cloth: seam_start: expected 0 to {len(self.seam_edges)}, the number of seam edges")
        if (np.diff(self.seam_start) < 1).any():
            raise ParameterError(f"cloth: seam {int(np.diff(self.seam_start).argmin())}: has no edges; expected one")

    def _check_numbers(self) -> None:
        for name in ("vertices", "rest"):
            values = getattr(self, name)
            bad = np.flatnonzero(~np.isfinite(values).reshape(len(values), -1).all(axis=1))
            if len(bad):
                where = "vertex" if name == "vertices" else "triangle"
                raise ParameterError(f"cloth: {where} {first_few(bad)}: got {name} that are not finite; expected cm")
        if not np.isfinite(self.seam_angle).all():
            raise ParameterError("cloth: seam_angle: got numbers that are not finite; expected radians")
        bad = np.flatnonzero((self.panel < 0) | (self.panel >= len(self.panel_names)))
        if len(bad):
            found = f"got panel {self.panel[bad[0]]}"
            raise ParameterError(f"cloth: triangle {bad[0]}: {found}; expected 0 to {len(self.panel_names) - 1}")

    def _check_rest(self) -> None:
        sides = np.roll(self.rest, -1, axis=1) - self.rest
        longest = (sides**2).sum(axis=2).max(axis=1, initial=0.0)
        bad = np.flatnonzero(np.abs(self.rest_area) <= SMALLEST_AREA * longest)
        if len(bad):
            raise ParameterError(
                f"cloth: triangle {first_few(bad)} ({self._panel_of(bad[0])}): has no area at rest; expected three "
                "corners that are not on one line; move them apart"
            )
        bad = np.flatnonzero(self.rest_area < 0.0)
        if len(bad):
            raise ParameterError(
                f"cloth: triangle {first_few(bad)} ({self._panel_of(bad[0])}): got its corners clockwise at rest; "
                "expected anticlockwise; mirror the panel or reverse the triangle"
            )

    def _check_surface(self) -> None:
        twin = self.twin
        following = np.arange(len(twin)).reshape(-1, 3)[:, [1, 2, 0]].ravel()
        check_fans(self.triangles.ravel(), np.where(twin == BORDER, BORDER, following[twin]), len(self.vertices))
        used = np.zeros(len(self.vertices), dtype=np.bool_)
        used[self.triangles] = True
        if not used.all():
            raise MeshError(f"vertex {first_few(np.flatnonzero(~used))}: no triangle uses it; remove isolated vertices")

    def _check_seams(self) -> None:
        edges = self.seam_edges
        if len(edges) and (edges.min() < 0 or edges.max() >= len(self.vertices)):
            raise ParameterError(
                f"cloth: seam_edges: got a vertex that does not exist; expected 0 to {len(self.vertices) - 1}"
            )
        sides = self.seam_sides
        bad = np.flatnonzero((sides == BORDER).any(axis=1))
        if len(bad):
            ends = "-".join(str(vertex) for vertex in edges[bad[0]])
            raise ParameterError(
                f"cloth: seam edge {ends}: no two triangles meet there; expected an edge inside the cloth"
            )
        gap = edges[1:, 0] != edges[:-1, 1]
        gap[self.seam_start[1:-1] - 1] = False
        if gap.any():
            edge = int(np.flatnonzero(gap)[0])
            raise ParameterError(
                f"cloth: seam edges {edge} and {edge + 1}: do not meet; expected them in order along the seam"
            )
        if len(np.unique(sides)) != sides.size:
            raise ParameterError("cloth: seam_edges: an edge occurs twice; expected each edge on one seam")

    def _panel_of(self, triangle: int) -> str:
        return f"panel {self.panel_names[self.panel[triangle]]!r}"


def signed_areas(corners: FloatArray) -> FloatArray:
    """Return the areas of triangles in the plane, positive if anticlockwise, shape (T, 3, 2) to (T,)."""
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area: FloatArray = 0.5 * (one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    return area


def _sides_with(side_vertices: IntArray, edges: IntArray, vertex_count: int) -> IntArray:
    """Return the side that runs from the first to the second vertex of each edge, ``BORDER`` if there is none, (S,)."""
    number = side_vertices[:, 0] * vertex_count + side_vertices[:, 1]
    order = np.argsort(number)
    wanted = edges[:, 0] * vertex_count + edges[:, 1]
    place = np.minimum(np.searchsorted(number, wanted, sorter=order), len(number) - 1)
    found = order[place]
    return np.where(number[found] == wanted, found, BORDER)


def border_sides(cloth: Cloth) -> tuple[IntArray, ...]:
    """Return the sides of triangles along each part of the border, ascending, ordered by their lowest sides."""
    sides = np.flatnonzero(cloth.twin == BORDER)
    start, end = cloth.side_vertices[sides].T
    along = cloth.vertices[end] - cloth.vertices[start]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), np.finfo(float).tiny)
    leaving = np.full(len(cloth.vertices), -1)
    leaving[start] = np.arange(len(sides))
    following = leaving[end]  # a border is closed: where one side ends, another begins
    # a border turns at a corner by more than 50 degrees; the hem of a coarse sleeve turns by less at each edge
    smooth = (along * along[following]).sum(axis=1) > np.cos(np.radians(50.0))
    joined = np.flatnonzero(smooth), following[smooth]
    graph = csr_array((np.ones(len(joined[0])), joined), shape=(len(sides), len(sides)))
    count, part = connected_components(graph, directed=False)
    return tuple(sides[part == number] for number in range(count))


def vertex_normals(triangles: IntArray, vertices: FloatArray) -> FloatArray:
    """Return the sums of the area vectors of the triangles at each vertex, of unit length, shape (V, 3)."""
    corners = vertices[triangles]
    areas = np.repeat(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), 3, axis=0)
    sums = [np.bincount(triangles.ravel(), areas[:, axis], len(vertices)) for axis in range(3)]
    return unit_vectors(np.stack(sums, axis=1).astype(np.float64))
