# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``tessellate``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.options import WRITTEN_STITCHES, Overwrite, StitchWidth
from stitchmesh.cli.say import say
from stitchmesh.cli.words import help_entry
from stitchmesh.recipe.sections import StitchesSection, YarnAndGauge
from stitchmesh.tessellate import STITCH_WIDTH, tessellate


@dataclass(frozen=True)
class Tessellate:
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
