# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``tessellate``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.arguments import help_entry
from stitchmesh.cli.options import WRITTEN_STITCHES, StitchWidth, YarnAndGauge
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING, STITCH_WIDTH, tessellate


@dataclass(frozen=True)
class Tessellate:
    """Divide a labeled mesh into stitches."""

    labeled: Annotated[Positional[str], help_entry("LABELED")]
    """labeled mesh, from `stitchmesh label`"""
    output: Annotated[str, help_entry("FILE", short="-o", help=WRITTEN_STITCHES)]
    stitch_width: StitchWidth = None
    stitch_height: Annotated[float | None, help_entry("CM", f"{COURSE_OVER_WALE_SPACING} stitch widths")] = None
    """course spacing [cm]"""
    yarn: YarnAndGauge = field(default_factory=YarnAndGauge)

    def run(self) -> None:
        """Divide the panels into stitch faces, and write the stitch mesh."""
        from stitchmesh.io import read_stitches, write_stitches
        from stitchmesh.mesh.stitch_counts import stitch_counts

        size = self.yarn.size(stitch_width=self.stitch_width, stitch_height=self.stitch_height)
        labeled = read_stitches(self.labeled)
        width = STITCH_WIDTH if size.stitch_width is None else size.stitch_width
        fabric = tessellate(labeled, stitch_width=width, stitch_height=size.stitch_height)
        write_stitches(self.output, fabric)
        print(", ".join(f"{count} {name}" for name, count in stitch_counts(fabric).items()))
