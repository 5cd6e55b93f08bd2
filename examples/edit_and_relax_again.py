# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edit stitches of a fabric whose yarns are at rest, and relax again from there.

    python examples/edit_and_relax_again.py

docs/editing.md lists all edits, and says how well the yarns come to the same rest as if relaxed anew.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import stitchmesh as sm

MESH = Path(__file__).resolve().parent.parent / "assets" / "meshes" / "hat.obj"


def main(folder: Path = Path("out/edited"), stitch_width: float = 1.6) -> sm.YarnSet:
    """Purl a few stitches of the hat, change one's mind about one of them, and relax."""
    mesh = sm.read_mesh(MESH)
    fabric = sm.relax_mesh(sm.tessellate(sm.label(mesh), stitch_width=stitch_width), surface=mesh)
    yarns = sm.generate_yarns(fabric, quality="draft")
    anew = sm.relax_yarns(yarns, quality="draft", device="cpu", keep_shape=fabric)

    history = sm.History(fabric)
    row = np.flatnonzero((fabric.row == 4) & (fabric.stitch == sm.Stitch.KNIT))
    history.apply(sm.Edit("change_stitch", {"faces": row[:4:2].tolist(), "stitch": "p"}))
    history.apply(sm.Edit("twist_loop", {"side": int(fabric.left_wale[row[8]]) - 1, "twist": 1}))
    history.undo()
    history.save(folder / "log.jsonl")

    yarns, start = sm.regenerate_yarns(anew.yarns, fabric, history.fabric, quality="draft")
    again = sm.relax_yarns(yarns, start=start, quality="draft", device="cpu", keep_shape=history.fabric)
    print(f"{anew.report['iterations']} iterations anew, {again.report['iterations']} again")
    sm.write_yarns(folder / "yarns.h5", again.yarns)
    return again.yarns


if __name__ == "__main__":
    main()
