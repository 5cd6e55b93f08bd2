# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far from rest garments are that say they are at rest.

A mesh is knitted and keeps its shape; yarns of a file are free. Each preset relaxes the yarns that it samples. The same
yarns, relaxed on by the same solver for ``--iterations`` iterations, are taken for their rest. The error is the largest
relative error of the mean distance of neighbouring stitches, along the yarns and across them, and the estimate is the
``remaining_change`` of the report. The last column is the residual of that long run. Kernels are loaded before the
clock starts. With ``--course``, each line is a state on the way of the long run, the last column error over residual.

With ``--agree``, two solvers bring the yarns to rest at a residual of 1e-4 in double precision, with what the preset
samples: L-BFGS with Newton's method at its end, and L-BFGS alone, which estimates the change that is left. The
difference is the largest one of the two spacings. ``flared_skirt`` is the one of ``mesh_relaxation.py``.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from tyro.conf import Positional

import stitchmesh as sm
from benchmarks.measures.garments.mesh_relaxation import SCENES
from benchmarks.table import Rows
from stitchmesh.compute.device import device_named
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.run import QUIET
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import Relaxation, YarnMaterial
from stitchmesh.yarnrelax.assembled_hessian import HessianAssembly
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.spacing_change import SpacingChange

HEAD = (
    "scene", "points", "quality", "seconds", "iterations", "at rest", "residual", "error %", "estimate %", "long run",
)  # fmt: skip
HEAD_OF_SOLVERS = (
    "scene", "points", "solver", "seconds", "iterations", "at rest", "residual", "left %", "erg", "difference %",
)  # fmt: skip


def relaxed(yarns: YarnSet, quality: Quality, options: Mapping[str, Any]) -> tuple[Relaxation, float]:
    """Relax yarns, and measure the time with loaded kernels [s]."""
    sm.relax_yarns(yarns, quality=replace(quality, max_iterations=20), **options)
    began = time.perf_counter()
    return sm.relax_yarns(yarns, quality=quality, **options), time.perf_counter() - began


def spacings(stitches: SpacingChange, yarns: YarnSet) -> np.ndarray:
    """Mean distances of neighbouring stitches along the yarns and across them [cm], shape (2,)."""
    return stitches.mean_distances(stitches.middles(yarns.points))


def row(scene: str, name: str, yarns: YarnSet, most: int, options: Mapping[str, Any]) -> tuple[object, ...]:
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
        scene, f"{len(yarns.points):,}", name, f"{seconds:.3g}", report["iterations"], at_rest,
        f"{report['residual']:.2g}", f"{100 * error:.2g}", estimate, f"{rest.report['residual']:.2g}",
    )  # fmt: skip


def course(scene: str, name: str, yarns: YarnSet, most: int, options: Mapping[str, Any]) -> Rows:
    """Yield how far the spacings are from those at the end of a long run, on the way there."""
    quality = replace(PRESETS[name], tolerance=1e-12, largest_change=1e-12)
    stitches, states = SpacingChange(yarns), []
    count = 60
    while count <= most:
        found = sm.relax_yarns(yarns, quality=replace(quality, max_iterations=count), **options)
        states.append((found.report, spacings(stitches, found.yarns)))
        count = round(count * 2.0**0.5 / 20.0) * 20
    yield f"{scene}, {name}, {len(yarns.points):,} control points"
    yield "iterations", "residual", "error %", "ratio"
    for report, spacing in states[:-1]:
        error = float(np.abs(spacing / states[-1][1] - 1.0).max())
        residual = report["residual"]
        yield report["iterations"], f"{residual:.2g}", f"{100 * error:.2g}", f"{error / residual:.2g}"


def agreement(scene: str, name: str, yarns: YarnSet, most: int, options: Mapping[str, Any]) -> Rows:
    """Yield two lines, one for each solver."""
    quality = replace(PRESETS[name], precision="float64", tolerance=1e-4, largest_change=4e-4)
    material, stitches, ends = YarnMaterial.named().of_radius(float(yarns.radius.mean())), SpacingChange(yarns), []
    kept = options.get("keep_shape")
    terms, constraints = ([], []) if kept is None else ([KeepShape(kept)], [KeepBorders(kept)])
    for by_newton in (True, False):
        simulation = YarnSimulation.start(
            yarns, material, quality, device_named(options["device"]), terms, constraints
        )  # fmt: skip
        loop = RelaxationLoop(simulation, quality.tolerance, quality.largest_change, by_newton=by_newton)
        loop.run(20)
        HessianAssembly(simulation).matrix()
        began = time.perf_counter()
        loop.run(most)
        seconds, left = time.perf_counter() - began, loop.remaining[0]
        ends.append(spacings(stitches, simulation.good_yarns()))
        yield (
            scene, f"{len(yarns.points):,}", "Newton" if by_newton else "L-BFGS", f"{seconds:.3g}", loop.iteration,
            "yes" if loop.at_rest[0] else "no", f"{loop.last.residual[0]:.2g}",
            "" if left is None else f"{100 * left.spacing:.2g}", f"{loop.last.energy[0]:.9g}",
            f"{100 * np.abs(ends[-1] / ends[0] - 1.0).max():.2g}",
        )  # fmt: skip


def scene_of(path: str, arguments: Options, name: str) -> tuple[YarnSet, dict[str, Any]]:
    """Yarns of one scene as a preset samples them, and how they are held."""
    options: dict[str, Any] = {"device": arguments.device, "run": QUIET}
    if path not in SCENES and not path.endswith(".obj"):
        return sm.read_yarns(path), options
    mesh = SCENES[path]() if path in SCENES else sm.read_mesh(path, unit=arguments.unit)
    fabric = sm.tessellate(sm.label(mesh), stitch_width=arguments.stitch_width)
    fabric = sm.relax_mesh(fabric, surface=mesh, device=arguments.device, run=QUIET).fabric
    yarns = sm.generate_yarns(fabric, yarn_radius=arguments.stitch_width / 8.0, quality=name)
    return yarns, {**options, "keep_shape": fabric}


@dataclass(frozen=True)
class Options:
    """What is measured."""

    scenes: Positional[tuple[str, ...]]
    """meshes (.obj) or yarns (.bcc)"""
    unit: str = "cm"
    """unit of the meshes"""
    stitch_width: float = 0.8
    """cm"""
    qualities: str = "draft,standard"
    iterations: int = 30000
    """of the longest run"""
    course: bool = False
    """states on the way of the longest run"""
    agree: bool = False
    """two solvers at a residual of 1e-4"""
    device: str | None = None


def garments_at_rest(arguments: Options) -> Rows:
    """Measure the scenes named on the command line."""
    if not arguments.course:
        yield HEAD_OF_SOLVERS if arguments.agree else HEAD
    for path in arguments.scenes:
        for name in arguments.qualities.split(","):
            yarns, options = scene_of(path, arguments, name)
            given = (Path(path).stem, name, yarns, arguments.iterations, options)
            if arguments.agree:
                yield from agreement(*given)
            elif arguments.course:
                yield from course(*given)
            else:
                yield row(*given)
