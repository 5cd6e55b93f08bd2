# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files with a plot, all in one style, which do not depend on files of settings in a folder or a home.

Matplotlib reads the file ``matplotlibrc`` of the present folder when it is imported, and PyVista imports it. Such a
file may ask for LaTeX, for example.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from stitchmesh.io.atomic import atomic_path
from stitchmesh.io.contents import FilePath

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, PALE_INK, GRID = "#26241f", "#7a756a", "#e4e0d6"
"""Colours of curves and text, of labels, and of grid lines."""
DASHES = (0, (5, 3))
"""Dashes of a line that is no curve."""


def import_matplotlib() -> None:
    """Import matplotlib as if the folder had no file of settings."""
    if "matplotlib" in sys.modules or not os.path.lexists("matplotlibrc"):
        return
    present = os.open(os.curdir, os.O_RDONLY)
    try:
        os.chdir(os.sep)
        import matplotlib  # noqa: F401
    finally:
        os.chdir(present)
        os.close(present)


@contextmanager
def own_settings() -> Iterator[None]:
    """Give matplotlib its default settings during a block."""
    import_matplotlib()
    import matplotlib

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        yield


@contextmanager
def plot_file(path: FilePath, size: tuple[float, float]) -> Iterator[Figure]:
    """Give an empty figure, which is written to a ``.png`` file when the block ends without an error.

    Args:
        path: the file; missing folders are created.
        size: width and height [inch].

    Raises:
        FileError: the file cannot be written.
    """
    with own_settings():
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=size, dpi=150, layout="constrained")
        yield figure
        with atomic_path(path) as temporary:
            FigureCanvasAgg(figure).print_png(str(temporary))


def style_axes(axes: Axes, name: str) -> None:
    """Give axes a pale grid, and their vertical axis a name."""
    axes.set_ylabel(name, color=PALE_INK)
    axes.grid(color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(which="both", colors=PALE_INK, labelsize=9)
    open_frame(axes)


def open_frame(axes: Axes) -> None:
    """Show only the left and the lower border of axes, in a pale colour."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(PALE_INK)
