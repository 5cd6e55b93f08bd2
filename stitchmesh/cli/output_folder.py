# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The folder that a command writes into, and the pictures that go there beside the numbers."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from stitchmesh.errors import DisplayError, FileError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.quality import Quality, quality_named


@contextmanager
def output_folder(name: str) -> Iterator[Path]:
    """The output folder, made before hours of work, so that they do not end at a closed door.

    Where the work is refused, a folder that was made for it and is still empty goes again.

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
    """Draw how yarns came to rest, as ``convergence.png``."""
    from stitchmesh.render.convergence_plot import plot_convergence

    plot_convergence(history, folder / "convergence.png", tolerance=quality_named(quality).tolerance)


def draw_if_possible(draw: Callable[[], None]) -> None:
    """Draw the picture of a run; a machine that cannot keeps its yarns and is told what it lacks."""
    try:
        draw()
    except DisplayError as error:
        print(f"no picture: {error}", file=sys.stderr)
