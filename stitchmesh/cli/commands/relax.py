# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands that relax yarns and write them into a file: ``relax`` and ``relax-edited``."""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import tyro
from tyro.conf import Positional

from stitchmesh.cli.budget_options import BudgetOptions, ChosenQuality, chosen_setting, exit_status
from stitchmesh.cli.options import (
    FOUND_RADIUS,
    READ_STITCHES,
    READ_YARNS,
    WRITTEN_YARNS,
    Device,
    KeptRun,
    Overwrite,
    PinnedPlaces,
    QualityName,
    ReportFolder,
    Threads,
    Unit,
)
from stitchmesh.cli.output_folder import output_folder, plot_history
from stitchmesh.cli.summary import AsJson, print_result, relax_summary
from stitchmesh.cli.words import Flag, help_entry
from stitchmesh.errors import ParameterError
from stitchmesh.io.atomic import write_json
from stitchmesh.io.history import write_history
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.quality import DEFAULT_QUALITY, Quality
from stitchmesh.recipe.sections import MaterialSection, PhysicsSection, RestLengthsSection, SolverSection
from stitchmesh.yarn.rest_length import RestLengths
from stitchmesh.yarngen.finish import YarnFinish

if TYPE_CHECKING:
    from stitchmesh.after_edit import RelaxedAgain
    from stitchmesh.run import Run
    from stitchmesh.yarn import YarnSet
    from stitchmesh.yarnrelax import Relaxation

FABRIC = tyro.conf.create_mutex_group(required=False, title="fabric")
"""Group of options of which at most one can be given."""
T = TypeVar("T", "Relaxation", "RelaxedAgain")
logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class RelaxCommand:
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
    even: Annotated[
        Flag, help_entry("", help="put control points at equal distances first: for the size of free yarns")
    ] = False
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
        from stitchmesh.periodic.sampling.even_sampling import sample_evenly
        from stitchmesh.pipeline.yarn_relaxation import relax_with_options, relax_within_budget
        from stitchmesh.recipe.recipe import relax_options

        quality = self.solver.quality(self.quality or DEFAULT_QUALITY)
        budget = self.budget.budget(chooses=self.quality is None and quality == DEFAULT_QUALITY)
        given = read_yarns(self.yarns, unit=self.unit, radius=self.yarn_radius)
        given = sample_evenly(given) if self.even else given
        lengths = self.rest_lengths.rest_lengths()
        kept = self.kept.run(_checkpoint_folder(self.output))
        if self.fabric is not None and not lengths.need_fabric:
            raise ParameterError("fabric: no rest length asks for it; add --loop-length or --rest-length, or take "
                                 "--keep-shape")  # fmt: skip
        options = relax_options(self.material, self.physics, lengths)
        keeps, terms = self.keep_shape is not None, [*options.terms, *self.pins.constraints()]
        options = replace(options, terms=terms, keep_shape=keeps)
        check_writable(self.output, given)
        shape = self.keep_shape or self.fabric
        how = relax_with_options if budget is None else partial(relax_within_budget, budget)
        relax = partial(
            how, given, options, quality=quality, device=self.device,
            fabric=None if shape is None else read_stitches(shape),
        )  # fmt: skip
        relaxed = _relax_to_file(self.output, self.report, given, relax, kept, quality=quality, as_json=self.json)
        return exit_status(relaxed.report)


@dataclass(frozen=True)
class RelaxEditedCommand:
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
        kept = self.kept.run(_checkpoint_folder(self.output))
        relaxed = read_yarns(self.yarns)
        check_writable(self.output, relaxed)
        before, after = read_stitches(self.before), read_stitches(self.after)
        relax = partial(
            relax_edited, relaxed, before, after, quality=quality, device=self.device, options=options,
            finish=self.finish, surface=None if self.surface is None else read_stitches(self.surface),
        )  # fmt: skip
        made = _relax_to_file(self.output, self.report, None, relax, kept, quality=quality, as_json=self.json)
        if made.fabric is not after:
            evened = Path(self.output).with_suffix(".stitches.h5")
            write_stitches(evened, made.fabric)
            logger.info(f"{evened}: the fabric of these yarns, evened out around the edit, for the next edit")


def _checkpoint_folder(output: str) -> Path:
    """Return the folder of checkpoints: it is beside the output file and has the name of that file.

    Raises:
        FileError: the output has no suffix of a format of yarns.
    """
    from stitchmesh.io.contents import suffix_of
    from stitchmesh.io.yarns import FORMATS

    suffix_of(output, FORMATS)
    return Path(output).with_suffix(".checkpoints")


def _relax_to_file(
    output: str, report: str | None, given: YarnSet | None, relax: Callable[..., T], run: Run[YarnSet], *,
    quality: str | Quality, as_json: bool = False,
) -> T:  # fmt: skip
    """Relax yarns and write them; after an interrupt, the last good state is written to the output file.

    Args:
        output: file for the relaxed yarns.
        report: folder for the report and the convergence; None writes neither.
        given: the yarns, which are written after an interrupt if there is no later state; None if nothing is to be
            written then.
        relax: function that relaxes the yarns; it takes the keyword argument ``run``.
        run: checkpoints of the relaxation.
        quality: name of a preset, or a ``Quality``.
        as_json: whether the report is printed instead of a summary.

    Returns:
        The result of ``relax``.

    Raises:
        StitchMeshError: the relaxation cannot continue, or a file cannot be written.
    """
    from stitchmesh.cli.progress import show_progress
    from stitchmesh.io import write_yarns

    last = [] if given is None else [given]

    def keep(state: YarnSet) -> None:
        last[:] = [state]

    with ExitStack() as stack:
        stack.enter_context(output_folder(str(Path(output).parent), [Path(output).name]))
        files = ("report.json", "convergence.csv", "convergence.png")
        folder = None if report is None else stack.enter_context(output_folder(report, files))
        progress = stack.enter_context(show_progress())
        try:
            relaxed: T = relax(run=replace(run, progress=progress, on_state=keep))
        except KeyboardInterrupt:
            for state in last:
                write_yarns(output, state)
            if folder is not None:
                write_json(folder / "report.json", {"unfinished": True})
            raise
        write_yarns(output, relaxed.yarns)
        if folder is not None:
            write_json(folder / "report.json", relaxed.report)
            write_history(folder / "convergence.csv", relaxed.history)
            plot_history(relaxed.history, folder, chosen_setting(relaxed.report) or quality)
    numbers = "--report DIR writes all numbers" if folder is None else f"{folder / 'report.json'} holds all numbers"
    lines = [*relax_summary(relaxed.yarns, relaxed.report), f"Wrote {output}; {numbers}."]
    print_result(relaxed.report, lines, as_json=as_json)
    return relaxed
