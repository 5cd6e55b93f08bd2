# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits of a stitch mesh as functions, such as ``sm.edits.stripe(fabric, yarn=1, rows=[3])``.

Each function takes a tessellated stitch mesh and the arguments of the edit by name. It returns an ``Edited``: the new
stitch mesh, the changes that made it, and the changes that undo them. The argument ``on`` takes a selection, such as
``hem 6``, instead of a face, faces or a side; the edit is then made at each place that the selection names. The
functions raise the errors of ``apply_edit``. Logs, recipes and jobs hold an edit as its name and its arguments
(``Edit``).
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any

from stitchmesh.editing import (
    bobble as bobbles,
)
from stitchmesh.editing import (
    cable_marks,
    course_edges,
    pasting,
    row_edits,
    stitch_marks,
    wale_columns,
    wale_edges,
    wale_lines,
    whole_mesh,
)
from stitchmesh.editing import (
    short_rows as shortened,
)
from stitchmesh.editing.edit import Edit, Edited, apply_edit
from stitchmesh.editing.on_selection import ON
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import Change
from stitchmesh.selection import Selection


def _function(changes: Callable[..., list[Change]]) -> Callable[..., Edited]:
    """Return the function that makes an edit, from the function that says which changes the edit makes."""

    @functools.wraps(changes)
    def edit(fabric: StitchMesh, *, on: str | Selection | None = None, **arguments: Any) -> Edited:
        place = {} if on is None else {ON: on}
        return apply_edit(fabric, Edit(changes.__name__, arguments | place))

    given = inspect.signature(changes)
    fabric, *others = given.parameters.values()
    named = [argument.replace(kind=inspect.Parameter.KEYWORD_ONLY) for argument in others]
    on = inspect.Parameter(ON, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=str | Selection | None)
    signature = given.replace(parameters=[fabric, *named, on], return_annotation=Edited)
    edit.__signature__ = signature  # type: ignore[attr-defined]
    return edit


change_stitch = _function(stitch_marks.change_stitch)
twist_loop = _function(stitch_marks.twist_loop)
stripe = _function(stitch_marks.stripe)
stripes = _function(stitch_marks.stripes)
recolour = _function(stitch_marks.recolour)
cross_cable = _function(cable_marks.cross_cable)
set_cable = _function(cable_marks.set_cable)
clear_cable = _function(cable_marks.clear_cable)
split_course_edge = _function(course_edges.split_course_edge)
collapse_course_edge = _function(course_edges.collapse_course_edge)
add_wale_edge = _function(wale_edges.add_wale_edge)
remove_wale_edge = _function(wale_edges.remove_wale_edge)
shift_wale_edge = _function(wale_edges.shift_wale_edge)
insert_wale = _function(wale_lines.insert_wale)
remove_wale = _function(wale_columns.remove_wale)
flip_row = _function(row_edits.flip_row)
insert_row = _function(row_edits.insert_row)
remove_row = _function(row_edits.remove_row)
short_rows = _function(shortened.short_rows)
bobble = _function(bobbles.bobble)
paste_pattern = _function(pasting.paste_pattern)
spiral = _function(whole_mesh.spiral)
unspiral = _function(whole_mesh.unspiral)
graft = _function(whole_mesh.graft)
ungraft = _function(whole_mesh.ungraft)
