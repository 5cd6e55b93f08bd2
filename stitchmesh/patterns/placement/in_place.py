# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches of a pattern that keep the face on which they lie: marks of faces change, but no face is replaced.

A shaping stitch of the garment keeps its loops and takes its knit or purl form, according to the pattern at that place.
A plain stitch of an incomplete unit is knit or purled as the pattern is there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.change import Marks
from stitchmesh.mesh.stitch import VOCABULARY, Stitch, turned_over
from stitchmesh.patterns.pattern import SECTIONS, Cell, Pattern
from stitchmesh.patterns.placement.placement import is_plain
from stitchmesh.patterns.placement.units import CellNumbers, Units


class CellTable:
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


def changes_in_place(
    fabric: StitchMesh, pattern: Pattern, cells: IntArray, table: CellTable, kept: NDArray[np.bool_]
) -> list[Marks]:
    """Return the changes of stitches and yarns of the faces that keep their loops.

    If the pattern has only one yarn, every face keeps its own yarn.

    Args:
        fabric: the mesh.
        pattern: the pattern.
        cells: number of each face's cell, ``BORDER`` outside the pattern, shape (F,).
        table: the new stitch of each cell.
        kept: whether each face keeps its loops, shape (F,).
    """
    faces = np.flatnonzero((cells != BORDER) & kept)
    wanted = table.stitch[cells[faces]]
    own, built_in = fabric.stitch[faces], fabric.built_in[faces]
    stitch, yarn = fabric.stitch.copy(), fabric.yarn.copy()
    shaped = np.where(wanted == Stitch.PURL, _AS_PURL[built_in], _AS_KNIT[built_in])
    shaped = np.where(own == built_in, shaped, own)
    stitch[faces] = np.where(is_plain(fabric)[faces], wanted, shaped)
    if pattern.yarn_count > 1:
        yarn[faces] = table.yarn[cells[faces]]
    marks = [changed(fabric, "stitch", stitch), changed(fabric, "yarn", yarn)]
    return [mark for mark in marks if len(mark.places)]


def changed(fabric: StitchMesh, name: str, values: IntArray) -> Marks:
    """Return the marks for the places where values differ from the values of a fabric."""
    places = np.flatnonzero(values != getattr(fabric, name))
    return Marks(name, places, values[places])


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
