# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Growth: seconds of each stage for skirts of more and more stitches, as a table and a plot.

The skirt is that of the walking body. Before the first skirt a small one goes through all stages, so that loading or
compiling kernels is not in the table. ``GPU GB`` is the largest memory of Warp's pool so far.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import warp as wp

import stitchmesh as sm
from benchmarks.scenes.walking_body import skirt
from benchmarks.table import Rows
from stitchmesh.compute.device import device_named
from stitchmesh.yarnrelax.relaxation_result import Relaxation

T = TypeVar("T")
STAGES = ("tessellate", "meshrelax", "yarngen", "yarnrelax")
SMALL = 2000
"""Stitches of the skirt that loads the kernels."""


def growth(
    *, stitches: tuple[int, ...] = (10_000, 30_000, 60_000), quality: str = "draft", device: str | None = None,
    picture: str | None = None,
) -> Rows:  # fmt: skip
    """Make skirts.

    Args:
        stitches: numbers of stitches, about
        quality: quality of the yarns
        device: Warp's name of the device
        picture: file of the plot; none if it is not given
    """
    labeled = sm.label(skirt())
    unit = sm.tessellate(labeled, stitch_width=1.0).face_count ** 0.5
    _stages(labeled, unit / SMALL**0.5, quality, device)
    names = (f"{stage} s" for stage in STAGES)
    yield "stitches", "points", *names, "all s", "us a stitch", "iterations", "at rest", "GPU GB"
    plotted = []
    for count in stitches:
        seconds, relaxed = _stages(labeled, unit / count**0.5, quality, device)
        made = int(relaxed.yarns.face.max()) + 1
        plotted.append((made, seconds))
        report, total = relaxed.report, sum(seconds)
        yield (
            made, len(relaxed.yarns.points), *(f"{own:.2f}" for own in seconds),
            f"{total:.1f}", f"{1e6 * total / made:.0f}",
            report["iterations"], report["converged"], _pool(device),
        )  # fmt: skip
    if picture is not None:
        _draw(plotted, Path(picture))


def _stages(
    labeled: sm.StitchMesh, width: float, quality: str, device: str | None
) -> tuple[list[float], Relaxation]:
    """The seconds of each stage, and the relaxed yarns, of a skirt with stitches of a width [cm]."""
    seconds: list[float] = []

    def timed(stage: Callable[[], T]) -> T:
        begun = time.perf_counter()
        result = stage()
        seconds.append(time.perf_counter() - begun)
        return result

    fabric = timed(lambda: sm.tessellate(labeled, stitch_width=width))
    even = timed(lambda: sm.relax_mesh(fabric, surface=labeled, device=device))
    yarns = timed(lambda: sm.generate_yarns(even.fabric, quality=quality, device=device))
    return seconds, timed(lambda: sm.relax_yarns(yarns, quality=quality, device=device, run=sm.Run(progress=False)))


def _pool(device: str | None) -> str:
    found = device_named(device)
    return f"{wp.get_mempool_used_mem_high(found) / 1e9:.1f}" if found.is_cuda else "-"


def _draw(rows: Sequence[tuple[int, list[float]]], path: Path) -> None:
    """Draw the microseconds for each stitch of each stage against the number of stitches."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.2, 4.0))
    counts = [count for count, _ in rows]
    for number, stage in enumerate(STAGES):
        axes.plot(counts, [1e6 * seconds[number] / count for count, seconds in rows], "o-", label=stage)
    axes.plot(counts, [1e6 * sum(seconds) / count for count, seconds in rows], "k--", label="all")
    axes.set(xscale="log", yscale="log", xlabel="stitches", ylabel="microseconds a stitch")
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=5, fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=130)
    plt.close(figure)
