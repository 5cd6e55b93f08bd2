# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A pattern on a fabric: on all of it, or on the grid of plain stitches around one face (section 5.3)."""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import Change, Marks, Patch, apply_change
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns.pattern import SECTIONS, Pattern, check_closes
from stitchmesh.patterns.placement.block import block_of
from stitchmesh.patterns.placement.columns import (
    DEFAULT_REMAINDER,
    OUTSIDE,
    TILE,
    Remainder,
    check_remainder,
    keeps_counts,
)
from stitchmesh.patterns.placement.crossing_marks import CrossingMarks
from stitchmesh.patterns.placement.grid import fill_grid, grid_around
from stitchmesh.patterns.placement.in_place import changed, changes_in_place
from stitchmesh.patterns.placement.placement import Placement, side_below
from stitchmesh.patterns.placement.replace import Replacement, Site, border_sides, find_site
from stitchmesh.patterns.placement.wales import follow_wales


def apply_pattern(
    fabric: StitchMesh, pattern: Pattern, *, face: int | None = None, remainder: Remainder = DEFAULT_REMAINDER
) -> StitchMesh:
    """Knit a fabric in a pattern.

    On a whole fabric columns follow the wales and rows count from the first above the cast-on row. Around a face it
    is the largest grid of plain stitches, from its bottom. Cast-on rows and the fabric's own increases and decreases
    keep their loops. Borders of the pattern stand at the ends of flat rows.

    A pattern whose stitches all take one loop and make one goes on to the last row, and over shaping, which becomes
    knit or purl. Of one that makes and takes loops together only whole tiles are put in, where as many plain stitches
    lie in rows; the counts around each stay as they were. New faces lie on the old course lines; relax the mesh
    afterwards.

    Args:
        fabric: stitch faces, relaxed or not.
        pattern: what ``read_pattern`` returned.
        face: a plain stitch of the grid; the whole fabric where not given.
        remainder: for loops that whole tiles leave over: ``centre`` leaves them on both sides as they are, in a ring
            at its start; ``stretch`` draws the tiles out over them, or where stitches cannot be doubled spreads them
            between tiles; ``refuse`` raises.

    Raises:
        ParameterError: the pattern fits nowhere, the face is no plain stitch, or as ``remainder``.
        PatternError: the pattern changes counts and does not close.
        LabelError: the cables of the fabric are malformed.
        MeshError: the fabric repeats on a lattice.
    """
    for change in pattern_changes(fabric, pattern, face=face, remainder=remainder):
        fabric = apply_change(fabric, change)
    return fabric


def pattern_changes(
    fabric: StitchMesh, pattern: Pattern, *, face: int | None = None, remainder: Remainder = DEFAULT_REMAINDER
) -> list[Change]:
    """What ``apply_pattern`` changes, one after the other, each with an exact inverse (``inverse_change``).

    Raises:
        ParameterError, PatternError, LabelError, MeshError: as for ``apply_pattern``.
    """
    check_remainder(remainder)
    panels = np.flatnonzero(fabric.stitch == Stitch.PANEL)
    if len(panels):
        raise ParameterError(f"face {panels[0]}: is a panel of a coarse mesh, not a stitch; tessellate the mesh first")
    if face is None:
        placement = follow_wales(fabric, pattern, remainder)
    else:
        placement = fill_grid(fabric, pattern, grid_around(fabric, face), remainder)
    if not keeps_counts(pattern):
        return _changes_of_faces(fabric, pattern, placement)
    if (placement.column == OUTSIDE).all():
        raise ParameterError(
            f"pattern {pattern.name!r}: its {pattern.width} columns are more than any first row of the fabric has; "
            "use narrower stitches or another pattern"
        )
    return [*changes_in_place(fabric, pattern, placement)]


def changed_face_count(changes: list[Change]) -> int:
    """How many faces a pattern's changes put in or make another stitch or colour."""
    added = sum(len(change.added_faces) for change in changes if isinstance(change, Patch))
    marked = [change.places for change in changes if isinstance(change, Marks) and change.name in ("stitch", "yarn")]
    return added + (len(np.unique(np.concatenate(marked))) if marked else 0)


def _changes_of_faces(fabric: StitchMesh, pattern: Pattern, placement: Placement) -> list[Change]:
    """Blocks of new faces; before them the cables taken away that they cut, after them the marks below them."""
    check_closes(pattern)
    blocks = {section: block for section in range(len(SECTIONS)) if (block := block_of(pattern, section))}
    sites = [find_site(fabric, placement, section, block) for section, block in blocks.items()]
    sites = [site for site in sites if len(site.grids)]
    if not any(site.section == TILE for site in sites):
        needed = f"needs {pattern.height} rows of {pattern.width} plain stitches together"
        raise ParameterError(f"pattern {pattern.name!r}: {needed}; found none, use another pattern or face")
    changes, cleared = _uncrossed(fabric, sites)
    replacement = Replacement(cleared, pattern, sites)
    patch = replacement.patch()
    return [*changes, patch, *replacement.marks(patch)]


def _uncrossed(fabric: StitchMesh, sites: list[Site]) -> tuple[list[Change], StitchMesh]:
    """The marks of cables taken away that blocks would cut, and the fabric without them."""
    inside = np.concatenate([fabric.face_start[site.grids].ravel() + 2 for site in sites])
    below = np.concatenate([side_below(fabric, site.grids[:, 0]).ravel() for site in sites])
    top = np.concatenate([border_sides(fabric, site.grids)[2].ravel() for site in sites])
    crossing = CrossingMarks(fabric)
    crossing.clear(np.concatenate([np.setdiff1d(inside, top), below[below >= 0]]))
    changes: list[Change] = []
    for name, values in (("cable_shift", crossing.shift), ("cable_layer", crossing.layer)):
        marks = changed(fabric, name, values)
        if len(marks.places):
            changes.append(marks)
            fabric = apply_change(fabric, marks)
    return changes, fabric
