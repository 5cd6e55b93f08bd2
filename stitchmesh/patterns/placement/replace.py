# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Replacement of plain stitches by the blocks of a pattern, in one change of the mesh.

Course lines keep their shape: the new loops of a row lie along the old course line, and the line changes only inside a
block.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER, BOTTOM, LEFT, PER_SIDE, RIGHT, TOP, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.change import UNKNOWN_STRETCH, Patch, stretch_at, vertices_left
from stitchmesh.mesh.own_stitch import FIRST_OWN
from stitchmesh.mesh.renumbering import Renumbering
from stitchmesh.patterns.pattern import Pattern
from stitchmesh.patterns.placement.block import Block
from stitchmesh.patterns.placement.units import Site


def _first_faces(sites: list[Site]) -> list[IntArray]:
    """Return the number of the first face of each copy among all added faces."""
    first, result = 0, []
    for site in sites:
        result.append(first + len(site.block.stitch) * np.arange(len(site.grids)))
        first += site.face_count
    return result


class Replacement:
    """The patch that replaces plain faces by the blocks of sites."""

    def __init__(self, fabric: StitchMesh, pattern: Pattern, sites: list[Site]) -> None:
        """Number the removed and added faces."""
        self.fabric, self.pattern, self.sites = fabric, pattern, sites
        self.removed = np.sort(np.concatenate([site.grids.ravel() for site in sites]))
        self.face = Renumbering.filling(fabric.face_count, self.removed, sum(site.face_count for site in sites))
        self.first_face = _first_faces(sites)
        self.across = self._sides_after()

    def _sides_after(self) -> IntArray:
        """Return the face and place of each old side after the change, shape (C, 2).

        A side of a removed face on the border of a grid maps to the side of the block that replaces it.
        """
        fabric = self.fabric
        after = np.stack([self.face.after[fabric.side_face], fabric.side_place], axis=1)
        for site, first in zip(self.sites, self.first_face, strict=True):
            for border, sides in border_sides(fabric, site.grids).items():
                face, place = site.block.border[border].T
                after[sides, 0] = self.face.added[first[:, None] + face]
                after[sides, 1] = place
        return after

    def patch(self) -> Patch:
        """Return the patch that replaces the plain faces by the blocks."""
        fabric = self.fabric
        positions, corners = self._vertices()
        count = len(fabric.vertices)
        gone = vertices_left(fabric, self.removed, corners[corners < count])
        vertex = Renumbering.filling(count, gone, len(positions))
        return Patch(
            removed_faces=self.removed,
            removed_vertices=gone,
            added_faces=self.face.added,
            added_vertices=vertex.added,
            positions=positions,
            face_size=self._of_faces("face_size"),
            corners=np.concatenate([vertex.after, vertex.added])[corners],
            twin=self._twins(),
            faces={
                "n_bottom": self._of_faces("n_bottom"),
                "n_top": self._of_faces("n_top"),
                "stitch": self._type_codes(),
                "row": self._from_old("row"),
                "yarn": self._of_faces("yarn") if self.pattern.yarn_count > 1 else self._from_old("yarn"),
            },
            sides={name: self._of_sides(name) for name in PER_SIDE},
            stretch=self._stretch(),
        )

    def _type_codes(self) -> IntArray:
        """Return the type code of each new face in the fabric, where the user's own stitches may have other codes."""
        codes = self._of_faces("stitch")
        own = np.array([self.fabric.type_code(stitch) for stitch in self.pattern.own_stitches], dtype=np.int64)
        mine = codes >= FIRST_OWN
        codes[mine] = own[codes[mine] - FIRST_OWN]
        return codes

    def _of_faces(self, name: str) -> IntArray:
        """Return an array of the blocks for all added faces."""
        return np.concatenate([np.tile(getattr(site.block, name), len(site.grids)) for site in self.sites])

    def _from_old(self, name: str) -> IntArray:
        """Return an array of the fabric for all added faces, taken from the nearest replaced face."""
        old = [site.grids[:, site.block.row, site.block.column].ravel() for site in self.sites]
        numbers: IntArray = getattr(self.fabric, name)[np.concatenate(old)]
        return numbers

    def _of_sides(self, name: str) -> IntArray:
        """Return a mark of all added sides; a top border takes the cable marks of the replaced sides."""
        parts = []
        for site in self.sites:
            marks = np.tile(getattr(site.block, name), (len(site.grids), 1))
            if name != "twist":
                top = flat_places(site.block, TOP)
                marks[:, top] = getattr(self.fabric, name)[border_sides(self.fabric, site.grids)[TOP]]
            parts.append(marks.ravel())
        return np.concatenate(parts)

    def _vertices(self) -> tuple[FloatArray, IntArray]:
        """Return the positions of all added vertices [cm], shape (v, 3), and the corners of all added faces.

        Added vertices are numbered after the old ones.
        """
        positions, corners, count = [], [], len(self.fabric.vertices)
        for site in self.sites:
            lines = [_old_line(self.fabric, site.grids, level) for level in range(site.block.height + 1)]
            vertices = []
            for level, (old, ends) in enumerate(zip(lines, site.block.lines, strict=True)):
                if level in (0, site.block.height):
                    vertices.append(old)
                    continue
                inner = _along(self.fabric.vertices[old], ends[1:-1])
                own = count + np.arange(inner.shape[0] * inner.shape[1]).reshape(inner.shape[:2])
                count += own.size
                positions.append(inner.reshape(-1, 3))
                vertices.append(np.concatenate([old[:, :1], own, old[:, -1:]], axis=1))
            corners.append(np.concatenate(vertices, axis=1)[:, site.block.corners].ravel())
        return np.concatenate(positions or [np.zeros((0, 3))]), np.concatenate(corners)

    def _twins(self) -> IntArray:
        parts = []
        for site, first in zip(self.sites, self.first_face, strict=True):
            inner = site.block.twin
            faces = self.face.added[first[:, None] + inner[:, 0]]
            twin = np.stack([faces, np.broadcast_to(inner[:, 1], faces.shape)], axis=2)
            for border, sides in border_sides(self.fabric, site.grids).items():
                across = self.fabric.twin[sides]
                outer = np.where((across == BORDER)[..., None], BORDER, self.across[across])
                twin[:, flat_places(site.block, border)] = outer
            parts.append(twin.reshape(-1, 2))
        return np.concatenate(parts)

    def _stretch(self) -> FloatArray:
        parts = []
        for site in self.sites:
            stretch = np.full((len(site.grids), len(site.block.corners)), UNKNOWN_STRETCH)
            for border, sides in border_sides(self.fabric, site.grids).items():
                known = stretch_at(self.fabric, sides.ravel()).reshape(sides.shape)
                stretch[:, flat_places(site.block, border)] = known
            parts.append(stretch.ravel())
        return np.concatenate(parts)

    def sides_after(self, patch: Patch) -> IntArray:
        """Return the number after the patch of each old side, ``BORDER`` if the side is gone, shape (C,).

        A side on the border of a removed grid maps to the side of the block at its place.
        """
        sizes = self.face.merged(np.diff(self.fabric.face_start), patch.face_size)
        start = np.concatenate([[0], np.cumsum(sizes)])
        face, place = self.across.T
        return np.where(face < 0, BORDER, start[face] + place)


def border_sides(fabric: StitchMesh, grids: IntArray) -> dict[int, IntArray]:
    """Return the old sides around grids of plain faces, in the order of ``Block.border``, each shape (copies, m)."""
    start = fabric.face_start
    return {
        BOTTOM: start[grids[:, 0]],
        RIGHT: start[grids[:, :, -1]] + 1,
        TOP: start[grids[:, -1]] + 2,
        LEFT: start[grids[:, :, 0]] + 3,
    }


def flat_places(block: Block, border: int) -> IntArray:
    """Return the places of a border's sides among all sides of a block."""
    first = np.cumsum(block.face_size) - block.face_size
    face, place = block.border[border].T
    places: IntArray = first[face] + place
    return places


def _old_line(fabric: StitchMesh, grids: IntArray, level: int) -> IntArray:
    """Return the vertices of a course line through grids, left to right, shape (copies, columns + 1)."""
    row, left, right = (level, 0, 1) if level < grids.shape[1] else (level - 1, 3, 2)
    first = fabric.face_start[grids[:, row]]
    return np.concatenate([fabric.face_vertex[first + left], fabric.face_vertex[first[:, -1:] + right]], axis=1)


def _along(line: FloatArray, ends: FloatArray) -> FloatArray:
    """Return the points of polylines at given distances from their starts, in segments, shape (copies, points, 3)."""
    segment = np.minimum(ends.astype(np.int64), line.shape[1] - 2)
    share = (ends - segment)[:, None]
    return line[:, segment] * (1.0 - share) + line[:, segment + 1] * share
