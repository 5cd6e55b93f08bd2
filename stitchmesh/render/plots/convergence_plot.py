# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Plot of the convergence of a relaxation: residual and energies against iterations and time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.io.contents import FilePath
from stitchmesh.io.history import HistoryEntry, energy_terms
from stitchmesh.mesh import FloatArray
from stitchmesh.render.plots.plot_file import DASHES, INK, PALE_INK, plot_file, style_axes
from stitchmesh.yarn.colours import DYES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STROKES = ("-", "--", ":")
"""Line styles of the energy terms; after all colours are used, the next style begins."""
ROUND_STEPS = [1, 2, 5, 10]
"""Leading digits of the distances between ticks."""


def plot_convergence(history: Sequence[HistoryEntry], path: FilePath, *, tolerance: float | None = None) -> None:
    """Draw the residual and the energies of a relaxation against its iterations, with seconds on a second axis.

    Args:
        history: assessments of the relaxation in order, at least one entry.
        path: a ``.png`` file; missing folders are created.
        tolerance: residual at which the relaxation has converged, drawn as a line.

    Raises:
        ParameterError: the history is empty.
        FileError: the picture cannot be written.
    """
    if not history:
        raise ParameterError("history: got no entries; expected at least one")
    with plot_file(path, (8.0, 6.0)) as figure:
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(1.0, 1.2))
        _mark_iterations(below, history)
        _mark_seconds(above, history)
        _draw_residual(above, history, tolerance)
        _draw_energies(below, history)
        figure.suptitle(_summary(history), x=0.01, ha="left", fontsize=11, color=INK)


def _draw_residual(axes: Axes, history: Sequence[HistoryEntry], tolerance: float | None) -> None:
    residual = _positive([entry["residual"] for entry in history])
    axes.plot(_iterations(history), residual, color=INK, linewidth=1.6, marker=_marker(history), markersize=4)
    if tolerance is not None:
        axes.axhline(tolerance, color=PALE_INK, linewidth=1.0, linestyle=DASHES)
        axes.annotate(
            f"tolerance {tolerance:g}", (0.0, tolerance), xycoords=("axes fraction", "data"), xytext=(4, 3),
            textcoords="offset points", ha="left", va="bottom", fontsize=9, color=PALE_INK,
        )  # fmt: skip
    _style_axes(axes, "relative force residual")


def _draw_energies(axes: Axes, history: Sequence[HistoryEntry]) -> None:
    """Draw one curve per term; the legend lists the terms in descending order of their last values."""
    _style_axes(axes, "energy [erg]")
    curves = {term: _positive([entry["energies"].get(term, np.nan) for entry in history])
              for term in energy_terms(history)}  # fmt: skip
    highest = {term: float(curve[np.isfinite(curve)].max(initial=0.0)) for term, curve in curves.items()}
    floor = max(highest.values(), default=0.0) / 10**6  # Smaller energies are not visible.
    lines = {}
    for number, term in enumerate(curves):
        if highest[term] > floor:
            lines[term] = axes.plot(
                _iterations(history), curves[term], color=tuple(DYES[number % len(DYES)]),
                linestyle=STROKES[number // len(DYES) % len(STROKES)], linewidth=1.6,
                marker=_marker(history), markersize=4,
            )[0]  # fmt: skip
    if lines:
        axes.set_ylim(bottom=max(axes.get_ylim()[0], floor))
        order = sorted(lines, key=lambda term: -float(np.nan_to_num(curves[term][-1])))
        axes.legend([lines[term] for term in order], order, frameon=False, fontsize=9, labelcolor=INK,
                    loc="center left", bbox_to_anchor=(1.0, 0.5))  # fmt: skip


def _mark_iterations(axes: Axes, history: Sequence[HistoryEntry]) -> None:
    """Set the limits of the iteration axis, with ticks at integer iterations."""
    from matplotlib.ticker import MaxNLocator

    iterations = _iterations(history)
    space = max(0.02 * float(np.ptp(iterations)), 0.5)
    axes.set_xlim(iterations.min() - space, iterations.max() + space)
    axes.xaxis.set_major_locator(MaxNLocator(8, steps=ROUND_STEPS, integer=True))
    axes.set_xlabel("iteration", color=PALE_INK)


def _mark_seconds(axes: Axes, history: Sequence[HistoryEntry]) -> None:
    """Add an upper axis with ticks at round seconds, placed at their iterations.

    The ticks are not equidistant if the time per iteration changes.
    """
    from matplotlib.ticker import MaxNLocator

    seconds = np.array([entry["seconds"] for entry in history], dtype=np.float64)
    ticks = np.asarray(MaxNLocator(8, steps=ROUND_STEPS).tick_values(seconds.min(), seconds.max()))
    ticks = ticks[(ticks >= seconds.min()) & (ticks <= seconds.max())]
    place = np.interp(ticks, seconds, _iterations(history))
    left, right = axes.get_xlim()
    apart = np.diff(place, prepend=-np.inf) > 0.04 * (right - left)  # Closer labels would touch.
    top = axes.twiny()
    top.set_xlim(left, right)
    top.set_xticks(place[apart], [f"{second:g}" for second in ticks[apart]])
    top.set_xlabel("time [s]", color=PALE_INK)
    top.tick_params(colors=PALE_INK, labelsize=9)
    top.spines[:].set_visible(False)


def _style_axes(axes: Axes, name: str) -> None:
    axes.set_yscale("log")
    style_axes(axes, name)


def _summary(history: Sequence[HistoryEntry]) -> str:
    last = history[-1]
    total = sum(last["energies"].values())
    return (
        f"residual {last['residual']:.3g}, energy {total:.4g} erg after {last['iteration']} iterations, "
        f"{last['seconds']:.3g} s"
    )


def _iterations(history: Sequence[HistoryEntry]) -> FloatArray:
    return np.array([entry["iteration"] for entry in history], dtype=np.float64)


def _marker(history: Sequence[HistoryEntry]) -> str:
    """Return the marker of each entry; many entries have none."""
    return "o" if len(history) <= 12 else ""


def _positive(values: Sequence[float]) -> FloatArray:
    """Return the positive finite values; all others become gaps, because a logarithmic axis cannot show them."""
    array = np.array(values, dtype=np.float64)
    return np.where(np.isfinite(array) & (array > 0.0), array, np.nan)
