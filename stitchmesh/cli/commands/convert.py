# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``convert``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tyro.conf import Positional, arg

from stitchmesh.cli.arguments import shown
from stitchmesh.cli.options import FileReading
from stitchmesh.errors import ParameterError


@dataclass(frozen=True)
class Convert:
    """Convert yarns, a polygon mesh or a stitch mesh to another format."""

    file: Annotated[Positional[str], shown("IN")]
    """polygon mesh, stitch mesh or yarns"""
    output: Annotated[Positional[str], shown("OUT")]
    """the same in the format of its suffix; a stitch mesh also as .k for a knitting machine"""
    tile: Annotated[tuple[int, int] | None, shown("C R", "one, or the lattice")] = None
    """of yarns that repeat: periods along the courses and along the wales to write"""
    reading: Annotated[FileReading, arg(name="")] = field(default_factory=FileReading)

    def run(self) -> None:
        """One format to another of the same noun."""
        from stitchmesh.cli.describe import kind_of
        from stitchmesh.io import write_mesh, write_stitches, write_yarns
        from stitchmesh.io.contents import suffix_of
        from stitchmesh.io.meshes import FORMATS
        from stitchmesh.io.stitches import WRITABLE
        from stitchmesh.mesh import StitchMesh
        from stitchmesh.yarn import YarnSet

        noun = self.reading.read(self.file)
        if isinstance(noun, YarnSet):
            write_yarns(self.output, noun, tiles=self.tile)
        elif self.tile is not None:
            raise ParameterError(f"tile: {self.file} is a {kind_of(noun)}; only yarns that repeat can be tiled")
        elif isinstance(noun, StitchMesh) and suffix_of(self.output, (*WRITABLE, *FORMATS)) in WRITABLE:
            write_stitches(self.output, noun)
        else:
            write_mesh(self.output, noun)
