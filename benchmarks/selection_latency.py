# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Times of selections, and of edits and patterns on selections with their undo, on a large garment.

Each time is that of a fabric whose cached values are not computed yet.
"""

from __future__ import annotations

import argparse
import platform
import time
from collections.abc import Callable

import numpy as np
from edit_latency import forgetful

from stitchmesh.editing.edit import Edit, apply_changes, apply_edit
from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.mesh import StitchMesh
from stitchmesh.patterns import lay_pattern
from stitchmesh.selection import borders, select
from stitchmesh.tessellate import tessellate

RUNS = 5
SELECTIONS = (
    "all", "rows 10-60 step 4", "last 6 rows", "hem 6", "cuffs 6", "neck 6", "border 0 40", "cuffs 7- step 8 height 4",
    "front", "back", "left", "sleeves", "left sleeve", "body", "front panel 20", "left panel 8", "stitch k",
    "decreases", "cast-on", "yarn 0", "faces 10-400", "wale 3000", "ring 3000 up 6", "rectangle 3000 20x30",
    "sleeves and cuffs 7- step 8 height 4", "front panel 20 and hem 10-57 and not cast-on",
)  # fmt: skip
EDITS = (
    Edit("stripe", {"on": "rows 10-60 step 4", "yarn": 1}),
    Edit("change_stitch", {"on": "front panel 20 and hem 10-57 and not (increases or decreases)", "stitch": "p"}),
    Edit("stripe", {"on": "sleeves and cuffs 7- step 8 height 4", "yarn": 1}),
)
PATTERNS = (
    ("rib2x2", "hem 6 or cuffs 6 or neck 5"),
    ("eyelet-lace", "front panel 20 and hem 10-57"),
    ("moss", "sleeves"),
)


def milliseconds(fabric: StitchMesh, work: Callable[[StitchMesh], object]) -> tuple[float, float]:
    """Return the median and the slowest time [ms] of some work on a fabric without cached values."""
    times = []
    for _ in range(RUNS):
        fresh = forgetful(fabric)
        start = time.perf_counter()
        work(fresh)
        times.append(1e3 * (time.perf_counter() - start))
    return float(np.median(times)), max(times)


def show(name: str, times: tuple[float, float], faces: int) -> None:
    """Print one line of the table."""
    print(f"{name:<62}{times[0]:>8.1f}{times[1]:>10.1f}{faces:>8}", flush=True)


def main() -> None:
    """Time the selections on one garment."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mesh", default="assets/meshes/sweater.obj")
    parser.add_argument("--stitch-width", type=float, default=0.8)
    arguments = parser.parse_args()
    fabric = tessellate(label(read_mesh(arguments.mesh)), stitch_width=arguments.stitch_width)
    print(f"{arguments.mesh}: {fabric.face_count} faces; Python {platform.python_version()}, {platform.machine()}")
    print(f"{'milliseconds':<62}{'median':>8}{'slowest':>10}{'faces':>8}")
    show("borders", milliseconds(fabric, borders), fabric.face_count)
    for text in SELECTIONS:
        show(text, milliseconds(fabric, lambda fresh, text=text: select(fresh, text)), len(select(fabric, text)))
    for edit in EDITS:
        name, edited = f"{edit.name} on {edit.arguments['on']}", apply_edit(fabric, edit)
        faces = len(select(fabric, str(edit.arguments["on"])))
        show(name, milliseconds(fabric, lambda fresh, edit=edit: apply_edit(fresh, edit)), faces)
        show(
            f"undo of {name}"[:60],
            milliseconds(edited.fabric, lambda fresh, edited=edited: apply_changes(fresh, edited.inverse)),
            faces,
        )
    for pattern, on in PATTERNS:
        faces = len(select(fabric, on))

        def lay(fresh: StitchMesh, pattern: str = pattern, on: str = on) -> object:
            return lay_pattern(fresh, pattern, faces=select(fresh, on))

        laid = lay_pattern(fabric, pattern, faces=select(fabric, on))
        show(f"{pattern} on {on}", milliseconds(fabric, lay), laid.faces_laid)


if __name__ == "__main__":
    main()
