# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Fabrics of described yarns, at rest and drawn, for the comparison with published measurements."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.relaxation.drawn_cell import Direction, Other
from stitchmesh.periodic.stretch import NEWTONS_PER_METRE, StretchCurve, StretchPath, stretch_test
from stitchmesh.run import QUIET
from stitchmesh.yarn.yarn_description import LIBRARY, described_yarn
from stitchmesh.yarn.yarn_presets import Yarn
from stitchmesh.yarnrelax import YarnMaterial

PATTERNS = ("stockinette", "rib1x1", "seed", "garter")
"""The patterns of the laboratories."""


def yarn_with(name: str, **values: Any) -> Yarn:
    """Return a measured yarn of the library with other values of its description."""
    return described_yarn(name=name, **{**LIBRARY[name], **values})


@cache
def stretched(
    pattern: str | Pattern, yarn: Yarn, direction: Direction, most: float, *, loop: float, step: float = 0.1,
    friction: float | None = None, other: Other = "free", quality: str = "draft",
) -> StretchCurve:  # fmt: skip
    """Return the curve of a fabric of a yarn up to a strain.

    Args:
        pattern: a pattern of the library, or another one.
        yarn: its yarn, with its own stiffnesses.
        direction: along the courses or the wales.
        most: the last strain.
        loop: yarn of a stitch [cm].
        step: difference of successive strains.
        friction: coefficient between yarns; None for none.
        other: whether the size across is free or held.
        quality: a preset.
    """
    ends = (0.0, most)
    path = StretchPath(
        course=ends if direction == "course" else None, wale=ends if direction == "wale" else None, other=other,
        steps=round(most / step) + 1, friction=friction,
    )  # fmt: skip
    return stretch_test(
        pattern, path, material=YarnMaterial.of_yarn(yarn), quality=quality, device="cpu", run=QUIET,
        loop_length=loop, yarn_radius=yarn.core_radius,
    )  # fmt: skip


def strains(curve: StretchCurve) -> FloatArray:
    """Strains of a curve."""
    return curve.column("strain")


def newtons(curve: StretchCurve) -> FloatArray:
    """Tensions of a curve over the border at rest [N/m]."""
    return np.asarray(curve.tension * NEWTONS_PER_METRE)


def tension_at(curve: StretchCurve, strain: float) -> float:
    """Tension at a strain [N/m]."""
    return float(np.interp(strain, strains(curve), newtons(curve)))


def rest_text(curves: Sequence[StretchCurve]) -> str:
    """Return a line that says how many states of some curves are not at rest."""
    rest = [[curve.free.report["converged"], *curve.column("converged")] for curve in curves]
    moving = [sum(not each for each in states) for states in rest]
    found = f"{sum(moving)} of {sum(map(len, rest))} states of {len(curves)} curves did not come to rest"
    return found + (f", in {sum(map(bool, moving))} curves." if any(moving) else ".")


def strain_under(curve: StretchCurve, tension: float) -> float:
    """The first strain at which a tension [N/m] is reached; not a number if it is not reached."""
    found = newtons(curve)
    above = np.flatnonzero(found >= tension)
    if not len(above):
        return float("nan")
    end = int(above[0])
    if end == 0:
        return 0.0
    return float(np.interp(tension, found[end - 1 : end + 1], strains(curve)[end - 1 : end + 1]))


def spacings(curve: StretchCurve) -> tuple[FloatArray, FloatArray]:
    """Wale and course spacing of each state of a curve [cm]."""
    report = curve.free.report
    return curve.column("width") / report["wales"], curve.column("height") / report["courses"]
