# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Memory of friction: loops of stretch tests that turn, as in the experiments of Dresselhaus 2025 on a 1x1 rib."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.options import OptionalOutput
from benchmarks.table import Rows
from stitchmesh.periodic.hysteresis import StretchLoop
from stitchmesh.periodic.stretch import StretchCurve, StretchPath, stretch_test
from stitchmesh.render.plots.plot_file import INK, PALE_INK, plot_file, style_axes
from stitchmesh.yarn.colours import DYES

TURNS = (0.0, 0.4, 0.2, 0.4, 0.2, 0.4, 0.6, 0.2, 0.4, 0.2, 0.4, 0.6, 0.0, 0.6)
"""Twice from 40 % to 20 %, to 60 %, twice from 40 % to 20 % again, and a cycle of the whole way."""
STEPS = 16
"""Number of strains of the longest way: 4 % apart."""
FABRICS = (("rib1x1", "course"), ("rib1x1", "wale"), ("stockinette", "course"), ("stockinette", "wale"))
SLIPS = (0.05, 0.02, 0.01)
"""Slip lengths [yarn radii]; the first one is the default."""
FRICTION = 0.3
SPACINGS = (0.08, 0.04, 0.02)
"""Distances of strains: a test at other rates, which friction at rest does not feel."""


@cache
def curve(pattern: str, direction: str, slip: float, steps: int = STEPS, mu: float = FRICTION) -> StretchCurve:
    """The stretch test through ``TURNS``."""
    path = StretchPath(**{direction: TURNS}, steps=steps, friction=mu, slip_length=slip)
    return stretch_test(pattern, path, quality="standard", device="cpu")


def loops_between(found: StretchCurve, turn: float, away: float) -> list[StretchLoop]:
    """The loops of a curve that begin at a strain and turn at another one."""
    return [loop for loop in found.loops if np.allclose((loop.turn, loop.away), (turn, away))]


def memory_table() -> Iterable[list[object]]:
    """Say whether loops close, whether those after 40 % and after 60 % are congruent, and which work they return."""
    yield ["pattern", "drawn along", "slip length / r", "open at 40 %, first loop", "second loop", "open at 60 %",
           "loops after 40 % and after 60 %: difference", "in shape", "returned 40-20-40",
           "returned 0-60-0"]  # fmt: skip
    for pattern, direction in FABRICS:
        for slip in SLIPS:
            yield [pattern, f"{direction}s", slip, *_figures(curve(pattern, direction, slip))]
    yield ["published", "", "", "0", "0", "0", "", "0", "", "about 50 %"]


def _figures(found: StretchCurve) -> list[str]:
    first, second, after = loops_between(found, 0.4, 0.2)
    wide = loops_between(found, 0.6, 0.2)[0]
    whole, shape = second.difference(after)
    last = loops_between(found, 0.6, 0.0)[0]
    gaps = [f"{loop.gap:+.1%}" for loop in (first, second, wide)]
    return [*gaps, f"{whole:.1%}", f"{shape:.1%}", f"{second.work_returned:.0%}", f"{last.work_returned:.0%}"]


def rates_table() -> Iterable[list[object]]:
    """Draw the rib in fewer and in more steps: friction at rest knows no rate."""
    yield ["strains apart", "tension at 40 %", "at 60 %", "returned 40-20-40", "returned 0-60-0"]
    for spacing in SPACINGS:
        found = curve("rib1x1", "course", SLIPS[0], round(0.6 / spacing) + 1)
        inner, whole = loops_between(found, 0.4, 0.2)[1], loops_between(found, 0.6, 0.0)[0]
        yield [f"{spacing:.0%}", *(f"{loop.tension[0]:.1f}" for loop in (inner, whole)), f"{inner.work_returned:.1%}",
               f"{whole.work_returned:.1%}"]  # fmt: skip


def draw_memory(path: Path) -> None:
    """Draw the curves of the rib along its courses and of stockinette along its wales."""
    with plot_file(path, (9.0, 4.0)) as figure:
        panels = figure.subplots(1, 2)
        for axes, (pattern, direction) in zip(panels, (FABRICS[0], FABRICS[3]), strict=True):
            for slip, dye in zip((SLIPS[0], SLIPS[-1]), DYES, strict=False):
                found = curve(pattern, direction, slip)
                label = f"slip length {slip:g} r"
                axes.plot(100 * found.column("strain"), found.tension, color=tuple(dye), linewidth=1.2, label=label)
            axes.set_title(f"{pattern}, along the {direction}s", loc="left", fontsize=10, color=INK)
            axes.set_xlabel("strain [%]", color=PALE_INK)
            axes.legend(frameon=False, fontsize=9, labelcolor=INK)
            style_axes(axes, "tension [dyn/cm]")


def friction_memory(picture: OptionalOutput = None) -> Rows:
    """Stretch a rib and stockinette through loops.

    Args:
        picture: a picture of the curves.
    """
    yield "Loops of a stretch test that turns"
    yield from memory_table()
    yield "1x1 rib along its courses in fewer and more steps"
    yield from rates_table()
    if picture is not None:
        draw_memory(picture)
