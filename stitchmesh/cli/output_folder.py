# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The output folder of a command, and the pictures that are written to it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from stitchmesh.budget.budget import POINT_OF_PICTURE, START_OF_RENDERER
from stitchmesh.cli.say import say
from stitchmesh.errors import DisplayError, FileError, LabelError
from stitchmesh.io.disk_refusal import refusal
from stitchmesh.io.history import HistoryEntry
from stitchmesh.io.outputs import plan_outputs
from stitchmesh.io.part_folder import PartFolder, remove_stale_parts
from stitchmesh.io.path_kind import is_there
from stitchmesh.quality import Quality, quality_named

if TYPE_CHECKING:
    from stitchmesh.yarn import YarnSet

REMEDY = "knit it with --auto"
"""What helps a mesh of any kind that cannot be labeled: rows are found on it without labels."""


@contextmanager
def output_folder(name: str, outputs: Iterable[str] = ()) -> Iterator[Path]:
    """Make the output folder and check that it can be written, before a long computation starts.

    Parts of files that a killed run has left there are removed. If the folder is new and still empty when the block
    ends, for example because of an error, it is removed too.

    Args:
        name: path of the folder.
        outputs: names of the files that the command writes into it.

    Raises:
        FileError: the folder cannot be made or written, a file in it may not be replaced (``stitchmesh.io.outputs``),
            or another program removes it while the block runs.
    """
    folder = Path(name)
    made = not is_there(folder)  # Also raises the error of a name that no folder can have.
    plan_outputs([folder / output for output in outputs], folder=folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        remove_stale_parts(folder)
        PartFolder(folder).remove()
        number = folder.stat().st_ino
    except OSError as error:
        raise FileError(f"{name}: cannot be written {refusal(error)}") from error
    try:
        yield folder
        if not folder.exists() or folder.stat().st_ino != number:
            raise FileError(f"{name}: was removed while the command ran, with files of it; run the command again")
    finally:
        if made:
            with suppress(OSError):  # It holds files.
                folder.rmdir()


def plot_history(history: Sequence[HistoryEntry], folder: Path, quality: str | Quality) -> None:
    """Draw the convergence of a relaxation as ``convergence.png``."""
    from stitchmesh.render.plots.convergence_plot import plot_convergence

    plot_convergence(history, folder / "convergence.png", tolerance=quality_named(quality).tolerance)


def draw_if_possible(draw: Callable[[], None]) -> bool:
    """Draw a picture; if this machine cannot draw, print the reason and continue, because all other files exist.

    Returns:
        Whether the picture was drawn.
    """
    try:
        draw()
    except DisplayError as error:
        say(f"no picture: {error}", file=sys.stderr)
        return False
    return True


def picture_seconds(yarns: YarnSet) -> float:
    """Estimate the time to draw a picture of yarns [s], for the progress of the work before the picture."""
    return START_OF_RENDERER + POINT_OF_PICTURE * len(yarns.points)


@contextmanager
def faults_drawn(folder: Path, remedy: str = REMEDY) -> Iterator[None]:
    """Draw the faces at fault if a mesh cannot be labeled in this block, and name the picture in the error.

    Args:
        folder: folder of the picture.
        remedy: what to do instead of labeling the mesh, for the error.

    Raises:
        LabelError: the error of the block with the remedy, and with the name of the picture if this machine can draw
            pictures.
    """
    try:
        yield
    except LabelError as error:
        from stitchmesh.labeling import PartialLabeling

        if not isinstance(error.labeling, PartialLabeling):
            raise
        from stitchmesh.render.labeling_picture import render_labeling

        picture = folder / "labeling-faults.png"
        message = f"{remedy}, which finds rows where a mesh has none; or change the mesh: {error}"
        try:
            render_labeling(error.labeling, picture)
        except DisplayError:
            raise LabelError(message, labeling=error.labeling) from error
        raise LabelError(f"{message}; {picture} shows the faces", labeling=error.labeling) from error
