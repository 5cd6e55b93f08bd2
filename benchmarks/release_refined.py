# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far the size of knits off the needles depends on the number of contact samples and of load steps.

    python benchmarks/release_refined.py stockinette garter rib2x2 seed moss rope-cable --device cpu

Each pattern of the library is let go dry, as it is, with twice as many contact samples a segment, and with twice and
with half as many steps in which the forces on its borders fall. A column has the size, its largest relative difference
from the first one, and the time of the swatch; the swatches are made one after another.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from typing import Any

import stitchmesh as sm
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


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("patterns", nargs="+", help="patterns of the library")
    parser.add_argument("--quality", default="draft", help="preset (default: draft)")
    parser.add_argument("--device", default="cpu", help="device of the kernels (default: cpu)")
    given = parser.parse_args()
    print(f"| pattern | {' | '.join(f'{each.samples} samples, {each.steps} steps [cm], s' for each in RESOLUTIONS)} |")
    print("|---|" + "---:|" * len(RESOLUTIONS))
    for pattern in given.patterns:
        found = [_relaxed(pattern, given.quality, given.device, each) for each in RESOLUTIONS]
        print(f"| {pattern} | {' | '.join(_cell(report, found[0]) for report in found)} |", flush=True)


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


if __name__ == "__main__":
    main()
