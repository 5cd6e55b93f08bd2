# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The part that the commands ``relax`` and ``relax-edited`` share: relax yarns, and write the results."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from stitchmesh.cli.budget_options import chosen_setting
from stitchmesh.cli.output_folder import output_folder, plot_history
from stitchmesh.cli.summary import print_result, relax_summary
from stitchmesh.io.atomic import write_json
from stitchmesh.io.history import write_history
from stitchmesh.quality import Quality

if TYPE_CHECKING:
    from stitchmesh.after_edit import RelaxedAgain
    from stitchmesh.run import Run
    from stitchmesh.yarn import YarnSet
    from stitchmesh.yarnrelax import Relaxation

REPORT_FILES = ("report.json", "convergence.csv", "convergence.png")
"""Files that are written into the folder of a report."""
T = TypeVar("T", "Relaxation", "RelaxedAgain")


def checkpoint_folder(output: str) -> Path:
    """Return the folder of checkpoints: it is beside the output file and has the name of that file.

    Raises:
        FileError: the output has no suffix of a format of yarns.
    """
    from stitchmesh.io.contents import suffix_of
    from stitchmesh.io.yarns import FORMATS

    suffix_of(output, FORMATS)
    return Path(output).with_suffix(".checkpoints")


def relax_to_file(
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
        folder = None if report is None else stack.enter_context(output_folder(report, REPORT_FILES))
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
