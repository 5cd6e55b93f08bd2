# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Application of a pattern to a fabric: to the whole fabric, to a region, or to the plain stitches around one face.

Source: Yuksel et al. 2012, section 5.3.

A pattern without colours only numbers its yarns, and the fabric has the same numbers. A pattern with colours, such as a
chart from an image, keeps them. A fabric of one yarn without a palette takes the ground of the pattern as its yarn 0.
On any other fabric the yarns of the pattern take the numbers of the equal colours there, and the other colours are
added to the fabric.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import Change, OwnStitchesChange, PaletteChange, apply_change
from stitchmesh.mesh.palette import colour_text, filled_palette, parse_colour
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns.library import read_pattern
from stitchmesh.patterns.pattern import Pattern, check_closes
from stitchmesh.patterns.placement.columns import (
    DEFAULT_REMAINDER,
    OUTSIDE,
    Remainder,
    check_remainder,
    keeps_counts,
)
from stitchmesh.patterns.placement.grid import fill_grid, grid_around
from stitchmesh.patterns.placement.laying import LaidPattern, lay_placed
from stitchmesh.patterns.placement.placement import is_worked, region_of
from stitchmesh.patterns.placement.plain_ground import plain_ground
from stitchmesh.patterns.placement.rebuilt_runs import Rebuilt
from stitchmesh.patterns.placement.wales import follow_wales


def apply_pattern(
    fabric: StitchMesh,
    pattern: Pattern | FilePath,
    *,
    face: int | None = None,
    faces: Iterable[int] | None = None,
    remainder: Remainder = DEFAULT_REMAINDER,
    ground: str | None = None,
    centre: bool = False,
) -> StitchMesh:
    """Replace the stitches of a fabric by the stitches of a pattern, and return the new fabric; see ``lay_pattern``.

    Args:
        fabric: a mesh of stitches, relaxed or not.
        pattern: the pattern, its name in the library or the path of its file.
        face: a plain stitch of the grid to fill.
        faces: numbers of the faces of a region, in any order; without ``face`` and ``faces`` the whole fabric.
        remainder: what happens to the loops of a row that whole tiles do not cover (see ``lay_pattern``).
        ground: colour of the pattern, or number of one of its yarns, for the stitches left over.
        centre: whether the middle of a tile lies in the middle of each first row.

    Raises:
        ParameterError, FileError, PatternError, LabelError, MeshError: an error of ``lay_pattern``.
    """
    laid = lay_pattern(
        fabric, pattern, face=face, faces=faces, remainder=remainder, ground=ground, centre=centre
    )
    return laid.fabric


def lay_pattern(
    fabric: StitchMesh,
    pattern: Pattern | FilePath,
    *,
    face: int | None = None,
    faces: Iterable[int] | None = None,
    remainder: Remainder = DEFAULT_REMAINDER,
    ground: str | None = None,
    centre: bool = False,
) -> LaidPattern:
    """Replace the stitches of a fabric by the stitches of a pattern, and report the faces that keep theirs.

    On a whole fabric or a region, the columns of the pattern follow the wales and its rows are counted from the first
    row above the cast-on row, or from the lowest row of the region. Around a face, the pattern fills the largest grid
    of plain stitches that contains the face, from the bottom of the grid. Cast-on rows and the increases and decreases
    of the fabric keep their loops; an increase or a decrease becomes its knit or purl form. The borders of the pattern
    lie at the ends of flat rows.

    The pattern continues to the last row. Shaping or the end of a row can cut a repeat. The pattern then lays the parts
    of the repeat that make as many loops as they take, such as a yarn-over with its decrease, and knits or purls the
    other stitches. A cable crosses if all its loops are there. New faces lie on the old course lines, so the mesh
    should be relaxed afterwards.

    Args:
        fabric: a mesh of stitches, relaxed or not.
        pattern: the pattern, its name in the library or the path of its file.
        face: a plain stitch of the grid.
        faces: numbers of the faces of a region, in any order; without ``face`` and ``faces`` the whole fabric.
        remainder: what happens to the loops of a row that whole tiles do not cover. ``centre`` leaves them unchanged
            on both sides, or at the start of a ring; ``stretch`` stretches the tiles over them, or spreads them
            between the tiles if stitches cannot be doubled; ``refuse`` raises an error.
        ground: colour of the pattern, or number of one of its yarns, for the stitches left over; by default the yarn of
            most of its stitches. A pattern of one yarn leaves the yarns of the fabric as they are.
        centre: whether the middle of a tile lies in the middle of each first row. In a ring this is the middle of its
            front, so that loops left over lie behind.

    Raises:
        ParameterError: the pattern fits nowhere, is not in the library or has no yarn of the colour ``ground``; the
            face is not a plain stitch; the region is empty or holds a face that does not exist; both ``face`` and
            ``faces`` are given; the mesh has panels; or ``remainder`` is unknown or refuses the loops left over.
        FileError: the file of the pattern cannot be read.
        PatternError: the file does not describe a valid pattern, or the pattern has increases or decreases and does not
            close.
        LabelError: the cables of the fabric are malformed.
        MeshError: the fabric repeats on a lattice.
    """
    chosen = _pattern_of(pattern)
    check_remainder(remainder)
    _check_fabric(fabric)
    if not keeps_counts(chosen):
        check_closes(chosen)
    if face is not None and faces is not None:
        raise ParameterError("got a face and a region; expected one of them")
    inside = region_of(fabric, faces)
    chosen, ground_yarn, colours = colour_on_fabric(chosen, fabric, ground_of(chosen, ground))
    changes: list[Change] = [*_new_stitches(fabric, chosen), *colours]
    for change in changes:
        fabric = apply_change(fabric, change)
    if face is None:
        fabric, inside = _rebuilt(fabric, inside, plain_ground(fabric, inside), changes)
        placement, moved = follow_wales(fabric, chosen, remainder, inside, centre=centre)
        if moved:
            fabric, inside = _rebuilt(fabric, inside, moved, changes)
            placement, _ = follow_wales(fabric, chosen, remainder, inside, centre=centre)
    else:
        grid = grid_around(fabric, face)
        placement = fill_grid(fabric, chosen, grid, remainder, centre=centre)
        inside = np.zeros(fabric.face_count, dtype=bool)
        inside[grid.faces] = True
    where = "fabric" if faces is None else "region"
    if not (inside & is_worked(fabric)).any():
        raise ParameterError(f"{where}: got cast-on rows and drawn-through loops only; expected stitches of other rows")
    if (placement.column == OUTSIDE).all():
        raise ParameterError(
            f"pattern {chosen.name!r}: its {chosen.width} columns are more than any first row of the {where} has; "
            f"use narrower stitches{', a wider region' if faces is not None else ''} or another pattern"
        )
    return lay_placed(fabric, chosen, placement, inside, changes, ground_yarn)


def _new_stitches(fabric: StitchMesh, pattern: Pattern) -> list[Change]:
    """Return the change that adds the user's own stitches of the pattern to the own stitches of the fabric."""
    new = tuple(stitch for stitch in pattern.own_stitches if stitch not in fabric.own_stitches)
    return [OwnStitchesChange((*fabric.own_stitches, *new))] if new else []


def _rebuilt(
    fabric: StitchMesh, inside: NDArray[np.bool_], rebuilt: Rebuilt | None, changes: list[Change]
) -> tuple[StitchMesh, NDArray[np.bool_]]:
    """Apply a patch, add it to the changes, and return the fabric and its region after the patch."""
    if rebuilt is None:
        return fabric, inside
    changes.append(rebuilt.patch)
    new = np.ones(len(rebuilt.patch.added_faces), dtype=bool)
    return apply_change(fabric, rebuilt.patch), rebuilt.faces.merged(inside, new)


def _pattern_of(pattern: object) -> Pattern:
    if isinstance(pattern, Pattern):
        return pattern
    if isinstance(pattern, (str, PathLike)):
        return read_pattern(pattern)
    found = f"got {type(pattern).__name__}"
    raise ParameterError(f"pattern: {found}; expected a Pattern, a name of the library or the path of a file")


def _check_fabric(fabric: object) -> None:
    if not isinstance(fabric, StitchMesh):
        raise ParameterError(f"fabric: got {type(fabric).__name__}; expected a StitchMesh, the result of tessellate")
    panels = np.flatnonzero(fabric.stitch == Stitch.PANEL)
    if len(panels):
        raise ParameterError(f"face {panels[0]}: is a panel of a coarse mesh, not a stitch; tessellate the mesh first")


def ground_of(pattern: Pattern, named: str | None) -> int:
    """Return the number of the yarn of the ground of a pattern.

    Args:
        pattern: the pattern.
        named: a colour of the pattern (``parse_colour``), or the number of one of its yarns; for None, the yarn of most
            stitches (``Pattern.ground``).

    Raises:
        ParameterError: the text is no colour, or the pattern has no such colour or yarn.
    """
    if named is None:
        return pattern.ground
    yarns = sorted({cell.yarn for row in pattern.rows for cell in row.cells})
    colours = [colour_text(colour) for colour in pattern.palette]
    wanted = int(named) if named.isdecimal() else None
    if wanted is None and (colour := colour_text(parse_colour(named))) in colours:
        wanted = colours.index(colour)
    if wanted not in yarns:
        known = ", ".join(colours[yarn] if yarn < len(colours) else str(yarn) for yarn in yarns)
        raise ParameterError(f"ground {named!r}: is no yarn of pattern {pattern.name!r}; expected one of {known}")
    return wanted


def colour_on_fabric(pattern: Pattern, fabric: StitchMesh, ground: int) -> tuple[Pattern, int, list[PaletteChange]]:
    """Bring the colours of a pattern onto a fabric.

    Args:
        pattern: the pattern.
        fabric: the fabric.
        ground: the pattern's number of the yarn of its ground.

    Returns:
        The pattern in the yarn numbers of the fabric, the number of its ground there, and the change of the palette of
        the fabric, if there is one.
    """
    if not pattern.palette:
        return pattern, ground, []
    if len(fabric.palette) or fabric.yarn.any():
        colours = [tuple(colour) for colour in filled_palette(fabric.palette, int(fabric.yarn.max()) + 1).tolist()]
    else:
        colours = [pattern.palette[ground]]
    colours += [colour for colour in dict.fromkeys(pattern.palette) if colour not in colours]
    number = {yarn: colours.index(colour) for yarn, colour in enumerate(pattern.palette)}
    rows = tuple(
        replace(row, cells=tuple(replace(cell, yarn=number.get(cell.yarn, cell.yarn)) for cell in row.cells))
        for row in pattern.rows
    )
    changes = [PaletteChange(np.array(colours, dtype=np.uint8))] if len(colours) > len(fabric.palette) else []
    return replace(pattern, rows=rows, palette=()), number.get(ground, ground), changes
