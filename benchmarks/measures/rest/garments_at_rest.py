# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far from rest garments are that say they are at rest, and what solvers take to bring them there.

A mesh is knitted and keeps its shape; yarns of a file are free. Each preset relaxes the yarns that it samples. Times
are those of ``relax_yarns`` with loaded kernels.

- ``presets``: the same yarns, relaxed on by the same solver for ``--iterations`` iterations, are taken for their rest.
  The error is the largest relative error of the mean distance of neighbouring stitches, along the yarns and across
  them, and the estimate is the ``remaining_change`` of the report. The last column is the residual of that long run.
- ``course``: each line is a state on the way of the long run, the last column error over residual.
- ``agree``: two solvers bring the yarns to rest at a residual of 1e-4 in double precision: L-BFGS with Newton's method
  at its end, and L-BFGS alone, which estimates the change that is left. The difference is that of the spacings.
- ``solvers``: both solvers with the same convergence test; the time of the linking certificates is also given apart.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from tyro.conf import Positional

import stitchmesh as sm
from benchmarks.scenes.garments import FORMULAS, Garment
from benchmarks.table import Rows
from benchmarks.timing import relaxed
from stitchmesh.compute.device import device_named
from stitchmesh.linking.certificate import doubled_linking
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.run import QUIET
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.assembled_hessian import HessianAssembly
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.spacing_change import SpacingChange


@dataclass(frozen=True)
class Options:
    """The scenes, and what relaxes them."""

    scenes: Positional[tuple[str, ...]]
    """meshes (.obj), meshes of a formula, or yarns (.bcc)"""
    unit: str = "cm"
    """unit of the meshes"""
    stitch_width: float = 0.8
    """cm"""
    qualities: tuple[str, ...] = ("draft", "standard")
    iterations: int = 30000
    """of the longest run"""
    device: str | None = None


@dataclass(frozen=True)
class Scene:
    """Yarns as a preset samples them, and how they are held."""

    name: str
    preset: str
    yarns: YarnSet
    held: Mapping[str, Any]
    """Arguments of their relaxation."""

    @property
    def cells(self) -> tuple[str, str]:
        """Name and number of control points."""
        return self.name, f"{len(self.yarns.points):,}"

    @property
    def quality(self) -> Quality:
        """The preset."""
        return PRESETS[self.preset]

    def spacings(self, yarns: YarnSet) -> np.ndarray:
        """Mean distances of neighbouring stitches along the yarns and across them [cm], shape (2,)."""
        stitches = SpacingChange(self.yarns, device_named("cpu"))
        return stitches.mean_distances(stitches.middles(yarns.points))


def scenes_of(given: Options) -> Iterator[Scene]:
    """Yield each scene in each quality."""
    for path in given.scenes:
        for preset in given.qualities:
            held: dict[str, Any] = {"device": given.device, "run": QUIET}
            if path in FORMULAS or path.endswith(".obj"):
                fabric = Garment(path, given.stitch_width, given.unit).evened(given.device)
                yarns = sm.generate_yarns(fabric, yarn_radius=given.stitch_width / 8.0, quality=preset)
                held["keep_shape"] = fabric
            else:
                yarns = sm.read_yarns(path)
            yield Scene(Path(path).stem, preset, yarns, held)


def presets(given: Options) -> Rows:
    """Compare presets with a long run."""
    yield (
        "scene", "points", "quality", "seconds", "iterations", "at rest", "residual", "error %", "estimate %",
        "long run",
    )  # fmt: skip
    for scene in scenes_of(given):
        found, seconds = relaxed(scene.yarns, scene.quality, **scene.held)
        never = replace(scene.quality, tolerance=1e-12, largest_change=1e-12, max_iterations=given.iterations)
        rest = sm.relax_yarns(scene.yarns, quality=never, **scene.held)
        error = np.abs(scene.spacings(found.yarns) / scene.spacings(rest.yarns) - 1.0).max()
        report, left = found.report, found.report["remaining_change"]
        yield (
            *scene.cells, scene.preset, f"{seconds:.3g}", report["iterations"], "yes" if report["converged"] else "no",
            f"{report['residual']:.2g}", f"{100 * error:.2g}", "" if left is None else f"{100 * left['spacing']:.2g}",
            f"{rest.report['residual']:.2g}",
        )  # fmt: skip


def course(given: Options) -> Rows:
    """Yield how far the spacings are from those at the end of a long run, on the way there."""
    for scene in scenes_of(given):
        quality = replace(scene.quality, tolerance=1e-12, largest_change=1e-12)
        states, count = [], 60
        while count <= given.iterations:
            found = sm.relax_yarns(scene.yarns, quality=replace(quality, max_iterations=count), **scene.held)
            states.append((found.report, scene.spacings(found.yarns)))
            count = round(count * 2.0**0.5 / 20.0) * 20
        yield f"{scene.name}, {scene.preset}, {len(scene.yarns.points):,} control points"
        yield "iterations", "residual", "error %", "ratio"
        for report, spacing in states[:-1]:
            error = float(np.abs(spacing / states[-1][1] - 1.0).max())
            residual = report["residual"]
            yield report["iterations"], f"{residual:.2g}", f"{100 * error:.2g}", f"{error / residual:.2g}"


def agree(given: Options) -> Rows:
    """Compare Newton's method with L-BFGS alone."""
    yield (
        "scene", "points", "solver", "seconds", "iterations", "at rest", "residual", "left %", "erg", "difference %",
    )  # fmt: skip
    for scene in scenes_of(given):
        quality = replace(scene.quality, precision="float64", tolerance=1e-4, largest_change=4e-4)
        material = YarnMaterial.named().of_radius(float(scene.yarns.radius.mean()))
        kept = scene.held.get("keep_shape")
        terms, constraints = ([], []) if kept is None else ([KeepShape(kept)], [KeepBorders(kept)])
        ends: list[np.ndarray] = []
        for by_newton in (True, False):
            simulation = YarnSimulation.start(
                scene.yarns, material, quality, device_named(given.device), terms, constraints
            )
            loop = RelaxationLoop(simulation, quality.tolerance, quality.largest_change, by_newton=by_newton)
            loop.run(20)
            HessianAssembly(simulation).matrix()
            began = time.perf_counter()
            loop.run(given.iterations)
            seconds, left = time.perf_counter() - began, loop.remaining[0]
            ends.append(scene.spacings(simulation.good_yarns()))
            yield (
                *scene.cells, "Newton" if by_newton else "L-BFGS", f"{seconds:.3g}", loop.iteration,
                "yes" if loop.at_rest[0] else "no", f"{loop.last.residual[0]:.2g}",
                "" if left is None else f"{100 * left.spacing:.2g}", f"{loop.last.energy[0]:.9g}",
                f"{100 * np.abs(ends[-1] / ends[0] - 1.0).max():.2g}",
            )  # fmt: skip


def solvers(given: Options) -> Rows:
    """Compare quasistatic and dynamic relaxation."""
    yield (
        "scene", "points", "quality", "solver", "iterations", "seconds", "certificate", "residual", "energy erg",
        "at rest", "strain", "nearest [r]",
    )  # fmt: skip
    for scene in scenes_of(given):
        for solver in ("quasistatic", "dynamics"):
            quality = replace(scene.quality, solver=solver, max_iterations=given.iterations)
            began = time.perf_counter()
            doubled_linking(scene.yarns, device=given.device)
            certificate = 2 * (time.perf_counter() - began)
            found, seconds = relaxed(scene.yarns, quality, **scene.held)
            report = found.report
            yield (
                *scene.cells, scene.preset, solver, report["iterations"], f"{seconds:.2f}", f"{certificate:.2f}",
                f"{report['residual']:.4f}", f"{report['energy']:.1f}", "yes" if report["converged"] else "no",
                f"{report['max_strain']:.3f}", f"{report['min_distance_over_radius']:.2f}",
            )  # fmt: skip


ACTIONS = (presets, course, agree, solvers)
