# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What steam and plasticity leave of stockinette: energy, moments of curling, and its size after release."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from benchmarks.published.knits import MATERIAL
from benchmarks.table import Rows
from stitchmesh.periodic.swatch import swatch
from stitchmesh.yarnrelax import YarnMaterial

STATES: dict[str, dict[str, Any]] = {
    "frictionless": {"relax_cell": True, "relaxation": "frictionless"},
    "dry": {"relax_cell": True, "relaxation": "dry"},
    "blocked at 50 dyn/cm, then freed": {"blocked": 50.0},
}
SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
LIMITS = (4.0, 2.0, 1.5, 1.0)
"""Yield curvatures [1/cm]; stockinette of this yarn bends to 2.8 / cm."""


def _row(**options: Any) -> list[object]:
    report = swatch(
        "stockinette", material=YarnMaterial.named(MATERIAL), quality="draft", device="cpu", progress=False, **options
    ).report
    figures = (f"{report[name]:.1f}" for name in ("energy_per_stitch", "course_moment", "wale_moment"))
    size = f"{report['wale_spacing']:.3f} x {report['course_spacing']:.3f}"
    return [*figures, size + ("" if report["converged"] else " (not at rest)")]


HEADS = ("energy of a stitch [erg]", "moment of courses [dyn]", "of wales [dyn]", "size of a stitch [cm]")


def steam_table() -> Iterable[list[object]]:
    """Stockinette by the share of bending that steam sets; without steam a blocked swatch stays pinned."""
    yield ["state", "steamed", *HEADS]
    for state, options in STATES.items():
        for share in SHARES:
            pinned = " (pinned)" if "blocked" in options and not share else ""
            yield [state, f"{share}{pinned}", *_row(**options, steamed=share)]


def yield_table() -> Iterable[list[object]]:
    """Stockinette without friction by the yield curvature of its yarn."""
    yield ["yield curvature [1/cm]", *HEADS]
    for limit in LIMITS:
        yield [limit, *_row(**STATES["frictionless"], yield_curvature=limit)]


def lasting_bends() -> Rows:
    """Steam stockinette, and let its yarn yield."""
    yield "Stockinette that was steamed"
    yield from steam_table()
    yield "Stockinette of yarn that yields"
    yield from yield_table()
