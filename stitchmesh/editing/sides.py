# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Single faces and sides by their numbers: checks and names, without looking at the whole mesh."""

from __future__ import annotations

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, StitchMesh


def check_face(fabric: StitchMesh, face: int) -> None:
    """Check that a face exists.

    Raises:
        ParameterError: it does not.
    """
    if not 0 <= face < fabric.face_count:
        raise ParameterError(f"face {face}: is gone; the mesh has faces 0 to {fabric.face_count - 1}")


def check_side(fabric: StitchMesh, side: int, kind: str) -> None:
    """Check that a side exists and is a ``"course"``, ``"wale"`` or ``"top"`` side.

    Raises:
        ParameterError: it does not, or is of another kind.
    """
    if not 0 <= side < fabric.side_count:
        raise ParameterError(f"side {side}: is gone; the mesh has sides 0 to {fabric.side_count - 1}")
    role = role_of(fabric, side)
    if role not in {"course": (0, 2), "wale": (1, 3), "top": (2,)}[kind]:
        found = ("bottom", "right wale", "top", "left wale")[role]
        raise ParameterError(f"{fabric.side_name(side)}: is a {found} side; expected a {kind} side")


def role_of(fabric: StitchMesh, side: int) -> int:
    """Role of one side, as ``StitchMesh.side_role`` numbers them."""
    face = int(fabric.side_face[side])
    above = side - int(fabric.face_start[face]) - int(fabric.n_bottom[face])
    return int(above >= 0) + int(above > 0) + int(above > fabric.n_top[face])


def course_place(fabric: StitchMesh, side: int) -> tuple[bool, int]:
    """Whether a course side is on top of its face, and its place there from the left."""
    face = int(fabric.side_face[side])
    place = side - int(fabric.face_start[face])
    n_bottom, n_top = int(fabric.n_bottom[face]), int(fabric.n_top[face])
    return (False, place) if place < n_bottom else (True, n_bottom + n_top - place)


def edge_of(fabric: StitchMesh, side: int) -> int:
    """Name of a side's edge, as ``Draft.edge_of`` has it."""
    across = int(fabric.twin[side])
    return side if across == BORDER else min(side, across)
