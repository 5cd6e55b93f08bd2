# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Make relaxed yarns from a polygon mesh, stage by stage.

    python examples/knit_a_hat.py

Every stage takes one object and returns a new one. Each of these objects can be written to a file and read again.
"""

from __future__ import annotations

from pathlib import Path

import stitchmesh as sm

MESH = Path(__file__).resolve().parent.parent / "assets" / "meshes" / "hat.obj"


def main(folder: Path = Path("out/hat"), stitch_width: float = 1.6) -> sm.YarnSet:
    """Knit the hat and write its stitches and yarns."""
    mesh = sm.read_mesh(MESH)  # Coordinates are in centimetres.
    labeled = sm.label(mesh)  # Rows are numbered from the brim upwards.
    fabric = sm.tessellate(labeled, stitch_width=stitch_width)
    fabric = sm.relax_mesh(fabric, surface=mesh).fabric  # The stitches become equal in size on the smooth surface.
    print(f"{fabric.face_count} stitches, stretched {fabric.face_stretch.min():.2f} to {fabric.face_stretch.max():.2f}")
    yarns = sm.generate_yarns(fabric, quality="draft")
    result = sm.relax_yarns(yarns, quality="draft", device="cpu", keep_shape=fabric)
    print(f"{result.report['iterations']} iterations, largest strain {result.report['max_strain']:.1%}")
    sm.write_stitches(folder / "stitches.h5", fabric)
    sm.write_yarns(folder / "yarns.bcc", result.yarns)
    return result.yarns


if __name__ == "__main__":
    main()
