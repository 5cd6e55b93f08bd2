# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands about parts of a fabric: ``select``, ``pattern`` and ``capture``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
from stitchmesh.cli.words import Flag, help_entry
from stitchmesh.patterns.placement.columns import DEFAULT_REMAINDER, check_remainder

if TYPE_CHECKING:
    from stitchmesh.mesh import IntArray, StitchMesh


PICTURE_SUFFIX = ".png"


@dataclass(frozen=True)
class SelectCommand:
    """Show parts of a stitch mesh by name, as counts, a picture or a list."""

    fabric: Annotated[Positional[str], help_entry("FABRIC", help=READ_STITCHES)]
    selections: Annotated[Positional[tuple[str, ...]], help_entry("SELECTION", "list the names")] = ()
    """parts of the fabric, such as 'hem 6' (docs/selections.md)"""
    output: Annotated[str | None, help_entry("FILE", "none", short="-o")] = None
    """picture (.png) with each selection in its own colour, or a text file of face numbers"""
    overwrite: Overwrite = False

    def run(self) -> None:
        """Print the names or the counts, and write the file."""
        from stitchmesh.io import read_stitches
        from stitchmesh.selection import select

        fabric = read_stitches(self.fabric)
        names = self.selections or tuple(_names(fabric))
        chosen = {name: select(fabric, name) for name in names}
        if self.output is not None:
            self._write(fabric, chosen, self.output)
        for name, faces in chosen.items():
            rows = fabric.row[faces]
            say(f"{name}: {len(faces)} of {fabric.face_count} stitches, in rows {rows.min()} to {rows.max()}")

    def _write(self, fabric: StitchMesh, chosen: dict[str, IntArray], path: str) -> None:
        import numpy as np

        if Path(path).suffix.lower() == PICTURE_SUFFIX:
            from stitchmesh.render.selection_picture import render_selections

            render_selections(fabric, chosen, path)
            return
        from stitchmesh.io.atomic import write_text

        faces = np.unique(np.concatenate(list(chosen.values())))
        write_text(path, "".join(f"{face}\n" for face in faces.tolist()))


def _names(fabric: StitchMesh) -> list[str]:
    """Return the names of borders and parts that the fabric has."""
    from stitchmesh.errors import ParameterError
    from stitchmesh.selection import borders, select
    from stitchmesh.selection.selection import PLACES

    names = [*(border.name for border in borders(fabric)), *PLACES]
    found = []
    for name in dict.fromkeys("tips" if name == "tip" else name for name in names):
        try:
            select(fabric, name)
        except ParameterError:
            continue
        found.append(name)
    return found


@dataclass(frozen=True)
class PatternCommand:
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


@dataclass(frozen=True)
class CaptureCommand:
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
        from stitchmesh.periodic.charts.chart_picture import write_pattern
        from stitchmesh.selection import select

        fabric = read_stitches(self.fabric)
        faces = None if self.on is None else select(fabric, self.on)
        captured = capture_pattern(fabric, faces, name=self.name)
        pattern = captured if self.whole else smallest_repeat(captured)
        write_pattern(self.output, pattern)
        size = f"{pattern.width} loops x {pattern.height} rows"
        part = f"one repeat of {captured.width} x {captured.height}"
        say(f"Wrote {self.output}: {size}{'' if pattern == captured else f', {part}'}.")
