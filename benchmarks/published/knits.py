# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knitted swatches in free cells: gauge against Munden's constants, widths of ribs, and the tendency to curl."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from stitchmesh.patterns import Pattern, parse_pattern
from stitchmesh.periodic.swatch import Swatch, swatch
from stitchmesh.periodic.swatch_options import COMPACT_LOOP, YARN_RADIUS
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial

MATERIAL = "kaldor-simulation"
"""The published material of all tables except one; its yarn has the default radius."""
DIAMETER = 2 * YARN_RADIUS
"""Diameter of the yarn [cm]."""
PATTERNS = ("stockinette", "garter", "seed", "rib1x1", "rib2x2")
CELLS = {"between planes": {"planes": True}, "right angles": {}, "free": {"shear": True}}
"""Cells by name; cells at right angles and free cells lie on nothing."""
LOOPS = (10, 11, 12, 13, 14, 15, 16, COMPACT_LOOP, 17, 18, 20, 22, 24, 27, 30)
"""Loop lengths [yarn diameters]; below about 13.7, swatches start with a smaller yarn radius that then grows."""


@dataclass(frozen=True)
class Gauge:
    """Dimensionless measures of plain knit."""

    k_c: float
    """Loop length over course spacing."""
    k_w: float
    """Loop length over wale spacing."""

    @property
    def k_s(self) -> float:
        """Stitch density times the square of the loop length."""
        return self.k_c * self.k_w

    @property
    def ratio(self) -> float:
        """Wale spacing over course spacing."""
        return self.k_c / self.k_w


MUNDEN = {"dry": Gauge(5.0, 3.8), "wet": Gauge(5.3, 4.1), "full": Gauge(5.5, 4.2)}
"""Relaxed plain knit of spun yarn, in three states of relaxation (Munden 1959, as cited by Spencer 2001)."""


def relaxed(
    pattern: str | Pattern, *, material: str = MATERIAL, quality: str | Quality = "reference", shear: bool = False,
    planes: bool = False, **options: Any,
) -> Swatch:  # fmt: skip
    """A swatch in a free cell, on nothing or between two planes, on the CPU."""
    return swatch(
        pattern, material=YarnMaterial.named(material), quality=quality, device="cpu",
        relax_cell=RelaxCell(shear=shear) if not planes else True, relaxation="frictionless", progress=False,
        **options,
    )  # fmt: skip


def gauge(found: Swatch) -> Gauge:
    """Return the gauge for the actual loop length."""
    report = found.report
    return Gauge(report["loop_length"] / report["course_spacing"], report["loop_length"] / report["wale_spacing"])


def presets_table() -> Iterable[list[object]]:
    """Compare presets and materials for stockinette at the compact loop."""
    yield ["material", "quality", "K_c", "K_w", "K_s", "R", "course moment [dyn]", "wale moment [dyn]"]
    runs = [(MATERIAL, name) for name in PRESETS] + [(name, "reference") for name in ("leaf", "stitchmesh")]
    for material, quality in runs:
        yield _gauge_row(relaxed("stockinette", material=material, quality=quality), material, quality)
    limp = replace(PRESETS["reference"], tolerance=1e-3)
    yield _gauge_row(relaxed("stockinette", material="kaldor-relaxation", quality=limp), "kaldor-relaxation",
                     "reference, tolerance 1e-3")  # fmt: skip


def _gauge_row(found: Swatch, material: str, quality: str) -> list[object]:
    constants, report = gauge(found), found.report
    moments = [round(report[f"{name}_moment"], 1) for name in ("course", "wale")]
    sizes = [f"{value:.2f}" for value in (constants.k_c, constants.k_w, constants.k_s, constants.ratio)]
    return [material, quality, *sizes, *moments]


@cache
def loops() -> list[tuple[float, Gauge, float]]:
    """Loop length [diameters], gauge, and smallest distance of axes [diameters], of stockinette."""
    runs = [(length, relaxed("stockinette", loop_length=length * DIAMETER)) for length in LOOPS]
    return [(length, gauge(run), run.report["min_distance_over_radius"] / 2) for length, run in runs]


def loops_table() -> Iterable[list[object]]:
    """Compare loop lengths for stockinette."""
    yield ["loop length / d", "K_c", "K_w", "K_s", "R", "nearest axes / d", "R at standard quality"]
    for length, constants, nearest in loops():
        sizes = [f"{value:.2f}" for value in (constants.k_c, constants.k_w, constants.k_s, constants.ratio)]
        hasty = gauge(relaxed("stockinette", quality="standard", loop_length=length * DIAMETER))
        yield [length, *sizes, f"{nearest:.3f}", f"{hasty.ratio:.2f}"]


def tiling_table() -> Iterable[list[object]]:
    """Compare a cell of one stitch with cells of several stitches."""
    yield ["cell", "energy a stitch [erg]", "wale spacing [cm]", "course spacing [cm]"]
    exact, stitch = replace(PRESETS["reference"], tolerance=1e-6), parse_pattern("round 1: k")
    for columns, rows in ((1, 1), (2, 1), (1, 2), (2, 3)):
        report = relaxed(stitch, quality=exact, columns=columns, rows=rows).report
        sizes = [f"{report[name]:.6f}" for name in ("energy_per_stitch", "wale_spacing", "course_spacing")]
        yield [f"{report['wales']} x {report['courses']}", *sizes]


def knits_table() -> Iterable[list[object]]:
    """Compare spacings, thickness and moments of several fabrics with those of stockinette."""
    yield ["pattern", "cell", "wale spacing", "course spacing", "thickness / d", "lean", "course moment",
           "wale moment", "energy a stitch [erg]"]  # fmt: skip
    plain = relaxed("stockinette").report
    for pattern in PATTERNS:
        for cell, freedom in CELLS.items():
            report = relaxed(pattern, **freedom).report
            ratios = [f"{report[name] / plain[name]:.3f}" for name in ("wale_spacing", "course_spacing")]
            moments = [f"{100 * report[name] / abs(plain[name]):.1f} %" for name in ("course_moment", "wale_moment")]
            yield [pattern, cell, *ratios, f"{report['thickness'] / DIAMETER:.2f}",
                   f"{report['shear']:.3f}", *moments, f"{report['energy_per_stitch']:.2f}"]  # fmt: skip


def shaken_table() -> Iterable[list[object]]:
    """Perturb relaxed fabrics slightly and relax them again, to find other stable shapes nearby."""
    from stitchmesh.yarnrelax import relax_yarns

    yield ["pattern", "repeats", "energy a stitch [erg]", "after shaking, four times"]
    exact, material = replace(PRESETS["standard"], precision="float64", tolerance=1e-4), YarnMaterial.named(MATERIAL)
    for pattern, repeats in itertools.product(PATTERNS, (1, 2)):
        found = relaxed(pattern, quality=exact, columns=repeats, rows=repeats)
        energies = []
        for seed in range(4):
            noise = np.random.default_rng(seed).normal(scale=0.1 * YARN_RADIUS, size=found.yarns.points.shape)
            shaken = replace(found.yarns, points=found.yarns.points + noise)
            cell = RelaxCell(shear=False)
            rest = relax_yarns(shaken, material=material, quality=exact, device="cpu", cell=cell)
            energies.append(rest.report["energy"] / found.report["stitches"])
        after = ", ".join(f"{energy:.2f}" for energy in energies)
        yield [pattern, f"{repeats} x {repeats}", f"{found.report['energy_per_stitch']:.2f}", after]
