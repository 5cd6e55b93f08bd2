# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Both solvers on real scenes with the same convergence test: iterations, time and energy during and after relaxation.

The yarns of a yarn file relax freely. A mesh is knitted first, without a measurement, and its yarns keep its shape. The
times [s] are those of ``relax_yarns`` with loaded kernels; the time of the linking certificates before and after the
relaxation is also printed separately.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from tyro.conf import Positional

import stitchmesh as sm
from benchmarks.table import Rows
from stitchmesh.mesh import StitchMesh
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.linking.certificate import doubled_linking
from stitchmesh.yarnrelax.relax import Relaxation, relax_yarns

YARN_SUFFIXES = (".bcc", ".h5")


def scene(
    path: str, unit: str, stitch_width: float, quality: Quality, device: str | None
) -> tuple[YarnSet, StitchMesh | None]:
    """Yarns from a file, or yarns generated from a mesh together with the fabric whose shape they keep."""
    if Path(path).suffix in YARN_SUFFIXES:
        return sm.read_yarns(path), None
    mesh = sm.read_mesh(path, unit=unit)
    fabric = sm.relax_mesh(sm.tessellate(sm.label(mesh), stitch_width=stitch_width), surface=mesh, device=device).fabric
    return sm.generate_yarns(fabric, quality=quality), fabric


def show(name: str, quality: Quality, result: Relaxation, certificate: float, levels: Sequence[float]) -> Rows:
    """Yield one line of the table, and the iteration at which the energy reached each of the given levels."""
    report = result.report
    at_rest = "at rest" if report["converged"] else "NOT at rest"
    yield (
        name, quality.solver, report["iterations"], f"{report['seconds']:.2f}", f"{certificate:.2f}",
        f"{report['residual']:.4f}", f"{report['energy']:.1f}", at_rest, f"{report['max_strain']:.3f}",
        f"{report['min_distance_over_radius']:.2f}", report["device"],
    )  # fmt: skip
    for level in levels:
        entry = next((e for e in result.history if sum(e["energies"].values()) <= level), None)
        found = f"{entry['iteration']} iterations, {entry['seconds']:.2f} s" if entry else "not reached"
        yield f"energy {level:.6g}: {found}"


def measure(path: str, arguments: Options) -> Rows:
    """Run the chosen solvers on one scene and print their lines."""
    base = quality_named(arguments.quality)
    base = replace(
        base,
        tolerance=arguments.tolerance or base.tolerance,
        max_iterations=arguments.max_iterations or base.max_iterations,
    )
    yarns, fabric = scene(path, arguments.unit, arguments.stitch_width, base, arguments.device)
    yield f"{Path(path).name}: {len(yarns.points)} control points, {yarns.yarn_count} yarns"
    for solver in arguments.solver:
        quality = replace(base, solver=solver)
        # a short run loads the kernels
        relax_yarns(yarns, quality=replace(quality, max_iterations=20), device=arguments.device, keep_shape=fabric)
        began = time.perf_counter()
        doubled_linking(yarns, device=arguments.device)
        certificate = 2 * (time.perf_counter() - began)
        result = relax_yarns(yarns, quality=quality, device=arguments.device, keep_shape=fabric)
        yield from show(Path(path).name, quality, result, certificate, arguments.level)


@dataclass(frozen=True)
class Options:
    """What is measured."""

    scene: Positional[tuple[str, ...]]
    unit: str = "cm"
    stitch_width: float = 0.8
    quality: str = "draft"
    tolerance: float | None = None
    max_iterations: int | None = None
    solver: tuple[str, ...] = ("quasistatic", "dynamics")
    level: tuple[float, ...] = ()
    """print when these energies [erg] occur"""
    device: str | None = None


def solvers(arguments: Options) -> Rows:
    """Measure the scenes named on the command line."""
    yield (
        "scene", "solver", "iter.", "seconds", "certif.", "residual", "energy erg", "", "strain", "nearest [r]",
        "device",
    )  # fmt: skip
    for path in arguments.scene:
        yield from measure(path, arguments)
