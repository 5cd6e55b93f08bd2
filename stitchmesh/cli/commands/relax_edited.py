# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``relax-edited``."""

from __future__ import annotations

import logging
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional

from stitchmesh.cli.options import (
    READ_STITCHES,
    WRITTEN_YARNS,
    Device,
    KeptRun,
    Overwrite,
    QualityName,
    ReportFolder,
    Threads,
)
from stitchmesh.cli.relax_to_file import checkpoint_folder, relax_to_file
from stitchmesh.cli.summary import AsJson
from stitchmesh.cli.words import help_entry
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.recipe.sections import MaterialSection, PhysicsSection, SolverSection
from stitchmesh.yarn.rest_length import RestLengths
from stitchmesh.yarngen.finish import YarnFinish

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class RelaxEdited:
    """Relax yarns after an edit, starting from the relaxed yarns before it."""

    yarns: Annotated[Positional[str], help_entry("YARNS")]
    """relaxed yarns of the fabric before the edit: .h5"""
    before: Annotated[str, help_entry("FABRIC", help=f"{READ_STITCHES}, before the edit")]
    after: Annotated[str, help_entry("FABRIC", help=f"{READ_STITCHES}, after the edit; the yarns keep its shape")]
    output: Annotated[str, help_entry("FILE", short="-o", help=WRITTEN_YARNS)]
    surface: Annotated[str | None, help_entry("LABELED", "the fabric before the edit")] = None
    """labeled mesh, on whose surface stitches around the edit are evened out if they are too crowded"""
    report: ReportFolder = None
    json: AsJson = False
    quality: QualityName = DEFAULT_QUALITY
    device: Device = None
    threads: Threads = None
    finish: YarnFinish = field(default_factory=YarnFinish)
    physics: PhysicsSection = field(default_factory=PhysicsSection)
    material: MaterialSection = field(default_factory=MaterialSection)
    solver: SolverSection = field(default_factory=SolverSection)
    kept: KeptRun = field(default_factory=KeptRun)
    overwrite: Overwrite = False

    def run(self) -> None:
        """Generate the yarns of the edited fabric, relax them, and write them."""
        from stitchmesh.after_edit import relax_edited
        from stitchmesh.io import read_stitches, read_yarns, write_stitches
        from stitchmesh.io.yarns import check_writable
        from stitchmesh.recipe.recipe import relax_options

        quality = self.solver.quality(self.quality)
        options = relax_options(self.material, self.physics, RestLengths())
        kept = self.kept.run(checkpoint_folder(self.output))
        relaxed = read_yarns(self.yarns)
        check_writable(self.output, relaxed)
        before, after = read_stitches(self.before), read_stitches(self.after)
        relax = partial(
            relax_edited, relaxed, before, after, quality=quality, device=self.device, options=options,
            finish=self.finish, surface=None if self.surface is None else read_stitches(self.surface),
        )  # fmt: skip
        made = relax_to_file(self.output, self.report, None, relax, kept, quality=quality, as_json=self.json)
        if made.fabric is not after:
            evened = Path(self.output).with_suffix(".stitches.h5")
            write_stitches(evened, made.fabric)
            logger.info(f"{evened}: the fabric of these yarns, evened out around the edit, for the next edit")
