# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``capture``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.options import READ_STITCHES, OnSelection, Overwrite
from stitchmesh.cli.say import say
from stitchmesh.cli.words import Flag, help_entry


@dataclass(frozen=True)
class Capture:
    """Take a part of a stitch mesh as a pattern."""

    fabric: Annotated[Positional[str], help_entry("FABRIC", help=READ_STITCHES)]
    output: Annotated[str, help_entry("FILE", short="-o")]
    """pattern: .knit, or .png for a picture of its chart, which can be read as a pattern too"""
    on: OnSelection = None
    name: Annotated[str, help_entry("NAME")] = "captured"
    """name of the pattern"""
    whole: Flag = False
    """keep the whole part as one tile; without this option, one repeat of it is kept"""
    overwrite: Overwrite = False

    def run(self) -> None:
        """Capture the pattern, and write it."""
        from stitchmesh.io import read_stitches
        from stitchmesh.patterns import capture_pattern, smallest_repeat
        from stitchmesh.periodic.charts.pattern_file import write_pattern
        from stitchmesh.selection import select

        fabric = read_stitches(self.fabric)
        faces = None if self.on is None else select(fabric, self.on)
        captured = capture_pattern(fabric, faces, name=self.name)
        pattern = captured if self.whole else smallest_repeat(captured)
        write_pattern(self.output, pattern)
        size = f"{pattern.width} loops x {pattern.height} rows"
        part = f"one repeat of {captured.width} x {captured.height}"
        say(f"Wrote {self.output}: {size}{'' if pattern == captured else f', {part}'}.")
