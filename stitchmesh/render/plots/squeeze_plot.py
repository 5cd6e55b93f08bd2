# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Plot of a squeeze curve: thickness, and the flattening of the yarn, against the pressure."""

from __future__ import annotations

from stitchmesh.io.contents import FilePath
from stitchmesh.periodic.squeeze import SqueezeCurve
from stitchmesh.render.plots.plot_file import INK, PALE_INK, plot_file, style_axes
from stitchmesh.yarn.colours import DYES


def plot_squeeze(curve: SqueezeCurve, path: FilePath) -> None:
    """Draw the thickness, and the height of the flattest section over its width, over the pressure.

    Args:
        curve: result of a squeeze test.
        path: a ``.png`` file; missing folders are created.

    Raises:
        FileError: the picture cannot be written.
    """
    kilopascal = 1e-4 * curve.column("pressure")
    with plot_file(path, (7.0, 5.4)) as figure:
        panels = figure.subplots(2, 1, sharex=True)
        labels = {"thickness": "thickness [cm]", "flattening": "flattest section: height / width"}
        for axes, (name, label), dye in zip(panels, labels.items(), DYES, strict=False):
            axes.plot(kilopascal, curve.column(name), color=tuple(dye), linewidth=1.6, marker="o", markersize=4)
            style_axes(axes, label)
        panels[-1].set_xlabel("pressure [kPa]", color=PALE_INK)
        first, last = curve.points[0].thickness, curve.points[-1].thickness
        figure.suptitle(f"squeezed from {first:.3g} to {last:.3g} cm", x=0.01, ha="left", fontsize=11, color=INK)
