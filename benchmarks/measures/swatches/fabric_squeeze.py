# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Thickness against pressure of fabrics between plates, with stiff and with soft yarn of one transverse modulus."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.options import OptionalOutput
from benchmarks.published.knits import MATERIAL
from benchmarks.table import Rows
from stitchmesh.periodic.squeeze import LIGHT, SqueezeCurve, squeeze_test
from stitchmesh.render.plots.plot_file import INK, PALE_INK, plot_file, style_axes
from stitchmesh.yarn.colours import DYES
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.model.material import Compression

PATTERNS = ("stockinette", "garter", "rib1x1", "plain")
LAWS: tuple[Compression, ...] = ("stiff", "van-wyk")
HEAVY = 1e4
"""The heavier pressure [dyn/cm^2], 1 kPa."""
PARTS = tuple(np.round(np.linspace(0.95, 0.45, 11), 2))


@cache
def curve(pattern: str, law: Compression, quality: str = "standard") -> SqueezeCurve:
    """The squeeze test of a pattern."""
    material = YarnMaterial.named(MATERIAL).compressed_by(law)
    return squeeze_test(pattern, PARTS, material=material, quality=quality, device="cpu")


def squeeze_table() -> Iterable[list[object]]:
    """Compare thicknesses under the pressures of testers, and the exponent of the hardest squeeze."""
    yield ["pattern", "contact", "free [cm]", "at 49 Pa", "at 1 kPa", "flattest section at the end",
           "last d ln T / d ln p", "largest pressure [kPa]", "work over energy"]  # fmt: skip
    for pattern in PATTERNS:
        for law in LAWS:
            yield [pattern, law, *_figures(curve(pattern, law))]


def _figures(found: SqueezeCurve) -> list[str]:
    thickness, pressure, energy = (found.column(name) for name in ("thickness", "pressure", "energy"))
    slope = np.diff(np.log(thickness[-2:])) / np.diff(np.log(pressure[-2:]))
    work = -np.trapezoid(pressure, thickness) / (energy[-1] - energy[0])
    light, heavy = found.thickness_at(LIGHT), "not reached"
    if pressure[-1] >= HEAVY:
        heavy = f"{found.thickness_at(HEAVY):.3f}, {found.thickness_at(HEAVY) / light - 1.0:.0%}"
    return [f"{thickness[0]:.3f}", f"{light:.3f}", heavy,
            f"{found.points[-1].flattening:.2f}", f"{slope[0]:.2f}", f"{1e-4 * pressure[-1]:.2f}",
            f"{work:.3f}"]  # fmt: skip


def sampling_table() -> Iterable[list[object]]:
    """Squeeze stockinette of soft yarn at each preset of quality."""
    yield ["quality", "free [cm]", "at 49 Pa", "at 0.5 kPa", "at 2 kPa"]
    for quality in ("draft", "standard"):
        found = curve("stockinette", "van-wyk", quality)
        thick = [found.points[0].thickness, *(found.thickness_at(pressure) for pressure in (LIGHT, 5e3, 2e4))]
        yield [quality, *(f"{each:.4f}" for each in thick)]


def draw_squeeze(path: Path) -> None:
    """Draw thickness against pressure, both over logarithmic axes."""
    with plot_file(path, (7.0, 4.4)) as figure:
        axes = figure.subplots()
        for pattern, dye in zip(PATTERNS, DYES, strict=False):
            for law, line in zip(LAWS, (":", "-"), strict=True):
                found = curve(pattern, law)
                pressure = 1e-4 * found.column("pressure")[2:]
                axes.loglog(pressure, found.column("thickness")[2:], line, color=tuple(dye), linewidth=1.5,
                            label=f"{pattern}, {law}")  # fmt: skip
        axes.set_xlabel("pressure [kPa]", color=PALE_INK)
        axes.legend(frameon=False, fontsize=8, labelcolor=INK, ncols=2)
        style_axes(axes, "thickness [cm]")


def fabric_squeeze(picture: OptionalOutput = None) -> Rows:
    """Squeeze fabrics between plates.

    Args:
        picture: a picture of thickness against pressure.
    """
    yield "Thickness against pressure"
    yield from squeeze_table()
    yield "Stockinette of soft yarn by quality"
    yield from sampling_table()
    if picture is not None:
        draw_squeeze(picture)
