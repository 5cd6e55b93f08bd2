# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time to read each pattern of the library and to apply it to a whole garment, and the number of faces in the pattern.

The targets for the dress of 60,694 faces are 1 s if the pattern keeps the faces, and 5 s if it replaces faces.
"""

from __future__ import annotations

import time
from pathlib import Path

from benchmarks.places import ROOT
from benchmarks.table import Rows
from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.mesh import StitchMesh
from stitchmesh.patterns import lay_pattern, parse_pattern, pattern_names
from stitchmesh.patterns.placement.columns import keeps_counts
from stitchmesh.tessellate import tessellate

ASSETS = ROOT / "assets"


def measured(fabric: StitchMesh, path: Path) -> tuple[object, ...]:
    """A line of the table."""
    text = path.read_text()
    begin = time.perf_counter()
    pattern = parse_pattern(text, path.name)
    parsed = time.perf_counter()
    laid = lay_pattern(fabric, pattern)
    applied = time.perf_counter()
    size = f"{sum(pattern.rows[0].bottoms)} x {pattern.height}"
    kind = "stay" if keeps_counts(pattern) else "replaced"
    times = f"{1e3 * (parsed - begin):.2f}", f"{applied - parsed:.3f}"
    return path.stem, size, kind, *times, laid.faces_laid


def patterns(*, garment: str = "dress", stitch_width: float = 0.45) -> Rows:
    """Yield the table.

    Args:
        garment: name of a mesh of assets/meshes
        stitch_width: [cm]
    """
    mesh = read_mesh(ASSETS / "meshes" / f"{garment}.obj")
    fabric = tessellate(label(mesh), stitch_width=stitch_width)
    yield f"{garment}, {fabric.face_count} faces"
    yield "pattern", "size", "faces", "read [ms]", "lay [s]", "laid"
    for name in pattern_names():
        yield measured(fabric, ASSETS / "patterns" / f"{name}.knit")
