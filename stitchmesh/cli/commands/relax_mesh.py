# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``relax-mesh``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional

from stitchmesh.cli.options import READ_STITCHES, WRITTEN_STITCHES, Overwrite
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.io.mesh_reading import MeshReading
from stitchmesh.meshrelax.options import MeshRelaxOptions

if TYPE_CHECKING:
    from stitchmesh.mesh import Mesh


@dataclass(frozen=True)
class RelaxMesh:
    """Relax the stitches of a stitch mesh on the surface of the garment."""

    fabric: Annotated[Positional[str], help_entry("FABRIC", help=READ_STITCHES)]
    surface: Annotated[str, help_entry("LABELED|MESH")]
    """labeled mesh, from `stitchmesh label`, or the polygon mesh that it was made for"""
    output: Annotated[str, help_entry("FILE", short="-o", help=WRITTEN_STITCHES)]
    in_file: MeshReading = field(default_factory=MeshReading)
    forces: MeshRelaxOptions = field(default_factory=MeshRelaxOptions)
    overwrite: Overwrite = False

    def run(self) -> None:
        """Relax the stitch mesh on the smooth surface, and write it."""
        from stitchmesh.cli.progress import show_progress
        from stitchmesh.io import read_stitches, write_stitches
        from stitchmesh.meshrelax import relax_mesh
        from stitchmesh.run import Run

        fabric, surface = read_stitches(self.fabric), self._surface()
        with show_progress() as progress:
            relaxed = relax_mesh(fabric, surface=surface, options=self.forces, run=Run(progress))
        report = relaxed.report
        write_stitches(self.output, relaxed.fabric)
        stretch = f"stretch: rms {report.rms_stretch:.3f}, maximum {report.max_stretch:.3f}"
        say(f"{report.iterations} iterations, {stretch}")

    def _surface(self) -> Mesh:
        """Read the surface; a polygon mesh is repaired and turned, as it is where rows are found on it."""
        from stitchmesh.io import read_stitches
        from stitchmesh.io.garments import read_garment
        from stitchmesh.io.stitches import READABLE

        if self.surface.lower().endswith(READABLE):
            return read_stitches(self.surface)
        return read_garment(self.surface, self.in_file, repaired=True).mesh
