# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Make stitches tighter where a garment should be narrower, and relax yarn with weight and friction.

    python examples/draw_in_a_waist.py

Rest lengths determine the length of yarn in each stitch. Energy terms that are not requested have no cost.
"""

from __future__ import annotations

from pathlib import Path

import stitchmesh as sm

MESH = Path(__file__).resolve().parent.parent / "assets" / "meshes" / "hat.obj"
DOWN = (0.0, -981.0, 0.0)  # Acceleration of gravity [cm / s^2].


def main(folder: Path = Path("out/waist"), stitch_width: float = 1.6) -> sm.YarnSet:
    """Knit the hat with less yarn in every second row of its lower half."""
    fabric = sm.tessellate(sm.label(sm.read_mesh(MESH)), stitch_width=stitch_width)
    half = int(fabric.row.max()) // 2
    tight = sm.RestLengths(factor=1.02, rows=dict.fromkeys(range(1, half, 2), 0.97))
    yarns = sm.apply_rest_lengths(sm.generate_yarns(fabric, quality="draft"), tight)
    terms = [sm.Gravity(DOWN), sm.Friction(0.3)]
    result = sm.relax_yarns(yarns, quality="draft", device="cpu", keep_shape=fabric, terms=terms)
    for name, energy in result.report["energies"].items():
        print(f"{name:<10} {energy:12.1f} erg")
    sm.write_yarns(folder / "yarns.usdc", result.yarns)
    return result.yarns


if __name__ == "__main__":
    main()
