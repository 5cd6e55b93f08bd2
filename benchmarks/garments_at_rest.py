# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far from rest garments are that say they are at rest.

    python benchmarks/garments_at_rest.py skirt.obj --unit dm --stitch-width 0.8
    python benchmarks/garments_at_rest.py assets/meshes/hat.obj --stitch-width 0.6 --device cpu --iterations 10000
    python benchmarks/garments_at_rest.py glove.bcc
    python benchmarks/garments_at_rest.py assets/meshes/hat.obj --stitch-width 0.6 --course

A mesh is knitted and keeps its shape; yarns of a file are free. Each preset relaxes the yarns that it samples. The same
yarns, relaxed on by the same solver for ``--iterations`` iterations, are taken for their rest. The error is the largest
relative error of the mean distance of neighbouring stitches, along the yarns and across them, and the estimate is the
``remaining_change`` of the report. The last column is the residual of that long run. Kernels are loaded before the
clock starts. With ``--course``, each line is a state on the way of the long run, the last column error over residual.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import stitchmesh as sm
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import Relaxation
from stitchmesh.yarnrelax.solvers.spacing_change import SpacingChange

HEAD = """| scene | points | quality | seconds | iterations | at rest | residual | error % | estimate % | long run |
|---|---:|---|---:|---:|---|---:|---:|---:|---:|"""


def relaxed(yarns: YarnSet, quality: Quality, options: Mapping[str, Any]) -> tuple[Relaxation, float]:
    """Relax yarns, and measure the time with loaded kernels [s]."""
    sm.relax_yarns(yarns, quality=replace(quality, max_iterations=20), **options)
    began = time.perf_counter()
    return sm.relax_yarns(yarns, quality=quality, **options), time.perf_counter() - began


def spacings(stitches: SpacingChange, yarns: YarnSet) -> np.ndarray:
    """Mean distances of neighbouring stitches along the yarns and across them [cm], shape (2,)."""
    return stitches.mean_distances(stitches.middles(yarns.points))


def row(scene: str, name: str, yarns: YarnSet, most: int, options: Mapping[str, Any]) -> str:
    """The line of one preset."""
    quality, stitches = PRESETS[name], SpacingChange(yarns)
    found, seconds = relaxed(yarns, quality, options)
    never = replace(quality, tolerance=1e-12, largest_change=1e-12, max_iterations=most)
    rest = sm.relax_yarns(yarns, quality=never, **options)
    error = np.abs(spacings(stitches, found.yarns) / spacings(stitches, rest.yarns) - 1.0).max()
    report, left = found.report, found.report["remaining_change"]
    estimate = "" if left is None else f"{100 * left['spacing']:.2g}"
    at_rest = "yes" if report["converged"] else "no"
    return (
        f"| {scene} | {len(yarns.points):,} | {name} | {seconds:.3g} | {report['iterations']} | {at_rest} "
        f"| {report['residual']:.2g} | {100 * error:.2g} | {estimate} | {rest.report['residual']:.2g} |"
    )


def print_course(scene: str, name: str, yarns: YarnSet, most: int, options: Mapping[str, Any]) -> None:
    """Print how far the spacings are from those at the end of a long run, on the way there."""
    quality = replace(PRESETS[name], tolerance=1e-12, largest_change=1e-12)
    stitches, states = SpacingChange(yarns), []
    count = 60
    while count <= most:
        found = sm.relax_yarns(yarns, quality=replace(quality, max_iterations=count), **options)
        states.append((found.report, spacings(stitches, found.yarns)))
        count = round(count * 2.0**0.5 / 20.0) * 20
    print(f"\n{scene}, {name}, {len(yarns.points):,} control points\n\n| iterations | residual | error % | ratio |")
    print("|---:|---:|---:|---:|")
    for report, spacing in states[:-1]:
        error = float(np.abs(spacing / states[-1][1] - 1.0).max())
        residual = report["residual"]
        print(f"| {report['iterations']} | {residual:.2g} | {100 * error:.2g} | {error / residual:.2g} |")


def scene_of(path: str, arguments: argparse.Namespace, name: str) -> tuple[YarnSet, dict[str, Any]]:
    """Yarns of one scene as a preset samples them, and how they are held."""
    options: dict[str, Any] = {"device": arguments.device, "progress": False}
    if not path.endswith(".obj"):
        return sm.read_yarns(path), options
    mesh = sm.read_mesh(path, unit=arguments.unit)
    fabric = sm.tessellate(sm.label(mesh), stitch_width=arguments.stitch_width)
    fabric = sm.relax_mesh(fabric, surface=mesh, device=arguments.device, progress=False)
    yarns = sm.generate_yarns(fabric, yarn_radius=arguments.stitch_width / 8.0, quality=name)
    return yarns, {**options, "keep_shape": fabric}


def main() -> None:
    """Measure the scenes named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="+", help="meshes (.obj) or yarns (.bcc)")
    parser.add_argument("--unit", default="cm", help="unit of the meshes")
    parser.add_argument("--stitch-width", type=float, default=0.8, help="cm")
    parser.add_argument("--qualities", default="draft,standard")
    parser.add_argument("--iterations", type=int, default=30_000, help="of the longest run")
    parser.add_argument("--course", action="store_true", help="states on the way of the longest run")
    parser.add_argument("--device", default=None)
    arguments = parser.parse_args()
    if not arguments.course:
        print(HEAD)
    for path in arguments.scenes:
        for name in arguments.qualities.split(","):
            yarns, options = scene_of(path, arguments, name)
            given = (Path(path).stem, name, yarns, arguments.iterations, options)
            if arguments.course:
                print_course(*given)
            else:
                print(row(*given), flush=True)


if __name__ == "__main__":
    main()
