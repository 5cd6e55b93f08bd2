# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``yarns``."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.arguments import help_entry
from stitchmesh.cli.options import DRAWN_RADIUS, GENERATED_RADIUS, READ_STITCHES, WRITTEN_YARNS, QualityName, YarnName
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.yarn.stitch_size import stitch_size
from stitchmesh.yarngen.finish import YarnFinish


@dataclass(frozen=True)
class Yarns:
    """Generate yarn curves from a stitch mesh."""

    fabric: Annotated[Positional[str], help_entry("FABRIC", help=READ_STITCHES)]
    output: Annotated[str, help_entry("FILE", short="-o", help=WRITTEN_YARNS)]
    yarn: YarnName = None
    yarn_radius: Annotated[float | None, help_entry("CM", GENERATED_RADIUS)] = None
    """yarn radius [cm]"""
    drawn_radius: Annotated[float | None, help_entry("CM", DRAWN_RADIUS)] = None
    """radius of the yarn in pictures and files for renderers [cm]"""
    quality: QualityName = DEFAULT_QUALITY
    finish: YarnFinish = field(default_factory=YarnFinish)

    def run(self) -> None:
        """Generate the yarns, and write them."""
        from stitchmesh.io import read_stitches, write_yarns
        from stitchmesh.yarngen import generate_yarns

        size = stitch_size(self.yarn, yarn_radius=self.yarn_radius, drawn_radius=self.drawn_radius)
        fabric = read_stitches(self.fabric)
        yarns = generate_yarns(
            fabric, yarn_radius=size.yarn_radius, drawn_radius=size.drawn_radius, quality=self.quality,
            **asdict(self.finish),
        )  # fmt: skip
        write_yarns(self.output, yarns)
        print(f"{yarns.yarn_count} yarns, {len(yarns.points)} control points, {yarns.lengths.sum():.1f} cm")
