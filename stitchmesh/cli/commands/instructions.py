# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``instructions``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.arguments import help_entry
from stitchmesh.cli.options import READ_STITCHES, Overwrite
from stitchmesh.cli.say import say


@dataclass(frozen=True)
class Instructions:
    """Write instructions in words to knit a stitch mesh by hand."""

    fabric: Annotated[Positional[str], help_entry("FABRIC", help=READ_STITCHES)]
    output: Annotated[str | None, help_entry("FILE", "standard output", short="-o")] = None
    """text file for the instructions"""
    overwrite: Overwrite = False

    def run(self) -> None:
        """Write the instructions to the file, or print them if no file is given."""
        from stitchmesh.hand_knitting import knitting_instructions
        from stitchmesh.io import read_stitches
        from stitchmesh.io.atomic import write_text

        text = knitting_instructions(read_stitches(self.fabric))
        if self.output is None:
            say(text, end="")
        else:
            write_text(self.output, text)
            say(f"Wrote {self.output}: {len(text.splitlines())} lines.")
