# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Throughput of many free swatches: small repeats of the library in several materials and loop lengths.

All variants are prepared one after another (``prepare_swatch``), then made together by ``sm.relax_swatches``, and some
of them one after another by ``sm.swatch``. The kernels are compiled, and the sizes and bits of the swatches that were
made both ways are compared.

For the call that makes all variants, lines say when the first result came, in which part of the time the GPU was busy
(``nvidia-smi`` samples it; a dash on a CPU), and which stages took the time. A stage is a shared function
(``ways_together``) with its kernels; what is left is the preparation of repeats, the kicks and the reports.
"""

from __future__ import annotations

import logging
import os
import platform
import shutil
import subprocess
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any
from unittest import mock

import numpy as np

import stitchmesh as sm
from benchmarks.scenes.swatches import evenly, requested, variants
from benchmarks.table import Rows, note
from stitchmesh.compute.device import device_named
from stitchmesh.compute.shared_work import Call
from stitchmesh.compute.work_together import Together
from stitchmesh.errors import StitchMeshError
from stitchmesh.periodic.relaxation.prepared_swatch import prepare_swatch
from stitchmesh.yarnrelax.together.relax_together import ways_together

WARM = 4
"""Variants that are made first, both ways, so that all kernels are compiled."""
SAME_SIZE = 0.005
"""Relative difference of widths and heights below which two swatches are in the same state."""
SAY_SECONDS = 10.0
"""Time between two lines of progress [s]."""
SAMPLE_MILLISECONDS = 200
"""Time between two samples of the GPU [ms]."""


@dataclass
class Spent:
    """What one call for many swatches spent."""

    seconds: float = 0.0
    """Time of the call [s]."""
    first: float = 0.0
    """Time until the first result [s]."""
    stages: Counter[str] = field(default_factory=Counter)
    """Time of each shared function [s]."""
    busy: Sequence[float] = ()
    """Samples of the utilisation of the GPU [%]; empty on a CPU."""

    @property
    def share_of_the_device(self) -> str:
        """Mean utilisation of the GPU, and the part of the samples in which it did nothing; a dash without samples."""
        if not len(self.busy):
            return "-"
        idle = np.mean(np.array(self.busy) == 0.0)
        return f"{np.mean(self.busy):.0f} % busy, nothing in {100 * idle:.0f} % of {len(self.busy)} samples"

    def timed(self, name: str, way: Together, calls: Sequence[Call]) -> Sequence[Any]:
        """Do the work of a shared function, and count its time."""
        began = time.perf_counter()
        try:
            return way(calls)
        finally:
            self.stages[name] += time.perf_counter() - began

    def ways(self) -> dict[Callable[..., Any], Together]:
        """Return the ways in which shared functions do their calls together, timed."""
        return {each: partial(self.timed, each.__name__, way) for each, way in ways_together().items()}

    @contextmanager
    def sampling(self, device: str) -> Iterator[None]:
        """Sample the utilisation of the GPU in a block."""
        command = shutil.which("nvidia-smi")
        if command is None or not device.startswith("cuda"):
            yield
            return
        asked = ["--query-gpu=utilization.gpu", "--format=csv,noheader,nounits", f"-lms={SAMPLE_MILLISECONDS}"]
        number = device.partition(":")[2] or "0"
        with subprocess.Popen([command, "-i", number, *asked], stdout=subprocess.PIPE, text=True) as sampler:
            try:
                yield
            finally:
                sampler.terminate()
                lines = sampler.communicate()[0].splitlines()
                self.busy = [float(line) for line in lines if line.strip().isdigit()]


def alone(request: sm.SwatchRequest, device: str) -> sm.Swatch | StitchMeshError:
    """Make a swatch by itself."""
    try:
        return sm.swatch(
            request.pattern, material=request.material, quality=request.quality, relax_cell=request.relax_cell,
            device=device, progress=False, **request.options,
        )  # fmt: skip
    except StitchMeshError as error:
        return error


def together(requests: list[sm.SwatchRequest], device: str) -> tuple[list[sm.Swatch | StitchMeshError], Spent]:
    """Make swatches together; return them and what the call spent."""
    spent, began = Spent(), time.perf_counter()
    said = [began]

    def say(done: int, count: int) -> None:
        now = time.perf_counter()
        spent.first = spent.first or now - began
        if now - said[0] > SAY_SECONDS or done == count:
            said[0] = now
            note(f"{now - began:8.1f} s: {done} of {count}")

    with spent.sampling(device), mock.patch("stitchmesh.periodic.swatch.ways_together", spent.ways):
        made = sm.relax_swatches(requests, device=device, progress=say)
        spent.seconds = time.perf_counter() - began
    return made, spent


def prepared(requests: Sequence[sm.SwatchRequest], device: str) -> float:
    """Prepare swatches one after another, without their relaxation; return the time [s]."""
    began = time.perf_counter()
    for request in requests:
        prepare_swatch(
            request.pattern, material=request.material, quality=request.quality, device=device,
            relax_cell=request.relax_cell, **request.options,
        )  # fmt: skip
    return time.perf_counter() - began


def has_bits_of(one: sm.Swatch | StitchMeshError, other: sm.Swatch | StitchMeshError) -> bool:
    """Whether two results have the same control points to the last bit."""
    if isinstance(one, StitchMeshError) or isinstance(other, StitchMeshError):
        return type(one) is type(other)
    return np.array_equal(one.yarns.points, other.yarns.points)


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
    only_prepared: bool = False
    """end when all variants are prepared"""


def swatch_throughput(given: Options) -> Rows:
    """Measure, and print one line for each finding."""
    logging.disable(logging.WARNING)
    device = device_named(given.device)
    yield f"{device.name or platform.machine()}, {os.cpu_count()} cores; {given.quality}"
    requests = [requested(variant, given.quality) for variant in variants(given.variants)]
    first = [requests[number] for number in evenly(len(requests), WARM)]
    prepared(first, str(device))
    seconds = prepared(requests, str(device))
    yield f"{len(requests)} prepared: {seconds:.2f} s, {1e3 * seconds / len(requests):.2f} ms each"
    if given.only_prepared:
        return
    for request in first:
        alone(request, str(device))
    together(first, str(device))
    note("the kernels are compiled")
    made, call = together(requests, str(device))
    seconds = call.seconds
    failed = [each for each in made if isinstance(each, StitchMeshError)]
    rested = sum(each.report["converged"] for each in made if isinstance(each, sm.Swatch))
    points = sum(each.report["control_points"] for each in made if isinstance(each, sm.Swatch))
    rest = f"{rested} at rest, {len(failed)} refused, {points} control points"
    yield f"{len(made)} together: {seconds:.1f} s, {1e3 * seconds / len(made):.1f} ms each; {rest}"
    for error in failed[:3]:
        yield f"{error}"
    yield f"first result after {call.first:.1f} s; share of the device: {call.share_of_the_device}"
    yield "stage", "s", "ms a swatch"
    left = {"preparation, kicks, reports": seconds - sum(call.stages.values())}
    for name, own in {**call.stages, **left}.items():
        yield name, f"{own:.1f}", f"{1e3 * own / len(made):.1f}"
    spent, different, same_bits = list[float](), 0, 0
    yield "alone", "s", "different"
    for number in evenly(len(requests), given.alone):
        began = time.perf_counter()
        single = alone(requests[number], str(device))
        spent.append(time.perf_counter() - began)
        difference = differs(single, made[number])
        different += bool(difference)
        same_bits += has_bits_of(single, made[number])
        yield requests[number].pattern, f"{spent[-1]:.2f}", difference
    if spent:
        ratio = float(np.mean(spent)) * len(made) / seconds
        times = f"{np.mean(spent):.2f} s each, {np.mean(spent) * len(made):.0f} s for all"
        yield f"{len(spent)} one after another: {times}; {different} differ in size by more than {100 * SAME_SIZE:g} %"
        yield f"{same_bits} of {len(spent)} have the same bits as in the call for all"
        yield f"together {ratio:.1f} times the throughput"
