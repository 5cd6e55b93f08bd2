# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``edit``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.arguments import help_entry
from stitchmesh.cli.options import READ_STITCHES, WRITTEN_STITCHES
from stitchmesh.errors import ParameterError


@dataclass(frozen=True)
class Edit:
    """Apply a log of edits to a stitch mesh."""

    fabric: Annotated[Positional[str], help_entry("FABRIC", help=READ_STITCHES)]
    replay: Annotated[str | None, help_entry("LOG", "none")] = None
    """file of edits, one JSON object in each line (docs/editing.md)"""
    output: Annotated[str | None, help_entry("FILE", "none", short="-o", help=WRITTEN_STITCHES)] = None

    def run(self) -> None:
        """Apply the edits, and write the result; if one edit is not possible, nothing is written."""
        from stitchmesh.editing.log import replay_edits
        from stitchmesh.io import read_stitches, write_stitches

        if self.replay is None or self.output is None:
            raise ParameterError("edit: needs a log of edits and a file for the result; give --replay LOG and -o FILE")
        before = read_stitches(self.fabric)
        after = replay_edits(before, self.replay)
        write_stitches(self.output, after)
        print(f"{before.face_count} stitches before, {after.face_count} after")
