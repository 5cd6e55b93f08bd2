# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A pattern as a tube, knitted in rounds: the tiles of a swatch whose sides are joined."""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns.pattern import Pattern
from stitchmesh.patterns.placement.apply import apply_pattern
from stitchmesh.patterns.swatch_mesh import check_swatch_size

LEAST_STITCHES = 3
"""Fewest stitches around a tube; fewer enclose no space."""


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
