# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far the size of knits off the needles depends on the number of contact samples.

    python benchmarks/contact_samples.py stockinette garter rib2x2 seed moss rope-cable --device cpu

Each pattern of the library is let go with friction (``relaxation = "dry"``) with as many contact samples a segment as
such a knit has, and with twice as many. The last column is the larger relative difference of both sizes. The times are
those of one swatch after another.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

import stitchmesh as sm
from stitchmesh.periodic.sampling.sampling import CONTACTS_RELEASED
from stitchmesh.quality import PRESETS


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("patterns", nargs="+", help="patterns of the library")
    parser.add_argument("--quality", default="draft", help="preset (default: draft)")
    parser.add_argument("--device", default="cpu", help="device of the kernels (default: cpu)")
    given = parser.parse_args()
    columns = [f"{factor * CONTACTS_RELEASED} samples [cm] | s" for factor in (1, 2)]
    print(f"| pattern | {' | '.join(columns)} | difference % |")
    print("|---|---|---:|---|---:|---:|")
    for pattern in given.patterns:
        found = [_relaxed(pattern, given.quality, given.device, factor) for factor in (1, 2)]
        cells = " | ".join(_cells(report) for report in found)
        apart = max(abs(found[1][name] / found[0][name] - 1.0) for name in ("width", "height"))
        print(f"| {pattern} | {cells} | {100.0 * apart:.2f} |", flush=True)


def _relaxed(pattern: str, quality: str, device: str, factor: int) -> dict[str, Any]:
    """The report of a swatch with a multiple of the contact samples."""
    sampled = replace(PRESETS[quality], contact_samples=factor * CONTACTS_RELEASED)
    return sm.swatch(pattern, quality=sampled, relaxation="dry", device=device, progress=False).report


def _cells(report: dict[str, Any]) -> str:
    """Width and height, whether they are those of a state of rest, and the time."""
    size = f"{report['width']:.3f} x {report['height']:.3f}"
    return f"{size}{'' if report['converged'] else ', not at rest'} | {report['seconds']:.1f}"


if __name__ == "__main__":
    main()
