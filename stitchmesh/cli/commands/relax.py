# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``relax``."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Annotated

import tyro
from tyro.conf import Positional

from stitchmesh.cli.budget_options import BudgetOptions, ChosenQuality, exit_status
from stitchmesh.cli.options import (
    FOUND_RADIUS,
    READ_STITCHES,
    READ_YARNS,
    WRITTEN_YARNS,
    Device,
    KeptRun,
    Overwrite,
    PinnedPlaces,
    ReportFolder,
    Threads,
    Unit,
)
from stitchmesh.cli.relax_to_file import checkpoint_folder, relax_to_file
from stitchmesh.cli.summary import AsJson
from stitchmesh.cli.words import help_entry
from stitchmesh.errors import ParameterError
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.recipe.sections import MaterialSection, PhysicsSection, RestLengthsSection, SolverSection

FABRIC = tyro.conf.create_mutex_group(required=False, title="fabric")
"""Group of options of which at most one can be given."""


@dataclass(frozen=True)
class Relax:
    """Relax yarns by their physical forces."""

    yarns: Annotated[Positional[str], help_entry("YARNS", help=READ_YARNS)]
    output: Annotated[str, help_entry("FILE", short="-o", help=WRITTEN_YARNS)]
    report: ReportFolder = None
    json: AsJson = False
    keep_shape: Annotated[
        str | None, FABRIC, help_entry("FABRIC", "none", help=f"{READ_STITCHES}; the yarns keep its borders and shape")
    ] = None
    fabric: Annotated[
        str | None, FABRIC,
        help_entry("FABRIC", "none", help=f"{READ_STITCHES}, of which the yarns were made; its shape may change"),
    ] = None  # fmt: skip
    yarn_radius: Annotated[float | None, help_entry("CM", FOUND_RADIUS)] = None
    """yarn radius [cm]"""
    unit: Unit = DEFAULT_UNIT
    quality: ChosenQuality = None
    budget: BudgetOptions = field(default_factory=BudgetOptions)
    device: Device = None
    threads: Threads = None
    rest_lengths: RestLengthsSection = field(default_factory=RestLengthsSection)
    physics: PhysicsSection = field(default_factory=PhysicsSection)
    material: MaterialSection = field(default_factory=MaterialSection)
    solver: SolverSection = field(default_factory=SolverSection)
    kept: KeptRun = field(default_factory=KeptRun)
    pins: PinnedPlaces = field(default_factory=PinnedPlaces)
    overwrite: Overwrite = False

    def run(self) -> int | None:
        """Relax the yarns, write them and print a summary.

        Returns:
            The exit status if the time ended the relaxation, otherwise None.

        Raises:
            ParameterError: a fabric is given that nothing asks for.
        """
        from stitchmesh.io import read_stitches, read_yarns
        from stitchmesh.io.yarns import check_writable
        from stitchmesh.pipeline.yarn_relaxation import relax_with_options, relax_within_budget
        from stitchmesh.recipe.recipe import relax_options

        quality = self.solver.quality(self.quality or DEFAULT_QUALITY)
        budget = self.budget.budget(chooses=self.quality is None and quality == DEFAULT_QUALITY)
        given = read_yarns(self.yarns, unit=self.unit, radius=self.yarn_radius)
        lengths = self.rest_lengths.rest_lengths()
        kept = self.kept.run(checkpoint_folder(self.output))
        if self.fabric is not None and not lengths.need_fabric:
            raise ParameterError("fabric: no rest length asks for it; add --loop-length or --rest-length, or take "
                                 "--keep-shape")  # fmt: skip
        options = relax_options(self.material, self.physics, lengths)
        options = replace(options, terms=[*options.terms, *self.pins.constraints()])
        check_writable(self.output, given)
        shape = self.keep_shape or self.fabric
        how = relax_with_options if budget is None else partial(relax_within_budget, budget)
        relax = partial(
            how, given, options, quality=quality, device=self.device,
            fabric=None if shape is None else read_stitches(shape), keep_shape=self.keep_shape is not None,
        )  # fmt: skip
        relaxed = relax_to_file(self.output, self.report, given, relax, kept, quality=quality, as_json=self.json)
        return exit_status(relaxed.report)
