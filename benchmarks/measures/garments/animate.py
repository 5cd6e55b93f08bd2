# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A skirt on a cloth that swings and twists (``benchmarks/scenes/swinging_skirt.py``): time and accuracy of its frames.

The time of a frame is that from the cloth of the frame to the yarns on the host, with its checks; frames with a
certificate of the linking count for the largest time. The first frame is left out. Some frames are compared with the
full relaxation of the yarns where the cloth of the frame carries them, which ``relax_yarns`` does at the same quality.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

import stitchmesh as sm
from benchmarks.scenes.swinging_skirt import SwingingSkirt, swinging_skirt
from benchmarks.table import Rows
from stitchmesh.compute.device import device_named
from stitchmesh.mesh import FloatArray
from stitchmesh.quality import quality_named
from stitchmesh.run import QUIET
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.animator import AnimationInputs, Animator
from stitchmesh.yarnrelax.motion.animation_options import AnimationOptions


@dataclass(frozen=True)
class Options:
    """What is measured."""

    device: str | None = None
    stitches: int = 20_616
    frames: int = 240
    quality: str = "draft"
    iterations: int = AnimationOptions.iterations
    """iterations of the solver in each frame"""
    first_iterations: int = AnimationOptions.first_iterations
    """largest number of iterations at the first frame"""
    compared: int = 6
    """number of frames that are compared with their full relaxation"""


def animate(given: Options) -> Rows:
    """Animate the skirt, and compare some frames with their full relaxation."""
    scene = swinging_skirt(given.stitches, given.frames)
    drawn = sm.generate_yarns(scene.fabric, quality=given.quality)
    rest = sm.relax_yarns(drawn, quality=given.quality, device=given.device, keep_shape=scene.fabric, run=QUIET)
    yield f"{scene.fabric.face_count:,} stitches, {len(drawn.points):,} control points, {given.iterations} iterations"
    chosen: list[int] = np.unique(np.linspace(0, given.frames - 1, given.compared + 1).round().astype(int))[1:].tolist()
    kept = yield from frames_of(given, scene, rest.yarns, chosen)
    if not chosen:
        return
    yield ""
    yield "frame", "carried, rms / r", "animated, rms / r", "largest / r", "iterations of the full relaxation"
    material = sm.YarnMaterial.named().of_radius(float(rest.yarns.radius.mean()))
    quality, device = quality_named(given.quality), device_named(given.device)
    animator = Animator(AnimationInputs(kept[0], scene.fabric, scene.cloth, material, quality, 1, device))
    for number in chosen:
        carried, fabric = animator.carried(number)
        full = sm.relax_yarns(carried, quality=given.quality, device=given.device, keep_shape=fabric, run=QUIET)
        before, after = (distances(each, full.yarns) for each in (carried, kept[number]))
        figures = f"{rms(before):.3f}", f"{rms(after):.3f}", f"{after.max():.2f}"
        yield number, *figures, full.report["iterations"]


def frames_of(
    given: Options, scene: SwingingSkirt, yarns: YarnSet, chosen: list[int]
) -> Generator[object, None, dict[int, YarnSet]]:
    """Animate yarns, print the times, and return the chosen frames."""
    made = sm.animate(
        scene.fabric, scene.cloth, yarns, quality=given.quality, device=given.device,
        options=AnimationOptions(given.iterations, given.first_iterations), run=QUIET,
    )  # fmt: skip
    kept, reports = dict[int, YarnSet](), []
    for frame in made:
        reports.append(frame.report)
        if frame.number in (0, *chosen):
            kept[frame.number] = frame.yarns
    milliseconds = [1e3 * report["seconds"] for report in reports[1:]]
    missed = [report for report in reports if report["missed"] is not None]
    nearest = min(report["min_distance_over_radius"] for report in reports)
    yield (
        "first frame, s", "frames", "ms a frame, median", "largest", "missed", "travels", "certified",
        "smallest distance / r",
    )  # fmt: skip
    travels, certified = (sum(report[name] for report in reports) for name in ("travels", "certified"))
    times = f"{np.median(milliseconds):.1f}", f"{max(milliseconds):.1f}"
    yield f"{reports[0]['seconds']:.1f}", len(reports), *times, len(missed), travels, certified, f"{nearest:.2f}"
    yield from (f"frame {report['frame']}: {report['missed']}" for report in missed)
    return kept


def distances(one: YarnSet, other: YarnSet) -> FloatArray:
    """Distances of control points over the mean radius, shape (N,)."""
    apart: FloatArray = np.linalg.norm(one.points - other.points, axis=1) / one.radius.mean()
    return apart


def rms(values: FloatArray) -> float:
    """Root mean square."""
    return float(np.sqrt((values**2).mean()))
