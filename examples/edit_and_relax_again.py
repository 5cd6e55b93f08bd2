# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edit stitches of a fabric whose yarns are relaxed, and relax the yarns again from their present state.

    python examples/edit_and_relax_again.py

docs/editing.md lists all edits, and compares the result with that of a relaxation from the beginning.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import stitchmesh as sm

MESH = Path(__file__).resolve().parent.parent / "assets" / "meshes" / "hat.obj"


def main(folder: Path = Path("out/edited"), stitch_width: float = 1.6) -> sm.YarnSet:
    """Purl two stitches of the hat, twist a loop and undo the twist, and relax the yarns again."""
    mesh = sm.read_mesh(MESH)
    fabric = sm.relax_mesh(sm.tessellate(sm.label(mesh), stitch_width=stitch_width), surface=mesh).fabric
    yarns = sm.generate_yarns(fabric, quality="draft")
    first = sm.relax_yarns(yarns, quality="draft", device="cpu", keep_shape=fabric)

    history = sm.History(fabric)
    row = np.flatnonzero((fabric.row == 4) & (fabric.stitch == sm.Stitch.KNIT))
    history.apply(sm.edits.change_stitch, faces=row[:4:2], stitch="p")
    history.apply(sm.edits.twist_loop, side=fabric.left_wale[row[8]] - 1, twist=1)
    history.undo()
    history.write(folder / "log.jsonl")

    yarns, start = sm.regenerate_yarns(first.yarns, fabric, history.fabric, quality="draft")
    again = sm.relax_yarns(
        yarns, quality="draft", device="cpu", keep_shape=history.fabric, run=sm.Run(start=start)
    )
    print(f"first relaxation: {first.report['iterations']} iterations, second: {again.report['iterations']}")
    sm.write_yarns(folder / "yarns.h5", again.yarns)
    return again.yarns


if __name__ == "__main__":
    main()
