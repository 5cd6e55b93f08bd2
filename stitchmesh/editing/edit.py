# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits as data: a name and arguments that JSON can hold, applied to a stitch mesh."""

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
from stitchmesh.editing.pasting import paste_pattern
from stitchmesh.editing.row_edits import flip_row, insert_row, remove_row
from stitchmesh.editing.stitch_marks import change_stitch, stripe, twist_loop
from stitchmesh.editing.wale_columns import remove_wale
from stitchmesh.editing.wale_edges import add_wale_edge, remove_wale_edge, shift_wale_edge
from stitchmesh.editing.wale_lines import insert_wale
from stitchmesh.editing.whole_mesh import graft, spiral, ungraft, unspiral
from stitchmesh.errors import MeshError, ParameterError
from stitchmesh.io.checked import checked
from stitchmesh.mesh import BORDER, TOP, IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.change import Change, Marks, apply_change, inverse_change
from stitchmesh.mesh.stitch import Stitch

EDITS: dict[str, Callable[..., list[Change]]] = {
    edit.__name__: edit
    for edit in (
        change_stitch, twist_loop, stripe,
        cross_cable, set_cable, clear_cable,
        split_course_edge, collapse_course_edge,
        add_wale_edge, remove_wale_edge, shift_wale_edge,
        insert_wale, remove_wale,
        flip_row, insert_row, remove_row,
        bobble, paste_pattern,
        spiral, unspiral, graft, ungraft,
    )
}  # fmt: skip
"""What each edit changes, by its name."""

LARGEST = 2**31 - 1
"""Of the whole numbers in an edit."""
WholeNumber = Annotated[int, msgspec.Meta(ge=-LARGEST, le=LARGEST)]


@dataclass(frozen=True)
class Edit:
    """What is done to a stitch mesh."""

    name: str
    """One of ``EDITS``."""
    arguments: Mapping[str, object] = field(default_factory=dict)
    """Arguments of that function beside the stitch mesh, by name: numbers, texts and lists of numbers."""


@dataclass(frozen=True, eq=False)
class Edited:
    """What an edit has made."""

    fabric: StitchMesh
    changes: tuple[Change, ...]
    """What it changed, in turn."""
    inverse: tuple[Change, ...]
    """What undoes it exactly, in turn."""


def apply_edit(fabric: StitchMesh, edit: Edit) -> Edited:
    """Apply an edit; the stitch mesh given stays as it is.

    Args:
        fabric: stitch faces.
        edit: what to do.

    Raises:
        ParameterError: there is no such edit, an argument is missing, unknown or of another kind, or what it names is
            not there or leaves no room for the edit.
        MeshError: the surface would not be an oriented manifold, or the mesh has no stitches yet or repeats.
        LabelError: a face would not be a legal stitch face, or a cable would be cut.
    """
    panels = np.flatnonzero(fabric.stitch == Stitch.PANEL)
    if len(panels) or fabric.lattice is not None:
        what = "repeats on a lattice" if fabric.lattice is not None else f"has panels (face {panels[0]})"
        raise MeshError(f"edit: the mesh {what}; expected stitches with borders, as `tessellate` makes them")
    arguments = checked_arguments(edit)
    return apply_changes(fabric, EDITS[edit.name](fabric, **arguments))


def apply_changes(fabric: StitchMesh, changes: Sequence[Change]) -> Edited:
    """Apply some changes in turn.

    Raises:
        MeshError: as for ``apply_change``.
        LabelError: likewise, or a cable would be cut.
    """
    inverse: list[Change] = []
    for change in changes:
        inverse.insert(0, inverse_change(fabric, change))
        fabric = apply_change(fabric, change)
    if changes and fabric.cable_shift.any():
        cable_groups(fabric, _loops_touched(fabric, changes[-1]))  # raises where it cuts one
    return Edited(fabric, tuple(changes), tuple(inverse))


def checked_arguments(edit: Edit) -> dict[str, Any]:
    """All arguments of an edit's function, those that are given checked for their names and kinds.

    Raises:
        ParameterError: there is no such edit, or an argument is missing, unknown or of another kind.
    """
    if edit.name not in EDITS:
        near = difflib.get_close_matches(edit.name, EDITS, n=1) or [", ".join(EDITS)]
        raise ParameterError(f"edit {edit.name!r}: is unknown; expected {near[0]}")
    try:
        return msgspec.structs.asdict(checked(dict(edit.arguments), arguments_of(edit.name)))
    except ParameterError as error:
        raise ParameterError(f"{edit.name}: {error}") from error


@cache
def arguments_of(name: str) -> type[msgspec.Struct]:
    """The arguments that an edit takes, as a type: the parameters of its function after the stitch mesh."""
    edit = EDITS[name]
    hints = get_type_hints(edit)
    fields: list[Any] = []
    for parameter in list(inspect.signature(edit).parameters.values())[1:]:
        optional = () if parameter.default is parameter.empty else (parameter.default,)
        fields.append((parameter.name, _bounded(hints[parameter.name]), *optional))
    return msgspec.defstruct(name, fields, forbid_unknown_fields=True, kw_only=True)


def _bounded(hint: Any) -> Any:
    """The type of an argument, with whole numbers that NumPy's can hold."""
    if hint is int:
        return WholeNumber
    if get_origin(hint) is Sequence:
        return list[WholeNumber]
    options = get_args(hint)
    return hint if not options else functools.reduce(operator.or_, map(_bounded, options))


def _loops_touched(fabric: StitchMesh, change: Change) -> IntArray:
    """Top sides of faces that a change put in or marked, and those below them."""
    if isinstance(change, Marks):
        sides = change.places if change.name.startswith("cable") else np.zeros(0, dtype=np.int64)
    else:
        sides = fabric.sides_of(change.added_faces)
    across = fabric.twin[sides]
    sides = np.concatenate([sides, across[across != BORDER]])
    return sides[fabric.side_role[sides] == TOP]
