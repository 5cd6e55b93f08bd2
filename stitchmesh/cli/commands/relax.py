# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``relax``."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Annotated

import tyro
from tyro.conf import Positional

from stitchmesh.cli.arguments import shown
from stitchmesh.cli.options import (
    FOUND_RADIUS,
    READ_STITCHES,
    READ_YARNS,
    WRITTEN_YARNS,
    Device,
    MorePhysics,
    PinnedPlaces,
    QualityName,
    ReportFolder,
    RestLengthFactors,
    SolverOptions,
    Unit,
)
from stitchmesh.cli.relax_to_file import checkpoint_folder, relax_to_file
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.quality import DEFAULT_QUALITY

FABRIC = tyro.conf.create_mutex_group(required=False, title="fabric")
"""The yarns' fabric is given once."""


@dataclass(frozen=True)
class Relax:
    """Relax yarns physically."""

    yarns: Annotated[Positional[str], shown("YARNS", help=READ_YARNS)]
    output: Annotated[str, shown("FILE", short="-o", help=WRITTEN_YARNS)]
    report: ReportFolder = None
    keep_shape: Annotated[
        str | None, FABRIC, shown("FABRIC", "none", help=f"{READ_STITCHES}, whose shape the yarns keep")
    ] = None
    fabric: Annotated[
        str | None, FABRIC,
        shown("FABRIC", "none", help=f"{READ_STITCHES}, that the yarns were made from; its shape is not kept"),
    ] = None  # fmt: skip
    yarn_radius: Annotated[float | None, shown("CM", FOUND_RADIUS)] = None
    """yarn radius [cm]"""
    unit: Unit = DEFAULT_UNIT
    quality: QualityName = DEFAULT_QUALITY
    device: Device = None
    rest_lengths: RestLengthFactors = field(default_factory=RestLengthFactors)
    physics: MorePhysics = field(default_factory=MorePhysics)
    solver: SolverOptions = field(default_factory=SolverOptions)
    pins: PinnedPlaces = field(default_factory=PinnedPlaces)

    def run(self) -> None:
        """Relaxed yarns."""
        from stitchmesh.io import read_stitches, read_yarns
        from stitchmesh.io.yarns import check_writable

        quality = self.solver.quality(self.quality)
        given = read_yarns(self.yarns, unit=self.unit, radius=self.yarn_radius)
        lengths, checkpoints = self.rest_lengths.rest_lengths(), checkpoint_folder(self.output)
        options = self.solver.relax_options(self.physics, lengths, checkpoints)
        options = replace(options, constraints=self.pins.constraints())
        check_writable(self.output, given)
        shape = self.keep_shape or self.fabric
        relax_to_file(
            self.output, self.report, given, options, quality=quality, device=self.device,
            fabric=None if shape is None else read_stitches(shape), keep_shape=self.keep_shape is not None,
        )  # fmt: skip
