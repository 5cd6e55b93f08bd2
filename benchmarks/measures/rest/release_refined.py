# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far the size of knits off the needles depends on the number of contact samples and of load steps.

Each pattern of the library is let go dry, as it is, with twice as many contact samples a segment, and with twice and
with half as many steps in which the forces on its borders fall. A column has the size, its largest relative difference
from the first one, and the time of the swatch; the swatches are made one after another.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import stitchmesh as sm
from benchmarks.table import Rows
from stitchmesh.periodic.relaxation import off_needles
from stitchmesh.periodic.sampling.sampling import CONTACTS_RELEASED
from stitchmesh.quality import PRESETS

STEPS = off_needles.RELEASE_STEPS
"""Steps of a knit as it is."""


@dataclass(frozen=True)
class Resolution:
    """The resolution of a release."""

    samples: int = CONTACTS_RELEASED
    """Contact samples of a segment."""
    steps: int = STEPS
    """Steps in which the forces fall."""


RESOLUTIONS = (
    Resolution(), Resolution(samples=2 * CONTACTS_RELEASED), Resolution(steps=2 * STEPS), Resolution(steps=STEPS // 2),
)  # fmt: skip


def release_refined(patterns: tuple[str, ...], /, *, quality: str = "draft", device: str = "cpu") -> Rows:
    """Yield the table.

    Args:
        patterns: patterns of the library
        quality: preset (default: draft)
        device: device of the kernels (default: cpu)
    """
    yield "pattern", *(f"{each.samples} samples, {each.steps} steps [cm], s" for each in RESOLUTIONS)
    for pattern in patterns:
        found = [_relaxed(pattern, quality, device, each) for each in RESOLUTIONS]
        yield pattern, *(_cell(report, found[0]) for report in found)


def _relaxed(pattern: str, quality: str, device: str, resolution: Resolution) -> dict[str, Any]:
    """The report of a swatch."""
    off_needles.RELEASE_STEPS = resolution.steps
    sampled = replace(PRESETS[quality], contact_samples=resolution.samples)
    return sm.swatch(pattern, quality=sampled, relaxation="dry", device=device, progress=False).report


def _cell(report: dict[str, Any], first: dict[str, Any]) -> str:
    """Width and height, their difference, whether they are those of a state of rest, and the time."""
    size, rest = f"{report['width']:.3f} x {report['height']:.3f}", "" if report["converged"] else ", not at rest"
    apart = max(abs(report[name] / first[name] - 1.0) for name in ("width", "height"))
    difference = "" if report is first else f" ({100.0 * apart:.2f} %)"
    return f"{size}{difference}{rest}, {report['seconds']:.1f}"
