# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Picture and tables of the trade-off between time and accuracy, from the rows of its file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from benchmarks.table import Rows

Row = dict[str, Any]

MARKERS = {
    "precision": ("s", "tab:brown"),
    "quadrature_points": ("v", "tab:green"),
    "contact_samples": ("^", "tab:olive"),
    "control_points_per_stitch": ("P", "tab:purple"),
    "step_fraction": ("X", "tab:pink"),
    "tolerance": ("o", "tab:blue"),
    "solver": ("D", "tab:gray"),
}
"""Marker and colour of each varied parameter."""
SHORT = {"control_points_per_stitch": "control points per stitch", "quadrature_points": "quadrature points",
         "contact_samples": "contact samples", "step_fraction": "step fraction"}  # fmt: skip
MACHINES = {"cpu": "a CPU", "cuda:0": "a GPU"}
"""Names of the devices in the panels; times can be compared within a panel only."""


def draw(rows: Sequence[Row], path: str) -> None:
    """Draw time against rms distance to the reference, with a panel for each scene."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    scenes = scenes_of(rows)
    columns = min(2, len(scenes))
    lines = math.ceil(len(scenes) / columns)
    figure, panels = plt.subplots(lines, columns, figsize=(6.2 * columns, 4.4 * lines), squeeze=False)
    for panel in panels.ravel()[len(scenes) :]:
        panel.axis("off")
    for scene, panel in zip(scenes, panels.ravel(), strict=False):
        _draw_scene(panel, scene, [row for row in rows if row["scene"] == scene and measured(row)])
    handles: dict[str, Any] = {}
    for panel in panels.ravel()[: len(scenes)]:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    figure.legend(list(handles.values()), list(handles), loc="lower center", ncols=5, frameon=False, fontsize=9)
    figure.tight_layout(rect=(0, 0.25 / lines * 0.45, 1, 1))
    figure.savefig(path, dpi=130)
    plt.close(figure)


def _draw_scene(panel: Any, scene: str, rows: list[Row]) -> None:
    """Draw one panel: the runs, the names of the presets, and the Pareto front."""
    compared = [row for row in rows if row["value"] != "reference"]
    for knob, (marker, colour) in MARKERS.items():
        for at_rest in (True, False):
            chosen = [row for row in compared if row["knob"] == knob and row["converged"] == at_rest]
            panel.plot(
                [row["seconds"] for row in chosen], [row["rms"] for row in chosen], marker, color=colour,
                markersize=6, markerfacecolor=colour if at_rest else "none", alpha=0.8, linestyle="none",
                label=SHORT.get(knob, knob) if at_rest else None,
            )  # fmt: skip
    front = pareto(compared)
    panel.plot(*zip(*front, strict=True), color="black", linewidth=1, drawstyle="steps-post", zorder=1,
               label="no other run is faster and nearer")  # fmt: skip
    for row in compared:
        if row["knob"] == "preset":
            place = row["seconds"], row["rms"]
            panel.plot(*place, "*", color="tab:red", markersize=16, markeredgecolor="black", zorder=4, label="preset")
            panel.annotate(row["value"], place, xytext=(9, 7), textcoords="offset points", weight="bold", zorder=5,
                           bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 1})  # fmt: skip
    reference = next((row for row in rows if row["value"] == "reference"), None)
    if reference is not None:
        panel.axvline(reference["seconds"], color="tab:red", linestyle=":", linewidth=1, label="reference")
    panel.set(xscale="log", yscale="log", xlabel="seconds", ylabel="rms distance to reference [yarn radii]")
    panel.set_title(f"{scene}, on {MACHINES.get(rows[0]['device'], rows[0]['device'])}")
    panel.set_xlim(*_decades(panel.get_xlim()))
    panel.set_ylim(*_decades(panel.get_ylim()))
    panel.grid(visible=True, which="both", alpha=0.2)


def _decades(limits: tuple[float, float]) -> tuple[float, float]:
    """Widen limits to whole decades, so that every axis has numbers."""
    return 10.0 ** math.floor(math.log10(limits[0])), 10.0 ** math.ceil(math.log10(limits[1]))


def pareto(rows: Sequence[Row]) -> list[tuple[float, float]]:
    """Return the Pareto front: times [s] and rms distances of the runs that no other run dominates, fastest first."""
    front: list[tuple[float, float]] = []
    for seconds, rms in sorted((row["seconds"], row["rms"]) for row in rows):
        if not front or rms < front[-1][1]:
            front.append((seconds, rms))
    return front


def measured(row: Row) -> bool:
    """Return whether a run produced yarns."""
    return "seconds" in row


def scenes_of(rows: Sequence[Row]) -> list[str]:
    """Return the names of the scenes in the order of their first rows."""
    return list(dict.fromkeys(row["scene"] for row in rows))


def tables(rows: Sequence[Row]) -> Rows:
    """Return the tables of ``docs/accuracy.md``: the presets of all scenes, and a table for each varied parameter."""
    yield from _scene_table([row for row in rows if row["knob"] == "preset"], "preset")
    for knob in MARKERS:
        chosen = [row for row in rows if row["knob"] == knob]
        if chosen:
            yield f"### {SHORT.get(knob, knob).capitalize()}"
            yield from _scene_table(chosen, SHORT.get(knob, knob))


def _scene_table(rows: Sequence[Row], knob: str) -> Rows:
    yield (
        "scene", knob, "seconds", "iterations", "residual", "rms, radii", "largest, radii", "wale spacing %",
        "course spacing %", "energy %",
    )  # fmt: skip
    for row in rows:
        if not measured(row):
            yield row["scene"], row["value"], row["failure"], *[""] * 7
            continue
        marks = "" if row["converged"] else ", not at rest"
        errors = [_percent(row[name]) for name in ("wale_error", "course_error", "energy_error")]
        distances = [f"{row[name]:.2g}" for name in ("rms", "largest")]
        if row["value"] == "reference":
            distances, errors = ["0", "0"], ["0" if error != "given" else error for error in errors]
        cells = [f"{row['seconds']:.3g}", row["iterations"], f"{row['residual']:.2g}{marks}"]
        yield row["scene"], row["value"], *cells, *distances, *errors


def _percent(error: float | None) -> str:
    """Return an error in per cent; a spacing that the lattice of the scene prescribes has no error."""
    return "given" if error is None else f"{100 * error:.2g}"
