# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The changes that lay a placed pattern on a fabric, and the faces that they leave out.

Faces on which a unit of the pattern fits are replaced. A shaping stitch of the garment keeps its loops and takes its
knit or purl form, according to the pattern at that place. A plain stitch of an incomplete unit is knit or purled as the
pattern is there.

Both the stitch that makes a loop and the stitch that works it can twist it (``held_twist``). A stitch outside the
pattern keeps its part of the half turn. The row above decides about crossings: old crossings below a stitch of the
pattern are removed as a whole, and a crossing of the pattern is added if all its loops lie side by side on one course
line and adjacent plain stitches work them. Otherwise the stitches are worked without the crossing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, LEFT, RIGHT, TOP, IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.change import Change, Marks, apply_change
from stitchmesh.mesh.courses import course_through, right_neighbours, sides_across
from stitchmesh.mesh.stitch import VOCABULARY, Stitch, turned_over
from stitchmesh.patterns.pattern import SECTIONS, Cell, Pattern, crossings
from stitchmesh.patterns.placement.columns import OUTSIDE, columns_of
from stitchmesh.patterns.placement.left_out import LeftOut, find_left_out
from stitchmesh.patterns.placement.placement import Placement, held_twist, is_plain, is_worked, side_below
from stitchmesh.patterns.placement.replace import Replacement, border_sides, flat_places
from stitchmesh.patterns.placement.units import CellNumbers, Units, find_sites, units_of

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


def lay_placed(
    fabric: StitchMesh, pattern: Pattern, placement: Placement, inside: NDArray[np.bool_], before: list[Change],
    ground: int,
) -> LaidPattern:  # fmt: skip
    """Apply the changes: first the stitches of faces that stay, then the new faces, then the marks of loops.

    Args:
        fabric: the fabric.
        pattern: the pattern, in the yarn numbers of the fabric.
        placement: the pattern's row and column of each face.
        inside: whether each face belongs to the region, shape (F,).
        before: the changes that have made the fabric.
        ground: number of the yarn for stitches left over.
    """
    laying = _Laying(fabric, pattern, placement, inside)
    shift, layer, uncrossed = laying.crossings()
    marks = {"twist": laying.twist(), "cable_shift": shift, "cable_layer": layer}
    changes: list[Change] = [*laying.changes_in_place()]
    reason = laying.reasons(uncrossed)
    if pattern.yarn_count > 1:
        left_over = np.flatnonzero((reason == _LEFT_OVER) & (fabric.yarn != ground))
        changes += [Marks("yarn", left_over, np.full(len(left_over), ground))] if len(left_over) else []
    after = fabric
    for change in changes:
        after = apply_change(after, change)
    laid = int((inside & (laying.cells.of_face != BORDER) & (reason < 0) & ~laying.in_site).sum())
    side_after = np.arange(fabric.side_count)
    if laying.sites:
        replacement = Replacement(after, pattern, laying.sites)
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


class _Laying:
    """A placed pattern: its units, and what its stitches do with the faces and the loops of the fabric."""

    def __init__(self, fabric: StitchMesh, pattern: Pattern, placement: Placement, inside: NDArray[np.bool_]) -> None:
        """Find the sites of the units, and the plain faces whose loops below are worked as the pattern says."""
        self.fabric, self.pattern, self.placement, self.inside = fabric, pattern, placement, inside
        self.cells = CellNumbers(pattern, placement)
        units = units_of(pattern)
        self.table = _CellTable(fabric, pattern, units, self.cells)
        self.sites, self.in_site = find_sites(fabric, placement, self.cells, units.larger)
        self.works = is_plain(fabric) & (self.cells.of_face != BORDER)
        self.kept = self.works & ~self.in_site
        for site in self.sites:
            self.works[site.grids[:, 1:]] = False

    def changes_in_place(self) -> list[Marks]:
        """Return the changes of stitches and yarns of the faces that keep their loops.

        If the pattern has only one yarn, every face keeps its own yarn.
        """
        fabric, cells = self.fabric, self.cells.of_face
        faces = np.flatnonzero((cells != BORDER) & ~self.in_site)
        wanted = self.table.stitch[cells[faces]]
        own, built_in = fabric.stitch[faces], fabric.built_in[faces]
        stitch, yarn = fabric.stitch.copy(), fabric.yarn.copy()
        shaped = np.where(wanted == Stitch.PURL, _AS_PURL[built_in], _AS_KNIT[built_in])
        shaped = np.where(own == built_in, shaped, own)
        stitch[faces] = np.where(is_plain(fabric)[faces], wanted, shaped)
        if self.pattern.yarn_count > 1:
            yarn[faces] = self.table.yarn[cells[faces]]
        places = [(name, np.flatnonzero(values != getattr(fabric, name)), values)
                  for name, values in (("stitch", stitch), ("yarn", yarn))]  # fmt: skip
        return [Marks(name, changed, values[changed]) for name, changed, values in places if len(changed)]

    def reasons(self, uncrossed: IntArray) -> IntArray:
        """Return the index of the reason why each face is left out, -1 for the other faces, shape (F,)."""
        cells, fabric = self.cells.of_face, self.fabric
        reason = np.full(fabric.face_count, -1)
        reason[self.inside & is_worked(fabric) & (cells == BORDER)] = _LEFT_OVER
        plain = np.flatnonzero(self.kept)
        reason[plain[~self.table.is_single[cells[plain]]]] = _CUT
        reason[uncrossed[~self.in_site[uncrossed]]] = _UNCROSSED
        return reason

    def twist(self) -> IntArray:
        """Return the twist of each side before the faces are replaced, shape (C,): of its maker and of its worker."""
        fabric, cells = self.fabric, self.cells.of_face
        held = held_twist(fabric)
        made = fabric.twist - held
        new, worked = np.zeros(fabric.side_count, dtype=bool), np.zeros(fabric.side_count, dtype=bool)
        kept = np.flatnonzero(self.kept)
        tops = fabric.face_start[kept] + 2
        made[tops], new[tops] = self.table.made[cells[kept]], True
        in_unit = np.zeros(fabric.face_count, dtype=bool)
        in_unit[kept] = self.table.is_single[cells[kept]]
        for site in self.sites:
            tops = border_sides(fabric, site.grids)[TOP]
            made[tops], new[tops] = site.block.twist[flat_places(site.block, TOP)], True
            in_unit[site.grids[:, 0]] = True
        workers = np.flatnonzero(self.works)
        below = side_below(fabric, workers)
        there = below != BORDER
        given = np.where(in_unit[workers], self._held()[cells[workers]], 0)
        held[below[there]], worked[below[there]] = given[there], True
        # A loop has one half turn at most, and the stitch of the pattern decides it.
        made[worked & ~new & (held != 0)] = 0
        held[new & ~worked & (made != 0)] = 0
        return made + held

    def _held(self) -> IntArray:
        """Return the half turn that the stitch of each cell gives to the loop below it, by the number of the cell."""
        pattern = self.pattern
        held = np.zeros(pattern.height * sum(pattern.rows[0].bottoms), dtype=np.int64)
        for number, row in enumerate(pattern.rows):
            for section in range(len(SECTIONS)):
                if row.bottoms[section] == pattern.rows[0].bottoms[section]:
                    for column, loop in enumerate(row.loop_sections[section]):
                        held[self.cells.number(section, number, column)] = loop.twist
        return held

    def crossings(self) -> tuple[IntArray, IntArray, IntArray]:
        """Return the cable shifts and layers of all sides, and the faces above incomplete crossings."""
        fabric = self.fabric
        below = side_below(fabric, np.flatnonzero(self.works))
        inner = [fabric.face_start[site.grids[:, :-1]].ravel() + 2 for site in self.sites]
        cleared = np.zeros(fabric.side_count, dtype=bool)
        cleared[np.concatenate([below[below != BORDER], *inner])] = True
        for group in cable_groups(fabric):
            cleared[group.sides] |= cleared[group.sides].any()
        shift, layer = (np.where(cleared, 0, marks) for marks in (fabric.cable_shift, fabric.cable_layer))
        right = right_neighbours(fabric)
        missed = [np.zeros(0, dtype=np.int64)]
        for number, row in enumerate(self.pattern.rows):
            for section, held in enumerate(row.loop_sections):
                if row.bottoms[section] != self.pattern.rows[0].bottoms[section]:
                    continue
                for cable in crossings(held):
                    runs, cut = self._runs(right, number, section, cable)
                    sides = side_below(fabric, runs)
                    crossed = _lie_side_by_side(fabric, runs, sides)
                    for place, loop in enumerate(held[cable.start : cable.stop]):
                        shift[sides[crossed, place]], layer[sides[crossed, place]] = loop.shift, loop.layer
                    missed += [cut, runs[~crossed].ravel()]
        return shift, layer, np.unique(np.concatenate(missed))

    def _runs(self, right: IntArray, number: int, section: int, cable: range) -> tuple[IntArray, IntArray]:
        """Return the runs of faces above a crossing, shape (n, loops), and the faces there that are in no whole run."""
        width = max(self.pattern.rows[0].bottoms[section], 1)
        columns = columns_of(section, self.placement.column)
        here = self.works & (self.placement.row == number) & (columns != OUTSIDE)
        within = here & (columns % width >= cable.start) & (columns % width < cable.stop)
        faces = [np.flatnonzero(within & (columns % width == cable.start))]
        for _ in range(len(cable) - 1):
            faces.append(np.where(faces[-1] == BORDER, BORDER, right[faces[-1]]))
        runs = np.stack(faces, axis=1)
        whole = (runs != BORDER).all(axis=1)
        whole &= (here[runs] & (columns[runs] == columns[runs[:, :1]] + np.arange(len(cable)))).all(axis=1)
        within[runs[whole].ravel()] = False
        return runs[whole], np.flatnonzero(within)


def _lie_side_by_side(fabric: StitchMesh, runs: IntArray, sides: IntArray) -> NDArray[np.bool_]:
    """Return whether the loops below each run of faces lie side by side on one course line, shape (n,)."""
    fits: NDArray[np.bool_] = ((runs != BORDER) & (sides != BORDER)).all(axis=1)
    fits &= (_next_top_sides(fabric, sides[:, :-1]) == sides[:, 1:]).all(axis=1)
    return fits


def _next_top_sides(fabric: StitchMesh, sides: IntArray) -> IntArray:
    """Return the top side to the right of each top side on its course line, across one wale edge at most."""
    within = sides - 1
    across = sides_across(fabric, within, LEFT)
    joined = (across != BORDER) & (fabric.side_role[across - 1] == TOP)
    joined &= fabric.row[fabric.side_face[across]] == fabric.row[fabric.side_face[sides]]
    return np.where(fabric.side_role[within] == RIGHT, np.where(joined, across - 1, BORDER), within)


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


class _CellTable:
    """The new stitch of a plain face in each cell of a pattern, by the number of the cell."""

    def __init__(self, fabric: StitchMesh, pattern: Pattern, units: Units, cells: CellNumbers) -> None:
        """Fill the table: units of one stitch give their stitch, and all other cells take a stitch near to them."""
        count = pattern.height * sum(pattern.rows[0].bottoms)
        self.is_single = np.zeros(count, dtype=bool)
        self.stitch = np.full(count, int(Stitch.KNIT))
        self.yarn = np.zeros(count, dtype=np.int64)
        self.made = np.zeros(count, dtype=np.int64)
        for section in range(len(SECTIONS)):
            width = pattern.rows[0].bottoms[section]
            for row in range(pattern.height):
                for column in range(width):
                    number = int(cells.number(section, row, column))
                    single = units.single.get((section, row, column))
                    near = single or _cell_near(pattern.rows[row].sections[section], (column + 0.5) / width)
                    self.is_single[number] = single is not None
                    self.stitch[number] = fabric.type_code(near.stitch if single else _plain_form(near))
                    self.made[number] = single.twist[0] if single else 0
                    self.yarn[number] = near.yarn


def _cell_near(cells: tuple[Cell, ...], share: float) -> Cell:
    """Return the stitch that works the loop at a share of the width of a row."""
    below = [place for place, cell in enumerate(cells) for _ in range(cell.n_bottom)]
    return cells[below[int(share * len(below))]]


def _plain_form(cell: Cell) -> Stitch:
    """Return the purl stitch for a stitch that is purled only, otherwise the knit stitch."""
    return Stitch.PURL if set(cell.making.made) & {"k", "p"} == {"p"} else Stitch.KNIT


def _flavoured(purl: bool) -> IntArray:
    """Return the knit or purl form of each stitch that has only one kind of loops, by type code.

    Front and back are exchanged where the form differs from the stitch.
    """
    table = np.arange(max(Stitch) + 1)
    for stitch, making in VOCABULARY.items():
        kinds = set(making.made) & {"k", "p"}
        if kinds == ({"k"} if purl else {"p"}):
            table[stitch] = turned_over(stitch)
    return table


_AS_KNIT, _AS_PURL = _flavoured(purl=False), _flavoured(purl=True)
