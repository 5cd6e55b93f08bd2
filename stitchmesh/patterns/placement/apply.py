# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Application of a pattern to a fabric: to the whole fabric, to a region, or to the plain stitches around one face.

Source: Yuksel et al. 2012, section 5.3.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.change import Change, Marks, OwnStitchesChange, apply_change
from stitchmesh.mesh.courses import course_through
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
from stitchmesh.patterns.placement.in_place import CellTable, changes_in_place
from stitchmesh.patterns.placement.left_out import LeftOut, find_left_out
from stitchmesh.patterns.placement.loop_marks import LoopMarks
from stitchmesh.patterns.placement.pattern_colours import colour_on_fabric, ground_of
from stitchmesh.patterns.placement.placement import Placement, is_plain, is_worked, region_of
from stitchmesh.patterns.placement.plain_ground import plain_ground
from stitchmesh.patterns.placement.rebuilt_runs import Rebuilt
from stitchmesh.patterns.placement.replace import Replacement
from stitchmesh.patterns.placement.units import CellNumbers, find_sites, units_of
from stitchmesh.patterns.placement.wales import follow_wales

_LEFT_OVER, _CUT, _UNCROSSED = range(3)
REASONS = [
    "these loops are left over beside whole repeats of the pattern and keep their stitches",
    "shaping or the end of a row cuts the repeat, and these stitches are knit or purled",
    "a loop of the cable is missing beside shaping or at the end of a row, and the cable does not cross",
]
"""The reasons why faces may be left out."""


@dataclass(frozen=True, eq=False)
class LaidPattern:
    """A fabric with a pattern, and the list of stitches that could not take it."""

    fabric: StitchMesh
    """The fabric with the pattern."""
    changes: tuple[Change, ...]
    """Changes that make this fabric from the given one, in order; each has an exact inverse (``inverse_change``)."""
    faces_laid: int
    """Number of faces that have the pattern."""
    reason: IntArray
    """Index in ``REASONS`` of the reason why each face is left out, -1 for all other faces, shape (F,)."""

    @cached_property
    def breaks_rounds(self) -> bool:
        """Whether stitches of a round remain outside the whole repeats of the pattern."""
        beside = np.flatnonzero(self.reason == _LEFT_OVER).tolist()
        return any(course_through(self.fabric, face).closed for face in beside)

    @cached_property
    def left_out(self) -> tuple[LeftOut, ...]:
        """Faces that are not in the pattern although they belong to the region, largest groups first.

        Cast-on rows and drawn-through loops are not listed, because no pattern changes them.
        """
        return find_left_out(self.fabric, self.reason, REASONS)


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
    return _Laying(fabric, chosen, placement, inside).laid(changes, ground_yarn)


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


class _Laying:
    """The changes that lay a placed pattern, and the faces that they leave out."""

    def __init__(self, fabric: StitchMesh, pattern: Pattern, placement: Placement, inside: NDArray[np.bool_]) -> None:
        self.fabric, self.pattern, self.placement, self.inside = fabric, pattern, placement, inside
        self.cells = CellNumbers(pattern, placement)
        units = units_of(pattern)
        self.table = CellTable(fabric, pattern, units, self.cells)
        self.sites, self.in_site = find_sites(fabric, placement, self.cells, units.larger)

    def laid(self, before: list[Change], ground: int) -> LaidPattern:
        """Apply the changes: first the stitches of faces that stay, then the new faces, then the marks of loops.

        Args:
            before: the changes that have made the fabric.
            ground: number of the yarn for stitches left over.
        """
        fabric = self.fabric
        loops = LoopMarks(fabric, self.pattern, self.placement, self.cells, self.sites)
        crossings, uncrossed = loops.crossings()
        marks = {"twist": loops.twist(self.table), "cable_shift": crossings.shift, "cable_layer": crossings.layer}
        changes: list[Change] = [*changes_in_place(fabric, self.pattern, self.cells.of_face, self.table, ~self.in_site)]
        reason = self._reasons(uncrossed)
        if self.pattern.yarn_count > 1:
            left_over = np.flatnonzero((reason == _LEFT_OVER) & (fabric.yarn != ground))
            changes += [Marks("yarn", left_over, np.full(len(left_over), ground))] if len(left_over) else []
        after = fabric
        for change in changes:
            after = apply_change(after, change)
        laid = int((self.inside & (self.cells.of_face != BORDER) & (reason < 0) & ~self.in_site).sum())
        side_after = np.arange(fabric.side_count)
        if self.sites:
            replacement = Replacement(after, self.pattern, self.sites)
            patch = replacement.patch()
            changes.append(patch)
            after = apply_change(after, patch)
            side_after = replacement.sides_after(patch)
            kept = np.flatnonzero(reason >= 0)
            moved = np.full(after.face_count, -1)
            moved[replacement.face.after[kept]] = reason[kept]
            reason = moved
            laid += len(patch.added_faces)
        for name, values in marks.items():
            mark = _mark_after(after, name, values, side_after)
            if len(mark.places):
                changes.append(mark)
                after = apply_change(after, mark)
        return LaidPattern(after, (*before, *changes), laid, reason)

    def _reasons(self, uncrossed: IntArray) -> IntArray:
        """Return the index of the reason why each face is left out, -1 for the other faces, shape (F,)."""
        cells, fabric = self.cells.of_face, self.fabric
        reason = np.full(fabric.face_count, -1)
        reason[self.inside & is_worked(fabric) & (cells == BORDER)] = _LEFT_OVER
        plain = np.flatnonzero(is_plain(fabric) & (cells != BORDER) & ~self.in_site)
        reason[plain[~self.table.is_single[cells[plain]]]] = _CUT
        reason[uncrossed[~self.in_site[uncrossed]]] = _UNCROSSED
        return reason


def _mark_after(fabric: StitchMesh, name: str, values: IntArray, side_after: IntArray) -> Marks:
    """Return the marks that give sides new values, where these differ from the values of the fabric.

    Args:
        fabric: the fabric in which the marks change.
        name: name of the mark.
        values: value of each side before the faces were replaced.
        side_after: number of each of these sides in ``fabric``, ``BORDER`` if the side is gone.
    """
    there = np.flatnonzero(side_after != BORDER)
    there = there[values[there] != getattr(fabric, name)[side_after[there]]]
    order = np.argsort(side_after[there])
    return Marks(name, side_after[there][order], values[there][order])
