# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Plot of what the presets of quality cost and how far they are from the finest one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stitchmesh.io.contents import FilePath
from stitchmesh.measuring import Measured, PresetMeasure
from stitchmesh.progress import STAGE_TEXTS
from stitchmesh.render.plots.plot_file import DASHES, GRID, INK, PALE_INK, plot_file, style_axes
from stitchmesh.yarn.colours import DYES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

KINDS = {"rms": "distance, rms [yarn radii]", "wale_spacing": "width of a stitch",
         "course_spacing": "height of a stitch", "energy": "energy"}  # fmt: skip
"""Fields of an ``ErrorOfPreset`` that are drawn, with their labels."""
LEAST_PART = 2.0
"""A stage that takes less of the time of all presets is among the others [%]."""
LEAST = 1e-6
"""A smaller error is drawn as this one."""


def plot_measures(measured: Measured, path: FilePath) -> None:
    """Draw the errors of the presets against their times, and the times of their stages.

    Args:
        measured: the measures of at least one preset.
        path: a ``.png`` file; missing folders are created.

    Raises:
        FileError: the picture cannot be written.
    """
    with plot_file(path, (9.0, 4.2)) as figure:
        left, right = figure.subplots(1, 2, width_ratios=(1.2, 1.0))
        _draw_errors(left, measured.presets)
        _draw_stages(right, measured.presets)
        title = f"{measured.piece} on {measured.device}"
        figure.suptitle(title, x=0.01, ha="left", fontsize=11, color=INK)


def _draw_errors(axes: Axes, presets: tuple[PresetMeasure, ...]) -> None:
    """Draw a point for each kind of error of each preset, and the time of the finest preset as a line."""
    *others, finest = presets
    for (name, label), dye, marker in zip(KINDS.items(), DYES, "os^D", strict=False):
        errors = [getattr(each.error, name) for each in others]
        known = [each.seconds for each, error in zip(others, errors, strict=True) if error is not None]
        values = [max(error, LEAST) for error in errors if error is not None]
        axes.plot(known, values, color=tuple(dye), marker=marker, markersize=5, linewidth=1.2, label=label)
    axes.set_xscale("log")
    if others:
        axes.set_yscale("log")
    times = [each.seconds for each in presets]
    axes.set_xlim(min(times) / 1.6, max(times) * 1.6)
    for each in presets:
        axes.axvline(each.seconds, color=PALE_INK, linewidth=0.8, linestyle=DASHES, zorder=0)
        axes.annotate(
            each.quality, (each.seconds, 1.01), xycoords=("data", "axes fraction"), ha="left", va="bottom",
            fontsize=9, color=PALE_INK, rotation=25,
        )  # fmt: skip
    axes.set_xlabel("time [s]", color=PALE_INK)
    axes.set_xticks(times, [f"{seconds:.3g}" for seconds in times])
    axes.minorticks_off()
    style_axes(axes, f"difference from {finest.quality}, relative or in radii")
    if others:
        axes.legend(frameon=False, fontsize=8, labelcolor=INK, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)


def _draw_stages(axes: Axes, presets: tuple[PresetMeasure, ...]) -> None:
    """Draw a bar for each preset, divided into the times of its stages in percent; short stages together are others."""
    shares = {name: [100.0 * each.stages.get(name, 0.0) / each.seconds for each in presets]
              for each in presets for name in each.stages}  # fmt: skip
    longest = sorted(shares, key=lambda name: -max(shares[name]))[: len(DYES)]
    names = [name for name in shares if name in longest and max(shares[name]) >= LEAST_PART]
    places = range(len(presets))
    begun = [0.0] * len(presets)
    for number, name in enumerate(names):
        axes.barh(
            places, shares[name], left=begun, color=tuple(DYES[number]), height=0.6, label=STAGE_TEXTS.get(name, name)
        )  # fmt: skip
        begun = [first + part for first, part in zip(begun, shares[name], strict=True)]
    axes.barh(places, [100.0 - first for first in begun], left=begun, color=GRID, height=0.6, label="others")
    axes.set_yticks(list(places), [f"{each.quality}\n{each.seconds:.3g} s" for each in presets])
    axes.invert_yaxis()
    style_axes(axes, "")
    axes.set_xlabel("part of the time [%]", color=PALE_INK)
    axes.legend(frameon=False, fontsize=8, labelcolor=INK, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
