# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knit many surfaces without modelled rows, and print how well the stitches fit.

    python benchmarks/any_surface.py --relax                        # the project's shapes and garments
    python benchmarks/any_surface.py body.obj --unit dm --width 1.0  # any file

Each line is one surface: seconds for the stitches, stitches, increases and decreases a thousand, short rows, grafted
edges, distance to the input (rms and largest, in stitch widths), rms deviation of the stretch of stitches and of edges
after mesh relaxation, rows whose increases and decreases are at seams or spread, and with ``--relax`` the largest
strain and the certificate of the yarns at ``draft``.
"""

from __future__ import annotations

import argparse
import logging
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np

import stitchmesh as sm
from stitchmesh.errors import StitchMeshError
from stitchmesh.io.meshes import read_repaired_mesh
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.meshrelax import relax_mesh_with_report
from stitchmesh.shaping.auto_stitches import ShapedFabric
from stitchmesh.shaping.options import DEFAULT_PLACEMENT, Placement
from stitchmesh.shaping.report import shaping_report

GARMENTS = Path(__file__).resolve().parent.parent / "assets" / "meshes"
SMALL = {"hat", "sock", "tea_cozy", "swatch"}
"""Garments that are knitted in stitches of 0.8 cm; the glove in stitches of 0.5 cm, larger ones of 1.6 cm."""
MOST_CHECKED = 10_000
"""Largest number of stitches whose loops are checked, which takes minutes beyond it."""
Scene = tuple[str, float, Callable[[], Mesh]]
"""Name of a surface, width of its stitches [cm], and the function that makes it."""


def scenes(options: argparse.Namespace) -> Iterator[Scene]:
    """The surfaces: the files that are named, or the project's own shapes and its garments, triangulated."""
    for path in options.files:
        yield path.stem, options.width, lambda path=path: read_repaired_mesh(path, unit=options.unit).mesh
    if options.files:
        return
    from surface_shapes import SHAPES, triangulated  # needs pyvista

    for name, make in SHAPES.items():
        yield name, 0.8, make
    for path in sorted(GARMENTS.glob("*.obj")):
        yield path.name, width_of(path), lambda path=path: triangulated(sm.read_mesh(path))


def width_of(garment: Path) -> float:
    """Return the width of the stitches in which a garment of the project is knitted [cm]."""
    return 0.5 if garment.stem == "glove" else 0.8 if garment.stem in SMALL else 1.6


def measure(scene: Scene, options: argparse.Namespace) -> str:
    """Knit one surface, and return its line of the table."""
    name, width, make = scene
    options.name = name
    mesh = make()
    start = time.perf_counter()
    shaped = sm.shape_fabric(mesh, stitch_width=width, most_shaping=options.most_shaping, shaping=options.shaping)
    seconds = time.perf_counter() - start
    fabric, how = relax_mesh_with_report(
        shaped.fabric, surface=shaped.surface_mesh, device=options.device, progress=False
    )
    fabric = sm.make_room(fabric)
    report = shaping_report(fabric, shaped.given, width, seconds)
    line = (
        f"{name:24s} {seconds:6.1f} {report.stitches:7d} {report.irregular_per_thousand:6.1f} {report.short_rows:4d} "
        f"{report.mismatched_edges:4d} {report.rms_distance:6.3f} {report.largest_distance:5.2f} "
        f"{100 * (report.rms_stretch or 0):5.1f} {100 * (report.rms_edge_stretch or 0):5.1f} "
        f"{'yes' if how.converged else 'no ':3s} {shaped.report.stacked_rows:4d} {shaped.report.spread_rows:4d}"
    )
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        sm.write_stitches(options.out / f"{name}.h5", fabric)
    return line + (relaxed(replace(shaped, fabric=fabric), options) if options.relax else "")


def relaxed(shaped: ShapedFabric, options: argparse.Namespace) -> str:
    """Relax the yarns at ``draft``, and return the figures."""
    start = time.perf_counter()
    yarns = sm.generate_yarns(shaped.fabric)
    result = sm.relax_yarns(yarns, quality="draft", keep_shape=shaped.fabric, device=options.device, progress=False)
    report = result.report
    if options.out:
        sm.write_yarns(options.out / f"{options.name}-yarns.h5", result.yarns)
    checked = options.loops and shaped.fabric.face_count < MOST_CHECKED
    loops = f" {loops_of(shaped.fabric, result.yarns)}" if checked else ""
    return (
        f" {100 * report['max_strain']:6.1f} {report['certificate']:9s} {'yes' if report['converged'] else 'no ':3s} "
        f"{time.perf_counter() - start:6.1f}{loops}"
    )


def loops_of(fabric: StitchMesh, yarns: sm.YarnSet) -> str:
    """Return ``held`` if each loop of the yarns is held as its stitch says, or what is wrong."""
    try:
        sm.check_loops(fabric, yarns)
    except StitchMeshError as error:
        return str(error)[:100]
    return "held"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--unit", default="cm")
    parser.add_argument("--width", type=float, default=0.8)
    parser.add_argument("--relax", action="store_true", help="relax the yarns at draft")
    parser.add_argument("--loops", action="store_true", help="check the loops of the relaxed yarns")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--out", type=Path, help="folder for stitch meshes")
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--most-shaping", type=float, help="largest part of a row that is increases or decreases")
    parser.add_argument("--shaping", default=DEFAULT_PLACEMENT, choices=get_args(Placement))
    options = parser.parse_args()
    logging.disable(logging.WARNING)
    np.seterr(all="ignore")
    heads = "second stitch  irr/k shor graf rms    max   rms % edge% even seam sprd strain cert. rest second loops"
    print(f"{'surface':24s} {heads}")
    for scene in scenes(options):
        if options.only and scene[0] not in options.only:
            continue
        try:
            print(measure(scene, options), flush=True)
        except StitchMeshError as error:
            print(f"{scene[0]:24s} {type(error).__name__}: {error}", flush=True)


if __name__ == "__main__":
    main()
