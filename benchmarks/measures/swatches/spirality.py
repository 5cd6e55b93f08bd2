# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Spirality of single jersey against loop length, twist and yarn, with its sign, and of fabrics that have none.

Kothari, Singh, Roy and Varshney 2011 report that spirality rises with the length of the loop, with finer yarn and on
coarser machines. The cells lie on nothing, because planes press the loops flat that the torque sets up.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path

from benchmarks.options import OptionalOutput
from benchmarks.table import Rows
from stitchmesh.periodic.swatch import Swatch, swatch
from stitchmesh.periodic.swatch_options import COMPACT_LOOP, KnitState
from stitchmesh.render.plots.plot_file import INK, PALE_INK, plot_file, style_axes
from stitchmesh.yarn.colours import DYES
from stitchmesh.yarn.yarn_description import described_yarn
from stitchmesh.yarn.yarn_presets import Yarn
from stitchmesh.yarnrelax import YarnMaterial

YARN = "cotton-28-tex"
LOOPS = (14, 15, COMPACT_LOOP, 18, 20, 22)
"""Loop lengths [yarn diameters]."""
TURNS = 50.0
"""Residual twist [turns/m]."""
STATES: tuple[KnitState, ...] = ("dry", "full")
COUNTS = (22.0, 25.0, 28.1, 32.0)
"""Linear densities at one loop length [tex]."""


@cache
def lean(
    yarn: Yarn, loop: float, turns: float, state: KnitState, pattern: str = "stockinette", *, lies: bool = False
) -> Swatch:  # fmt: skip
    """A swatch of yarn with residual twist; ``loop`` is the loop length [cm]."""
    return swatch(
        pattern, material=YarnMaterial.of_yarn(yarn), yarn_radius=yarn.core_radius, loop_length=loop, quality="draft",
        device="cpu", relax_cell=True, relaxation=state, residual_twist=turns, unsupported=not lies, progress=False,
    )  # fmt: skip


def _angle(found: Swatch) -> str:
    return f"{found.report['spirality']:.2f}" + ("" if found.report["converged"] else " (not at rest)")


def by_loop(state: KnitState, turns: float) -> list[float]:
    """Spirality at each of ``LOOPS`` [degrees]."""
    yarn = Yarn.named(YARN)
    return [lean(yarn, 2.0 * yarn.core_radius * loop, turns, state).report["spirality"] for loop in LOOPS]


def loops_table() -> Iterable[list[object]]:
    """Spirality by loop length, of Z and S twist."""
    heads = [f"{state}, {'Z' if sign > 0 else 'S'}" for state in STATES for sign in (1, -1)]
    yield ["loop length / d", *heads, "dry, Z, between planes", "torque of snarling"]
    yarn = Yarn.named(YARN)
    for loop in LOOPS:
        length = 2.0 * yarn.core_radius * loop
        found = [lean(yarn, length, sign * TURNS, state) for state in STATES for sign in (1, -1)]
        lies = lean(yarn, length, TURNS, "dry", lies=True)
        yield [loop, *map(_angle, found), _angle(lies), f"{100 * found[0].report['snarling']:.1f} %"]


def twists_table() -> Iterable[list[object]]:
    """Spirality by residual twist, at the compact loop."""
    yarn = Yarn.named(YARN)
    length = 2.0 * yarn.core_radius * COMPACT_LOOP
    yield ["residual twist [turns/m]", *STATES]
    for turns in (0.0, 10.0, 25.0, 50.0, 75.0, 100.0):
        yield [turns, *(_angle(lean(yarn, length, turns, state)) for state in STATES)]


def yarns_table() -> Iterable[list[object]]:
    """Spirality of finer and thicker yarn of the same fibres, in loops of one length."""
    length = 2.0 * Yarn.named(YARN).core_radius * COMPACT_LOOP
    yield ["linear density [tex]", "loop length / d", *STATES]
    for tex in COUNTS:
        yarn = described_yarn(
            linear_density=f"{tex} tex", diameter=f"{0.169 * (tex / 28.1) ** 0.5} mm", tensile_modulus="815 MPa",
            fibre="cotton", fibre_diameter="12 um",
        )  # fmt: skip
        loops = length / (2.0 * yarn.core_radius)
        yield [tex, f"{loops:.1f}", *(_angle(lean(yarn, length, TURNS, state)) for state in STATES)]


def patterns_table() -> Iterable[list[object]]:
    """Lean of fabrics whose two sides are alike, beside stockinette, and the part that changes with the sign of twist.

    Fabrics may lean to one of two sides without regard to the sign; spirality is half the difference of both signs.
    """
    yarn = Yarn.named(YARN)
    length = 2.0 * yarn.core_radius * COMPACT_LOOP
    yield ["pattern", *(f"{state}, {part}" for state in STATES for part in ("Z", "S", "by the sign"))]
    for pattern in ("stockinette", "rib1x1", "garter", "seed"):
        row: list[object] = [pattern]
        for state in STATES:
            right, left = (lean(yarn, length, sign * TURNS, state, pattern, lies=True) for sign in (1.0, -1.0))
            half = (right.report["spirality"] - left.report["spirality"]) / 2.0
            row += [_angle(right), _angle(left), f"{half:.3f}"]
        yield row


def draw_spirality(path: Path) -> None:
    """Draw spirality against loop length, for both directions of twist."""
    with plot_file(path, (6.4, 4.2)) as figure:
        axes = figure.subplots()
        for state, dye in zip(STATES, DYES, strict=False):
            for sign, twist, style in ((1.0, "Z", "o-"), (-1.0, "S", "s--")):
                label = f"{twist} twist, {state}"
                axes.plot(LOOPS, by_loop(state, sign * TURNS), style, color=tuple(dye), markersize=4, label=label)
        axes.axhline(0.0, color=PALE_INK, linewidth=1.0)
        axes.set_xlabel("loop length [yarn diameters]", color=PALE_INK)
        axes.legend(frameon=False, fontsize=9, labelcolor=INK)
        style_axes(axes, "lean of the wales to the right [degrees]")


def spirality(picture: OptionalOutput = None) -> Rows:
    """Lean the wales by residual twist.

    Args:
        picture: a picture of spirality against loop length.
    """
    yield "Spirality by loop length [degrees]"
    yield from loops_table()
    yield "Spirality by residual twist [degrees]"
    yield from twists_table()
    yield "Spirality by yarn at one loop length [degrees]"
    yield from yarns_table()
    yield "Spirality by pattern, between planes [degrees]"
    yield from patterns_table()
    if picture is not None:
        draw_spirality(picture)
