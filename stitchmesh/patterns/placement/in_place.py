# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patterns in which every stitch has one loop below and one above: marks of faces and sides change, but no faces.

A shaping stitch of the garment keeps its loops and takes its knit or purl form, according to the pattern at that place.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.change import Marks
from stitchmesh.mesh.stitch import VOCABULARY, Stitch, turned_over
from stitchmesh.patterns.pattern import Pattern
from stitchmesh.patterns.placement.columns import LEFT_BORDER, OUTSIDE, RIGHT_BORDER, TILE, columns_of
from stitchmesh.patterns.placement.crossing_marks import CrossingMarks, crossings_of
from stitchmesh.patterns.placement.placement import Placement, is_plain, side_below


def changes_in_place(fabric: StitchMesh, pattern: Pattern, placement: Placement) -> list[Marks]:
    """Return the changes of stitches, yarns, twists and cables that put a pattern on a fabric.

    If the pattern has only one yarn, every face keeps its own yarn.

    Raises:
        LabelError: the cables of the fabric are malformed.
    """
    cells = _cells(pattern, placement)
    faces = np.flatnonzero(cells != BORDER)
    plain = faces[is_plain(fabric)[faces]]
    shift, layer = _crossed(fabric, pattern, placement, plain)
    arrays = {
        "stitch": _stitches(fabric, pattern, cells, faces),
        "yarn": _yarns(fabric, pattern, cells, faces),
        "twist": _twists(fabric, pattern, cells, plain),
        "cable_shift": shift,
        "cable_layer": layer,
    }
    return [marks for name, values in arrays.items() if len((marks := changed(fabric, name, values)).places)]


def changed(fabric: StitchMesh, name: str, values: IntArray) -> Marks:
    """Return the marks at which values differ from the values of a fabric."""
    places = np.flatnonzero(values != getattr(fabric, name))
    return Marks(name, places, values[places])


def _cells(pattern: Pattern, placement: Placement) -> IntArray:
    """Return the index of each face's cell, counted row by row; ``BORDER`` outside the pattern, shape (F,)."""
    left, width, right = pattern.rows[0].bottoms
    cells = np.full(len(placement.column), BORDER)
    for section, start, count in ((LEFT_BORDER, 0, left), (TILE, left, width), (RIGHT_BORDER, left + width, right)):
        columns = columns_of(section, placement.column)
        own = np.flatnonzero(columns != OUTSIDE)
        cells[own] = placement.row[own] * (left + width + right) + start + columns[own] % max(count, 1)
    return cells


def _stitches(fabric: StitchMesh, pattern: Pattern, cells: IntArray, faces: IntArray) -> IntArray:
    wanted = np.array([cell.stitch for row in pattern.rows for cell in row.cells])[cells[faces]]
    purl = wanted == Stitch.PURL
    stitch = fabric.stitch.copy()
    stitch[faces] = np.where(
        is_plain(fabric)[faces], wanted, np.where(purl, _AS_PURL[stitch[faces]], _AS_KNIT[stitch[faces]])
    )
    return stitch


def _yarns(fabric: StitchMesh, pattern: Pattern, cells: IntArray, faces: IntArray) -> IntArray:
    yarn = fabric.yarn.copy()
    if pattern.yarn_count > 1:
        yarn[faces] = np.array([cell.yarn for row in pattern.rows for cell in row.cells])[cells[faces]]
    return yarn


def _twists(fabric: StitchMesh, pattern: Pattern, cells: IntArray, plain: IntArray) -> IntArray:
    """Return the twist of each side, shape (C,): from the stitch that makes a loop and the stitch that works it."""
    made = np.array([cell.twist[0] for row in pattern.rows for cell in row.cells])[cells[plain]]
    held = np.array([loop.twist for row in pattern.rows for loop in row.loops])[cells[plain]]
    twist = fabric.twist.copy()
    twist[fabric.face_start[plain] + 2] = made
    below = side_below(fabric, plain)
    held, below = held[below != BORDER], below[below != BORDER]
    new = np.zeros(fabric.face_count, dtype=bool)
    new[plain] = True
    own = np.where(new[fabric.side_face[below]] | (held == 0), twist[below], 0)
    twist[below] = own + held
    return twist


def _crossed(
    fabric: StitchMesh, pattern: Pattern, placement: Placement, plain: IntArray
) -> tuple[IntArray, IntArray]:
    """Return the cable shifts and cable layers of all sides, each of shape (C,)."""
    marks = CrossingMarks(fabric)
    below = side_below(fabric, plain)
    marks.clear(below[below != BORDER])
    takes = np.zeros(fabric.face_count, dtype=bool)
    takes[plain] = True
    for number, row in enumerate(pattern.rows):
        for section, cable in crossings_of(row):
            width = max(row.bottoms[section], 1)
            columns = columns_of(section, placement.column)
            here = takes & (placement.row == number) & (columns != OUTSIDE)
            first = np.flatnonzero(here & (columns % width == cable.start))
            runs = marks.runs(first, len(cable))
            runs = runs[(runs != BORDER).all(axis=1)]
            consecutive = (columns[runs] == columns[runs[:, :1]] + np.arange(len(cable))) & here[runs]
            marks.cross(runs[consecutive.all(axis=1)], row.loop_sections[section][cable.start : cable.stop])
    return marks.shift, marks.layer


def _flavoured(purl: bool) -> IntArray:
    """Return the knit or purl form of each stitch whose loops are all of one kind, by type code.

    Front and back are exchanged where the form differs from the stitch.
    """
    table = np.arange(max(Stitch) + 1)
    for stitch, making in VOCABULARY.items():
        kinds = set(making.made) & {"k", "p"}
        if kinds == ({"k"} if purl else {"p"}):
            table[stitch] = turned_over(stitch)
    return table


_AS_KNIT, _AS_PURL = _flavoured(purl=False), _flavoured(purl=True)
