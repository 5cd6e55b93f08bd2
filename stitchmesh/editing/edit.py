# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits of a stitch mesh as data: a name, and arguments that JSON can hold."""

from __future__ import annotations

import difflib
import functools
import inspect
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import msgspec
import numpy as np

from stitchmesh.editing.bobble import bobble
from stitchmesh.editing.cable_marks import clear_cable, cross_cable, set_cable
from stitchmesh.editing.course_edges import collapse_course_edge, split_course_edge
from stitchmesh.editing.on_selection import ON, edit_places, followed_places, place_argument, place_arguments
from stitchmesh.editing.pasting import paste_pattern
from stitchmesh.editing.row_edits import flip_row, insert_row, remove_row
from stitchmesh.editing.short_rows import short_rows
from stitchmesh.editing.stitch_marks import change_stitch, recolour, stripe, stripes, twist_loop
from stitchmesh.editing.wale_columns import remove_wale
from stitchmesh.editing.wale_edges import add_wale_edge, remove_wale_edge, shift_wale_edge
from stitchmesh.editing.wale_lines import insert_wale
from stitchmesh.editing.whole_mesh import graft, spiral, ungraft, unspiral
from stitchmesh.errors import MeshError, ParameterError, check_kind, described
from stitchmesh.io.checked import check_value, plain_value
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

LARGEST_NUMBER = 2**31 - 1
"""Largest absolute value of a whole number in the arguments of an edit."""
WholeNumber = Annotated[int, msgspec.Meta(ge=-LARGEST_NUMBER, le=LARGEST_NUMBER)]
"""Type of a whole number in the arguments of an edit."""


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
        if not isinstance(self.arguments, Mapping) or not all(isinstance(name, str) for name in self.arguments):
            expected = 'arguments by name, such as {"faces": [3, 4]}'
            raise ParameterError(f"edit {self.name!r}: got {described(self.arguments)}; expected {expected}")
        values = {name: str(value) if name == ON else value for name, value in self.arguments.items()}
        object.__setattr__(self, "arguments", plain_value(values))


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
    if edit.name not in EDITS:
        near = difflib.get_close_matches(edit.name, EDITS, n=1) or [", ".join(EDITS)]
        raise ParameterError(f"edit {edit.name!r}: is unknown; expected {near[0]}")
    try:
        on_selection = ON in edit.arguments
        return msgspec.structs.asdict(check_value(dict(edit.arguments), arguments_of(edit.name, on_selection)))
    except ParameterError as error:
        raise ParameterError(f"{edit.name}: {error}") from error


@cache
def arguments_of(name: str, on_selection: bool = False) -> type[msgspec.Struct]:
    """Return a class whose fields are the arguments of an edit: the parameters of its function after the first.

    Args:
        name: a key of ``EDITS``.
        on_selection: whether the argument ``on`` takes the place of the face, the faces or the side.

    Raises:
        ParameterError: the edit takes no selection.
    """
    edit = EDITS[name]
    hints = get_type_hints(edit)
    fields: list[Any] = [(ON, str)] if on_selection else []
    replaced = place_argument(name) if on_selection else None
    for parameter in list(inspect.signature(edit).parameters.values())[1:]:
        if parameter.name == replaced:
            continue
        optional = () if parameter.default is parameter.empty else (parameter.default,)
        fields.append((parameter.name, _bounded(hints[parameter.name]), *optional))
    return msgspec.defstruct(name, fields, forbid_unknown_fields=True, kw_only=True)


def _bounded(hint: Any) -> Any:
    """Return the type of an argument with ``int`` replaced by whole numbers that NumPy arrays can hold."""
    if hint is int:
        return WholeNumber
    if get_origin(hint) is Sequence:
        return list[WholeNumber]
    options = get_args(hint)
    return hint if not options else functools.reduce(operator.or_, map(_bounded, options))


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
