# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Plot of a fitted yarn: the measured load-extension curves of its fabric beside the fitted ones."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stitchmesh.io.contents import FilePath
from stitchmesh.periodic.stretch import NEWTONS_PER_METRE
from stitchmesh.periodic.yarn_fit import FittedCurve, YarnFit
from stitchmesh.render.plots.plot_file import INK, PALE_INK, plot_file, style_axes
from stitchmesh.yarn.colours import DYES

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_fit(fit: YarnFit, path: FilePath) -> None:
    """Draw the measured curves as circles and the fitted ones as lines with points, and their differences below.

    Args:
        fit: a fit of at least one curve.
        path: a ``.png`` file; missing folders are created.

    Raises:
        FileError: the picture cannot be written.
    """
    with plot_file(path, (7.0, 6.0)) as figure:
        loads, differences = figure.subplots(2, 1, sharex=True, height_ratios=(2.5, 1.0))
        for curve, dye in zip(fit.curves, DYES, strict=False):
            _draw_curve(loads, differences, curve, tuple(dye))
        loads.legend(frameon=False, fontsize=9, labelcolor=INK)
        style_axes(loads, "load [N/m]")
        differences.axhline(0.0, color=PALE_INK, linewidth=0.8)
        style_axes(differences, "fitted minus measured,\npart of the largest [%]")
        differences.set_xlabel("strain [%]", color=PALE_INK)
        values = [each for each in fit.values if each.found]
        lines = [f"{each.name.replace('_', ' ')} {each.text}" for each in values]
        figure.suptitle("\n".join(lines), x=0.01, ha="left", fontsize=9, color=INK)


def _draw_curve(loads: Axes, differences: Axes, curve: FittedCurve, colour: tuple[float, ...]) -> None:
    """Draw one curve, and its difference from the measured one."""
    measured, held = curve.measured, ", the other size held" if curve.measured.other == "held" else ""
    loads.plot(
        100.0 * measured.strain, NEWTONS_PER_METRE * measured.tension, color=colour, linestyle="", marker="o",
        markersize=4, markerfacecolor="none", label=f"measured along the {measured.direction}s{held}",
    )  # fmt: skip
    percent = 100.0 * curve.strain
    loads.plot([0.0, *percent], [0.0, *(NEWTONS_PER_METRE * curve.tension)], color=colour, linewidth=1.2, marker=".",
               label=f"fitted, {100.0 * curve.error:.3g} % rms")  # fmt: skip
    part = 100.0 * (curve.tension - curve.expected) / abs(curve.expected).max()
    differences.plot(percent, part, color=colour, linewidth=1.2, marker="o", markersize=3)
