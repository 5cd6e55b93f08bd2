# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The residual of a relaxation against its iterations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stitchmesh.io.history import HistoryEntry

if TYPE_CHECKING:
    import plotly.graph_objects as go


def residual_figure(history: Sequence[HistoryEntry]) -> go.Figure:
    """Return the plot."""
    import plotly.graph_objects as go

    line = go.Scatter(
        x=[entry["iteration"] for entry in history], y=[entry["residual"] for entry in history],
        mode="lines", line={"color": "#2b7bb9", "width": 2},
    )  # fmt: skip
    figure = go.Figure(line)
    figure.update_layout(
        margin={"l": 45, "r": 10, "t": 28, "b": 35}, title={"text": "Residual of the relaxation", "font": {"size": 13}},
        xaxis={"title": {"text": "iterations", "standoff": 4}}, yaxis={"type": "log", "exponentformat": "power"},
        showlegend=False,
    )  # fmt: skip
    return figure
