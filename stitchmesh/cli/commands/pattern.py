# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``pattern``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.arguments import shown
from stitchmesh.cli.options import READ_STITCHES, WRITTEN_STITCHES
from stitchmesh.patterns.placement.columns import DEFAULT_REMAINDER, check_remainder


@dataclass(frozen=True)
class Pattern:
    """Work a stitch mesh in a pattern."""

    fabric: Annotated[Positional[str], shown("FABRIC", help=READ_STITCHES)]
    pattern: Annotated[Positional[str], shown("PATTERN")]
    """name of a pattern (`stitchmesh patterns`), or a file"""
    output: Annotated[str, shown("FILE", short="-o", help=WRITTEN_STITCHES)]
    face: Annotated[int | None, shown("FACE", "the whole fabric")] = None
    """only the largest grid of plain stitches around this face, counted from 0"""
    remainder: Annotated[str, shown("HOW")] = DEFAULT_REMAINDER
    """stitches that whole tiles of the pattern leave over: centre, stretch or refuse"""

    def run(self) -> None:
        """A stitch mesh in a pattern."""
        from stitchmesh.io import read_stitches, write_stitches
        from stitchmesh.patterns import read_pattern
        from stitchmesh.pipeline import with_pattern

        chosen = read_pattern(self.pattern)
        remainder = check_remainder(self.remainder)
        fabric = read_stitches(self.fabric)
        made, faces = with_pattern(fabric, chosen, remainder, face=self.face)
        write_stitches(self.output, made)
        print(f"{chosen.name}: {faces} of {made.face_count} stitches changed")
