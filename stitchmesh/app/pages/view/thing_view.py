# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns or a mesh in the scene: colours, a clip box, and picking."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from stitchmesh.app.scene.drawing import IN_PLACE, Colours, Lines, Surface, YarnTubes
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.mesh import FloatArray, IntArray, Mesh, StitchMesh
from stitchmesh.mesh.face_triangles import face_triangles
from stitchmesh.mesh.picking import pick as pick_face
from stitchmesh.mesh.picking import picking_table
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.render.colouring import Coloured, colour_yarns
from stitchmesh.render.face_colouring import colour_faces
from stitchmesh.render.surface import lifted_corners
from stitchmesh.render.swatch_picture import DEFAULT_TILES
from stitchmesh.render.yarn_blocks import YarnBlocks, make_blocks
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.picking import PickedYarn, YarnPickingTable, pick_yarn, yarn_picking_table

SIDES: Mapping[str, tuple[int, float]] = {
    "Left": (0, 0.0), "Right": (0, 100.0), "Bottom": (1, 0.0), "Top": (1, 100.0), "Back": (2, 0.0), "Front": (2, 100.0),
}  # fmt: skip
"""Axis of each side of the box, and the place of the side where it hides nothing [% of the thing]."""


@dataclass(frozen=True)
class ClipBox:
    """A box."""

    low: tuple[float, float, float]
    """Smallest coordinates [cm]."""
    high: tuple[float, float, float]
    """Largest coordinates [cm]."""

    def inside(self, points: FloatArray) -> NDArray[np.bool_]:
        """Return whether points lie in the box, shape (n, 3) to (n,)."""
        return np.all((points >= self.low) & (points <= self.high), axis=1)

    def edges(self) -> Lines:
        """Return the twelve edges."""
        ends = np.array([self.low, self.high])
        corners = np.array([[ends[i, 0], ends[j, 1], ends[k, 2]] for i, j, k in itertools.product((0, 1), repeat=3)])
        pairs = [(a, b) for a, b in itertools.combinations(range(8), 2) if (a ^ b) in (1, 2, 4)]
        return Lines(corners[np.array(pairs)], (224, 138, 30), 2.0)


def box_of_shares(low: FloatArray, high: FloatArray, shares: Mapping[str, float]) -> ClipBox:
    """Return the box between given shares of the bounds of a thing.

    Args:
        low: smallest coordinates of the thing [cm], shape (3,).
        high: largest coordinates of the thing [cm], shape (3,).
        shares: place of each side of ``SIDES`` [% from low to high]; opposite sides in the wrong order are exchanged.
    """
    ends = np.zeros((2, 3))
    for side, (axis, far) in SIDES.items():
        share = shares.get(side, far)
        ends[int(far > 0.0), axis] = low[axis] + 0.01 * share * (high[axis] - low[axis])
    # Rounding of coordinates must not hide the outermost points.
    slack = 1e-9 * (1.0 + np.abs(ends).max())
    least, most = ends.min(axis=0) - slack, ends.max(axis=0) + slack
    return ClipBox(tuple(least.tolist()), tuple(most.tolist()))


NAME = "viewed"
"""Name of the drawing."""
EDGES = "viewed edges"
"""Name of the drawing of the edges of a mesh."""
MOST_EDGES = 60_000
"""Largest number of faces of a mesh whose edges are drawn."""
YARN_COLOURS = {
    "Colours of the yarns": "yarn", "Rows": "row", "Stitch types": "stitch", "Strain of the yarn": "strain",
    "Stretch of the stitches": "stretch", "Contact force": "contact", "Distance between yarns": "distance",
    "Distance from a body": "body-distance", "One colour": "",
}  # fmt: skip
"""Colours of yarns in the words of the page, and the words of ``colour_yarns``."""
FACE_COLOURS = {
    "Stitch types": "stitch", "Rows": "row", "Colours of the yarns": "yarn", "Stretch of the stitches": "stretch",
    "One colour": "",
}  # fmt: skip
"""Colours of faces in the words of the page, and the words of ``colour_faces``."""
SLOW_COLOURS: Mapping[str, int] = {"contact": 5_000, "distance": 10_000, "body-distance": 10_000}
"""Largest numbers of control points whose colours are computed at once; larger ones become a task."""


@dataclass(frozen=True, eq=False)
class Place:
    """A place that was clicked."""

    point: FloatArray
    """The point [cm], shape (3,)."""
    text: str
    """A description of the place."""
    yarn: PickedYarn | None = None
    """The place on a yarn."""


class ThingView(Protocol):
    """Something in the scene."""

    coloured_count: int
    """Number of control points or faces, each of which has a colour."""

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the smallest and the largest coordinates [cm], shape (3,) each."""

    def figures(self) -> list[tuple[str, str]]:
        """Return names and values of the figures of the thing."""

    def is_slow(self, colour: str) -> bool:
        """Whether the colours take long."""

    def coloured(self, colour: str, fabric: StitchMesh | None, body: Mesh | None) -> Coloured:
        """Return the colours and their legend; any thread may call this."""

    def draw(self, scene: DrawingScene, colours: NDArray[np.uint8], clip: ClipBox | None) -> None:
        """Draw the thing."""

    def pick(self, origin: FloatArray, direction: FloatArray, fabric: StitchMesh | None) -> Place | None:
        """Return the first place at which a ray meets the thing."""

    def stitch(self, number: int, fabric: StitchMesh | None) -> Place | None:
        """Return the middle of a stitch, or of a face of a mesh; None if the number does not exist."""


class YarnView:
    """Yarns in the scene; periodic yarns appear as one cell and its copies."""

    def __init__(self, yarns: YarnSet, before: ThingView | None = None) -> None:
        """Keep the yarns; the blocks of the view before are used again if both have the same segments."""
        self.yarns, self.coloured_count = yarns, len(yarns.points)
        self._table: YarnPickingTable | None = None
        self._blocks: tuple[ClipBox | None, YarnBlocks] | None = None
        if isinstance(before, YarnView) and _same_segments(before.yarns, yarns) and before._blocks is not None:
            self._blocks = before._blocks if before._blocks[0] is None else None
        self.copies = IN_PLACE if yarns.lattice is None else _copies(yarns)

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the box of the control points of all copies."""
        places = self.yarns.points
        if self.yarns.point_shift is not None:
            places = (places[self.yarns.segment_points] + self.yarns.point_shift).reshape(-1, 3)
        low, high = places.min(axis=0), places.max(axis=0)
        return low + self.copies.min(axis=0), high + self.copies.max(axis=0)

    def figures(self) -> list[tuple[str, str]]:
        """Return numbers, length and radius."""
        yarns = self.yarns
        size = " x ".join(f"{side:.1f}" for side in np.ptp(yarns.points, axis=0))
        return [
            ("Yarns", f"{yarns.yarn_count:,}"), ("Control points", f"{len(yarns.points):,}"),
            ("Length of yarn", f"{yarns.lengths.sum() / 100:,.2f} m"), ("Size", f"{size} cm"),
            ("Radius of the yarn", f"{10 * float(yarns.radius.mean()):.2f} mm"),
            ("Mean strain", f"{100 * float(yarns.lengths.sum() / yarns.rest_length.sum() - 1):+.2f} %"),
        ]  # fmt: skip

    def is_slow(self, colour: str) -> bool:
        """Return whether the colours need a task."""
        return len(self.yarns.points) > SLOW_COLOURS.get(colour, len(self.yarns.points))

    def coloured(self, colour: str, fabric: StitchMesh | None, body: Mesh | None) -> Coloured:
        """Return the colours of the control points."""
        return colour_yarns(self.yarns, colour, fabric=fabric, body=body)

    def draw(self, scene: DrawingScene, colours: NDArray[np.uint8], clip: ClipBox | None) -> None:
        """Draw the segments inside the box as tubes."""
        scene.remove(EDGES)
        if self._blocks is None or self._blocks[0] != clip:
            segments = self._inside(clip)
            if not len(segments):
                scene.remove(NAME)
                return
            self._blocks = clip, make_blocks(self.yarns, segments)
        scene.show(NAME, YarnTubes(self._blocks[1], self.yarns.points, colours, self.copies))

    def pick(self, origin: FloatArray, direction: FloatArray, fabric: StitchMesh | None) -> Place | None:
        """Return the place on the nearest copy of a yarn."""
        if self._table is None:
            self._table = yarn_picking_table(self.yarns)
        found = [(pick_yarn(self._table, origin - copy, direction), copy) for copy in self.copies]
        met = [(place, copy) for place, copy in found if place is not None]
        if not met:
            return None
        place, copy = min(met, key=lambda pair: pair[0].depth)
        place = replace(place, point=place.point + copy)
        return Place(place.point, self._said(place, fabric), place)

    def stitch(self, number: int, fabric: StitchMesh | None) -> Place | None:
        """Return the middle of the control points of a stitch."""
        own = np.flatnonzero(self.yarns.face == number)
        if not len(own):
            return None
        words = f"Stitch {number}{_stitch_name(fabric, number)}, row {self.yarns.row[own[0]]}"
        return Place(self.yarns.points[own].mean(axis=0), words)

    def _said(self, place: PickedYarn, fabric: StitchMesh | None) -> str:
        yarns = self.yarns
        point = int(yarns.segment_points[place.segment, 1])
        face = int(yarns.face[point])
        words = [f"Yarn {place.yarn}", f"row {yarns.row[point]}"]
        if face >= 0:
            words.append(f"stitch {face}{_stitch_name(fabric, face)}")
        words.append(f"strain {100 * float(yarns.strain[place.segment]):+.1f} %")
        return ", ".join(words)

    def _inside(self, clip: ClipBox | None) -> IntArray:
        """Return the segments whose middle lies in the box."""
        if clip is None:
            return np.arange(len(self.yarns.segment_yarn))
        middle = self.yarns.points[self.yarns.segment_points[:, 1:3]].mean(axis=1)
        return np.flatnonzero(clip.inside(middle))


class MeshView:
    """A polygon mesh or a stitch mesh in the scene."""

    def __init__(self, mesh: Mesh) -> None:
        """Prepare the triangles."""
        self.mesh, self.coloured_count = mesh, mesh.face_count
        self._triangles = face_triangles(mesh)
        self._position, self._lifted = mesh.corner_position, lifted_corners(mesh)
        self._table = picking_table(mesh)
        self._clip: ClipBox | None = None
        self._shown: tuple[IntArray, IntArray, Lines | None] | None = None

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the box of the corners."""
        return self._position.min(axis=0), self._position.max(axis=0)

    def figures(self) -> list[tuple[str, str]]:
        """Return numbers and size."""
        mesh = self.mesh
        size = " x ".join(f"{side:.1f}" for side in np.ptp(self._position, axis=0))
        what = "Stitches" if isinstance(mesh, StitchMesh) and not _is_panel(mesh) else "Faces"
        rows = [("Rows", f"{int(mesh.row.max(initial=-1)) + 1:,}")] if isinstance(mesh, StitchMesh) else []
        return [(what, f"{mesh.face_count:,}"), *rows, ("Vertices", f"{len(mesh.vertices):,}"), ("Size", f"{size} cm")]

    def is_slow(self, colour: str) -> bool:
        """Return False, because the colours of faces are quick."""
        return False

    def coloured(self, colour: str, fabric: StitchMesh | None, body: Mesh | None) -> Coloured:
        """Return the colours of the faces."""
        return colour_faces(self.mesh, colour)

    def draw(self, scene: DrawingScene, colours: NDArray[np.uint8], clip: ClipBox | None) -> None:
        """Draw the faces in the box, and their edges."""
        if self._shown is None or self._clip != clip:
            self._clip, self._shown = clip, self._cut(clip)
        corners, face, edges = self._shown
        if not len(corners):
            scene.remove(NAME)
            scene.remove(EDGES)
            return
        of_faces = Colours.of(colours)
        scene.show(NAME, Surface(self._position, corners, Colours(of_faces.index[face], of_faces.palette)))
        if edges is not None:
            scene.show(EDGES, edges)

    def pick(self, origin: FloatArray, direction: FloatArray, fabric: StitchMesh | None) -> Place | None:
        """Return the place on the nearest face."""
        found = pick_face(self._table, origin, direction)
        if found is None:
            return None
        return Place(found.point, self._said(found.face))

    def stitch(self, number: int, fabric: StitchMesh | None) -> Place | None:
        """Return the middle of a face."""
        if not 0 <= number < self.mesh.face_count:
            return None
        return Place(self._table.centre[number], self._said(number))

    def _said(self, face: int) -> str:
        if not isinstance(self.mesh, StitchMesh):
            return f"Face {face}"
        return f"Stitch {face}{_stitch_name(self.mesh, face)}, row {self.mesh.row[face]}"

    def _cut(self, clip: ClipBox | None) -> tuple[IntArray, IntArray, Lines | None]:
        """Return the triangles in the box, their faces, and the edges of these faces."""
        corners, face = self._triangles.corners, self._triangles.face
        sides = self.mesh.edge_side
        if clip is not None:
            kept = clip.inside(self._table.centre)
            corners, face = corners[kept[face]], face[kept[face]]
            sides = sides[kept[self.mesh.side_face[sides]]]
        ends = np.stack([sides, self.mesh.side_next[sides]], axis=1)
        many = self.mesh.face_count > MOST_EDGES
        return corners, face, None if many else Lines(self._lifted[ends], (60, 60, 66), 1.0)


def _same_segments(first: YarnSet, second: YarnSet) -> bool:
    """Return whether two sets of yarns have the same segments, so that only their positions differ."""
    alike = np.array_equal(first.start, second.start) and np.array_equal(first.closed, second.closed)
    radii = alike and np.array_equal(first.drawn_radius, second.drawn_radius)
    return radii and first.lattice is None and second.lattice is None


def _copies(yarns: YarnSet) -> FloatArray:
    """Return the displacements of the copies of a cell, shape (n, 3)."""
    assert yarns.lattice is not None
    tiles = np.stack(np.meshgrid(*(np.arange(count) for count in DEFAULT_TILES), indexing="ij"), axis=-1)
    return yarns.lattice.shift(tiles.reshape(-1, 2))


def _stitch_name(fabric: StitchMesh | None, face: int) -> str:
    if fabric is None or face >= fabric.face_count or _is_panel(fabric):
        return ""
    return f" ({stitch_name(fabric.stitch_type(int(fabric.stitch[face])))})"


def _is_panel(mesh: StitchMesh) -> bool:
    """Return whether a stitch mesh is only labeled, and not divided yet."""
    return bool((mesh.stitch == Stitch.PANEL).all())
