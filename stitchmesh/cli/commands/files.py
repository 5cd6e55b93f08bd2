# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands that say what a file holds, check it, and convert it: ``info``, ``check`` and ``convert``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tyro.conf import Positional, arg

from stitchmesh.cli.options import FileReading, Overwrite
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.errors import ParameterError
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


@dataclass(frozen=True)
class Check:
    """Check a file; the exit status is 0 for a valid file, else 2."""

    file: Annotated[Positional[str], help_entry("FILE")]
    """polygon mesh, stitch mesh or yarns"""
    reading: Annotated[FileReading, arg(name="")] = field(default_factory=FileReading)

    def run(self) -> None:
        """Read the file, which validates it, and print its kind."""
        from stitchmesh.cli.describe import kind_of

        say(f"{self.file}: valid {kind_of(self.reading.read(self.file))}")


@dataclass(frozen=True)
class Convert:
    """Convert yarns, a polygon mesh or a stitch mesh to another format."""

    file: Annotated[Positional[str], help_entry("IN")]
    """polygon mesh, stitch mesh or yarns"""
    output: Annotated[Positional[str], help_entry("OUT")]
    """output file in the format of its suffix; for a stitch mesh also .k for a knitting machine"""
    tile: Annotated[tuple[int, int] | None, help_entry("C R", "the lattice or one period")] = None
    """for periodic yarns: numbers of periods to write along the courses and along the wales"""
    reading: Annotated[FileReading, arg(name="")] = field(default_factory=FileReading)
    overwrite: Overwrite = False

    def run(self) -> None:
        """Read the file, and write its content in the other format."""
        from stitchmesh.cli.describe import in_brief, kind_of
        from stitchmesh.faces.face_mesh import FaceMesh
        from stitchmesh.io import write_mesh, write_stitches, write_yarns
        from stitchmesh.io.contents import suffix_of
        from stitchmesh.io.meshes import FORMATS
        from stitchmesh.io.stitch_formats.face_meshes import write_face_mesh
        from stitchmesh.io.stitches import WRITABLE
        from stitchmesh.io.yarns import FORMATS as YARNS
        from stitchmesh.mesh import StitchMesh
        from stitchmesh.yarn import YarnSet
        from stitchmesh.yarngen.face_yarns.generate import face_yarns

        content = self.reading.read(self.file)
        if isinstance(content, FaceMesh) and suffix_of(self.output, (".smobj", *YARNS)) != ".smobj":
            content = face_yarns(content).yarns
        if isinstance(content, YarnSet):
            write_yarns(self.output, content, tiles=self.tile)
        elif isinstance(content, FaceMesh):
            write_face_mesh(self.output, content)
        elif self.tile is not None:
            raise ParameterError(f"tile: {self.file} is a {kind_of(content)}; only periodic yarns can be tiled")
        elif isinstance(content, StitchMesh) and suffix_of(self.output, (*WRITABLE, *FORMATS)) in WRITABLE:
            write_stitches(self.output, content)
        else:
            write_mesh(self.output, content)
        repeats = "" if self.tile is None else f", {self.tile[0]} x {self.tile[1]} repeats of it"
        say(f"Wrote {self.output}: {in_brief(content)}{repeats}.")
