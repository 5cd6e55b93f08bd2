# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The output folder of a command, and the pictures that are written to it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from stitchmesh.budget.budget import POINT_OF_PICTURE, START_OF_RENDERER
from stitchmesh.errors import DisplayError, FileError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.quality import Quality, quality_named

if TYPE_CHECKING:
    from stitchmesh.yarn import YarnSet


@contextmanager
def output_folder(name: str) -> Iterator[Path]:
    """Make the output folder and check that it can be written, before a long computation starts.

    If the folder is new and still empty when the block ends, for example because of an error, it is removed.

    Raises:
        FileError: the folder cannot be made or written.
    """
    folder = Path(name)
    made = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".stitchmesh-probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise FileError(f"{name}: cannot be written ({error.strerror}); choose another output folder") from error
    try:
        yield folder
    finally:
        if made and not any(folder.iterdir()):
            folder.rmdir()


def plot_history(history: Sequence[HistoryEntry], folder: Path, quality: str | Quality) -> None:
    """Draw the convergence of a relaxation as ``convergence.png``."""
    from stitchmesh.render.convergence_plot import plot_convergence

    plot_convergence(history, folder / "convergence.png", tolerance=quality_named(quality).tolerance)


def draw_if_possible(draw: Callable[[], None]) -> bool:
    """Draw a picture; if this machine cannot draw, print the reason and continue, because all other files exist.

    Returns:
        Whether the picture was drawn.
    """
    try:
        draw()
    except DisplayError as error:
        print(f"no picture: {error}", file=sys.stderr)
        return False
    return True


def picture_seconds(yarns: YarnSet) -> float:
    """Estimate the time to draw a picture of yarns [s], for the progress of the work before the picture."""
    return START_OF_RENDERER + POINT_OF_PICTURE * len(yarns.points)
