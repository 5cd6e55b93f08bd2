# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checks, places and neighbours of single faces and sides by number, without a search through the whole mesh."""

from __future__ import annotations

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, BOTTOM, LEFT, RIGHT, TOP, StitchMesh


def check_face(fabric: StitchMesh, face: int) -> None:
    """Check that a face exists.

    Raises:
        ParameterError: the face does not exist.
    """
    if not 0 <= face < fabric.face_count:
        raise ParameterError(f"face {face}: does not exist; the mesh has faces 0 to {fabric.face_count - 1}")


def check_side(fabric: StitchMesh, side: int, kind: str) -> None:
    """Check that a side exists and is a ``"course"``, ``"wale"`` or ``"top"`` side.

    Raises:
        ParameterError: the side does not exist, or is of another kind.
    """
    if not 0 <= side < fabric.side_count:
        raise ParameterError(f"side {side}: does not exist; the mesh has sides 0 to {fabric.side_count - 1}")
    role = fabric.role_of(side)
    if role not in {"course": (BOTTOM, TOP), "wale": (RIGHT, LEFT), "top": (TOP,)}[kind]:
        found = ("bottom", "right wale", "top", "left wale")[role]
        raise ParameterError(f"{fabric.side_name(side)}: is a {found} side; expected a {kind} side")


def course_place(fabric: StitchMesh, side: int) -> tuple[bool, int]:
    """Whether a course side is on top of its face, and the place of the side there from the left."""
    face = int(fabric.side_face[side])
    place = side - int(fabric.face_start[face])
    n_bottom, n_top = int(fabric.n_bottom[face]), int(fabric.n_top[face])
    return (False, place) if place < n_bottom else (True, n_bottom + n_top - place)


def faces_beside(fabric: StitchMesh, side: int) -> tuple[int, int]:
    """Return the faces to the left and right of a wale edge; ``BORDER`` where there is none.

    Args:
        fabric: a mesh of stitches.
        side: either side of the edge.

    Raises:
        ParameterError: the two faces have opposite wale directions, or are one face.
    """
    across, role = int(fabric.twin[side]), fabric.role_of(side)
    if across != BORDER and fabric.role_of(across) == role:
        name = fabric.side_name(side)
        raise ParameterError(f"{name}: its two faces run in opposite directions; flip one of the rows first")
    face = int(fabric.side_face[side])
    other = BORDER if across == BORDER else int(fabric.side_face[across])
    if face == other:
        raise ParameterError(f"{fabric.side_name(side)}: has one face on both sides; expected two")
    return (face, other) if role == RIGHT else (other, face)
