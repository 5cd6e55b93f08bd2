# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The places of an edit that is made on a selection of faces.

An edit of faces is made once, on all of them. An edit of rows is made once for each row of the selection, an edit of
columns once for each stitch in the first row of the selection, and an edit of a stitch or a loop once for each stitch.
Crossings of cables are set side by side along each row.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, LEFT, TOP, IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.change import Change, Patch
from stitchmesh.mesh.courses import faces_across
from stitchmesh.mesh.renumbering import REMOVED, Renumbering
from stitchmesh.selection import select
from stitchmesh.selection.parts import face_centres

ON = "on"
"""Name of the argument that holds the selection of an edit."""
Places = Callable[[StitchMesh, IntArray, Mapping[str, object]], IntArray]


def _every_stitch(fabric: StitchMesh, faces: IntArray, arguments: Mapping[str, object]) -> IntArray:
    return faces


def _every_row(fabric: StitchMesh, faces: IntArray, arguments: Mapping[str, object]) -> IntArray:
    return faces[np.unique(fabric.row[faces], return_index=True)[1]]


def _every_column(fabric: StitchMesh, faces: IntArray, arguments: Mapping[str, object]) -> IntArray:
    return faces[fabric.row[faces] == fabric.row[faces].min()]


def _every_cable(fabric: StitchMesh, faces: IntArray, arguments: Mapping[str, object]) -> IntArray:
    """Return the face of one loop of each cable that lies within the selection."""
    inside = np.zeros(fabric.face_count, dtype=bool)
    inside[faces] = True
    owners = [fabric.side_face[np.asarray(group.sides)] for group in cable_groups(fabric)]
    return np.array([owner[0] for owner in owners if inside[owner].all()], dtype=np.int64)


def _every_crossing(fabric: StitchMesh, faces: IntArray, arguments: Mapping[str, object]) -> IntArray:
    """Return the leftmost face of each crossing; from the left, the crossings of a row lie side by side."""
    loops = arguments.get("destinations")
    width = len(loops) if isinstance(loops, list) else sum(_whole(arguments.get(name)) for name in ("left", "right"))
    inside = np.zeros(fabric.face_count, dtype=bool)
    inside[faces] = True
    after = faces_across(fabric, fabric.right_wale, LEFT)
    follows = np.zeros(fabric.face_count, dtype=bool)
    inner = faces[after[faces] != BORDER]
    follows[after[inner]] = True
    firsts = [face for face in faces.tolist() if not follows[face]] or faces[:1].tolist()
    starts: list[int] = []
    for first in firsts:
        run = [first]
        while (face := int(after[run[-1]])) not in (BORDER, first) and inside[face]:
            run.append(face)
        starts += run[: len(run) - len(run) % max(width, 1) : max(width, 1)]
    return np.array(starts, dtype=np.int64)


def _whole(value: object) -> int:
    return value if isinstance(value, int) and value > 0 else 0


FACE_EDITS: dict[str, Places] = {
    "flip_row": _every_row,
    "insert_row": _every_row,
    "remove_row": _every_row,
    "remove_wale": _every_column,
    "add_wale_edge": _every_stitch,
    "bobble": _every_stitch,
}
"""Places of the edits that take a face."""
LOOP_EDITS: dict[str, Places] = {
    "twist_loop": _every_stitch,
    "split_course_edge": _every_stitch,
    "collapse_course_edge": _every_stitch,
    "cross_cable": _every_crossing,
    "set_cable": _every_crossing,
    "clear_cable": _every_cable,
}
"""The places of each edit that takes a top side; its side is the leftmost loop of the place."""
WALE_EDITS: dict[str, Places] = {
    "insert_wale": _every_column,
    "remove_wale_edge": _every_stitch,
    "shift_wale_edge": _every_stitch,
}
"""The places of each edit that takes a wale side; its side is the right wale side of the place."""
FACES_EDITS = ("change_stitch", "stripe", "stripes", "short_rows", "paste_pattern")
"""Edits of all faces at once."""


def place_argument(name: str) -> str:
    """Return the argument of an edit that a selection replaces: ``faces``, ``face`` or ``side``.

    Raises:
        ParameterError: the edit changes the whole mesh, and takes no selection.
    """
    if name in FACES_EDITS:
        return "faces"
    if name in FACE_EDITS:
        return "face"
    if name in LOOP_EDITS or name in WALE_EDITS:
        return "side"
    raise ParameterError(f"takes no selection, because it changes the whole mesh; leave {ON!r} out")


def edit_places(fabric: StitchMesh, name: str, arguments: Mapping[str, object]) -> IntArray:
    """Return the faces at which an edit is made for a selection, each once.

    Args:
        fabric: the stitch mesh.
        name: name of the edit, which is not one of ``FACES_EDITS``.
        arguments: arguments of the edit, with the selection.

    Raises:
        ParameterError: an error of ``select``, or the selection has no place for the edit.
        FileError: an error of ``select``.
    """
    choose = {**FACE_EDITS, **LOOP_EDITS, **WALE_EDITS}[name]
    text = str(arguments[ON])
    places = choose(fabric, select(fabric, text), arguments)
    if not len(places):
        raise ParameterError(f"{name}: selection {text!r} has no place for it")
    return places


def place_arguments(fabric: StitchMesh, name: str, face: int) -> dict[str, object]:
    """Return the argument that names the place of an edit at a face.

    Raises:
        ParameterError: the face has no top side, and the edit needs one.
    """
    if name in FACE_EDITS:
        return {"face": face}
    if name in WALE_EDITS:
        return {"side": int(fabric.right_wale[face])}
    side = int(fabric.left_wale[face]) - 1
    if fabric.role_of(side) != TOP:
        raise ParameterError(f"{name}: face {face} of the selection makes no loop")
    return {"side": side}


def places_after(places: IntArray, face_count: int, changes: Iterable[Change]) -> IntArray:
    """Return the numbers of faces after some changes, shape (n,); ``REMOVED`` for faces that the changes remove.

    Args:
        places: numbers of faces before the changes, shape (n,).
        face_count: number of faces before the changes.
        changes: the changes, in order.
    """
    for change in changes:
        if isinstance(change, Patch):
            numbers = Renumbering.of(face_count, change.removed_faces, change.added_faces)
            places = np.where(places == REMOVED, REMOVED, numbers.after[places])
            face_count = len(numbers.moved) + len(numbers.added)
    return places


def followed_places(places: IntArray, before: StitchMesh, after: StitchMesh, changes: Iterable[Change]) -> IntArray:
    """Return the faces of an edited fabric that stand in the places of faces before the edit, shape (n,).

    An edit replaces the neighbours of its place by new faces. A face that it removes is followed to the nearest new
    face.

    Args:
        places: numbers of faces before the edit, shape (n,).
        before: the fabric before the edit.
        after: the fabric after the edit.
        changes: the changes of the edit.
    """
    moved = places_after(np.arange(before.face_count), before.face_count, changes)
    is_new = np.ones(after.face_count, dtype=bool)
    is_new[moved[moved != REMOVED]] = False
    new = np.flatnonzero(is_new)
    lost = np.flatnonzero(moved[places] == REMOVED)
    result = moved[places]
    if len(lost) and len(new):
        offset = face_centres(after, new)[None, :] - face_centres(before, places[lost])[:, None]
        result[lost] = new[np.linalg.norm(offset, axis=2).argmin(axis=1)]
    return result[result != REMOVED]
