# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Finished measures: a hat of rib, lace and stockinette that was made for its measures, relaxed with nothing around it.

The recipe comes to the measures by ``sm.finished_garment``. Its yarns are then generated and relaxed without the shape
of their surface. A girth is the sum of the distances of neighbouring stitches around a row, and the length the sum of
the distances along the wales, from row to row, whichever way the free fabric curls.
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

import stitchmesh as sm
from benchmarks.table import Rows, note
from stitchmesh.mesh import BORDER, BOTTOM, FloatArray, StitchMesh
from stitchmesh.mesh.courses import right_neighbours
from stitchmesh.pipeline.garment import Garment, whole_mesh
from stitchmesh.pipeline.stage_table import LABEL, STITCHES, YARNS, run_stages
from stitchmesh.recipe.finished import natural_sizes
from stitchmesh.recipe.recipe import recipe_options
from stitchmesh.recipe.sections import RecipePattern
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import apply_rest_lengths

HAT = Path(__file__).resolve().parents[3] / "assets" / "meshes" / "hat.obj"
PATTERNS = (RecipePattern(pattern="rib2x2", on="hem 5"), RecipePattern(pattern="eyelet-lace", on="hem 9-14"))
"""A hem of rib, and a band of lace above plain rows."""


def finished_garment(
    head: float = 56.0, length: float = 24.0, yarn: str = "super-bulky", quality: str = "draft", device: str = "cpu"
) -> Rows:
    """Make a hat for its measures, and relax it free.

    Args:
        head: girth of the hat [cm].
        length: its height [cm].
        yarn: name of the yarn.
        quality: preset of the swatches and of the yarns.
        device: device of the kernels.
    """
    recipe = sm.Recipe(mesh=str(HAT), yarn=yarn, quality=quality, device=device, patterns=PATTERNS)
    began = time.perf_counter()
    sized = sm.finished_garment(recipe, {"head": head, "length": length}, quality=quality, progress=False)
    note(f"the numbers of stitches are found after {time.perf_counter() - began:.0f} s: {sized.report()}")
    options = recipe_options(sized.recipe)
    garment = run_stages(
        (LABEL, *STITCHES, *YARNS), Garment.begin(whole_mesh(sized.mesh), options),
        lambda stage, done: stage.run(done, Run(False)),
    )  # fmt: skip
    fabric = garment.fabric
    yarns = apply_rest_lengths(garment.yarns, options.relaxation.rest_lengths, fabric=fabric)
    relaxed = sm.relax_yarns(
        yarns, material=options.relaxation.yarn_material(yarns), quality=quality, device=device, run=Run(False)
    )
    note(f"{fabric.face_count} stitches are relaxed free after {time.perf_counter() - began:.0f} s")
    yield f"Free yarns are at rest: {relaxed.report['converged']}, after {relaxed.report['iterations']} iterations."
    width, height = natural_sizes(fabric, options, sized.gauges)
    yield "part", "planned girth [cm]", "free girth", "error", "planned height of a row [cm]", "free height", "error"
    girth, step = _sizes(relaxed.yarns, fabric)
    for part, rows in _parts(fabric).items():
        planned = np.mean([width[fabric.row == row].sum() for row in rows])
        free = np.mean([girth[row] for row in rows])
        own, tall = (float(np.mean(values[np.isin(fabric.row, rows)])) for values in (height, step))
        yield (
            part, f"{planned:.2f}", f"{free:.2f}", f"{free / planned - 1.0:+.1%}", f"{own:.4f}", f"{tall:.4f}",
            f"{tall / own - 1.0:+.1%}",
        )  # fmt: skip


def _parts(fabric: StitchMesh) -> dict[str, list[int]]:
    """The rows of each part, without the rows at its ends, which the parts beside it draw in or widen."""
    first = int(fabric.row.min())
    bounds = {"rib": (1, 4), "lace": (9, 13), "stockinette": (15, 17)}
    return {name: list(range(first + begin, first + end)) for name, (begin, end) in bounds.items()}


def _sizes(yarns: YarnSet, fabric: StitchMesh) -> tuple[FloatArray, FloatArray]:
    """Return the girth of each row, and the distance of each stitch from the one below it [cm]."""
    made = yarns.face >= 0
    count = np.maximum(np.bincount(yarns.face[made], minlength=fabric.face_count), 1)
    sums = [np.bincount(yarns.face[made], yarns.points[made, axis], fabric.face_count) for axis in range(3)]
    middle = np.stack(sums, axis=1) / count[:, None]
    right = right_neighbours(fabric)
    apart = np.where(right == BORDER, 0.0, np.linalg.norm(middle[right] - middle, axis=1))
    girth = np.bincount(fabric.row, apart)
    below = np.full(fabric.face_count, np.nan)
    sides = np.flatnonzero((fabric.side_role == BOTTOM) & (fabric.twin != BORDER))
    face, other = fabric.side_face[sides], fabric.side_face[fabric.twin[sides]]
    below[face] = np.linalg.norm(middle[face] - middle[other], axis=1)
    return girth, np.where(np.isnan(below), np.nanmean(below), below)
