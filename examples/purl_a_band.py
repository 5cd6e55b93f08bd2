# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Change stitches before the yarns are generated: a garter band in a knitted swatch.

    python examples/purl_a_band.py

A stitch mesh is immutable; ``dataclasses.replace`` returns a new one with other stitches.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import stitchmesh as sm

MESH = Path(__file__).resolve().parent.parent / "assets" / "meshes" / "swatch.obj"


def main(folder: Path = Path("out/band"), stitch_width: float = 1.6) -> sm.YarnSet:
    """Knit the swatch with every second row of its middle part purled."""
    fabric = sm.tessellate(sm.label(sm.read_mesh(MESH)), stitch_width=stitch_width)
    rows = int(fabric.row.max()) + 1
    band = (fabric.row > rows // 4) & (fabric.row < 3 * rows // 4) & (fabric.row % 2 == 0)
    fabric = replace(fabric, stitch=np.where(band, sm.Stitch.PURL, fabric.stitch))
    yarns = sm.generate_yarns(fabric, quality="draft")
    result = sm.relax_yarns(yarns, quality="draft", device="cpu", keep_shape=fabric)
    sm.write_yarns(folder / "yarns.h5", result.yarns)
    return result.yarns


if __name__ == "__main__":
    main()
