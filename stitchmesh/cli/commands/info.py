# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``info``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tyro.conf import Positional, arg

from stitchmesh.cli.options import FileReading
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.mesh import Mesh


@dataclass(frozen=True)
class Info:
    """Describe the content of a file."""

    file: Annotated[Positional[str], help_entry("FILE")]
    """polygon mesh, stitch mesh or yarns"""
    reading: Annotated[FileReading, arg(name="")] = field(default_factory=FileReading)

    def run(self) -> None:
        """Print the lines that describe the file."""
        from stitchmesh.cli.describe import description
        from stitchmesh.io.garments import doubt_of_unit
        from stitchmesh.io.mesh_objects import scene_objects

        found = self.reading.read(self.file)
        for line in description(found):
            say(line)
        if type(found) is not Mesh:
            return
        objects = scene_objects(self.file, found.vertices, found.polygons).objects
        if len(objects) > 1:
            say(f"objects: {', '.join(objects)}")
        if doubt := doubt_of_unit(self.file, found, self.reading.unit):
            say(f"if it is a garment: {doubt}")
