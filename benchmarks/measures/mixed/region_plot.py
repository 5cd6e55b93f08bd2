# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Curves of the error of mixed runs over the size of their regions, from the rows of ``mixed``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

MEASURES = (
    ("near", "rms distance in the measured part [spacings]", 1.0),
    ("spectrum", "difference of the spectrum of wrinkles [%]", 100.0),
    ("energy", "difference of the stored energy [%]", 100.0),
    ("products", "products (line: yarns everywhere)", 1.0),
)
"""Columns of the picture: entry of a row, name and factor."""
STYLES = {"by hand": ("s", "tab:orange", "-"), "automatic": ("o", "tab:blue", "-"),
          "adapting": ("^", "tab:green", "-")}  # fmt: skip
WIDTHS = {1: "-", 2: "--", 3: ":"}
"""Line of each hybrid width in rings."""


def draw(rows: Sequence[dict[str, Any]], path: str) -> None:
    """Draw one row of panels for each loading: each measure over the number of simulated nodes."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    loadings = list(dict.fromkeys(row["loading"] for row in rows))
    shape = len(loadings), len(MEASURES)
    figure, panels = plt.subplots(*shape, figsize=(3.6 * shape[1], 2.9 * shape[0] + 0.5), squeeze=False)
    for line, loading in zip(panels, loadings, strict=True):
        own = [row for row in rows if row["loading"] == loading]
        for panel, measure in zip(line, MEASURES, strict=True):
            _draw_panel(panel, own, *measure)
        line[0].set_ylabel(loading, weight="bold", fontsize=11)
    for panel in panels[-1]:
        panel.set_xlabel("simulated yarn nodes [%]")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=len(labels), frameon=False, fontsize=9)
    figure.tight_layout(rect=(0, 0.5 / (2.9 * shape[0] + 0.5), 1, 1))
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_panel(panel: Any, rows: list[dict[str, Any]], entry: str, name: str, factor: float) -> None:
    """Draw one measure of a loading, with the run of triangles at the left and the full run at the right."""
    full = next(row for row in rows if row["region"] == "yarns everywhere")
    ends = [row for row in rows if row["region"] in ("triangles alone", "yarns everywhere")]
    for kind, (marker, colour, _line) in STYLES.items():
        for rings in sorted({row["rings"] for row in rows if row["region"] == kind}):
            chosen = [row for row in rows if row["region"] == kind and row["rings"] == rings]
            chosen.sort(key=lambda row: row["nodes"])
            panel.plot(
                [100.0 * row["nodes"] / full["nodes"] for row in chosen],
                [factor * abs(row[entry]) for row in chosen],
                marker=marker, color=colour, linestyle=WIDTHS.get(rings, "-."), markersize=5,
                markerfacecolor=colour if rings == 1 else "none",
                label=f"{kind}, {rings} ring{'s' if rings > 1 else ''}",
            )  # fmt: skip
    if entry == "products":
        panel.axhline(full[entry], color="black", linewidth=1, label="yarns everywhere")
    else:
        panel.axhline(factor * abs(ends[-1][entry]), color="tab:gray", linewidth=1, label="triangles alone")
        again = [factor * abs(row[entry]) for row in rows if row["region"] == "again, shaken"]
        if again:
            panel.axhline(max(again), color="black", linestyle=":", linewidth=1, label="yarns everywhere, shaken")
        panel.set_yscale("log")
    panel.set_title(name, fontsize=9)
    panel.set_xlim(0.0, 105.0)
