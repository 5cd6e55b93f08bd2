# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``relax-edited``."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.arguments import shown
from stitchmesh.cli.options import (
    READ_STITCHES,
    WRITTEN_YARNS,
    Device,
    MorePhysics,
    QualityName,
    ReportFolder,
    SolverOptions,
)
from stitchmesh.cli.relax_to_file import checkpoint_folder, relax_to_file
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.yarn.rest_length import RestLengths
from stitchmesh.yarngen.finish import YarnFinish


@dataclass(frozen=True)
class RelaxEdited:
    """Relax yarns again after an edit, from where they were at rest."""

    yarns: Annotated[Positional[str], shown("YARNS")]
    """yarns at rest before the edit: .h5"""
    before: Annotated[str, shown("FABRIC", help=f"{READ_STITCHES}, that the yarns were made from")]
    after: Annotated[str, shown("FABRIC", help=f"{READ_STITCHES}, edited; the yarns keep its shape")]
    output: Annotated[str, shown("FILE", short="-o", help=WRITTEN_YARNS)]
    report: ReportFolder = None
    quality: QualityName = DEFAULT_QUALITY
    device: Device = None
    finish: YarnFinish = field(default_factory=YarnFinish)
    physics: MorePhysics = field(default_factory=MorePhysics)
    solver: SolverOptions = field(default_factory=SolverOptions)

    def run(self) -> None:
        """Yarns of an edited fabric, relaxed from where those of the fabric before were at rest."""
        from stitchmesh.io import read_stitches, read_yarns
        from stitchmesh.io.yarns import check_writable
        from stitchmesh.yarngen import regenerate_yarns

        quality = self.solver.quality(self.quality)
        options = self.solver.relax_options(self.physics, RestLengths(), checkpoint_folder(self.output))
        rested = read_yarns(self.yarns)
        check_writable(self.output, rested)
        before, after = read_stitches(self.before), read_stitches(self.after)
        made, start = regenerate_yarns(rested, before, after, quality=quality, **asdict(self.finish))
        relax_to_file(
            self.output, self.report, made, options, quality=quality, device=self.device, fabric=after,
            keep_shape=True, start=start,
        )  # fmt: skip
