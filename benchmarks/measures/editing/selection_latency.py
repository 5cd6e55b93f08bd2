# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Times of selections, and of edits and patterns on selections with their undo, on a large garment.

Each time is that of a fabric whose cached values are not computed yet.
"""

from __future__ import annotations

import platform
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks.measures.editing.edit_latency import forgetful
from benchmarks.table import Rows
from benchmarks.timing import milliseconds
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


def timed(fabric: StitchMesh, work: Callable[[StitchMesh], object]) -> NDArray[np.float64]:
    """Return the times of some work on a fabric without cached values [ms]."""
    return milliseconds(work, RUNS, lambda: forgetful(fabric))


def row_of(name: str, times: NDArray[np.float64], faces: int) -> tuple[object, ...]:
    """Return a row of the table."""
    return name, f"{np.median(times):.1f}", f"{times.max():.1f}", faces


def selection_latency(*, mesh: str = "assets/meshes/sweater.obj", stitch_width: float = 0.8) -> Rows:
    """Time the selections on one garment."""
    fabric = tessellate(label(read_mesh(mesh)), stitch_width=stitch_width)
    yield f"{mesh}: {fabric.face_count} faces; Python {platform.python_version()}, {platform.machine()}"
    yield "milliseconds", "median", "slowest", "faces"
    yield row_of("borders", timed(fabric, borders), fabric.face_count)
    for text in SELECTIONS:
        times = timed(fabric, lambda fresh, text=text: select(fresh, text))
        yield row_of(text, times, len(select(fabric, text)))
    for edit in EDITS:
        name, edited = f"{edit.name} on {edit.arguments['on']}", apply_edit(fabric, edit)
        faces = len(select(fabric, str(edit.arguments["on"])))
        yield row_of(name, timed(fabric, lambda fresh, edit=edit: apply_edit(fresh, edit)), faces)
        yield row_of(
            f"undo of {name}"[:60],
            timed(edited.fabric, lambda fresh, edited=edited: apply_changes(fresh, edited.inverse)),
            faces,
        )
    for pattern, on in PATTERNS:
        faces = len(select(fabric, on))

        def lay(fresh: StitchMesh, pattern: str = pattern, on: str = on) -> object:
            return lay_pattern(fresh, pattern, faces=select(fresh, on))

        laid = lay_pattern(fabric, pattern, faces=select(fabric, on))
        yield row_of(f"{pattern} on {on}", timed(fabric, lay), laid.faces_laid)
