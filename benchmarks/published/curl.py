# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""V11: curl of stockinette by the aspect of its loop (Tajiri et al., arXiv 2410.13307).

Published: only the sides curl where loops are taller than wide; then sides and ends; and only the ends as the loop
becomes wider. A cell cannot curl, but it has moments: the course moment bends the courses and rolls the sides, the wale
moment bends the wales and rolls the ends. Cells of several widths, whose heights relax, have loops of several
aspects.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.published.comparison import Claim, Curve, Items, Section
from stitchmesh.periodic.swatch import swatch
from stitchmesh.periodic.swatch_options import YARN_RADIUS

WIDTHS = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3)
"""Widths of the cell over the free one."""
LOOPS = (14.0, 20.0, 24.0, 30.0)
"""Loop lengths of free cells [yarn diameters]."""


def run() -> Items:
    """Compare the ratio of the moments with the aspect of the loop."""
    free = swatch("stockinette", quality="standard", device="cpu", relax_cell=True, relaxation="frictionless",
                  progress=False).report  # fmt: skip
    aspects, ratios, rows = [], [], []
    for width in WIDTHS:
        report = swatch(
            "stockinette", quality="standard", device="cpu", relax_cell=True, relaxation="frictionless", progress=False,
            period=(width * free["width"], None),
        ).report  # fmt: skip
        aspects.append(_aspect(report))
        ratios.append(_ratio(report))
        rows.append(_row(f"{width:g}", report))
    for loop in LOOPS:
        report = swatch(
            "stockinette", quality="standard", device="cpu", relax_cell=True, relaxation="frictionless", progress=False,
            loop_length=2.0 * YARN_RADIUS * loop,
        ).report  # fmt: skip
        rows.append(_row(f"1, loops of {loop:g} d", report))
    steps = np.diff(ratios)
    monotone = bool(np.all(steps > 0.0) or np.all(steps < 0.0))
    ours = f"from {ratios[0]:.2f} to {ratios[-1]:.2f}"
    yield Claim(
        quantity="moment of the ends over that of the sides, as loops become wider: changes monotonically",
        published="yes", ours=f"{ours}, {'monotone' if monotone else 'not monotone'}",
        passes=monotone, sure="page",
    )  # fmt: skip
    yield Claim(
        quantity="the same: direction", published="rises", ours="rises" if ratios[-1] > ratios[0] else "falls",
        passes=ratios[-1] > ratios[0], sure="page",
    )  # fmt: skip
    yield Claim(
        quantity="signs of curl", published="sides to the back, ends to the front", sure="page",
        ours=f"course moment {free['course_moment']:.1f} dyn, wale moment {free['wale_moment']:.1f} dyn",
        passes=free["course_moment"] < 0.0 < free["wale_moment"],
    )  # fmt: skip
    yield Claim(quantity="three shapes of a free piece", published="side, double, top and bottom", sure="page",
                ours="not run: needs a free piece of tens of wales", passes=False)  # fmt: skip
    yield ""
    yield ["width / free width", "wale / course spacing", "course moment [dyn]", "wale moment [dyn]", "ratio"]
    yield from rows
    yield Curve(panel="moments of stockinette", label="wale over course moment", x=tuple(aspects), y=tuple(ratios))


def _aspect(report: dict[str, Any]) -> float:
    return float(report["wale_spacing"] / report["course_spacing"])


def _ratio(report: dict[str, Any]) -> float:
    return float(-report["wale_moment"] / report["course_moment"])


def _row(name: str, report: dict[str, Any]) -> list[object]:
    moments = [f"{report[f'{way}_moment']:.1f}" for way in ("course", "wale")]
    return [name, f"{_aspect(report):.2f}", *moments, f"{_ratio(report):.2f}"]


TABLE = Section(
    name="V11", title="Curl of stockinette", run=run, accepted="signs and the trend",
    verdict="the ratio falls as the cell is held wider; a free piece was not run",
    picture="validation-v11.png", axes=("wale over course spacing", "wale moment over course moment"),
)  # fmt: skip
