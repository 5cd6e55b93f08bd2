# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Estimates the memory that a computation needs, before it allocates any, and compares it with the free memory.

All figures hold for float32 unless they say otherwise. ``benchmarks/run.py garments estimates`` and ``benchmarks/run.py
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
"""Memory of the stages before the yarns, for each stitch [bytes]."""
BYTES_PER_FOUND_STITCH = 2_500.0
"""Memory of the search for stitches on any mesh, for each stitch [bytes], measured on a tube of 100,000 stitches."""
BYTES_PER_STITCH_OF_GARMENT = 40_000.0
"""Memory of all stages of a garment, for each stitch [bytes]; ``benchmarks/run.py garments stages`` measures it."""
BYTES_PER_KEPT_POINT = 300.0
"""Memory of a state of rest that is kept beside others, for each control point [bytes]."""
BYTES_PER_POINT = {"yarngen": 1_500.0, "yarnrelax": 1_430.0}
"""Memory of the stages of yarns for each control point [bytes]; the relaxation takes twice as much in float64."""
BYTES_PER_SAMPLE = 490.0
"""Additional memory of the relaxation for each contact sample of a control point [bytes]."""
ON_GPU, ON_GPU_PER_SAMPLE = 1_315.0, 22.0
"""Memory of a relaxation on a GPU [bytes]: for each control point, and in addition for each contact sample times the
number of control points of a stitch, because candidate lists grow with that number."""
RENDERER, BYTES_PER_PIXEL, BYTES_PER_DRAWN_POINT = 680e6, 500.0, 3_100.0
"""Memory of a picture without a GPU [bytes]: of the renderer, for each pixel, and for each control point."""
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
        ParameterError: there is not enough memory (``check_memory``).
    """
    from stitchmesh.compute.device import device_named

    chosen = device_named(device)
    needed, free = relaxation_memory(points, quality, on_gpu=chosen.is_cuda), available_memory(chosen)
    check_memory(asked, needed, "fewer stitches, or a coarser quality", where=str(chosen), free=free)


def picture_memory(points: float, pixels: float) -> float:
    """Return the memory of the program while it draws yarns without a GPU [bytes]; 0 if there are no pixels."""
    return RENDERER + BYTES_PER_PIXEL * pixels + BYTES_PER_DRAWN_POINT * points if pixels else 0.0


def check_memory(
    asked: str, needed: float, remedy: str, *, where: str = "this machine", free: float | None = None
) -> None:
    """Refuse a computation that does not fit into the memory, before it begins.

    Args:
        asked: what the user asked for, with its numbers, for the message.
        needed: memory that the computation needs [bytes].
        remedy: what to ask for instead.
        where: name of the device.
        free: free memory of the device [bytes]; by default the free memory of the host.

    Raises:
        ParameterError: the computation does not fit; the message holds all of these.
    """
    free = host_memory() if free is None else free
    if not needed <= free:
        found = f"needs about {needed / GIGABYTE:.3g} GB, and {where} has {free / GIGABYTE:.3g} GB free"
        raise ParameterError(f"memory: {asked} {found}; expected {remedy}")
