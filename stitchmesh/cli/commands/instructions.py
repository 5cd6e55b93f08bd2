# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``instructions``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.arguments import shown
from stitchmesh.cli.options import READ_STITCHES


@dataclass(frozen=True)
class Instructions:
    """Write a stitch mesh in words, to knit by hand."""

    fabric: Annotated[Positional[str], shown("FABRIC", help=READ_STITCHES)]
    output: Annotated[str | None, shown("FILE", "printed", short="-o")] = None
    """text file"""

    def run(self) -> None:
        """The text, printed unless a file is named."""
        from stitchmesh.hand_knitting import knitting_instructions
        from stitchmesh.io import read_stitches
        from stitchmesh.io.atomic import write_text

        text = knitting_instructions(read_stitches(self.fabric))
        if self.output is None:
            print(text, end="")
        else:
            write_text(self.output, text)
