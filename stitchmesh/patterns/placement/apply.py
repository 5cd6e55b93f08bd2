# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Application of a pattern to a fabric: to the whole fabric, or to the grid of plain stitches around one face.

Source: Yuksel et al. 2012, section 5.3.
"""

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
from stitchmesh.patterns.placement.pattern_colours import colour_on_fabric
from stitchmesh.patterns.placement.placement import Placement, side_below
from stitchmesh.patterns.placement.replace import Replacement, Site, border_sides, find_site
from stitchmesh.patterns.placement.wales import follow_wales


def apply_pattern(
    fabric: StitchMesh, pattern: Pattern, *, face: int | None = None, remainder: Remainder = DEFAULT_REMAINDER
) -> StitchMesh:
    """Replace the stitches of a fabric by those of a pattern.

    On a whole fabric, the columns of the pattern follow the wales and its rows are counted from the first row above the
    cast-on row. Around a face, the pattern fills the largest grid of plain stitches that contains the face, from the
    bottom of the grid. Cast-on rows and the increases and decreases of the fabric keep their loops. The borders of the
    pattern lie at the ends of flat rows.

    If every stitch of the pattern has one loop below and one above, the pattern continues to the last row and over
    shaping; a shaping stitch becomes its knit or purl form. If the pattern has increases and decreases, only whole
    tiles are placed, where plain stitches fill a rectangle of the size of a tile; the loops around each tile stay as
    they were. New faces lie on the old course lines, so the mesh should be relaxed afterwards.

    Args:
        fabric: a mesh of stitches, relaxed or not.
        pattern: the pattern, for example from ``read_pattern``.
        face: a plain stitch of the grid; the pattern covers the whole fabric if no face is given.
        remainder: what happens to the loops of a row that whole tiles do not cover. ``centre`` leaves them unchanged
            on both sides, or at the start of a ring; ``stretch`` stretches the tiles over them, or spreads them
            between the tiles if stitches cannot be doubled; ``refuse`` raises an error.

    Raises:
        ParameterError: the pattern fits nowhere, the face is not a plain stitch, the mesh has panels, or ``remainder``
            is unknown or refuses the loops that are left over.
        PatternError: the pattern has increases or decreases and does not close.
        LabelError: the cables of the fabric are malformed.
        MeshError: the fabric repeats on a lattice.
    """
    for change in pattern_changes(fabric, pattern, face=face, remainder=remainder):
        fabric = apply_change(fabric, change)
    return fabric


def pattern_changes(
    fabric: StitchMesh, pattern: Pattern, *, face: int | None = None, remainder: Remainder = DEFAULT_REMAINDER
) -> list[Change]:
    """Return the changes of ``apply_pattern`` in order; each has an exact inverse (``inverse_change``).

    The arguments are those of ``apply_pattern``.

    Raises:
        ParameterError, PatternError, LabelError, MeshError: as for ``apply_pattern``.
    """
    check_remainder(remainder)
    pattern, colours = colour_on_fabric(pattern, fabric)
    panels = np.flatnonzero(fabric.stitch == Stitch.PANEL)
    if len(panels):
        raise ParameterError(f"face {panels[0]}: is a panel of a coarse mesh, not a stitch; tessellate the mesh first")
    if face is None:
        placement = follow_wales(fabric, pattern, remainder)
    else:
        placement = fill_grid(fabric, pattern, grid_around(fabric, face), remainder)
    if not keeps_counts(pattern):
        return [*colours, *_block_changes(fabric, pattern, placement)]
    if (placement.column == OUTSIDE).all():
        raise ParameterError(
            f"pattern {pattern.name!r}: its {pattern.width} columns are more than any first row of the fabric has; "
            "use narrower stitches or another pattern"
        )
    return [*colours, *changes_in_place(fabric, pattern, placement)]


def changed_face_count(changes: list[Change]) -> int:
    """Return the number of faces that the changes of a pattern add, or whose stitch or yarn they change."""
    added = sum(len(change.added_faces) for change in changes if isinstance(change, Patch))
    marked = [change.places for change in changes if isinstance(change, Marks) and change.name in ("stitch", "yarn")]
    return added + (len(np.unique(np.concatenate(marked))) if marked else 0)


def _block_changes(fabric: StitchMesh, pattern: Pattern, placement: Placement) -> list[Change]:
    """Return the removal of cables that the blocks cut, then the new faces, then the marks of the loops below."""
    check_closes(pattern)
    blocks = {section: block for section in range(len(SECTIONS)) if (block := block_of(pattern, section))}
    sites = [find_site(fabric, placement, section, block) for section, block in blocks.items()]
    sites = [site for site in sites if len(site.grids)]
    if not any(site.section == TILE for site in sites):
        needed = f"needs {pattern.height} rows of {pattern.width} adjacent plain stitches"
        raise ParameterError(f"pattern {pattern.name!r}: {needed}; found none, use another pattern or face")
    changes, cleared = _remove_cut_cables(fabric, sites)
    replacement = Replacement(cleared, pattern, sites)
    patch = replacement.patch()
    return [*changes, patch, *replacement.marks(patch)]


def _remove_cut_cables(fabric: StitchMesh, sites: list[Site]) -> tuple[list[Change], StitchMesh]:
    """Remove the marks of cables that the blocks would cut; return these changes and the fabric without the cables."""
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
