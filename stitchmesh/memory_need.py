# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Memory that a work takes, estimated from its numbers before anything of it is made, and compared with what is free.

All figures are of float32 unless they say otherwise. ``benchmarks/run.py garments estimates`` and ``benchmarks/run.py
job-memory`` compare them with the largest resident memory of processes, or with the largest use of the memory of a GPU.
"""

from __future__ import annotations

from stitchmesh.compute.free_memory import available_memory, host_memory
from stitchmesh.errors import ParameterError
from stitchmesh.quality import Quality

GIGABYTE = 1e9
"""Bytes in the unit of the messages."""
BASE_MEMORY = 275e6
"""Memory of the program with its libraries [bytes]."""
BYTES_PER_STITCH = {"tessellate": 2_000.0, "meshrelax": 12_000.0}
"""Memory of the stages before the yarns [bytes]."""
BYTES_PER_FOUND_STITCH = 2_500.0
"""Memory of the search for stitches on any mesh, measured on a tube of 100,000 stitches [bytes]."""
BYTES_PER_STITCH_OF_GARMENT = 40_000.0
"""Memory of all stages of a garment for each of its stitches [bytes]; ``benchmarks/run.py garments stages`` has it."""
BYTES_PER_KEPT_POINT = 300.0
"""Memory of each control point of a state of rest that is kept beside others [bytes]."""
BYTES_PER_POINT = {"yarngen": 1_500.0, "yarnrelax": 1_430.0}
"""Memory of the stages of yarns for each control point [bytes]; twice as much in float64 for the relaxation."""
BYTES_PER_SAMPLE = 490.0
"""Additional memory of the relaxation for each contact sample of a control point [bytes]."""
ON_GPU, ON_GPU_PER_SAMPLE = 1_315.0, 22.0
"""Memory of a relaxation on a GPU for each control point, and additional memory for each of its contact samples times
the control points of a stitch, with which candidate lists become longer [bytes]."""
RENDERER, BYTES_PER_PIXEL, BYTES_PER_DRAWN_POINT = 680e6, 500.0, 3_100.0
"""Memory of a picture without a GPU: with the renderer, for each pixel, and for each control point [bytes]."""
BYTES_PER_TILED_POINT = 1_300.0
"""Memory for each control point of yarns that are tiled and written [bytes], measured with 540,000 of them as OBJ."""
BYTES_PER_TEXTURE_SAMPLE = 80.0
"""Memory for each of the places at which texture maps are computed [bytes], measured with 6 million of them."""


def bytes_per_point(quality: Quality) -> float:
    """Return the memory of a relaxation for each control point [bytes]."""
    digits = 2.0 if quality.precision == "float64" else 1.0
    return digits * (BYTES_PER_POINT["yarnrelax"] + BYTES_PER_SAMPLE * quality.contact_samples)


def stage_memory(stitches: float, points: float, quality: Quality) -> dict[str, float]:
    """Return the largest memory of the program in each stage of a garment [bytes]."""
    memory = {name: size * stitches for name, size in BYTES_PER_STITCH.items()}
    memory |= {"yarngen": BYTES_PER_POINT["yarngen"] * points, "yarnrelax": bytes_per_point(quality) * points}
    return {name: BASE_MEMORY + own for name, own in memory.items()}


def relaxation_memory(points: float, quality: Quality, *, on_gpu: bool) -> float:
    """Return the memory of a relaxation of control points on its device [bytes]."""
    if not on_gpu:
        return BASE_MEMORY + points * bytes_per_point(quality)
    listed = ON_GPU_PER_SAMPLE * quality.contact_samples * quality.control_points_per_stitch
    return points * (ON_GPU + listed) * (2.0 if quality.precision == "float64" else 1.0)


def check_relaxation_memory(asked: str, points: float, quality: Quality, device: str | None) -> None:
    """Refuse a relaxation of control points that does not fit into the memory of its device, before it begins.

    Raises:
        ParameterError: as for ``check_memory``.
    """
    from stitchmesh.compute.device import device_named

    chosen = device_named(device)
    needed, free = relaxation_memory(points, quality, on_gpu=chosen.is_cuda), available_memory(chosen)
    check_memory(asked, needed, "fewer stitches, or a coarser quality", where=str(chosen), free=free)


def picture_memory(points: float, pixels: float) -> float:
    """Return the memory of the program while it draws a picture of yarns without a GPU [bytes]; 0 without pixels."""
    return RENDERER + BYTES_PER_PIXEL * pixels + BYTES_PER_DRAWN_POINT * points if pixels else 0.0


def check_memory(
    asked: str, needed: float, remedy: str, *, where: str = "this machine", free: float | None = None
) -> None:
    """Refuse a work that does not fit into the memory, before it is made.

    Args:
        asked: what was asked for, with its numbers, for the message.
        needed: memory that it takes [bytes].
        remedy: what to ask for instead.
        where: name of the device.
        free: memory that is free there [bytes]; by default that beside the processor.

    Raises:
        ParameterError: it does not fit; the message has all of these.
    """
    free = host_memory() if free is None else free
    if not needed <= free:
        found = f"needs about {needed / GIGABYTE:.3g} GB, and {where} has {free / GIGABYTE:.3g} GB free"
        raise ParameterError(f"memory: {asked} {found}; expected {remedy}")
