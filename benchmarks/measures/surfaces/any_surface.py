# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knit many surfaces without modelled rows, and print how well the stitches fit.

Each line is one surface: seconds for the stitches, stitches, increases and decreases a thousand, short rows, grafted
edges, distance to the input (rms and largest, in stitch widths), rms deviation of the stretch of stitches and of edges
after mesh relaxation, rows whose increases and decreases are at seams or spread, and with ``--relax`` the largest
strain and the certificate of the yarns at ``draft``.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from tyro.conf import Positional

import stitchmesh as sm
from benchmarks.places import MESHES
from benchmarks.table import Rows
from stitchmesh.errors import StitchMeshError
from stitchmesh.io.meshes import read_repaired_mesh
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.run import QUIET
from stitchmesh.shaping.auto_stitches import ShapedFabric
from stitchmesh.shaping.options import DEFAULT_PLACEMENT, Placement
from stitchmesh.shaping.report import shaping_report

SMALL = {"hat", "sock", "tea_cozy", "swatch"}
"""Garments that are knitted in stitches of 0.8 cm; the glove in stitches of 0.5 cm, larger ones of 1.6 cm."""
MOST_CHECKED = 10_000
"""Largest number of stitches whose loops are checked, which takes minutes beyond it."""
Scene = tuple[str, float, Callable[[], Mesh]]
"""Name of a surface, width of its stitches [cm], and the function that makes it."""


def scenes(options: Options) -> Iterator[Scene]:
    """The surfaces: the files that are named, or the project's own shapes and its garments, triangulated."""
    for path in options.files:
        yield path.stem, options.width, lambda path=path: read_repaired_mesh(path, unit=options.unit).mesh
    if options.files:
        return
    from benchmarks.surface_shapes import SHAPES, triangulated  # needs pyvista

    for name, make in SHAPES.items():
        yield name, 0.8, make
    for path in sorted(MESHES.glob("*.obj")):
        yield path.name, width_of(path), lambda path=path: triangulated(sm.read_mesh(path))


def width_of(garment: Path) -> float:
    """Return the width of the stitches in which a garment of the project is knitted [cm]."""
    return 0.5 if garment.stem == "glove" else 0.8 if garment.stem in SMALL else 1.6


def measure(scene: Scene, options: Options) -> tuple[object, ...]:
    """Knit one surface, and return its row of the table."""
    name, width, make = scene
    mesh = make()
    start = time.perf_counter()
    shaping = sm.ShapingOptions(most_shaping=options.most_shaping, shaping=options.shaping)
    shaped = sm.shape_fabric(mesh, stitch_width=width, options=shaping)
    seconds = time.perf_counter() - start
    made = relax_mesh(
        shaped.fabric, surface=shaped.surface_mesh, device=options.device, run=QUIET
    )
    fabric, how = made.fabric, made.report
    fabric = sm.make_room(fabric)
    report = shaping_report(fabric, shaped.given, width, seconds)
    row = (
        name, f"{seconds:.1f}", report.stitches, f"{report.irregular_per_thousand:.1f}", report.short_rows,
        report.mismatched_edges, f"{report.rms_distance:.3f}", f"{report.largest_distance:.2f}",
        f"{100 * (report.rms_stretch or 0):.1f}", f"{100 * (report.rms_edge_stretch or 0):.1f}",
        "yes" if how.converged else "no", shaped.report.stacked_rows, shaped.report.spread_rows,
    )  # fmt: skip
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        sm.write_stitches(options.out / f"{name}.h5", fabric)
    return *row, *(relaxed(name, replace(shaped, fabric=fabric), options) if options.relax else ())


def relaxed(name: str, shaped: ShapedFabric, options: Options) -> tuple[object, ...]:
    """Relax the yarns at ``draft``, and return the figures."""
    start = time.perf_counter()
    yarns = sm.generate_yarns(shaped.fabric)
    result = sm.relax_yarns(yarns, quality="draft", keep_shape=shaped.fabric, device=options.device, run=QUIET)
    report = result.report
    if options.out:
        sm.write_yarns(options.out / f"{name}-yarns.h5", result.yarns)
    checked = options.loops and shaped.fabric.face_count < MOST_CHECKED
    loops = loops_of(shaped.fabric, result.yarns) if checked else ""
    rest = "yes" if report["converged"] else "no"
    seconds = f"{time.perf_counter() - start:.1f}"
    return f"{100 * report['max_strain']:.1f}", report["certificate"], rest, seconds, loops


def loops_of(fabric: StitchMesh, yarns: sm.YarnSet) -> str:
    """Return ``held`` if each loop of the yarns is held as its stitch says, or what is wrong."""
    try:
        sm.check_loops(fabric, yarns)
    except StitchMeshError as error:
        return str(error)[:100]
    return "held"


HEAD = (
    "surface", "s", "stitches", "irregular / 1000", "short rows", "grafted", "rms", "max", "rms %", "edge %", "even",
    "seam", "spread",
)  # fmt: skip
HEAD_OF_YARNS = ("strain", "certificate", "rest", "s", "loops")


@dataclass(frozen=True)
class Options:
    """What is measured."""

    files: Positional[tuple[Path, ...]] = ()
    unit: str = "cm"
    width: float = 0.8
    relax: bool = False
    """relax the yarns at draft"""
    loops: bool = False
    """check the loops of the relaxed yarns"""
    device: str = "cpu"
    out: Path | None = None
    """folder for stitch meshes"""
    only: tuple[str, ...] = ()
    most_shaping: float | None = None
    """largest part of a row that is increases or decreases"""
    shaping: Placement = DEFAULT_PLACEMENT


def any_surface(options: Options) -> Rows:
    """Yield the table."""
    logging.disable(logging.WARNING)
    np.seterr(all="ignore")
    yield *HEAD, *(HEAD_OF_YARNS if options.relax else ())
    for scene in scenes(options):
        if options.only and scene[0] not in options.only:
            continue
        try:
            yield measure(scene, options)
        except StitchMeshError as error:
            yield scene[0], f"{type(error).__name__}: {error}"
