# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The plot of a relaxation: energies at the top and the residual below, against the iterations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import plotly.graph_objects as go

from stitchmesh.io.history import HistoryEntry
from stitchmesh.markup import markup

MOST_POINTS = 400
"""Largest number of points of a curve; more are invisible, and each costs time at every update."""
COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442")
"""Colours of curves that colour-blind people can tell apart (Okabe and Ito)."""
DASHES = ("solid", "dash", "dot", "dashdot")
"""Dashes of curves, so that no user needs the colours."""
RESIDUAL, LIMIT = "#444444", "#d55e00"
"""Colours of the residual and of the residual at rest."""
LOGARITHMIC: dict[str, object] = {"type": "log", "dtick": 1, "exponentformat": "power"}
"""An axis with one mark for each power of ten."""


@dataclass(frozen=True)
class Assessed:
    """The figures of one assessment."""

    iteration: int
    residual: float
    energies: Mapping[str, float]
    """Energy of each term [erg]."""


def history_plot(history: Sequence[HistoryEntry], tolerance: float | None) -> go.Figure | None:
    """Return the plot of an ended relaxation; other arguments as for ``energy_plot``."""
    found = [Assessed(entry["iteration"], entry["residual"], entry["energies"]) for entry in history]
    return energy_plot(found, tolerance)


def energy_plot(assessed: Sequence[Assessed], tolerance: float | None) -> go.Figure | None:
    """Return the plot with the residual at rest if it is known; None while there are fewer than two assessments."""
    if len(assessed) < 2:
        return None
    chosen = [assessed[k] for k in np.unique(np.linspace(0, len(assessed) - 1, MOST_POINTS).astype(int)).tolist()]
    iterations = [entry.iteration for entry in chosen]
    names = dict.fromkeys(name for entry in chosen for name in entry.energies)
    # Some energies, such as that of gravity, have both signs, which a logarithmic axis cannot show.
    positive = all(energy >= 0.0 for entry in chosen for energy in entry.energies.values())
    figure = go.Figure()
    for number, name in enumerate(names):
        energies = [_microjoules(entry, name, logarithmic=positive) for entry in chosen]
        line = {"color": COLOURS[number % len(COLOURS)], "dash": DASHES[number % len(DASHES)], "width": 2}
        figure.add_scatter(x=iterations, y=energies, mode="lines", name=str(markup("{}", name)), line=line)
    below = {"mode": "lines", "yaxis": "y2", "showlegend": False}
    residuals = [max(entry.residual, 1e-12) for entry in chosen]
    figure.add_scatter(x=iterations, y=residuals, name="residual", line={"color": RESIDUAL, "width": 2}, **below)
    if tolerance is not None:
        limit = {"color": LIMIT, "dash": "dash", "width": 1.5}
        figure.add_scatter(x=[iterations[0], iterations[-1]], y=[tolerance] * 2, name="at rest", line=limit, **below)
    scale = LOGARITHMIC if positive else {}
    return figure.update_layout(
        xaxis={"title": "iterations", "anchor": "y2"},
        yaxis={"title": "energy [\N{MICRO SIGN}J]", "domain": [0.46, 0.9], "tickfont": {"size": 10}, **scale},
        yaxis2={"title": "residual", "domain": [0.0, 0.38], "tickfont": {"size": 10}, **LOGARITHMIC},
        legend={"orientation": "h", "y": 1.13, "yanchor": "top", "x": 0.0, "font": {"size": 10}}, uirevision="energies",
    )  # fmt: skip


def _microjoules(entry: Assessed, name: str, *, logarithmic: bool) -> float | None:
    """Return an energy; None if a logarithmic axis has no place for it."""
    energy = 0.1 * entry.energies.get(name, 0.0)  # 1 erg is 0.1 microjoules
    return None if logarithmic and energy == 0.0 else energy
