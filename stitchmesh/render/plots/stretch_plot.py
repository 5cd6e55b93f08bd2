# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Plot of a stretch curve: tension, and the transverse size, against the strain."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.stretch import NEWTONS_PER_METRE, StretchCurve
from stitchmesh.render.plots.plot_file import DASHES, INK, PALE_INK, plot_file, style_axes
from stitchmesh.yarn.colours import DYES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ALONG = {"course": "along the courses", "wale": "along the wales"}
"""Names of the directions in labels."""


def plot_stretch(curve: StretchCurve, path: FilePath) -> None:
    """Draw the tensions of a stretch curve, and the transverse size if it is free.

    Args:
        curve: result of a stretch test.
        path: a ``.png`` file; missing folders are created.

    Raises:
        FileError: the picture cannot be written.
    """
    free = curve.other == "free"
    with plot_file(path, (7.0, 6.0 if free else 4.2)) as figure:
        panels = figure.subplots(1 + free, 1, sharex=True, squeeze=False)[:, 0]
        _draw_tension(panels[0], curve)
        if free:
            _draw_other(panels[1], curve)
        panels[-1].set_xlabel(f"strain {ALONG[curve.direction]} [%]", color=PALE_INK)
        figure.suptitle(_summary(curve), x=0.01, ha="left", fontsize=11, color=INK)


def _draw_tension(axes: Axes, curve: StretchCurve) -> None:
    """Draw the tension along the stretch, the transverse tension if that size is held, and snaps as dashed lines."""
    percent = _percent(curve)
    names = ("course", "wale") if curve.other == "held" else (curve.direction,)
    for name, dye in zip(names, DYES, strict=False):
        tension = curve.column(f"{name}_tension")
        axes.plot(percent, tension, color=tuple(dye), linewidth=1.6, marker="o", markersize=4, label=ALONG[name])
    for number, point in enumerate(curve.snaps):
        place = (percent[point - 1] + percent[point]) / 2
        label = "snap to another shape" if number == 0 else None
        axes.axvline(place, color=PALE_INK, linewidth=1.0, linestyle=DASHES, label=label)
    axes.axhline(0.0, color=PALE_INK, linewidth=0.8)
    axes.legend(frameon=False, fontsize=9, labelcolor=INK)
    style_axes(axes, "tension [dyn/cm]")
    newtons = axes.secondary_yaxis("right", functions=(_in_newtons, _in_dynes))
    newtons.set_ylabel("tension [N/m]", color=PALE_INK)
    newtons.tick_params(colors=PALE_INK, labelsize=9)
    newtons.spines[:].set_color(PALE_INK)


def _draw_other(axes: Axes, curve: StretchCurve) -> None:
    """Draw the relative change of the free transverse size."""
    width, height = size_of(curve.free.lattice)
    name, size, rest = ("height", curve.column("height"), height) if curve.direction == "course" else (
        "width", curve.column("width"), width)  # fmt: skip
    axes.plot(_percent(curve), 100.0 * (size / rest - 1.0), color=INK, linewidth=1.6, marker="o", markersize=4)
    style_axes(axes, f"change of {name} [%]")


def _summary(curve: StretchCurve) -> str:
    width, height = size_of(curve.free.lattice)
    across = "wale" if curve.direction == "course" else "course"
    fabric = f"free cell {width:.3g} x {height:.3g} cm"
    return f"{fabric}, stretched {ALONG[curve.direction]}, {curve.other} {ALONG[across]}"


def _percent(curve: StretchCurve) -> FloatArray:
    return 100.0 * curve.column("strain")


def _in_newtons(tension: Any) -> Any:
    return tension * NEWTONS_PER_METRE


def _in_dynes(tension: Any) -> Any:
    return tension / NEWTONS_PER_METRE
