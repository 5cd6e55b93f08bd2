# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``render``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tyro.conf import Positional, arg

from stitchmesh.cli.arguments import help_entry
from stitchmesh.cli.options import FileReading


@dataclass(frozen=True)
class Render:
    """Draw a picture of yarns, of stitches, of rows or of a mesh."""

    file: Annotated[Positional[str], help_entry("FILE")]
    """polygon mesh, stitch mesh or yarns"""
    output: Annotated[str, help_entry("PNG", short="-o")]
    """picture file"""
    what: Annotated[str | None, help_entry("KIND", "rows of a labeled mesh, stitches of a stitch mesh")] = None
    """colours of a stitch mesh: rows, stitches or stretch"""
    reading: Annotated[FileReading, arg(name="")] = field(default_factory=FileReading)

    def run(self) -> None:
        """Draw the picture, and write it."""
        from stitchmesh.render import render_file

        unit, radius = self.reading.unit, self.reading.yarn_radius
        render_file(self.file, self.output, what=self.what, unit=unit, radius=radius)
