# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A pattern as a flat stitch mesh: a cast-on row, then tiles side by side and repeats one above another.

The module also makes a pattern as a tube, knitted in rounds: the tiles of a swatch whose sides are joined.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import ParameterError, check_kind, check_positive
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns.pattern import Pattern
from stitchmesh.patterns.placement.apply import apply_pattern

LEAST_STITCHES = 3
"""Smallest number of stitches around a tube; fewer enclose no space."""


def pattern_mesh(
    pattern: Pattern, columns: int = 1, rows: int = 1, *, stitch_width: float, stitch_height: float
) -> StitchMesh:
    """Make a flat stitch mesh of a pattern.

    The mesh lies in the plane z = 0 with its right side up and its lower left corner at the origin.

    Args:
        pattern: the pattern, for example from ``read_pattern``.
        columns: number of tiles side by side, between the borders of the pattern.
        rows: number of vertical repeats above the cast-on row.
        stitch_width: wale spacing of the cast-on row [cm]; rows with more or fewer loops keep the same total width.
        stitch_height: course spacing [cm].

    Raises:
        ParameterError: a number is not positive.
        PatternError: the pattern does not close.
    """
    check_kind("pattern_mesh", pattern, Pattern)
    check_swatch_size(columns, rows, stitch_width, stitch_height)
    left, width, right = pattern.rows[0].bottoms
    plain = plain_piece(left + columns * width + right, 1 + rows * pattern.height, stitch_width, stitch_height)
    return apply_pattern(plain, pattern, remainder="refuse")


def check_swatch_size(columns: int, rows: int, stitch_width: float, stitch_height: float) -> None:
    """Check the numbers of tiles and the sizes of stitches [cm] of a swatch.

    Raises:
        ParameterError: a number is not positive.
    """
    for name, number in (("columns", columns), ("rows", rows)):
        if number < 1:
            raise ParameterError(f"{name}: got {number}; expected at least 1")
    for name, size in (("stitch width", stitch_width), ("stitch height", stitch_height)):
        check_positive(name, size, "cm")


def plain_piece(columns: int, rows: int, stitch_width: float, stitch_height: float) -> StitchMesh:
    """Return a flat rectangle of knit stitches; its first row is the cast-on row. Widths and heights are in cm."""
    x, y = np.meshgrid(stitch_width * np.arange(columns + 1), stitch_height * np.arange(rows + 1))
    row, column = (index.ravel() for index in np.indices((rows, columns)))
    lower = row * (columns + 1) + column
    corners = np.stack([lower, lower + 1, lower + columns + 2, lower + columns + 1], axis=1).ravel()
    return _knit_rows(np.stack([x, y, np.zeros_like(x)], axis=2).reshape(-1, 3), corners, row)


def _knit_rows(points: FloatArray, corners: IntArray, row: IntArray) -> StitchMesh:
    """Return quads of one knit stitch each, with cast-on stitches in row 0."""
    face_start = 4 * np.arange(len(row) + 1)
    ones = np.ones(len(row), dtype=np.int64)
    return StitchMesh(
        vertices=points,
        face_start=face_start,
        face_vertex=corners,
        twin=find_twins(face_start, corners, len(points)),
        n_bottom=ones,
        n_top=ones,
        stitch=np.where(row == 0, Stitch.CAST_ON, Stitch.KNIT),
        row=row,
    )


def pattern_tube(
    pattern: Pattern, columns: int = 1, rows: int = 1, *, stitch_width: float, stitch_height: float
) -> StitchMesh:
    """Make an upright round tube of a pattern, whose borders are left out.

    The axis of the tube is y, and its right side is outside.

    Args:
        pattern: the pattern, for example from ``read_pattern``.
        columns: number of tiles around the tube.
        rows: number of vertical repeats above the cast-on round.
        stitch_width: wale spacing of the cast-on round [cm].
        stitch_height: course spacing [cm].

    Raises:
        ParameterError: a number is not positive, or the tube has fewer than three stitches around.
        PatternError: the pattern does not close.
    """
    check_kind("pattern_tube", pattern, Pattern)
    check_swatch_size(columns, rows, stitch_width, stitch_height)
    around = columns * pattern.width
    if around < LEAST_STITCHES:
        found = f"{columns} tiles of {pattern.width} stitches make a round of {around}"
        raise ParameterError(f"columns: {found}; expected at least {LEAST_STITCHES} stitches")
    plain = _plain_tube(around, 1 + rows * pattern.height, stitch_width, stitch_height)
    return apply_pattern(plain, pattern.without_borders(), remainder="refuse")


def _plain_tube(around: int, rows: int, stitch_width: float, stitch_height: float) -> StitchMesh:
    """Return a tube of knit stitches; its first round is the cast-on round. Widths and heights are in cm."""
    angle = 2.0 * np.pi * np.arange(around) / around
    radius = 0.5 * stitch_width / np.sin(np.pi / around)
    height, turn = np.meshgrid(stitch_height * np.arange(rows + 1), angle, indexing="ij")
    points = np.stack([radius * np.sin(turn), height, radius * np.cos(turn)], axis=2).reshape(-1, 3)
    row, column = (index.ravel() for index in np.indices((rows, around)))
    lower, following = row * around, (column + 1) % around
    upper = lower + around
    corners = np.stack([lower + column, lower + following, upper + following, upper + column], axis=1).ravel()
    return _knit_rows(points, corners, row)
