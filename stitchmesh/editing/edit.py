# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits of a stitch mesh as data: a name, and arguments that JSON can hold."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stitchmesh.editing.bobble import bobble
from stitchmesh.editing.edges import (
    add_wale_edge,
    collapse_course_edge,
    remove_wale_edge,
    shift_wale_edge,
    split_course_edge,
)
from stitchmesh.editing.graft import graft, ungraft
from stitchmesh.editing.marks import (
    change_stitch,
    clear_cable,
    cross_cable,
    recolour,
    set_cable,
    stripe,
    stripes,
    twist_loop,
)
from stitchmesh.editing.on_selection import ON, edit_places, followed_places, place_argument, place_arguments
from stitchmesh.editing.pasting import paste_pattern
from stitchmesh.editing.row_edits import flip_row, insert_row, remove_row
from stitchmesh.editing.short_rows import short_rows
from stitchmesh.editing.spiral import spiral, unspiral
from stitchmesh.editing.wale_lines import insert_wale, remove_wale
from stitchmesh.errors import MeshError, ParameterError, check_kind
from stitchmesh.io.named_steps import check_step_name, checked_arguments_of, plain_arguments
from stitchmesh.mesh import BORDER, TOP, IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.change import Change, Marks, Patch, apply_change, inverse_change
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.selection import select

EDITS: dict[str, Callable[..., list[Change]]] = {
    edit.__name__: edit
    for edit in (
        change_stitch, twist_loop, stripe, stripes, recolour,
        cross_cable, set_cable, clear_cable,
        split_course_edge, collapse_course_edge,
        add_wale_edge, remove_wale_edge, shift_wale_edge,
        insert_wale, remove_wale,
        flip_row, insert_row, remove_row,
        short_rows, bobble, paste_pattern,
        spiral, unspiral, graft, ungraft,
    )
}  # fmt: skip
"""Function of each edit, by name. It takes a stitch mesh and the arguments, and returns the changes of the mesh."""


@dataclass(frozen=True)
class Edit:
    """One edit of a stitch mesh.

    Raises:
        ParameterError: the arguments are not given by name.
    """

    name: str
    """A key of ``EDITS``."""
    arguments: Mapping[str, object] = field(default_factory=dict)
    """Arguments of the edit by name, without the stitch mesh: numbers, texts and lists of numbers.

    The argument ``on`` holds a selection, such as ``hem 6``, in place of the numbers of a face, faces or a side. A
    ``Selection`` becomes its text, and NumPy numbers, NumPy arrays, tuples, ranges and sets become numbers and lists
    when the edit is made.
    """

    def __post_init__(self) -> None:
        arguments = self.arguments
        if isinstance(arguments, Mapping) and ON in arguments:
            arguments = {**arguments, ON: str(arguments[ON])}
        arguments = plain_arguments(f"edit {self.name!r}", arguments, '{"faces": [3, 4]}')
        object.__setattr__(self, "arguments", arguments)


@dataclass(frozen=True, eq=False)
class Edited:
    """The result of an edit."""

    fabric: StitchMesh
    """Stitch mesh after the edit."""
    changes: tuple[Change, ...]
    """Changes of the edit, in the order in which they are applied."""
    inverse: tuple[Change, ...]
    """Changes that undo the edit exactly, in the order in which they are applied."""

    def __repr__(self) -> str:
        """Return one line: the number of changes, and the fabric."""
        return f"Edited({len(self.changes)} changes, {self.fabric})"


def apply_edit(fabric: StitchMesh, edit: Edit) -> Edited:
    """Apply an edit, and return a new stitch mesh; the given stitch mesh stays unchanged.

    Args:
        fabric: a tessellated stitch mesh without a lattice.
        edit: the edit.

    Raises:
        ParameterError: the edit is unknown; an argument is missing, unknown or of another type; an argument names a
            face, a side or a row that does not exist or at which the edit is not possible; or a selection is malformed
            or empty.
        MeshError: the mesh would not be an oriented manifold surface, is not tessellated, or is periodic.
        LabelError: a face would not be a legal stitch face, or a cable would be cut.
    """
    check_kind("apply_edit", fabric, StitchMesh)
    check_kind("apply_edit, edit", edit, Edit)
    panels = np.flatnonzero(fabric.stitch == Stitch.PANEL)
    if len(panels) or fabric.lattice is not None:
        what = "is periodic" if fabric.lattice is not None else f"has panels (face {panels[0]})"
        raise MeshError(f"edit: the mesh {what}; expected a tessellated mesh with borders")
    arguments = checked_arguments(edit)
    if ON not in arguments:
        return apply_changes(fabric, EDITS[edit.name](fabric, **arguments))
    if place_argument(edit.name) != "faces":
        return _apply_at_places(fabric, edit.name, arguments)
    arguments["faces"] = select(fabric, arguments.pop(ON)).tolist()
    return apply_changes(fabric, EDITS[edit.name](fabric, **arguments))


def _apply_at_places(fabric: StitchMesh, name: str, arguments: dict[str, Any]) -> Edited:
    """Apply an edit at each place of a selection, one after another."""
    places = edit_places(fabric, name, arguments)
    others = {key: value for key, value in arguments.items() if key != ON}
    changes: list[Change] = []
    inverse: list[Change] = []
    while len(places):
        place = place_arguments(fabric, name, int(places[0]))
        edited = apply_changes(fabric, EDITS[name](fabric, **others, **place))
        places = followed_places(places[1:], fabric, edited.fabric, edited.changes)
        fabric, changes, inverse = edited.fabric, [*changes, *edited.changes], [*edited.inverse, *inverse]
    return Edited(fabric, tuple(changes), tuple(inverse))


def apply_changes(fabric: StitchMesh, changes: Sequence[Change]) -> Edited:
    """Apply changes one after another.

    Raises:
        MeshError: an error of ``apply_change``.
        LabelError: an error of ``apply_change``, or a cable would be cut.
    """
    inverse: list[Change] = []
    for change in changes:
        inverse.insert(0, inverse_change(fabric, change))
        fabric = apply_change(fabric, change)
    if changes and fabric.cable_shift.any():
        cable_groups(fabric, _changed_loops(fabric, changes[-1]))  # This raises LabelError for a cut cable.
    return Edited(fabric, tuple(changes), tuple(inverse))


def checked_arguments(edit: Edit) -> dict[str, Any]:
    """Check the names and the types of an edit's arguments, and return all arguments, defaults included.

    Raises:
        ParameterError: the edit is unknown, or an argument is missing, unknown or of another type.
    """
    check_step_name("edit", edit.name, EDITS)
    try:
        if ON in edit.arguments:
            return checked_arguments_of(EDITS[edit.name], edit.arguments, place_argument(edit.name), ON)
        return checked_arguments_of(EDITS[edit.name], edit.arguments)
    except ParameterError as error:
        raise ParameterError(f"{edit.name}: {error}") from error


def _changed_loops(fabric: StitchMesh, change: Change) -> IntArray:
    """Return the top sides of the faces that a change has added or marked, and of the faces below them."""
    if isinstance(change, Marks):
        sides = change.places if change.name.startswith("cable") else np.zeros(0, dtype=np.int64)
    else:
        added = change.added_faces if isinstance(change, Patch) else np.zeros(0, dtype=np.int64)
        sides = fabric.sides_of(added)
    across = fabric.twin[sides]
    sides = np.concatenate([sides, across[across != BORDER]])
    return sides[fabric.side_role[sides] == TOP]
