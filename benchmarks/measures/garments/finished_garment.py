# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Finished measures: a hat of rib, lace and stockinette that was made for its measures, relaxed with nothing around it.

The recipe comes to the measures by ``sm.finished_garment``. Its yarns are then generated and relaxed without the shape
of their surface. In a rib neighbouring stitches lie in front and behind, so that their distance is not the width of a
wale. The girth is therefore the length of the row after each stitch has got the mean place of ``REPEAT`` neighbours. Of
a flat swatch this is its width exactly; a round row of N stitches shrinks by REPEAT sin(pi / N) / sin(REPEAT pi / N),
which is added again. The height of a row is the length of the mean way from a stitch to those above it, of as many
neighbours, so that stitches of a lace that lean to either side do not count as high.
"""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import stitchmesh as sm
from benchmarks.table import Rows, note
from stitchmesh.mesh import BORDER, BOTTOM, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.courses import right_neighbours
from stitchmesh.periodic.swatch_options import KnitState
from stitchmesh.pipeline.garment import Garment, whole_mesh
from stitchmesh.pipeline.stage_table import LABEL, STITCHES, YARNS, run_stages
from stitchmesh.quality import quality_named, quality_with
from stitchmesh.recipe.finished import natural_sizes
from stitchmesh.recipe.recipe import recipe_options
from stitchmesh.recipe.sections import RecipePattern
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import apply_rest_lengths

HAT = Path(__file__).resolve().parents[3] / "assets" / "meshes" / "hat.obj"
PATTERNS = (RecipePattern(pattern="rib2x2", on="hem 5"), RecipePattern(pattern="eyelet-lace", on="hem 9-14"))
"""A hem of rib, and a band of lace above plain rows."""


REPEAT = 4
"""Wales of a repeat of the rib and of the lace."""


def finished_garment(
    head: float = 56.0, length: float = 24.0, yarn: str = "super-bulky", quality: str = "draft", device: str = "cpu",
    tolerance: float | None = None, iterations: int | None = None, relaxation: KnitState = "wet", even: bool = False,
) -> Rows:  # fmt: skip
    """Make a hat for its measures, and relax it free.

    Args:
        head: girth of the hat [cm].
        length: its height [cm].
        yarn: name of the yarn.
        quality: preset of the swatches and of the yarns.
        device: device of the kernels.
        tolerance: tolerance of the free relaxation; None for that of the preset.
        iterations: largest number of its iterations; None for that of the preset.
        relaxation: state of the swatches.
        even: put the control points of the free yarns at equal distances.
    """
    recipe = sm.Recipe(mesh=str(HAT), yarn=yarn, quality=quality, device=device, patterns=PATTERNS)
    began = time.perf_counter()
    sized = sm.finished_garment(
        recipe, {"head": head, "length": length}, quality=quality, relaxation=relaxation, progress=False
    )
    note(f"the numbers of stitches are found after {time.perf_counter() - began:.0f} s: {sized.report()}")
    options = recipe_options(sized.recipe)
    garment = run_stages(
        (LABEL, *STITCHES, *YARNS), Garment.begin(whole_mesh(sized.mesh), options),
        lambda stage, done: stage.run(done, Run(False)),
    )  # fmt: skip
    fabric = garment.fabric
    yarns = apply_rest_lengths(garment.yarns, options.relaxation.rest_lengths, fabric=fabric)
    preset = quality_named(quality_with(quality, max_iterations=iterations))
    relaxed = sm.relax_yarns(
        sm.sample_evenly(yarns) if even else yarns, material=options.relaxation.yarn_material(yarns), device=device,
        quality=preset if tolerance is None else replace(preset, tolerance=tolerance), run=Run(False),
    )  # fmt: skip
    note(f"{fabric.face_count} stitches are relaxed free after {time.perf_counter() - began:.0f} s")
    yield f"Free yarns are at rest: {relaxed.report['converged']}, after {relaxed.report['iterations']} iterations."
    width, height = natural_sizes(fabric, options, sized.gauges)
    yield "part", "planned girth [cm]", "free girth", "error", "planned height of a row [cm]", "free height", "error"
    girth, step = sizes_of_rows(relaxed.yarns, fabric)
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


def sizes_of_rows(yarns: YarnSet, fabric: StitchMesh) -> tuple[FloatArray, FloatArray]:
    """Return the girth of each row, and at each stitch the height of a row [cm]."""
    made = yarns.face >= 0
    count = np.maximum(np.bincount(yarns.face[made], minlength=fabric.face_count), 1)
    sums = [np.bincount(yarns.face[made], yarns.points[made, axis], fabric.face_count) for axis in range(3)]
    middle = np.stack(sums, axis=1) / count[:, None]
    sides = np.flatnonzero((fabric.side_role == BOTTOM) & (fabric.twin != BORDER))
    face, up = fabric.side_face[sides], middle[fabric.side_face[sides]] - middle[fabric.side_face[fabric.twin[sides]]]
    ups = np.stack([np.bincount(face, up[:, axis], fabric.face_count) for axis in range(3)], axis=1)
    pairs = np.bincount(face, minlength=fabric.face_count)
    right, girth = right_neighbours(fabric), np.zeros(int(fabric.row.max()) + 1)
    step = np.full(fabric.face_count, np.nan)
    for row in range(len(girth)):
        ring = _ring(right, int(np.flatnonzero(fabric.row == row)[0]))
        smooth = np.mean([np.roll(middle[ring], -k, axis=0) for k in range(REPEAT)], axis=0)
        shrunk = np.sin(REPEAT * np.pi / len(ring)) / (REPEAT * np.sin(np.pi / len(ring)))
        girth[row] = np.linalg.norm(np.roll(smooth, -1, axis=0) - smooth, axis=1).sum() / shrunk
        count = np.sum([np.roll(pairs[ring], -k) for k in range(REPEAT)], axis=0)
        if count.all():
            total = np.sum([np.roll(ups[ring], -k, axis=0) for k in range(REPEAT)], axis=0)
            step[ring] = np.linalg.norm(total / count[:, None], axis=1)
    return girth, np.where(np.isnan(step), np.nanmean(step), step)


def _ring(right: IntArray, first: int) -> list[int]:
    """Return the stitches of a closed row, from one of them to the right."""
    ring, face = [first], int(right[first])
    while face != first:
        ring.append(face)
        face = int(right[face])
    return ring
