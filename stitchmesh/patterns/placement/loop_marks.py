# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Twists and cables of the loops that a pattern makes and works.

Both the stitch that makes a loop and the stitch that works it can twist it. The row above decides about crossings: old
crossings below a stitch of the pattern are removed as a whole, and a crossing of the pattern is added if all its loops
are there.

This module also removes and adds cable marks; a crossing is always removed or added as a whole.

A crossing is added only if all its loops lie side by side on one course line and adjacent plain stitches work them.
Otherwise the stitches are worked without the crossing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, LEFT, RIGHT, TOP, IntArray, StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.courses import right_neighbours, sides_across
from stitchmesh.patterns.pattern import SECTIONS, Loop, Pattern, Row, crossings
from stitchmesh.patterns.placement.columns import OUTSIDE, columns_of
from stitchmesh.patterns.placement.in_place import CellTable
from stitchmesh.patterns.placement.placement import Placement, is_plain, side_below
from stitchmesh.patterns.placement.replace import border_sides, flat_places
from stitchmesh.patterns.placement.units import CellNumbers, Site


class CrossingMarks:
    """Cable marks of all sides of a fabric, which the methods change."""

    def __init__(self, fabric: StitchMesh) -> None:
        """Start with the marks of a fabric."""
        self.shift, self.layer = fabric.cable_shift.copy(), fabric.cable_layer.copy()
        self._fabric = fabric
        self._right = right_neighbours(fabric)

    def clear(self, sides: IntArray) -> None:
        """Remove the marks of some sides, together with every crossing that has a loop at one of these sides.

        Raises:
            LabelError: the crossings of the fabric are malformed.
        """
        cleared = np.zeros(len(self.shift), dtype=bool)
        cleared[sides] = True
        for group in cable_groups(self._fabric):
            cleared[group.sides] |= cleared[group.sides].any()
        self.shift[cleared] = self.layer[cleared] = 0

    def runs(self, first: IntArray, count: int) -> IntArray:
        """Return each face and the faces to its right in its row; ``BORDER`` beyond the end, shape (n, count)."""
        faces = [first]
        for _ in range(count - 1):
            faces.append(np.where(faces[-1] == BORDER, BORDER, self._right[faces[-1]]))
        return np.stack(faces, axis=1)

    def cross(self, faces: IntArray, loops: tuple[Loop, ...]) -> NDArray[np.bool_]:
        """Add a crossing below each run of faces, shape (n, loops), if the loops below the run lie side by side.

        Returns:
            Whether the crossing is added below each run, shape (n,).
        """
        sides = side_below(self._fabric, faces)
        fits: NDArray[np.bool_] = ((faces != BORDER) & (sides != BORDER)).all(axis=1)
        fits &= (self._next_top_sides(sides[:, :-1]) == sides[:, 1:]).all(axis=1)
        for place, loop in enumerate(loops):
            self.shift[sides[fits, place]], self.layer[sides[fits, place]] = loop.shift, loop.layer
        return fits

    def _next_top_sides(self, sides: IntArray) -> IntArray:
        """Return the top side to the right of each top side on its course line, across one wale edge at most."""
        fabric = self._fabric
        within = sides - 1
        across = sides_across(fabric, within, LEFT)
        joined = (across != BORDER) & (fabric.side_role[across - 1] == TOP)
        joined &= fabric.row[fabric.side_face[across]] == fabric.row[fabric.side_face[sides]]
        return np.where(fabric.side_role[within] == RIGHT, np.where(joined, across - 1, BORDER), within)


def crossings_of(row: Row) -> list[tuple[int, range]]:
    """Return the crossings of a row: the index of the section, and the loops counted from its first loop."""
    return [(section, cable) for section, loops in enumerate(row.loop_sections) for cable in crossings(loops)]


class LoopMarks:
    """Marks of the top sides of a fabric with a pattern, given for the sides before the faces are replaced."""

    def __init__(
        self, fabric: StitchMesh, pattern: Pattern, placement: Placement, cells: CellNumbers, sites: list[Site]
    ) -> None:
        """Find the plain faces whose loops below are worked as the pattern says."""
        self.fabric, self.pattern, self.placement, self.cells, self.sites = fabric, pattern, placement, cells, sites
        self.works = is_plain(fabric) & (cells.of_face != BORDER)
        self.kept = self.works.copy()
        for site in sites:
            self.works[site.grids[:, 1:]] = False
            self.kept[site.grids] = False

    def twist(self, table: CellTable) -> IntArray:
        """Return the twist of each side, shape (C,)."""
        fabric = self.fabric
        twist, new = fabric.twist.copy(), self.kept.copy()
        kept = np.flatnonzero(self.kept)
        twist[fabric.face_start[kept] + 2] = table.made[self.cells.of_face[kept]]
        for site in self.sites:
            twist[border_sides(fabric, site.grids)[TOP]] = site.block.twist[flat_places(site.block, TOP)]
            new[site.grids] = True
        in_unit = np.zeros(fabric.face_count, dtype=bool)
        in_unit[kept] = table.is_single[self.cells.of_face[kept]]
        for site in self.sites:
            in_unit[site.grids[:, 0]] = True
        faces = np.flatnonzero(self.works & in_unit)
        held, below = self._held()[self.cells.of_face[faces]], side_below(fabric, faces)
        held, below = held[below != BORDER], below[below != BORDER]
        own = np.where(new[fabric.side_face[below]] | (held == 0), twist[below], 0)
        twist[below] = own + held
        return twist

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

    def crossings(self) -> tuple[CrossingMarks, IntArray]:
        """Return the cable marks of all sides, and the faces above incomplete crossings."""
        fabric, marks = self.fabric, CrossingMarks(self.fabric)
        below = side_below(fabric, np.flatnonzero(self.works))
        inner = [fabric.face_start[site.grids[:, :-1]].ravel() + 2 for site in self.sites]
        marks.clear(np.concatenate([below[below != BORDER], *inner]))
        missed = [np.zeros(0, dtype=np.int64)]
        for number, row in enumerate(self.pattern.rows):
            for section, cable in crossings_of(row):
                if row.bottoms[section] == self.pattern.rows[0].bottoms[section]:
                    loops = row.loop_sections[section][cable.start : cable.stop]
                    runs, cut = self._runs(marks, number, section, cable)
                    crossed = marks.cross(runs, loops)
                    missed += [cut, runs[~crossed].ravel()]
        return marks, np.unique(np.concatenate(missed))

    def _runs(self, marks: CrossingMarks, number: int, section: int, cable: range) -> tuple[IntArray, IntArray]:
        """Return the runs of faces above a crossing, shape (n, loops), and the faces there that are in no whole run."""
        width = max(self.pattern.rows[0].bottoms[section], 1)
        columns = columns_of(section, self.placement.column)
        here = self.works & (self.placement.row == number) & (columns != OUTSIDE)
        within = here & (columns % width >= cable.start) & (columns % width < cable.stop)
        runs = marks.runs(np.flatnonzero(within & (columns % width == cable.start)), len(cable))
        whole = (runs != BORDER).all(axis=1)
        whole &= (here[runs] & (columns[runs] == columns[runs[:, :1]] + np.arange(len(cable)))).all(axis=1)
        within[runs[whole].ravel()] = False
        return runs[whole], np.flatnonzero(within)
