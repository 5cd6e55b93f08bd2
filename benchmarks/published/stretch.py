# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stiffness of knitted swatches: tension at a strain of 0.2, and the dependence of one spacing on the other."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cache

import numpy as np

from benchmarks.published.knits import MATERIAL
from stitchmesh.periodic.stretch import NEWTONS_PER_METRE, StretchCurve, StretchPath, stretch_test
from stitchmesh.quality import PRESETS
from stitchmesh.yarnrelax import YarnMaterial

PATTERNS = ("stockinette", "garter", "seed", "rib1x1")
MOST, STEPS = 0.4, 9
"""Largest strain, and number of strains; every second strain is a multiple of 0.1."""
AT = 0.2
"""Strain at which tensions are compared."""
PUBLISHED = {"course": "stockinette > garter > seed > rib", "wale": "stockinette > rib > garter > seed"}
"""Orders of stiffness (Singal et al. 2024)."""
HYLC = {("stockinette", "course"): 10.26, ("stockinette", "wale"): 8.30, ("rib1x1", "course"): 0.33,
        ("rib1x1", "wale"): 2.86}  # fmt: skip
"""Tension at 20 % with the other direction held [N/m], of another yarn and rib, from the data of Sperl et al. 2020."""
POINCLOUX = 0.86
"""Decrease of wale spacing over increase of course spacing in stretched stockinette (Poincloux et al. 2018), if their c
is the width of a stitch (``loose_monofilament``)."""

Curves = dict[tuple[str, str, str], StretchCurve]


@cache
def curves() -> Curves:
    """Return stretch curves by pattern, direction and condition of the other direction."""
    material = YarnMaterial.named(MATERIAL)
    made: Curves = {}
    for pattern in PATTERNS:
        for other in ("free", "held"):
            for direction in ("course", "wale"):
                path = StretchPath(**{direction: (0.0, MOST)}, other=other, steps=STEPS)
                made[pattern, direction, other] = stretch_test(
                    pattern, path, material=material, quality="standard", device="cpu"
                )
    return made


def tension_at(curve: StretchCurve, strain: float = AT) -> float:
    """Return the tension in the direction of the stretch [dyn/cm]."""
    return float(np.interp(strain, curve.column("strain"), curve.tension))


def stiffness_table() -> Iterable[list[object]]:
    """Compare the tensions of the patterns at 20 % [dyn/cm] with that of stockinette."""
    yield ["pattern", "course, free", "wale, free", "course, held", "wale, held", "of stockinette", "snaps",
           "HYLC held, of stockinette"]  # fmt: skip
    made = curves()
    ways = [(direction, other) for other in ("free", "held") for direction in ("course", "wale")]
    plain = {way: tension_at(made["stockinette", *way]) for way in ways}
    for pattern in PATTERNS:
        found = {way: tension_at(made[pattern, *way]) for way in ways}
        share = ", ".join(f"{found[way] / plain[way]:.2f}" for way in ways)
        snaps = sum(len(made[pattern, *way].snaps) for way in ways)
        yield [pattern, *(f"{tension:.1f}" for tension in found.values()), share, snaps, _hylc(pattern)]


def _hylc(pattern: str) -> str:
    if (pattern, "course") not in HYLC:
        return ""
    return ", ".join(f"{HYLC[pattern, way] / HYLC['stockinette', way]:.2f}" for way in ("course", "wale"))


def orders_table() -> Iterable[list[object]]:
    """Compare the order of the stiffnesses with published orders."""
    yield ["drawn along", "across", "10 %", "20 %", "40 %", "published"]
    for direction, published in PUBLISHED.items():
        for other in ("free", "held"):
            drawn = {pattern: curves()[pattern, direction, other] for pattern in PATTERNS}
            yield [f"{direction}s", other, *(_order(drawn, strain) for strain in (0.1, AT, MOST)), published]


def _order(drawn: dict[str, StretchCurve], strain: float) -> str:
    order = sorted(drawn, key=lambda pattern: -tension_at(drawn[pattern], strain))
    return " > ".join(pattern.removesuffix("1x1") for pattern in order)


def ratios_table() -> Iterable[list[object]]:
    """Compare the course spacing with the wale spacing of stretched stockinette, and tensions with another yarn."""
    yield ["measure", "here", "published"]
    made = curves()
    for direction in ("course", "wale"):
        curve = made["stockinette", direction, "free"]
        report = curve.free.report
        wale, course = curve.column("width") / report["wales"], curve.column("height") / report["courses"]
        slopes, whole = np.diff(wale) / np.diff(course), (wale[-1] - wale[0]) / (course[-1] - course[0])
        yield [
            f"stockinette drawn along the {direction}s to {100 * MOST:g} %: - d(wale spacing) / d(course spacing)",
            f"{-slopes[0]:.2f} at first, {-slopes[-1]:.2f} at last, {-whole:.2f} in all",
            f"{POINCLOUX}, or {1 / POINCLOUX:.2f} in the other reading (Poincloux et al. 2018)",
        ]
    for pattern in ("stockinette", "rib1x1"):
        course, wale = (tension_at(made[pattern, way, "held"]) * NEWTONS_PER_METRE for way in ("course", "wale"))
        other = HYLC[pattern, "course"] / HYLC[pattern, "wale"]
        yield [f"{pattern}, {100 * AT:g} %, other direction held: course, wale", f"{course:.3f}, {wale:.3f} N/m", ""]
        yield [f"{pattern}, course over wale", f"{course / wale:.2f}", f"{other:.2f} (HYLC)"]


def accuracy_table() -> Iterable[list[object]]:
    """Compare the presets for stockinette stretched along the courses with held wales."""
    yield ["quality", "10 %", "20 %", "30 %", "40 %"]
    for quality in PRESETS:
        path = StretchPath(course=(0.0, MOST), other="held", steps=5)
        material = YarnMaterial.named(MATERIAL)
        curve = stretch_test("stockinette", path, quality=quality, device="cpu", material=material)
        yield [quality, *(f"{tension:.1f}" for tension in curve.tension[1:])]


def sampling_table() -> Iterable[list[object]]:
    """Compare numbers of control points, which the axial stiffness of a yarn must not depend on."""
    yield ["pattern", "control points", "10 %", "20 %"]
    path = StretchPath(course=(0.0, 0.2), other="held", steps=3)
    for pattern in ("plain", "stockinette"):
        for count in (24, 48, 96):
            quality = replace(PRESETS["standard"], precision="float64", control_points_per_stitch=count)
            curve = stretch_test(pattern, path, quality=quality, device="cpu")
            yield [pattern, count, *(f"{tension:.1f}" for tension in curve.tension[1:])]
