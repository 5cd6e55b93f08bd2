# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A pattern in the round: ropes up a hat, and what a hand knitter would read.

    python examples/cable_a_hat.py

`stitchmesh patterns` lists the library; docs/patterns.md is the language that PATTERN is written in.
"""

from __future__ import annotations

from pathlib import Path

import stitchmesh as sm

MESH = Path(__file__).resolve().parent.parent / "assets" / "meshes" / "hat.obj"
PATTERN = """
pattern "Rope between purls"
rounds 1-3: p1 k4
round 4: p1 c4f
"""


def main(folder: Path = Path("out/cables"), stitch_width: float = 1.6) -> sm.YarnSet:
    """Knit the hat in ropes, chained off, and write it in words too."""
    mesh = sm.read_mesh(MESH)
    fabric = sm.tessellate(sm.label(mesh), stitch_width=stitch_width)
    fabric = sm.apply_pattern(fabric, sm.parse_pattern(PATTERN))  # columns follow the wales of the hat
    fabric = sm.relax_mesh(fabric, surface=mesh)
    yarns = sm.generate_yarns(fabric, quality="draft", bind_off="chain")
    result = sm.relax_yarns(yarns, quality="draft", device="cpu", keep_shape=fabric)
    sm.write_stitches(folder / "stitches.h5", fabric)
    sm.write_yarns(folder / "yarns.h5", result.yarns)
    (folder / "hat.txt").write_text(sm.knitting_instructions(fabric), encoding="utf-8")
    return result.yarns


if __name__ == "__main__":
    main()
