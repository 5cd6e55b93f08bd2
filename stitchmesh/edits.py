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

from stitchmesh.editing.edit import EDITS, Edit, Edited, apply_edit
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


change_stitch = _function(EDITS["change_stitch"])
twist_loop = _function(EDITS["twist_loop"])
stripe = _function(EDITS["stripe"])
stripes = _function(EDITS["stripes"])
recolour = _function(EDITS["recolour"])
cross_cable = _function(EDITS["cross_cable"])
set_cable = _function(EDITS["set_cable"])
clear_cable = _function(EDITS["clear_cable"])
split_course_edge = _function(EDITS["split_course_edge"])
collapse_course_edge = _function(EDITS["collapse_course_edge"])
add_wale_edge = _function(EDITS["add_wale_edge"])
remove_wale_edge = _function(EDITS["remove_wale_edge"])
shift_wale_edge = _function(EDITS["shift_wale_edge"])
insert_wale = _function(EDITS["insert_wale"])
remove_wale = _function(EDITS["remove_wale"])
flip_row = _function(EDITS["flip_row"])
insert_row = _function(EDITS["insert_row"])
remove_row = _function(EDITS["remove_row"])
short_rows = _function(EDITS["short_rows"])
bobble = _function(EDITS["bobble"])
paste_pattern = _function(EDITS["paste_pattern"])
spiral = _function(EDITS["spiral"])
unspiral = _function(EDITS["unspiral"])
graft = _function(EDITS["graft"])
ungraft = _function(EDITS["ungraft"])
