# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What ``relax`` and ``relax-edited`` do after they have read their files."""

from __future__ import annotations

import json
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from stitchmesh.cli.output_folder import output_folder, plot_history
from stitchmesh.io.atomic import write_json
from stitchmesh.io.history import write_history
from stitchmesh.quality import Quality

if TYPE_CHECKING:
    from stitchmesh.mesh import StitchMesh
    from stitchmesh.pipeline import RelaxOptions
    from stitchmesh.yarn import YarnSet


def checkpoint_folder(output: str) -> Path:
    """Beside the output, in a folder of its name."""
    return Path(output).with_suffix(".checkpoints")


def relax_to_file(
    output: str, report: str | None, given: YarnSet, options: RelaxOptions, *, quality: str | Quality,
    device: str | None, fabric: StitchMesh | None, keep_shape: bool, start: YarnSet | None = None,
) -> None:  # fmt: skip
    """Relax yarns and write them; an interrupt leaves the last good state in the output file.

    Args:
        output: file for the yarns.
        report: folder for the report and the convergence, if it is asked for.
        given: the yarns.
        options: as for ``pipeline.relax_as_told``, and so are those that follow.
        quality: a preset or a ``Quality``.
        device: name of the processor.
        fabric: the fabric that the yarns were made from.
        keep_shape: whether its shape is kept.
        start: the same yarns in another place to start from.

    Raises:
        StitchMeshError: the relaxation cannot go on, or a file cannot be written.
    """
    from stitchmesh.cli.progress import on_terminal
    from stitchmesh.io import write_yarns
    from stitchmesh.pipeline import relax_as_told

    last = [start or given]
    with ExitStack() as stack:
        stack.enter_context(output_folder(str(Path(output).parent)))
        folder = None if report is None else stack.enter_context(output_folder(report))
        progress = stack.enter_context(on_terminal())
        try:
            relaxed = relax_as_told(
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
    print(json.dumps(relaxed.report, indent=2))
