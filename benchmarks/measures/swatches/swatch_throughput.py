# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Throughput of many free swatches: small repeats of the library in several materials and loop lengths.

All variants are made together by ``sm.relax_swatches``, and some of them one after another by ``sm.swatch``. The
kernels are compiled, and the sizes of the swatches that were made both ways are compared.
"""

from __future__ import annotations

import logging
import os
import platform
import time
from dataclasses import dataclass

import numpy as np

import stitchmesh as sm
from benchmarks.scenes.swatches import evenly, requested, variants
from benchmarks.table import Rows, note
from stitchmesh.compute.device import device_named
from stitchmesh.errors import StitchMeshError

WARM = 4
"""Variants that are made first, both ways, so that all kernels are compiled."""
SAME_SIZE = 0.005
"""Relative difference of widths and heights below which two swatches are in the same state."""
SAY_SECONDS = 10.0
"""Time between two lines of progress [s]."""


def alone(request: sm.SwatchRequest, device: str) -> sm.Swatch | StitchMeshError:
    """Make a swatch by itself."""
    try:
        return sm.swatch(
            request.pattern, material=request.material, quality=request.quality, relax_cell=request.relax_cell,
            device=device, progress=False, **request.options,
        )  # fmt: skip
    except StitchMeshError as error:
        return error


def together(requests: list[sm.SwatchRequest], device: str) -> tuple[list[sm.Swatch | StitchMeshError], float]:
    """Make swatches together; return them and the seconds."""
    began = time.perf_counter()
    said = [began]

    def say(done: int, count: int) -> None:
        now = time.perf_counter()
        if now - said[0] > SAY_SECONDS or done == count:
            said[0] = now
            note(f"{now - began:8.1f} s: {done} of {count}")

    return sm.relax_swatches(requests, device=device, progress=say), time.perf_counter() - began


def differs(one: sm.Swatch | StitchMeshError, other: sm.Swatch | StitchMeshError) -> str:
    """How two results of one request differ; empty if they are the same."""
    if isinstance(one, StitchMeshError) or isinstance(other, StitchMeshError):
        return "" if type(one) is type(other) else f"{one} and {other}"
    sizes = np.array([[made.report[name] for name in ("width", "height")] for made in (one, other)])
    change = float(np.abs(sizes[1] / sizes[0] - 1.0).max())
    return f"sizes by {100 * change:.2g} %" if change > SAME_SIZE else ""


@dataclass(frozen=True)
class Options:
    """What is measured."""

    device: str | None = None
    quality: str = "draft"
    variants: int = 1000
    alone: int = 50
    """variants that are also made one after another"""


def swatch_throughput(given: Options) -> Rows:
    """Measure, and print one line for each finding."""
    logging.disable(logging.WARNING)
    device = device_named(given.device)
    yield f"{device.name or platform.machine()}, {os.cpu_count()} cores; {given.quality}"
    requests = [requested(variant, given.quality) for variant in variants(given.variants)]
    first = [requests[number] for number in evenly(len(requests), WARM)]
    for request in first:
        alone(request, str(device))
    together(first, str(device))
    note("the kernels are compiled")
    made, seconds = together(requests, str(device))
    failed = [each for each in made if isinstance(each, StitchMeshError)]
    rested = sum(each.report["converged"] for each in made if isinstance(each, sm.Swatch))
    points = sum(each.report["control_points"] for each in made if isinstance(each, sm.Swatch))
    rest = f"{rested} at rest, {len(failed)} refused, {points} control points"
    yield f"{len(made)} together: {seconds:.1f} s, {1e3 * seconds / len(made):.1f} ms each; {rest}"
    for error in failed[:3]:
        yield f"{error}"
    spent, different = list[float](), 0
    yield "alone", "s", "different"
    for number in evenly(len(requests), given.alone):
        began = time.perf_counter()
        single = alone(requests[number], str(device))
        spent.append(time.perf_counter() - began)
        difference = differs(single, made[number])
        different += bool(difference)
        yield requests[number].pattern, f"{spent[-1]:.2f}", difference
    if spent:
        ratio = float(np.mean(spent)) * len(made) / seconds
        times = f"{np.mean(spent):.2f} s each, {np.mean(spent) * len(made):.0f} s for all"
        yield f"{len(spent)} one after another: {times}; {different} differ in size by more than {100 * SAME_SIZE:g} %"
        yield f"together {ratio:.1f} times the throughput"
