# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands that list what comes with the program: ``patterns`` and ``examples``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from stitchmesh.cli.options import Overwrite
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry


@dataclass(frozen=True)
class PatternsCommand:
    """List the patterns and weaves of the library."""

    def run(self) -> None:
        """Print a table of the knitting patterns and then of the weaves."""
        from stitchmesh.patterns import pattern_names, read_pattern
        from stitchmesh.periodic.weave.library import read_weave, weave_names

        width = max(map(len, (*pattern_names(), *weave_names())))
        say(f"{'name':{width}}    size  yarns  title; source")
        for name in pattern_names():
            found = read_pattern(name)
            size = f"{found.width} x {found.height}"
            say(f"{name:{width}}  {size:>7}  {found.yarn_count:5}  {found.name}; {found.source}")
        for name in weave_names():
            weave = read_weave(name)
            size = f"{len(weave.warps)} x {len(weave.wefts)}"
            say(f"{name:{width}}  {size:>7}  woven  {weave.name}; {weave.source}")


@dataclass(frozen=True)
class ExamplesCommand:
    """List the garments that come with the program, or write all examples."""

    output: Annotated[str | None, help_entry("DIR", "only a list", short="-o")] = None
    """folder for the recipes, the scenes and the meshes, where they lie as the documentation names them"""
    overwrite: Overwrite = False

    def run(self) -> None:
        """Print the names of the garments with their sizes, or write the files."""
        if self.output is None:
            self._list()
        else:
            self._write(Path(self.output))

    def _list(self) -> None:
        from stitchmesh.io.examples import example_names
        from stitchmesh.io.meshes import read_mesh
        from stitchmesh.mesh.polygon_mesh import extent

        names = example_names()
        width = max(map(len, names))
        for name in names:
            mesh = read_mesh(name)
            say(f"{name:{width}}  {mesh.face_count:5} faces  {extent(mesh.vertices)}")
        say("Knit one by its name: stitchmesh knit hat -o out/hat")
        say("Write the meshes, recipes and scenes into a folder: stitchmesh examples -o DIR")

    def _write(self, folder: Path) -> None:
        from stitchmesh.io.atomic import write_bytes
        from stitchmesh.io.contents import read_bytes
        from stitchmesh.io.examples import example_files

        files = example_files()
        for place, path in files.items():
            write_bytes(folder / place, read_bytes(path))
        say(f"Wrote {len(files)} files. In {folder}: stitchmesh knit examples/hat.toml -o out/hat")
