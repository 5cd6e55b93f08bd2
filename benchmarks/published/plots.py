# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of the validation: gauge against loop length, stretch curves, crimp of a plain weave, and kept curves."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.published.comparison import Curve
from benchmarks.published.knits import MUNDEN, loops
from benchmarks.published.stretch import PATTERNS, curves
from benchmarks.published.weaves import SPACINGS, Peirce, taut_weave

NORMAL = (16.0, 17.0)
"""Loop lengths for which Munden's constants hold [yarn diameters]."""
MEASURES = {"k_c": "$K_c$ = loop length / course spacing", "k_w": "$K_w$ = loop length / wale spacing",
            "k_s": "$K_s = K_c K_w$", "ratio": "$R$ = wale / course spacing"}  # fmt: skip


def draw_loops(path: Path) -> None:
    """Munden's constants against loop length."""
    figure, panels = _figure(2, 2, (9.0, 6.4))
    found = loops()
    length = [row[0] for row in found]
    for panel, (name, title) in zip(panels.ravel(), MEASURES.items(), strict=True):
        values = [getattr(constants, name) for constants in MUNDEN.values()]
        what = "Munden, dry to full relaxed"
        panel.axhspan(min(values), max(values), color="tab:orange", alpha=0.18, linewidth=0)
        panel.fill_between(NORMAL, min(values), max(values), color="tab:orange", alpha=0.6, linewidth=0, label=what)
        panel.plot(length, [getattr(row[1], name) for row in found], "o-", color="tab:blue", markersize=4, label="here")
        panel.set_title(title, fontsize=10)
        panel.grid(alpha=0.3)
    for panel in panels[1]:
        panel.set_xlabel("loop length [yarn diameters]")
    panels[0, 0].legend(frameon=False, fontsize=9)
    _save(figure, path)


def draw_curves(path: Path) -> None:
    """Draw tension against strain of every pattern, with a panel for each kind of stretch."""
    figure, panels = _figure(2, 2, (9.0, 6.4))
    for line, other in zip(panels, ("free", "held"), strict=True):
        for panel, direction in zip(line, ("course", "wale"), strict=True):
            for pattern in PATTERNS:
                curve = curves()[pattern, direction, other]
                panel.plot(100 * curve.column("strain"), curve.tension, "o-", markersize=3.5, label=pattern)
            panel.set_title(f"drawn along the {direction}s, {other} across", fontsize=10)
            panel.grid(alpha=0.3)
            panel.set_ylabel("tension [dyn/cm]")
            panel.set_xlabel("strain [%]")
    panels[0, 0].legend(frameon=False, fontsize=9)
    _save(figure, path)


def draw_crimp(path: Path) -> None:
    """Draw crimp against spacing, with Peirce's curve up to the jammed state."""
    found = [taut_weave(spacing) for spacing in (1.75, *SPACINGS)]
    figure, panels = _figure(1, 1, (6.4, 4.2))
    panel = panels[0, 0]
    theory = [Peirce.at(angle) for angle in np.linspace(0.15, np.pi / 3, 200)]
    shown = [state for state in theory if state.spacing < max(SPACINGS) + 0.3]
    panel.plot([s.spacing for s in shown], [100 * s.crimp for s in shown], color="tab:orange", label="Peirce 1937")
    panel.axvline(np.sqrt(3), color="0.5", linewidth=1.0, linestyle=(0, (5, 3)), label="jammed")
    panel.plot([s.spacing for s in found], [100 * s.crimp for s in found], "o", color="tab:blue", label="here")
    panel.set_xlabel("distance of neighbouring yarns [yarn diameters]")
    panel.set_ylabel("crimp [%]")
    panel.grid(alpha=0.3)
    panel.legend(frameon=False, fontsize=9)
    _save(figure, path)


def draw_panels(curves: Sequence[Curve], axes: tuple[str, str], path: Path) -> None:
    """Draw curves by panel; published ones are grey, and equal labels are named once."""
    names = list(dict.fromkeys(curve.panel for curve in curves))
    columns = min(len(names), 2)
    figure, panels = _figure(-(-len(names) // columns), columns, (4.6 * columns, 3.4 * -(-len(names) // columns)))
    for panel in panels.ravel()[len(names) :]:
        panel.axis("off")
    for panel, name in zip(panels.ravel(), names, strict=False):
        shown: set[str] = set()
        for number, curve in enumerate(each for each in curves if each.panel == name):
            label = curve.label if curve.label not in shown else None
            shown.add(curve.label)
            style = {"color": f"C{number}", "marker": "o", "markersize": 3.5}
            if not curve.ours:
                style = {"color": "0.45", "linestyle": (0, (4, 2))}
            panel.plot(curve.x, curve.y, label=label, **style)
        panel.set_title(name, fontsize=10)
        panel.set_xlabel(axes[0])
        panel.set_ylabel(axes[1])
        panel.grid(alpha=0.3)
        panel.legend(frameon=False, fontsize=8)
    _save(figure, path)


def _figure(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=130, layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False)


def _save(figure: Any, path: Path) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure).print_png(str(path))
