# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``instructions``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.options import READ_STITCHES, Overwrite, YarnName
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.errors import ParameterError


@dataclass(frozen=True)
class InstructionsCommand:
    """Write a pattern to knit a stitch mesh by hand, in words or as a PDF."""

    fabric: Annotated[Positional[str], help_entry("FABRIC", help=READ_STITCHES)]
    output: Annotated[str | None, help_entry("FILE", "standard output", short="-o")] = None
    """text file (.txt) for the instructions, or PDF (.pdf) for the whole pattern"""
    yarns: Annotated[str | None, help_entry("FILE", "yarns.h5 beside the stitches")] = None
    """with a PDF, the yarns, whose lengths it states by colour"""
    picture: Annotated[str | None, help_entry("FILE", "preview.png beside the stitches")] = None
    """with a PDF, the picture on its first page"""
    yarn: YarnName = None
    overwrite: Overwrite = False

    def run(self) -> None:
        """Write the instructions to the file, or print them if no file is given."""
        from stitchmesh.hand_knitting import knitting_instructions
        from stitchmesh.io import read_stitches
        from stitchmesh.io.atomic import write_text

        if self.output is not None and self.output.lower().endswith(".pdf"):
            self._write_sheet(self.output)
            return
        given = [name for name in ("yarns", "picture", "yarn") if getattr(self, name) is not None]
        if given:
            raise ParameterError(f"{given[0]}: is for a PDF; expected an output such as pattern.pdf")
        text = knitting_instructions(read_stitches(self.fabric))
        if self.output is None:
            say(text, end="")
        else:
            write_text(self.output, text)
            say(f"Wrote {self.output}: {len(text.splitlines())} lines.")

    def _write_sheet(self, output: str) -> None:
        """Write the PDF."""
        from stitchmesh.io import read_stitches, read_yarns
        from stitchmesh.io.contents import read_bytes
        from stitchmesh.io.yarn_files import yarn_of
        from stitchmesh.render.pattern_sheet import garment_sheet, write_pattern_sheet

        folder = Path(self.fabric).parent
        yarns = self.yarns or _beside(folder / "yarns.h5")
        picture = self.picture or _beside(folder / "preview.png")
        sheet = garment_sheet(
            read_stitches(self.fabric),
            None if yarns is None else read_yarns(yarns),
            title=Path(output).stem.replace("-", " ").capitalize(),
            yarn=None if self.yarn is None else yarn_of(self.yarn),
            picture=None if picture is None else read_bytes(picture),
        )
        write_pattern_sheet(output, sheet)
        say(f"Wrote {output}: {len(sheet.charts)} charts, {len(sheet.text.splitlines())} lines of instructions.")


def _beside(path: Path) -> str | None:
    """Return the path of a file, if it is there."""
    return str(path) if path.is_file() else None
