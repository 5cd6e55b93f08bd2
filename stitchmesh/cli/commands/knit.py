# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``knit``."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.arguments import Flag, help_entry
from stitchmesh.cli.options import (
    GENERATED_RADIUS,
    Device,
    MaterialOptions,
    MeshRelaxation,
    MorePhysics,
    QualityName,
    RestLengthFactors,
    Rows,
    SolverOptions,
    StitchCounts,
    StitchWidth,
    Unit,
    YarnAndGauge,
)
from stitchmesh.cli.output_folder import draw_if_possible, output_folder, plot_history
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.patterns.placement.columns import DEFAULT_REMAINDER, check_remainder
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.tessellate import STITCH_WIDTH
from stitchmesh.yarngen.finish import YarnFinish


@dataclass(frozen=True)
class Knit:
    """Make relaxed yarns, a picture and a report from a polygon mesh."""

    mesh: Annotated[Positional[str], help_entry("MESH")]
    """polygon mesh: OBJ, PLY, OFF, STL, VTK ..."""
    output: Annotated[str, help_entry("DIR", short="-o")]
    """output folder for the stitches, the yarns, a picture, a report and the convergence"""
    unit: Unit = DEFAULT_UNIT
    stitch_width: StitchWidth = None
    pattern: Annotated[str | None, help_entry("NAME|FILE", "all knit")] = None
    """pattern of the stitches: a name of `stitchmesh patterns`, or a file"""
    pattern_remainder: Annotated[str, help_entry("HOW")] = DEFAULT_REMAINDER
    """treatment of stitches that remain beside whole tiles of the pattern: centre, stretch or refuse"""
    spiral: Flag = False
    """knit tubes in one spiral row with a single yarn instead of rings"""
    yarn_radius: Annotated[float | None, help_entry("CM", GENERATED_RADIUS)] = None
    """yarn radius [cm]"""
    quality: QualityName = DEFAULT_QUALITY
    device: Device = None
    no_picture: Flag = False
    """do not write preview.png"""
    yarn: YarnAndGauge = field(default_factory=YarnAndGauge)
    rows: Rows = field(default_factory=Rows)
    stitches: StitchCounts = field(default_factory=StitchCounts)
    mesh_relaxation: MeshRelaxation = field(default_factory=MeshRelaxation)
    finish: YarnFinish = field(default_factory=YarnFinish)
    material: MaterialOptions = field(default_factory=MaterialOptions)
    rest_lengths: RestLengthFactors = field(default_factory=RestLengthFactors)
    physics: MorePhysics = field(default_factory=MorePhysics)
    solver: SolverOptions = field(default_factory=SolverOptions)

    def run(self) -> None:
        """Run all stages, write their results, draw the pictures and print the report."""
        from stitchmesh.cli.progress import show_progress
        from stitchmesh.io import read_mesh
        from stitchmesh.patterns import read_pattern
        from stitchmesh.pipeline import KnitOptions, knit

        size = self.yarn.size(
            stitch_width=self.stitch_width, stitch_height=self.stitches.course_height, yarn_radius=self.yarn_radius
        )
        edges, lengths = self.stitches.edge_settings(), self.rest_lengths.rest_lengths(size.loop_length)
        options = KnitOptions(
            stitch_width=STITCH_WIDTH if size.stitch_width is None else size.stitch_width,
            stitch_height=size.stitch_height,
            counts=edges.counts,
            marked=edges.marked,
            mesh_relaxation=self.mesh_relaxation.mesh_relax_options(),
            yarn_radius=size.yarn_radius,
            quality=self.solver.quality(self.quality),
            device=self.device,
            seeds=self.rows.seed,
            flip=self.rows.flip,
            pattern=None if self.pattern is None else read_pattern(self.pattern),
            pattern_remainder=check_remainder(self.pattern_remainder),
            spiral=self.spiral,
            finish=self.finish,
            relaxation=self.solver.relax_options(self.physics, lengths, self.material, Path(self.output)),
        )
        with output_folder(self.output) as folder:
            mesh = read_mesh(self.mesh, unit=self.unit)
            with show_progress() as progress:
                made = knit(mesh, folder, options, progress=progress)
        plot_history(made.history, folder, options.quality)
        if not self.no_picture:
            from stitchmesh.render import render_yarns

            draw_if_possible(lambda: render_yarns(made.yarns, folder / "preview.png"))
        print(json.dumps(made.report, indent=2))
