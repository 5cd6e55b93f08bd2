# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands for single stages between the rows and the yarns: ``tessellate``, ``relax-mesh`` and ``yarns``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, UseAppendAction

from stitchmesh.cli.options import (
    READ_STITCHES,
    WRITTEN_STITCHES,
    WRITTEN_YARNS,
    DrawnRadius,
    Overwrite,
    QualityName,
    StitchWidth,
    YarnName,
    YarnRadius,
)
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.io.mesh_reading import MeshReading
from stitchmesh.meshrelax.options import MeshRelaxOptions
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.recipe.sections import StitchesSection, YarnAndGauge
from stitchmesh.tessellate import STITCH_WIDTH, tessellate
from stitchmesh.yarn.stitch_size import stitch_size
from stitchmesh.yarngen.finish import YarnFinish

if TYPE_CHECKING:
    from stitchmesh.mesh import Mesh


@dataclass(frozen=True)
class TessellateCommand:
    """Divide a labeled mesh into stitches."""

    labeled: Annotated[Positional[str], help_entry("LABELED")]
    """labeled mesh, from `stitchmesh label`"""
    output: Annotated[str, help_entry("FILE", short="-o", help=WRITTEN_STITCHES)]
    stitch_width: StitchWidth = None
    yarn: YarnAndGauge = field(default_factory=YarnAndGauge)
    stitches: StitchesSection = field(default_factory=StitchesSection)
    overwrite: Overwrite = False

    def run(self) -> None:
        """Divide the panels into stitch faces, and write the stitch mesh."""
        from stitchmesh.io import read_stitches, write_stitches
        from stitchmesh.mesh.shaping_stitches import stitch_counts
        from stitchmesh.tessellate.counts import reached_sizes

        size = self.yarn.measures(stitch_width=self.stitch_width, stitch_height=self.stitches.course_height)
        labeled = read_stitches(self.labeled)
        width = STITCH_WIDTH if size.stitch_width is None else size.stitch_width
        edges = self.stitches.edge_settings()
        fabric = tessellate(
            labeled, stitch_width=width, stitch_height=size.stitch_height, counts=edges.counts, marked=edges.marked,
            increase=self.stitches.increase,
        )  # fmt: skip
        write_stitches(self.output, fabric)
        say(", ".join(f"{count} {name}" for name, count in stitch_counts(fabric).items()))
        for name, reached in reached_sizes(fabric).items():
            spread = f"{reached['p5']:.3g} to {reached['p95']:.3g} cm from the 5th to the 95th percentile"
            say(f"stitch {name.removesuffix('_cm')}: {reached['median']:.3g} cm (median), {spread}")


@dataclass(frozen=True)
class RelaxMeshCommand:
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


@dataclass(frozen=True)
class YarnsCommand:
    """Generate yarn curves from a stitch mesh."""

    fabric: Annotated[Positional[str], help_entry("FABRIC", help=READ_STITCHES)]
    output: Annotated[str, help_entry("FILE", short="-o", help=WRITTEN_YARNS)]
    yarn: YarnName = None
    yarn_radius: YarnRadius = None
    drawn_radius: DrawnRadius = None
    faces: Annotated[UseAppendAction[tuple[str, ...]], help_entry("SF", "none")] = ()
    """library of drawn faces (.sf), for the faces of an .smobj file that are no stitches; may be repeated"""
    quality: QualityName = DEFAULT_QUALITY
    finish: YarnFinish = field(default_factory=YarnFinish)
    overwrite: Overwrite = False

    def run(self) -> None:
        """Generate the yarns, and write them."""
        from stitchmesh.io import read_stitches, write_yarns
        from stitchmesh.io.contents import suffix_of
        from stitchmesh.io.stitch_formats.face_libraries import read_face_libraries
        from stitchmesh.io.stitch_formats.face_meshes import holds_foreign_faces, read_face_mesh
        from stitchmesh.io.stitches import READABLE
        from stitchmesh.io.yarn_files import yarn_of
        from stitchmesh.yarngen import generate_yarns
        from stitchmesh.yarngen.face_yarns.generate import face_yarns

        yarn = None if self.yarn is None else yarn_of(self.yarn)
        size = stitch_size(yarn, yarn_radius=self.yarn_radius, drawn_radius=self.drawn_radius)
        if self.faces or (suffix_of(self.fabric, READABLE) == ".smobj" and holds_foreign_faces(self.fabric)):
            library = read_face_libraries(self.faces)
            yarns = face_yarns(
                read_face_mesh(self.fabric), library, yarn_radius=size.yarn_radius, quality=self.quality
            ).yarns
        else:
            yarns = generate_yarns(
                read_stitches(self.fabric), yarn_radius=size.yarn_radius, drawn_radius=size.drawn_radius,
                mass_per_length=size.mass_per_length, quality=self.quality, finish=self.finish,
            )  # fmt: skip
        write_yarns(self.output, yarns)
        say(f"{yarns.yarn_count} yarns, {len(yarns.points)} control points, {yarns.lengths.sum():.1f} cm")
