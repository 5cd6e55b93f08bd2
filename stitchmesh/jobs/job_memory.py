# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Memory that a job needs, estimated before its long stages, and compared with the memory of its device.

On a CPU it is the memory of the process, and on a GPU the memory of the relaxation on the device. ``benchmarks/run.py
job-memory`` compares the estimates with the largest resident memory of jobs, or with the largest use of the memory of a
GPU.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from stitchmesh.compute.device import device_named
from stitchmesh.compute.free_memory import available_memory
from stitchmesh.jobs.sections import RenderTable, SwatchTable
from stitchmesh.memory_need import GIGABYTE, check_memory, picture_memory, relaxation_memory, stage_memory
from stitchmesh.mesh import StitchMesh
from stitchmesh.periodic.resolve_pattern import resolve_pattern, stitches_of
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.recipe.estimate import control_points, estimate_garment, loops_in_chains

KEPT, BYTES_PER_KEPT_POINT = 25e6, 540.0
"""Additional memory of a job, and for each control point in float32, for the results of earlier stages and the states
of checkpoints [bytes]."""


def garment_memory(
    labeled: StitchMesh, options: KnitOptions, quality: Quality, device: str, pictures: Sequence[RenderTable]
) -> float:
    """Return the largest memory on its device of a job that makes a garment [bytes]."""
    estimate = estimate_garment(
        labeled, stitch_width=options.stitch_width, stitch_height=options.stitch_height, counts=options.counts,
        marked=options.marked, quality=quality, device=device,
    )  # fmt: skip
    return _largest_memory(estimate.memory, estimate.control_points, quality, device, pictures)


def found_memory(fabric: StitchMesh, quality: Quality, device: str, pictures: Sequence[RenderTable]) -> float:
    """Return the largest memory of a job whose stitches were found, as for ``garment_memory`` [bytes]."""
    bind_off = loops_in_chains(fabric, np.ones(fabric.side_count, dtype=np.int64))
    shaped = int(np.abs(fabric.n_top - fabric.n_bottom).sum())
    points = control_points(fabric.face_count, bind_off, shaped, quality)
    largest = max(stage_memory(fabric.face_count, points, quality).values())
    return _largest_memory(largest, points, quality, device, pictures)


def _largest_memory(
    largest: float, points: int, quality: Quality, device: str, pictures: Sequence[RenderTable]
) -> float:
    """Memory of a job, from the largest memory of its stages on a CPU [bytes]."""
    if device_named(device).is_cuda:
        return relaxation_memory(points, quality, on_gpu=True)
    return max(largest + _kept_memory(points, quality), _picture_memory(points, pictures))


def swatch_memory(swatch: SwatchTable, quality: Quality, device: str, pictures: Sequence[RenderTable]) -> float:
    """Return the largest memory on its device of a job that relaxes a swatch [bytes]."""
    stitches = stitches_of(resolve_pattern(swatch.pattern)) * swatch.columns * swatch.rows
    points = stitches * quality.control_points_per_stitch * (quality.refinement if swatch.has_free_size else 1.0)
    if device_named(device).is_cuda:
        return relaxation_memory(points, quality, on_gpu=True)
    drawn = points * max((picture.tiles[0] * picture.tiles[1] for picture in pictures), default=0)
    relaxed = relaxation_memory(points, quality, on_gpu=False) + _kept_memory(points, quality)
    return max(relaxed, _picture_memory(drawn, pictures))


def _kept_memory(points: float, quality: Quality) -> float:
    """Return the memory that a job needs besides its stages [bytes]."""
    return KEPT + BYTES_PER_KEPT_POINT * points * (2.0 if quality.precision == "float64" else 1.0)


def _picture_memory(points: float, pictures: Sequence[RenderTable]) -> float:
    """Return the memory of a job while it draws its largest picture [bytes]; 0 without pictures.

    A part of it takes the place of memory that the relaxation has given back.
    """
    return picture_memory(points, max((picture.size[0] * picture.size[1] for picture in pictures), default=0))


def check_job_memory(
    memory_at: Callable[[Quality], float], quality: Quality, device: str, smaller: str, available: float | None = None
) -> dict[str, float]:
    """Compare the memory of a job with the memory of its device, and return both for the report [GB].

    Args:
        memory_at: memory of the job at a quality [bytes].
        quality: quality of the job.
        device: Warp's name of the device.
        smaller: what makes a job smaller if no quality fits, for the message.
        available: free memory [bytes]; by default the free memory of the device.

    Raises:
        ParameterError: the job does not fit; the message has the memory that it needs, and the quality that would fit.
    """
    free = available_memory(device_named(device)) if available is None else available
    needed = memory_at(quality)
    remedy = smaller
    if needed > free and (fits := [name for name, preset in reversed(PRESETS.items()) if memory_at(preset) <= free]):
        remedy = f"quality {fits[0]}, which needs about {memory_at(PRESETS[fits[0]]) / GIGABYTE:.3g} GB"
    check_memory("the job", needed, remedy, where=device, free=free)
    return {"estimate_gb": round(needed / GIGABYTE, 3), "available_gb": round(free / GIGABYTE, 3)}
