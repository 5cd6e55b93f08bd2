# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``render``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tyro.conf import Positional, arg

from stitchmesh.cli.arguments import shown
from stitchmesh.cli.options import FileReading


@dataclass(frozen=True)
class Render:
    """Draw a picture of yarns, stitches, rows or a mesh."""

    file: Annotated[Positional[str], shown("FILE")]
    """polygon mesh, stitch mesh or yarns"""
    output: Annotated[str, shown("PNG", short="-o")]
    """picture"""
    what: Annotated[str | None, shown("KIND", "rows if it is only labeled, else stitches")] = None
    """of a stitch mesh: rows, stitches or stretch"""
    reading: Annotated[FileReading, arg(name="")] = field(default_factory=FileReading)

    def run(self) -> None:
        """A picture."""
        from stitchmesh.render import render_file

        unit, radius = self.reading.unit, self.reading.yarn_radius
        render_file(self.file, self.output, what=self.what, unit=unit, radius=radius)
