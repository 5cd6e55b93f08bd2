# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Apply a pattern in the round: cables on a hat, and the written instructions for a hand knitter.

    python examples/cable_a_hat.py

The command `stitchmesh patterns` lists the library of patterns; docs/patterns.md describes the language of PATTERN.
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
    """Knit the hat with cables and a chained bind-off, and also write its hand-knitting instructions."""
    mesh = sm.read_mesh(MESH)
    fabric = sm.tessellate(sm.label(mesh), stitch_width=stitch_width)
    fabric = sm.apply_pattern(fabric, sm.parse_pattern(PATTERN))  # Columns of the pattern follow the wales of the hat.
    fabric = sm.relax_mesh(fabric, surface=mesh).fabric
    yarns = sm.generate_yarns(fabric, quality="draft", finish=sm.YarnFinish(bind_off="chain"))
    result = sm.relax_yarns(yarns, quality="draft", device="cpu", keep_shape=fabric)
    sm.write_stitches(folder / "stitches.h5", fabric)
    sm.write_yarns(folder / "yarns.h5", result.yarns)
    (folder / "hat.txt").write_text(sm.knitting_instructions(fabric), encoding="utf-8")
    return result.yarns


if __name__ == "__main__":
    main()
