# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cost of the relaxation after an edit of one stitch: start from the relaxed yarns, or from newly generated yarns.

Three relaxations of the edited fabric are compared. They start from the newly generated yarns; from the yarns that were
relaxed before the edit (``regenerate_yarns``); and from the newly generated yarns with every control point moved by a
hundredth of a radius. The last relaxation shows how well the relaxed state is determined.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

import stitchmesh as sm
from benchmarks.scenes.garments import Garment
from benchmarks.table import Rows
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import Marks, apply_change
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.regenerate import regenerate_yarns
from stitchmesh.yarnrelax import Relaxation

NUDGE = 0.01
"""Root mean square displacement of the perturbed start, in radii."""


@dataclass(frozen=True)
class Options:
    """What is measured."""

    garment: str = "hat"
    stitch_width: float = 1.2
    device: str | None = None


def edit_relaxation(arguments: Options) -> Rows:
    """Yield a table of the three relaxations for a few edits."""
    quality = PRESETS["standard"]
    fabric = Garment(arguments.garment, arguments.stitch_width).evened(arguments.device)
    yarns = sm.generate_yarns(fabric, quality=quality)
    before = relaxed(yarns, fabric, quality, arguments.device)
    size = f"{fabric.face_count} stitches, {len(yarns.points)} control points"
    yield f"{arguments.garment}: {size}, standard: {before.report['iterations']} iterations"
    yield "edit", "anew", "again", "part", "apart, points", "apart, curves", "nudged apart, points", "curves"
    for name, stitch, place in (("k to p", Stitch.PURL, 0.35), ("k to slip", Stitch.SLIP_BACK, 0.6)):
        edited = with_stitch(fabric, stitch, place)
        yield row_of(name, before.yarns, fabric, edited, quality, arguments.device)


def relaxed(
    yarns: YarnSet, fabric: StitchMesh, quality: Quality, device: str | None, start: YarnSet | None = None
) -> Relaxation:
    """Relax yarns with the shape of the fabric."""
    return sm.relax_yarns(yarns, quality=quality, keep_shape=fabric, device=device, run=sm.Run(start=start))


def with_stitch(fabric: StitchMesh, stitch: Stitch, place: float) -> StitchMesh:
    """Return the fabric after the change of one knit stitch in the middle, at a fraction of its circumference."""
    knits = np.flatnonzero((fabric.stitch == Stitch.KNIT) & (fabric.row == fabric.row.max() // 2))
    face = knits[[int(place * len(knits))]]
    return apply_change(fabric, Marks("stitch", face, np.array([stitch])))


def row_of(
    name: str, before: YarnSet, fabric: StitchMesh, edited: StitchMesh, quality: Quality, device: str | None
) -> tuple[object, ...]:
    """One line of the table."""
    yarns, start = regenerate_yarns(before, fabric, edited, quality=quality)
    nudge = np.random.default_rng(1).normal(size=yarns.points.shape) * (NUDGE / np.sqrt(3.0) * yarns.radius[0])
    anew = relaxed(yarns, edited, quality, device)
    again = relaxed(yarns, edited, quality, device, start)
    nudged = relaxed(yarns, edited, quality, device, replace(yarns, points=yarns.points + nudge))
    first, second = anew.report["iterations"], again.report["iterations"]
    cells: list[object] = [name, first, second, f"{second / first:.0%}"]
    for other in (again, nudged):
        cells += [f"{points_apart(anew.yarns, other.yarns):.3f}", f"{curves_apart(anew.yarns, other.yarns):.3f}"]
    return tuple(cells)


def points_apart(first: YarnSet, second: YarnSet) -> float:
    """Root mean square distance of control points, in radii."""
    return float(np.sqrt(np.mean(np.sum((first.points - second.points) ** 2, axis=1))) / first.radius[0])


def curves_apart(first: YarnSet, second: YarnSet) -> float:
    """Return the root mean square distance between the curves of two sets, in radii, without sliding along yarns."""
    distance = cKDTree(np.concatenate(second.sampled(32))).query(np.concatenate(first.sampled(4)))[0]
    return float(np.sqrt(np.mean(distance**2)) / first.radius[0])
