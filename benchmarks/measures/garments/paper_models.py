# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The garments of Yuksel et al. 2012, table 2, at their numbers of stitches: modelled, patterned and relaxed.

The meshes are our own (``assets/meshes``); the paper gives no patterns beyond names. The stitch width is the one that
gives about the paper's number of stitches, or ``--share`` of it. The seconds of the
yarns are those of ``relax_yarns`` with loaded kernels, and the paper's hours are those of its computer of 2012.
``--draw`` draws the yarns that are in the folder, and writes them as one picture.
"""

from __future__ import annotations

import json
import time
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from tyro.conf import Positional

import stitchmesh as sm
from benchmarks.options import Output
from benchmarks.places import MESHES
from benchmarks.table import Rows
from benchmarks.timing import relaxed
from stitchmesh.mesh import StitchMesh
from stitchmesh.quality import PRESETS
from stitchmesh.run import QUIET
from stitchmesh.yarn import YarnSet

HEAD = (
    "model", "pattern", "stitches", "points", "mesh s", "yarns s", "iterations", "at rest", "residual", "strain %",
    "nearest, radii", "passed through", "certificate", "Y: stitches", "points", "hours",
)  # fmt: skip
COLUMNS, SIZE, FINER = 4, (480, 480), 2
"""Pictures in a row of the sheet, their size [pixels], and how much larger they are drawn than shown."""


@dataclass(frozen=True)
class Model:
    """A garment of the paper."""

    name: str
    mesh: str
    pattern: str | None
    """Name of the pattern; None for plain knit."""
    stitches: int
    points: int
    hours: float
    """Numbers of stitches and control points, and hours of the yarn relaxation, in the paper; 0 where it has none."""
    sideways: bool = False
    """Whether rows run along the body instead of around it."""
    view: str = "front"


MODELS = (
    Model("sweater", "sweater", None, 21_568, 407_746, 7),
    Model("sweater-feather", "sweater", "ridged-feather", 21_568, 407_746, 7),
    Model("dress-1", "dress", None, 60_560, 1_134_597, 9),
    Model("dress-2", "dress", None, 65_732, 1_194_833, 11, sideways=True),
    Model("glove", "glove", "rib1x1", 5_373, 88_196, 1),
    Model("tea-cozy", "tea_cozy", None, 10_220, 208_506, 2),
    Model("poncho", "poncho", "rib2x2", 9_976, 166_882, 1),
    Model("sock", "sock", None, 10_000, 0, 0, view="60,10"),
    Model("alien-1", "alien", None, 13_440, 209_170, 2),
    Model("alien-2", "alien", "braid-cables", 13_440, 213_856, 33),
    Model("sheep", "sheep", "ridged-feather", 52_916, 1_094_173, 21, view="60,10"),
)


def knitted(model: Model, stitches: float) -> tuple[sm.Mesh, StitchMesh]:
    """The mesh, and its stitches, about as many as asked for, with the pattern laid on all of them."""
    mesh = sm.read_mesh(MESHES / f"{model.mesh}.obj")
    labeled = sm.label(mesh)
    if model.sideways:
        side = int(np.flatnonzero(labeled.is_wale)[0])
        ends = int(labeled.face_vertex[side]), int(labeled.face_vertex[labeled.side_next[side]])
        labeled = sm.label(mesh, seeds=[ends])
    width = 1.0
    for _ in range(4):
        fabric = sm.tessellate(labeled, stitch_width=width)
        width *= float(np.sqrt(fabric.face_count / stitches))
    return mesh, fabric if model.pattern is None else sm.apply_pattern(fabric, model.pattern)


def yarns_of(model: Model, share: float, quality: str, device: str | None) -> tuple[StitchMesh, YarnSet, float]:
    """The relaxed stitches, their yarns, and the seconds of mesh relaxation."""
    mesh, fabric = knitted(model, share * model.stitches)
    began = time.perf_counter()
    fabric = sm.relax_mesh(fabric, surface=mesh, device=device or "cpu", run=QUIET).fabric
    seconds = time.perf_counter() - began
    return fabric, sm.generate_yarns(fabric, quality=quality), seconds


def measured(model: Model, given: Options) -> dict[str, Any]:
    """Knit and relax a model, write its yarns, and return its numbers."""
    fabric, yarns, mesh_seconds = yarns_of(model, given.share, given.quality, given.device)
    found, seconds = relaxed(yarns, PRESETS[given.quality], keep_shape=fabric, device=given.device, run=QUIET)
    given.output.mkdir(parents=True, exist_ok=True)
    np.save(given.output / f"{model.name}.npy", found.yarns.points.astype(np.float32))
    report = found.report
    kept = ("converged", "residual", "iterations", "max_strain", "min_distance_over_radius", "pull_throughs")
    return {
        "stitches": fabric.face_count, "points": len(yarns.points), "mesh_seconds": mesh_seconds, "seconds": seconds,
        **{key: report[key] for key in kept}, "certificate": report["certificate"],
        "stopped": report.get("stopped"), "remaining_change": report["remaining_change"],
    }  # fmt: skip


def row_of(model: Model, row: dict[str, Any]) -> tuple[object, ...]:
    """The row of a model in the table."""
    paper = ("", "", "") if not model.points else (f"{model.stitches:,}", f"{model.points:,}", f"{model.hours:g}")
    return (
        model.name, model.pattern or "plain", f"{row['stitches']:,}", f"{row['points']:,}",
        f"{row['mesh_seconds']:.1f}", f"{row['seconds']:.1f}", f"{row['iterations']:,}",
        "yes" if row["converged"] else "no", f"{row['residual']:.2g}", f"{100 * row['max_strain']:.2g}",
        f"{row['min_distance_over_radius']:.2f}", row["pull_throughs"], row["certificate"], *paper,
    )  # fmt: skip


def draw(models: list[Model], given: Options) -> None:
    """Draw the yarns that are in the folder."""
    from benchmarks.sheet import drawn
    from stitchmesh.render.animation_pictures import joined

    pictures = []
    for model in models:
        file = given.output / f"{model.name}.npy"
        if file.exists():
            _, yarns, _ = yarns_of(model, given.share, given.quality, given.device)
            yarns = replace(yarns, points=np.load(file).astype(float))
            large = (FINER * SIZE[0], FINER * SIZE[1])
            pictures.append(drawn(partial(sm.render, yarns, view=model.view, size=large), SIZE))
    joined(pictures, COLUMNS).save(given.output / "models.jpg", quality=88)


@dataclass(frozen=True)
class Options:
    """What is measured."""

    output: Output
    models: Positional[tuple[str, ...]] = ()
    share: float = 1.0
    """of the paper's number of stitches"""
    quality: str = "standard"
    device: str | None = None
    draw: bool = False
    """draw the yarns of an earlier run"""


def paper_models(given: Options) -> Rows:
    """Measure or draw the models named on the command line."""
    chosen = [model for model in MODELS if model.name in given.models or not given.models]
    if given.draw:
        draw(chosen, given)
        return
    yield HEAD
    rows = {}
    for model in chosen:
        try:
            rows[model.name] = measured(model, given)
        except sm.StitchMeshError as error:
            yield model.name, error
            continue
        yield row_of(model, rows[model.name])
        (given.output / "models.json").write_text(json.dumps(rows, indent=1, default=float))
