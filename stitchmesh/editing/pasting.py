# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The edit that applies a pattern to a stitch mesh."""

from __future__ import annotations

from collections.abc import Sequence

from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import Change
from stitchmesh.patterns.language.parse import parse_pattern
from stitchmesh.patterns.library import read_pattern
from stitchmesh.patterns.placement.apply import lay_pattern
from stitchmesh.patterns.placement.columns import DEFAULT_REMAINDER, check_remainder


def paste_pattern(
    fabric: StitchMesh,
    pattern: str,
    face: int | None = None,
    faces: Sequence[int] | None = None,
    remainder: str = DEFAULT_REMAINDER,
    ground: str | None = None,
    centre: bool = False,
) -> list[Change]:
    """Replace the stitches of a fabric by the stitches of a pattern, as ``apply_pattern`` does.

    Args:
        fabric: a mesh of stitches.
        pattern: a name in the library, the path of a file, or the text of a pattern, which has at least two lines.
        face: a plain stitch of the grid to fill.
        faces: the faces of a region; without ``face`` and ``faces`` the pattern covers the whole fabric.
        remainder: what happens to loops that whole tiles do not cover (see ``apply_pattern``).
        ground: colour, or number of a yarn, for the stitches left over (see ``apply_pattern``).
        centre: whether the middle of a tile lies in the middle of the front (see ``apply_pattern``).

    Raises:
        ParameterError: an error of ``apply_pattern``, or the library has no such pattern.
        FileError: the file cannot be read.
        PatternError: the text does not describe a valid pattern, or an error of ``apply_pattern``.
    """
    read = parse_pattern(pattern) if "\n" in pattern else read_pattern(pattern)
    laid = lay_pattern(
        fabric, read, face=face, faces=faces, remainder=check_remainder(remainder), ground=ground, centre=centre
    )
    return list(laid.changes)
