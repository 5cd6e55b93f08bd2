# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``pattern``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.options import (
    READ_STITCHES,
    WRITTEN_STITCHES,
    Centre,
    Ground,
    Mirror,
    OnSelection,
    Overwrite,
    Remainder,
    Shift,
)
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.patterns.placement.columns import DEFAULT_REMAINDER, check_remainder


@dataclass(frozen=True)
class Pattern:
    """Apply a knitting pattern to a stitch mesh."""

    fabric: Annotated[Positional[str], help_entry("FABRIC", help=READ_STITCHES)]
    pattern: Annotated[Positional[str], help_entry("PATTERN")]
    """pattern: a name of `stitchmesh patterns`, or a file"""
    output: Annotated[str, help_entry("FILE", short="-o", help=WRITTEN_STITCHES)]
    on: OnSelection = None
    face: Annotated[int | None, help_entry("FACE", "the whole fabric")] = None
    """limit the pattern to the largest grid of plain stitches around this face, counted from 0"""
    stitches: Annotated[str | None, help_entry("FILE", "built-in stitches only")] = None
    """drawings (.json) of stitches of your own, whose codes the pattern uses (docs/own-stitches.md)"""
    remainder: Remainder = DEFAULT_REMAINDER
    ground: Ground = None
    shift: Shift = (0, 0)
    mirror: Mirror = False
    centre: Centre = False
    overwrite: Overwrite = False

    def run(self) -> None:
        """Apply the pattern, and write the stitch mesh."""
        from stitchmesh.io import read_stitches, write_stitches
        from stitchmesh.patterns import lay_pattern, read_pattern
        from stitchmesh.patterns.moved import mirrored_pattern, shifted_pattern
        from stitchmesh.patterns.placement.left_out import left_out_lines
        from stitchmesh.selection import select
        from stitchmesh.yarngen.templates.own_checks import read_own_stitches

        own = () if self.stitches is None else read_own_stitches(self.stitches)
        read = read_pattern(self.pattern, stitches=own)
        chosen = shifted_pattern(mirrored_pattern(read) if self.mirror else read, *self.shift)
        remainder = check_remainder(self.remainder)
        fabric = read_stitches(self.fabric)
        faces = None if self.on is None else select(fabric, self.on)
        laid = lay_pattern(
            fabric, chosen, face=self.face, faces=faces, remainder=remainder, ground=self.ground, centre=self.centre
        )
        write_stitches(self.output, laid.fabric)
        say(f"{chosen.name}: {laid.faces_laid} of {laid.fabric.face_count} stitches are in the pattern")
        for line in left_out_lines(laid.left_out):
            say(line)
