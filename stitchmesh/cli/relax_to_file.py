# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The part that the commands ``relax`` and ``relax-edited`` share: relax yarns, and write the results."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from stitchmesh.cli.output_folder import output_folder, plot_history
from stitchmesh.cli.summary import print_result, relax_summary
from stitchmesh.io.atomic import write_json
from stitchmesh.io.history import write_history
from stitchmesh.quality import Quality

if TYPE_CHECKING:
    from stitchmesh.mesh import StitchMesh
    from stitchmesh.pipeline import RelaxOptions
    from stitchmesh.yarn import YarnSet


def checkpoint_folder(output: str) -> Path:
    """Return the folder of checkpoints: it is beside the output file and has the name of that file."""
    return Path(output).with_suffix(".checkpoints")


def relax_to_file(
    output: str, report: str | None, given: YarnSet, options: RelaxOptions, *, quality: str | Quality,
    device: str | None, fabric: StitchMesh | None, keep_shape: bool, start: YarnSet | None = None,
    as_json: bool = False,
) -> None:  # fmt: skip
    """Relax yarns and write them; after an interrupt, the last good state is written to the output file.

    Args:
        output: file for the relaxed yarns.
        report: folder for the report and the convergence; None writes neither.
        given: the yarns.
        options: options of the relaxation.
        quality: name of a preset, or a ``Quality``.
        device: Warp's name of the device; None for the preferred device.
        fabric: the fabric from which the yarns were made, if it is known.
        keep_shape: whether the relaxation keeps the borders and the shape of the fabric.
        start: the same yarns at the positions from which the relaxation starts; ``given`` if None.
        as_json: whether the report is printed instead of a summary.

    Raises:
        StitchMeshError: the relaxation cannot continue, or a file cannot be written.
    """
    from stitchmesh.cli.progress import show_progress
    from stitchmesh.io import write_yarns
    from stitchmesh.pipeline import relax_with_options

    last = [start or given]
    with ExitStack() as stack:
        stack.enter_context(output_folder(str(Path(output).parent)))
        folder = None if report is None else stack.enter_context(output_folder(report))
        progress = stack.enter_context(show_progress())
        try:
            relaxed = relax_with_options(
                given, options, quality=quality, device=device, fabric=fabric, keep_shape=keep_shape,
                start=start, progress=progress, on_state=lambda state: last.__setitem__(0, state),
            )  # fmt: skip
        except KeyboardInterrupt:
            write_yarns(output, last[0])
            if folder is not None:
                write_json(folder / "report.json", {"unfinished": True})
            raise
        write_yarns(output, relaxed.yarns)
        if folder is not None:
            write_json(folder / "report.json", relaxed.report)
            write_history(folder / "convergence.csv", relaxed.history)
            plot_history(relaxed.history, folder, quality)
    numbers = "--report DIR writes all numbers" if folder is None else f"{folder / 'report.json'} holds all numbers"
    lines = [*relax_summary(relaxed.yarns, relaxed.report), f"Wrote {output}; {numbers}."]
    print_result(relaxed.report, lines, as_json=as_json)
