# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The faces that cannot be labeled, and the reasons in words."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import first_few
from stitchmesh.labeling.growth import COURSE, UNKNOWN, WALE, EdgeLabels
from stitchmesh.labeling.seeds import edge_name
from stitchmesh.mesh import BORDER, IntArray, Mesh
from stitchmesh.mesh.polygon_mesh import connected_faces


@dataclass(frozen=True)
class LabelingFault:
    """Faces that cannot be labeled for one reason."""

    faces: tuple[int, ...]
    """The faces."""
    reason: str
    """The reason in words, and what to do."""


def find_faults(mesh: Mesh, labels: EdgeLabels) -> tuple[LabelingFault, ...]:
    """Find the faces that cannot be labeled: faces with contradicting edges, and parts without a start."""
    rest = np.flatnonzero(labels.row < 0)
    if len(rest) == 0:
        return ()
    sides = labels.fault_side[rest]
    faults = [_contradiction(mesh, labels, int(side)) for side in sides[sides >= 0]]
    faults += _wrong_wale_counts(mesh, labels, rest[labels.fault_side[rest] < 0])
    return (*faults, *_parts_without_start(mesh, labels))


def error_message(mesh: Mesh, labels: EdgeLabels, faults: tuple[LabelingFault, ...]) -> str:
    """Return one line that says why faces are unlabeled."""
    rest = np.count_nonzero(labels.row < 0)
    triangles = triangles_message(mesh)
    if triangles:
        return triangles
    if not faults:
        return f"mesh: {rest} of {mesh.face_count} faces have no row yet; label more rows"
    others = "" if len(faults) == 1 else f" (+{len(faults) - 1} more faults; {rest} faces have no row)"
    return f"{faults[0].reason}{others}"


def triangles_message(mesh: Mesh) -> str:
    """Return one line that says that a mesh consists of triangles; no text for other meshes."""
    triangles = np.count_nonzero(np.diff(mesh.face_start) == 3)
    # A mesh is called a mesh of triangles if a larger part of its faces than this are triangles.
    if triangles <= 0.5 * mesh.face_count:
        return ""
    return (
        f"mesh: these are triangles: {triangles} of {mesh.face_count} faces; rows need quads that lie in rows, so "
        "remodel the mesh with quads, or join pairs of triangles to quads in a modelling program"
    )


def _contradiction(mesh: Mesh, labels: EdgeLabels, side: int) -> LabelingFault:
    """The fault of a face that needs another label of this side than the side has."""
    face, twin = int(mesh.side_face[side]), mesh.twin[side]
    faces = (face,) if twin == BORDER else (face, int(mesh.side_face[twin]))
    edge = mesh.side_edge[side]
    if labels.by_hand[edge]:
        name = "wale" if labels.edge_label[edge] == WALE else "course"
        return LabelingFault(
            (face,),
            f"face {face}: edge {edge_name(mesh, side)} was set to {name} by hand, which does not fit the rows around "
            "the face; set its other edges by hand too, or clear this one",
        )
    wale = _corner_of_row(mesh, labels, face)
    by_hand = "set edges by hand"
    if wale is not None:
        by_hand = f"set edge {edge_name(mesh, wale)} to wale so that a row turns here"
    return LabelingFault(
        (face,),
        f"face {' and '.join(map(str, faces))}: edge {edge_name(mesh, side)} would be both wale and course, but a face "
        "needs exactly 2 wale edges and rows must not cross; remodel the faces around this edge, start at another "
        f"edge, or {by_hand}",
    )


def _corner_of_row(mesh: Mesh, labels: EdgeLabels, face: int) -> int | None:
    """One of the two sides that are no course sides, for a face whose other edges are all course edges; else None.

    The two edges can be wale edges, although the rule of growth would choose others. The user decides whether a row
    should turn there.
    """
    sides = np.arange(mesh.face_start[face], mesh.face_start[face + 1])
    wales = sides[labels.edge_label[mesh.side_edge[sides]] != COURSE]
    return int(wales[0]) if len(wales) == 2 else None


def _wrong_wale_counts(mesh: Mesh, labels: EdgeLabels, faces: IntArray) -> list[LabelingFault]:
    """The faults of unlabeled faces that have more than two wale edges, or fewer and no edge without a label."""
    label = labels.edge_label[mesh.side_edge]
    wales = np.add.reduceat(label == WALE, mesh.face_start[:-1], dtype=np.int64)[faces]
    unknown = np.add.reduceat(label == UNKNOWN, mesh.face_start[:-1], dtype=np.int64)[faces]
    bad = (wales > 2) | ((unknown == 0) & (wales != 2))
    return [
        LabelingFault(
            (face,),
            f"face {face}: has {count} wale edge{'s' * (count != 1)}, but a face needs exactly 2; set or clear labels "
            "of its edges by hand",
        )
        for face, count in zip(faces[bad].tolist(), wales[bad].tolist(), strict=True)
    ]


def _parts_without_start(mesh: Mesh, labels: EdgeLabels) -> list[LabelingFault]:
    """The faults of parts of the mesh that have no border and no labeled face."""
    part = connected_faces(mesh)
    startable = np.zeros(part.max() + 1, dtype=bool)
    startable[part[(labels.row >= 0) | (labels.fault_side >= 0)]] = True
    startable[part[mesh.side_face[mesh.twin == BORDER]]] = True
    faults = []
    for number in np.flatnonzero(~startable):
        faces = np.flatnonzero(part == number)
        whole = len(faces) == mesh.face_count
        name = "mesh: has no border" if whole else f"face {first_few(faces)}: its part of the mesh has no border"
        faults.append(LabelingFault(tuple(faces.tolist()), f"{name} to start from; name an edge of its first row"))
    return faults
