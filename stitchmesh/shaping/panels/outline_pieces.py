# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The outlines of panels, divided at corners and at the ends of seams.

A piece of an outline is a hem if it runs nearly perpendicular to the direction of knitting: rows begin or end there. At
every other piece rows are cut: it is a side.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from stitchmesh.mesh import BORDER, FloatArray, IntArray
from stitchmesh.mesh.face_triangles import face_triangles
from stitchmesh.shaping.borders import corner_angles
from stitchmesh.shaping.panels.panel_mesh import PanelMesh
from stitchmesh.shaping.triangle_surface import TriangleSurface

CORNER = np.radians(30.0)
"""Turning of an outline at a vertex that makes a corner [rad]."""
SIDE, BEGINS, ENDS = 0, -1, 1
"""Kinds of a piece: rows are cut at a side, and begin or end at a hem."""


@dataclass(frozen=True, eq=False)
class OutlinePiece:
    """A piece of the outline of a panel."""

    panel: int
    """The panel."""
    vertices: IntArray
    """Vertices of the panel mesh along the piece, with the panel on the left, shape (n,)."""
    length: float
    """Length [cm]."""
    kind: int
    """``SIDE``, ``BEGINS`` or ``ENDS``."""
    partner: int
    """Number of the piece that it is sewn to, -1 if it is not sewn."""
    following: int
    """Number of the next piece of the same border."""


def outline_pieces(panels: PanelMesh, direction: FloatArray, stitch_width: float) -> list[OutlinePiece]:
    """Divide the outlines of all panels.

    Args:
        panels: the panels.
        direction: direction of knitting of each panel in its texture, shape (P, 2).
        stitch_width: width of a stitch [cm].
    """
    breaks = _breaks(panels)
    across, place = _side_of_vertex(panels), _places_across(panels, direction)
    pieces: list[OutlinePiece] = []
    for loop in panels.mesh.boundary_loops:
        first = len(pieces)
        lines = _between_breaks(panels.mesh.face_vertex[loop], breaks)
        for number, line in enumerate(lines):
            panel = int(panels.face_panel[panels.mesh.side_face[loop[0]]])
            length = float(_steps(panels.mesh.vertices[line]).sum())
            kind = _kind(float(place[line[-1]] - place[line[0]]), length)
            # Length of the shortest hem, in stitch widths.
            kind = kind if length >= 2.0 * stitch_width else SIDE
            pieces.append(OutlinePiece(panel, line, length, kind, -1, first + (number + 1) % len(lines)))
    return _without_touching_hems(_with_partners(pieces, across))


def hem_runs(pieces: list[OutlinePiece], panel: int) -> list[list[int]]:
    """Return the pieces of each hem of a panel, along the border; neighbours of one kind are one hem."""
    hems = [number for number, piece in enumerate(pieces) if piece.panel == panel and piece.kind != SIDE]
    before = {pieces[number].following: number for number in hems}
    runs = []
    for number in hems:
        if number in before and pieces[before[number]].kind == pieces[number].kind and before[number] != number:
            continue
        run = [number]
        while pieces[following := pieces[run[-1]].following].kind == pieces[number].kind and following not in run:
            run.append(following)
        runs.append(run)
    return runs


def _steps(points: FloatArray) -> FloatArray:
    return np.linalg.norm(np.diff(points, axis=0), axis=1)


def _breaks(panels: PanelMesh) -> set[int]:
    """The vertices at which outlines are divided: corners, ends of seams, and vertices that are sewn to these."""
    mesh = panels.mesh
    surface = TriangleSurface(mesh.vertices, mesh.face_vertex[face_triangles(mesh).corners])
    border = mesh.face_vertex[mesh.twin == BORDER]
    turning = np.abs(np.pi - corner_angles(surface)[border])
    breaks = set(border[turning > CORNER].tolist())
    for seam in panels.seams:
        breaks.update(int(vertex) for line in (seam.first, seam.second) for vertex in line[[0, -1]])
    pairs = {pair for seam in panels.seams for pair in zip(seam.first.tolist(), seam.second.tolist(), strict=True)}
    while True:
        sewn = {vertex for pair in pairs if not breaks.isdisjoint(pair) for vertex in pair} - breaks
        if not sewn:
            return breaks
        breaks |= sewn


def _side_of_vertex(panels: PanelMesh) -> dict[int, int]:
    """For the first vertex of each border side that is sewn, the first vertex of the side that it is sewn to."""
    across: dict[int, int] = {}
    for seam in panels.seams:
        across.update(zip(seam.first[:-1].tolist(), seam.second[1:].tolist(), strict=True))
        across.update(zip(seam.second[1:].tolist(), seam.first[:-1].tolist(), strict=True))
    return across


def _between_breaks(loop: IntArray, breaks: set[int]) -> list[IntArray]:
    """Divide a border at some vertices; each line contains both of its ends."""
    places = [place for place, vertex in enumerate(loop.tolist()) if vertex in breaks] or [0]
    ring = np.roll(loop, -places[0])
    cuts = [place - places[0] for place in places] + [len(loop)]
    ring = np.append(ring, ring[0])
    return [ring[first : last + 1] for first, last in pairwise(cuts)]


def _places_across(panels: PanelMesh, direction: FloatArray) -> FloatArray:
    """Place of each vertex across the direction of knitting of its panel, to the right seen from outside [cm], (V,)."""
    mesh, place = panels.mesh, np.zeros(len(panels.mesh.vertices))
    divided = face_triangles(mesh)
    for panel in range(panels.panel_count):
        own = mesh.face_vertex[divided.corners[panels.face_panel[divided.face] == panel]]
        surface = TriangleSurface(mesh.vertices, own)
        slope = np.linalg.norm(surface.gradient(panels.texture @ direction[panel]), axis=1)
        mean = max(float(np.average(slope, weights=surface.area)), np.finfo(np.float64).tiny)
        a, b, c = (panels.texture[own[:, k]] for k in range(3))
        area = float(((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]).sum())
        turned = np.array([direction[panel][1], -direction[panel][0]]) * np.sign(area)
        vertices = np.unique(own)
        place[vertices] = panels.texture[vertices] @ turned / mean
    return place


def _kind(width: float, length: float) -> int:
    """Tell a hem from a side by its width across the direction of knitting, positive to the right, and its length."""
    # A piece is a hem if its width across the direction of knitting, over its length, is at least this: a slope of
    # 21 degrees.
    if abs(width) < 0.93 * length:
        return SIDE
    return BEGINS if width > 0.0 else ENDS


def _with_partners(pieces: list[OutlinePiece], across: dict[int, int]) -> list[OutlinePiece]:
    """Find the piece that each piece is sewn to."""
    owner = {vertex: number for number, piece in enumerate(pieces) for vertex in piece.vertices[:-1].tolist()}
    return [replace(piece, partner=owner.get(across.get(int(piece.vertices[0]), -1), -1)) for piece in pieces]


def _without_touching_hems(pieces: list[OutlinePiece]) -> list[OutlinePiece]:
    """Where a hem that begins rows and a hem that ends rows share a vertex, make the shorter one a side."""
    kinds = [piece.kind for piece in pieces]
    for number, piece in enumerate(pieces):
        following = piece.following
        if kinds[number] * kinds[following] == -1:
            shorter = min((number, following), key=lambda one: pieces[one].length)
            kinds[shorter] = SIDE
    return [replace(piece, kind=kind) for piece, kind in zip(pieces, kinds, strict=True)]
