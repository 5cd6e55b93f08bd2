# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time to read each pattern of the library and to apply it to a whole garment, and the number of faces in the pattern.

    python benchmarks/patterns.py
    python benchmarks/patterns.py --garment hat --stitch-width 0.8

The targets for the dress of 60,694 faces are 1 s if the pattern keeps the faces, and 5 s if it replaces faces.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.mesh import StitchMesh
from stitchmesh.patterns import lay_pattern, parse_pattern, pattern_names
from stitchmesh.patterns.placement.columns import keeps_counts
from stitchmesh.tessellate import tessellate

ASSETS = Path(__file__).resolve().parent.parent / "assets"


def measured(fabric: StitchMesh, path: Path) -> str:
    """A line of the table."""
    text = path.read_text()
    begin = time.perf_counter()
    pattern = parse_pattern(text, path.name)
    parsed = time.perf_counter()
    laid = lay_pattern(fabric, pattern)
    applied = time.perf_counter()
    size = f"{sum(pattern.rows[0].bottoms)} x {pattern.height}"
    kind = "stay" if keeps_counts(pattern) else "replaced"
    times = f"{1e3 * (parsed - begin):10.2f} {applied - parsed:9.3f}"
    return f"{path.stem:24} {size:>8} {kind:>9} {times} {laid.faces_laid:9}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--garment", default="dress", help="name of a mesh of assets/meshes")
    parser.add_argument("--stitch-width", type=float, default=0.45, help="[cm]")
    arguments = parser.parse_args()
    mesh = read_mesh(ASSETS / "meshes" / f"{arguments.garment}.obj")
    fabric = tessellate(label(mesh), stitch_width=arguments.stitch_width)
    print(f"{arguments.garment}, {fabric.face_count} faces")
    print(f"{'pattern':24} {'size':>8} {'faces':>9} {'read [ms]':>10} {'lay [s]':>9} {'laid':>9}")
    for name in pattern_names():
        print(measured(fabric, ASSETS / "patterns" / f"{name}.knit"), flush=True)


if __name__ == "__main__":
    main()
