# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which relaxed swatches are in the same state of rest.

Two relaxations of one repeat end in the same state if the fabric has the same size, lean and relief. Yarns may have
moved along the fabric by any amount, to another image, along themselves, or to the place of an equal stitch, and the
fabric may be mirrored. The comparison therefore uses only figures that depend on none of this:

    width, height        of the repeat, relative differences
    lean                 the magnitude of the shear of the repeat
    relief               heights of points at equal distances along the yarns over their mean, in ascending order, over
                         the thickness; the root mean square of the differences, of the fabric or of its back

The distance of two states is the largest of these differences. It is symmetric and fulfils the triangle inequality up
to the choice of the side. States at a distance below ``SAME`` are the same. Each state is compared with the lowest
state of each group, in ascending order of energy, so that the result does not depend on the order of the starts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stitchmesh.lattice import lattice_frame
from stitchmesh.mesh import FloatArray
from stitchmesh.periodic.swatch import Swatch
from stitchmesh.yarn import YarnSet

SAME = 0.05
"""Distance below which two states are the same: the spacing that the quality ``draft`` promises."""
HEIGHTS = 256
"""Heights that are compared."""


@dataclass(frozen=True, eq=False)
class Rest:
    """A state of rest, and how many starts came to it."""

    swatch: Swatch
    """The swatch of the lowest energy that was found in this state."""
    count: int
    """Number of starts that came to this state."""
    usual: bool = False
    """Whether ``swatch`` comes to this state."""

    @property
    def energy(self) -> float:
        """Energy of a stitch [erg]."""
        return float(self.swatch.report["energy_per_stitch"])

    def row(self) -> dict[str, Any]:
        """Return the figures of the state as plain numbers and words."""
        report = self.swatch.report
        names = ("energy_per_stitch", "wale_spacing", "course_spacing", "thickness", "thickness_ratio", "course_fold",
                 "wale_fold", "shape")  # fmt: skip
        # A fabric leans from this value of its lean
        leaned = abs(report["shear"]) >= 0.02
        return {name: report[name] for name in names} | {
            "lean": report["shear"], "posture": "leaned" if leaned else "upright", "count": self.count,
            "usual": self.usual,
        }  # fmt: skip


def distance(first: YarnSet, second: YarnSet) -> float:
    """Return the distance of two states of the yarns of one repeat."""
    one, two = (_size(yarns) for yarns in (first, second))
    sizes = np.abs(np.log(one[:2] / two[:2])).max()
    return max(float(sizes), abs(abs(one[2]) - abs(two[2])), _relief_distance(first, second))


def distinct_rests(swatches: Sequence[Swatch], usual: Swatch | None = None) -> list[Rest]:
    """Group relaxed swatches by state, in ascending order of energy.

    Args:
        swatches: the relaxed swatches.
        usual: the swatch among these that ``swatch`` returns.
    """
    groups: list[list[Swatch]] = []
    for made in sorted(swatches, key=lambda made: float(made.report["energy_per_stitch"])):
        near = [group for group in groups if distance(group[0].yarns, made.yarns) < SAME]
        if near:
            near[0].append(made)
        else:
            groups.append([made])
    return [Rest(group[0], len(group), any(made is usual for made in group)) for group in groups]


def _size(yarns: YarnSet) -> FloatArray:
    """Return width and height of the repeat [cm], and its lean."""
    assert yarns.lattice is not None
    along, across, _normal = lattice_frame(yarns.lattice.periods)
    width, height = yarns.lattice.periods[0] @ along, yarns.lattice.periods[1] @ across
    return np.array([width, height, (yarns.lattice.periods[1] @ along) / height])


def _relief_distance(first: YarnSet, second: YarnSet) -> float:
    one, two = _relief(first), _relief(second)
    whole = max(float(np.ptp(one)), float(np.ptp(two)), 2.0 * float(first.radius.mean()))
    return min(float(np.sqrt(np.mean((one - other) ** 2))) for other in (two, -two[::-1])) / whole


def _relief(yarns: YarnSet) -> FloatArray:
    """Return heights over their mean in ascending order [cm], shape (HEIGHTS,): they are quantiles along the yarn."""
    assert yarns.lattice is not None
    curves = [curve @ lattice_frame(yarns.lattice.periods)[2] for curve in yarns.sampled(8)]
    height = np.concatenate(curves)
    quantiles: FloatArray = np.quantile(height - height.mean(), (np.arange(HEIGHTS) + 0.5) / HEIGHTS)
    return quantiles
