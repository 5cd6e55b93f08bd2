# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stiffness of knitted swatches against loop length: modulus of the relaxed swatch, and extension under one load.

Singal et al. 2024 stretch swatches in one direction with the other direction free, fit a modulus Y [N/mm] to the linear
part of force per width, and compare Y L A / B, where L is the yarn length of a stitch, A the area of a stitch and B the
bending stiffness of the yarn.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cache

import numpy as np

from benchmarks.published.knits import DIAMETER, MATERIAL
from benchmarks.published.stretch import PATTERNS, PUBLISHED
from stitchmesh.periodic.stretch import StretchCurve, StretchPath, stretch_test
from stitchmesh.quality import PRESETS
from stitchmesh.yarnrelax import YarnMaterial

LOOPS = (14, 15, 16.67)
"""Loop lengths [yarn diameters]."""
LOADS = (500.0, 1e3, 1500.0)
"""Tensions under which extensions are compared [dyn/cm]."""
REST = 0.02
"""Largest strain for the measurement of the modulus of the relaxed fabric."""
MOST = {"course": {"stockinette": 2.0, "garter": 1.6, "seed": 2.0, "rib1x1": 4.2},
        "wale": {"stockinette": 1.0, "garter": 1.9, "seed": 1.7, "rib1x1": 1.1}}  # fmt: skip
"""Strains at which the largest load has been reached."""
STEP = 0.05
"""Difference of successive strains of a curve."""
FINE = replace(PRESETS["reference"], quadrature_points=5, contact_samples=7, tolerance=2e-4)
"""Number of contact spheres; with fewer spheres, yarns interlock, which changes slopes."""

Curves = dict[tuple[float, str, str], StretchCurve]


@cache
def curves() -> Curves:
    """Return stretch curves by loop length, direction and pattern, the other direction free; they start at ``REST``."""
    return {
        (loop, direction, pattern): drawn(loop, direction, pattern, STEP, MOST[direction][pattern])
        for loop in LOOPS for direction in PUBLISHED for pattern in PATTERNS
    }  # fmt: skip


def drawn(loop: float, direction: str, pattern: str, step: float, most: float) -> StretchCurve:
    """Return the stretch curve of a swatch up to the strain ``most``."""
    path = StretchPath(**{direction: (0.0, most)}, steps=round(most / step) + 1)
    return stretch_test(
        pattern, path, quality=FINE, device="cpu", material=YarnMaterial.named(MATERIAL), loop_length=loop * DIAMETER
    )  # fmt: skip


def modulus_table() -> Iterable[list[object]]:
    """Compare the moduli of relaxed fabrics, also divided by B / (L A)."""
    yield ["loop length / d", "drawn along", "Y [dyn/cm]", "Y L A / B", "published"]
    for loop in LOOPS:
        for direction, published in PUBLISHED.items():
            found = {pattern: drawn(loop, direction, pattern, REST, REST) for pattern in PATTERNS}
            modulus = {pattern: curve.tension[-1] / REST for pattern, curve in found.items()}
            scaled = {pattern: modulus[pattern] * _similarity(curve) for pattern, curve in found.items()}
            yield [loop, f"{direction}s", _ordered(modulus, ".0f"), _ordered(scaled, ".0f"), published]


def _similarity(curve: StretchCurve) -> float:
    """L A / B [cm/dyn]; B is twice the material's bending stiffness."""
    report = curve.free.report
    area = report["wale_spacing"] * report["course_spacing"]
    return float(report["loop_length"] * area / (2 * YarnMaterial.named(MATERIAL).k_bend))


def loads_table() -> Iterable[list[object]]:
    """Compare the extensions of the fabrics under the same load, the stiffest first."""
    yield ["loop length / d", "drawn along", *(f"extension at {load / 1000:g} N/m" for load in LOADS), "published"]
    for loop in LOOPS:
        for direction, published in PUBLISHED.items():
            orders = []
            for load in LOADS:
                found = {pattern: 100 * extension(curves()[loop, direction, pattern], load) for pattern in PATTERNS}
                orders.append(_ordered(found, ".0f", stiffest=1.0))
            yield [loop, f"{direction}s", *orders, published]


def extension(curve: StretchCurve, load: float) -> float:
    """Return the strain at which the tension first reaches the load, by linear interpolation between states."""
    tension, strain = curve.tension, curve.column("strain")
    above = int(np.argmax(tension >= load))
    assert tension[above] >= load, f"drawn to {strain[-1]:g}, which takes {tension[-1]:g} dyn/cm"
    return float(np.interp(load, tension[above - 1 : above + 1], strain[above - 1 : above + 1]))


def slopes_table() -> Iterable[list[object]]:
    """Compare the slopes of tension against strain along the wales under the same load."""
    yield ["loop length / d", *(f"slope at {load / 1000:g} N/m [dyn/cm]" for load in LOADS), "published"]
    for loop in LOOPS:
        orders = []
        for load in LOADS:
            found = {pattern: slope(curves()[loop, "wale", pattern], load) for pattern in PATTERNS}
            orders.append(_ordered(found, ".0f"))
        yield [loop, *orders, PUBLISHED["wale"]]


def slope(curve: StretchCurve, load: float) -> float:
    """Return the slope of the tension where it first reaches the load, with strain relative to that state [dyn/cm]."""
    tension, strain = curve.tension, curve.column("strain")
    above = int(np.argmax(tension >= load))
    rise = (tension[above] - tension[above - 1]) / (strain[above] - strain[above - 1])
    return float(rise * (1.0 + extension(curve, load)))


def _ordered(found: dict[str, float], form: str, stiffest: float = -1.0) -> str:
    """Return names and numbers in decreasing order, or in increasing order if ``stiffest`` is 1."""
    order = sorted(found, key=lambda pattern: stiffest * found[pattern])
    return ", ".join(f"{pattern.removesuffix('1x1')} {found[pattern]:{form}}" for pattern in order)
