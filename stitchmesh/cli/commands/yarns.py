# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``yarns``."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.arguments import shown
from stitchmesh.cli.options import GENERATED_RADIUS, READ_STITCHES, WRITTEN_YARNS, QualityName
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.yarngen.finish import YarnFinish


@dataclass(frozen=True)
class Yarns:
    """Turn stitches into yarn curves."""

    fabric: Annotated[Positional[str], shown("FABRIC", help=READ_STITCHES)]
    output: Annotated[str, shown("FILE", short="-o", help=WRITTEN_YARNS)]
    yarn_radius: Annotated[float | None, shown("CM", GENERATED_RADIUS)] = None
    """yarn radius [cm]"""
    quality: QualityName = DEFAULT_QUALITY
    finish: YarnFinish = field(default_factory=YarnFinish)

    def run(self) -> None:
        """Yarn curves."""
        from stitchmesh.io import read_stitches, write_yarns
        from stitchmesh.yarngen import generate_yarns

        fabric = read_stitches(self.fabric)
        made = generate_yarns(fabric, yarn_radius=self.yarn_radius, quality=self.quality, **asdict(self.finish))
        write_yarns(self.output, made)
        print(f"{made.yarn_count} yarns, {len(made.points)} control points, {made.lengths.sum():.1f} cm")
