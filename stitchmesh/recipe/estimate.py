# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a garment will cost, estimated from its labeled mesh and the sizes alone: yarn, control points, time and memory.

The numbers of stitches and rows are exact, because the mesh is divided by the same rule. Yarn length and control points
follow from the size of each stitch. Time and memory were measured on a shared server processor, and count the threads
that a relaxation uses here; another machine may be twice as fast or as slow. ``benchmarks/run.py garments estimates``
compares all estimates with finished garments.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stitchmesh.compute.device import device_named
from stitchmesh.compute.threads import thread_count
from stitchmesh.errors import check_kind
from stitchmesh.memory_need import stage_memory
from stitchmesh.mesh import BOTTOM, TOP, FloatArray, IntArray, StitchMesh
from stitchmesh.quality import DEFAULT_QUALITY, PRESETS, Quality, quality_named
from stitchmesh.tessellate.counts import EdgeName
from stitchmesh.tessellate.planned_stitches import PlannedStitches, planned_stitches
from stitchmesh.yarngen.bind_off import SMALL_RING_LOOPS

YARN_PER_WIDTH, YARN_PER_HEIGHT = 1.0, 4.0
"""Yarn in a plain stitch: centimetres for each centimetre of its width and of its height."""
YARN_PER_BIND_OFF = 5.0
"""Yarn of a chain bind-off for each loop, divided by the stitch width."""
POINTS_PER_BIND_OFF = 1.5
"""Control points of a chain bind-off for each loop, divided by the control points of a plain stitch."""
POINTS_PER_SHAPED_LOOP = 0.65
"""Additional control points for each increased or decreased loop, divided by the control points of a plain stitch."""
LARGE_GARMENT = 20_000
"""Number of stitches of a garment that needs ``ITERATIONS``."""
ITERATIONS, ITERATIONS_OF_PANELS = 300.0, 100.0
"""Iterations in which the yarns of such a garment come to rest at quality ``draft``, with the shape kept: for closed
yarns, and for the open yarns of flat panels, which end as soon as their energy hardly falls
(``yarnrelax.convergence``)."""
SMALLER_NEEDS_MORE, SMALLER_PANELS_NEED_MORE = 0.15, 0.4
"""Exponents of the increase of iterations with decreasing numbers of stitches."""
FINER_NEEDS_MORE, FINER_PANELS_NEED_MORE = 1.4, 0.5
"""Exponents of the increase of iterations with decreasing ``Quality.largest_change``, or tolerance for panels."""
SECONDS_PER_STITCH = {"tessellate": 35e-6, "meshrelax": 140e-6}
"""Time of the stages before the yarns [s]."""
SECONDS_OF_YARNGEN = 0.08, 4e-6
"""Time of the generation of yarns: a constant, and an addition for each control point [s]."""
SECONDS_PER_POINT_ITERATION = {"cpu": 6.3e-7, "cuda": 1.5e-9}
"""Time of the relaxation of yarns for each control point and iteration, with lists of contacts and assessments [s].
On a CPU it is the time of one thread."""
GAIN_OF_THREADS = 0.9
"""Exponent of the gain of speed with the number of threads of a CPU."""
SECONDS_PER_ITERATION = {"cpu": 2e-4, "cuda": 2e-4}
"""Additional time of each iteration [s]."""
SECONDS_TO_START = {"cpu": 0.2, "cuda": 0.2}
"""Time until the first iteration, with loaded kernels [s]."""


@dataclass(frozen=True, kw_only=True)
class StageCost:
    """Estimated cost of one stage."""

    seconds: float
    """Time [s]."""
    memory: float
    """Largest memory of the program in this stage [bytes]."""


@dataclass(frozen=True, eq=False, kw_only=True)
class GarmentEstimate:
    """What a garment will cost."""

    planned: PlannedStitches
    """Numbers of stitches along the edges and in the faces; exact."""
    yarn_length: float
    """Length of all yarns as generated, within a few percent [cm]."""
    control_points: int
    """Number of control points, within a few percent."""
    stages: Mapping[str, StageCost]
    """Cost of each stage (``tessellate``, ``meshrelax``, ``yarngen``, ``yarnrelax``), within a factor of two."""

    @property
    def stitches(self) -> int:
        """Number of stitches; exact."""
        return self.planned.total

    @property
    def rows(self) -> int:
        """Number of rows of stitches; exact."""
        return self.planned.rows

    @property
    def doubt(self) -> str:
        """Why the size of the stitches may be wrong, in one line; no text if the size is met."""
        return self.planned.doubt

    @property
    def seconds(self) -> float:
        """Time of all stages [s]."""
        return sum(cost.seconds for cost in self.stages.values())

    @property
    def memory(self) -> float:
        """Largest memory of any stage [bytes]."""
        return max(cost.memory for cost in self.stages.values())


def estimate_garment(
    labeled: StitchMesh, *, stitch_width: float, stitch_height: float | None = None,
    counts: Mapping[EdgeName, int] | None = None, marked: Sequence[EdgeName] = (),
    quality: str | Quality = DEFAULT_QUALITY, device: str | None = None,
) -> GarmentEstimate:  # fmt: skip
    """Estimate what a garment of plain stitches will cost, before any stage is run.

    Args:
        labeled: a labeled mesh (``label``).
        stitch_width: wale spacing [cm].
        stitch_height: course spacing [cm]; by default 0.77 times the width.
        counts: number of stitches along single edges, as for ``tessellate``.
        marked: marked wale edges, as for ``tessellate``; they change no number.
        quality: name of a preset, or a ``Quality``.
        device: Warp's name of the device; None for the preferred device.

    Raises:
        ParameterError: as for ``tessellate``, or there is no such quality or device.
        TessellationError: as for ``tessellate``.
    """
    check_kind("estimate_garment", labeled, StitchMesh, "sm.label(mesh)")
    planned = planned_stitches(
        labeled, stitch_width=stitch_width, stitch_height=stitch_height, counts=counts, marked=marked
    )
    chosen = quality_named(quality)
    bind_off = loops_in_chains(labeled, planned.along[labeled.side_edge])
    points = control_points(planned.total, bind_off, planned.shaped, chosen)
    return GarmentEstimate(
        planned=planned,
        yarn_length=_yarn_length(labeled, planned, bind_off),
        control_points=points,
        stages=_stages(
            planned.total,
            points,
            _iterations(labeled, planned.total, chosen),
            chosen,
            "cuda" if device_named(device).is_cuda else "cpu",
        ),
    )


def control_points(stitches: int, bind_off: int, shaped: int, quality: Quality) -> int:
    """Return the number of control points of a garment of plain stitches, within a few percent.

    Args:
        stitches: number of stitches.
        bind_off: number of loops that are bound off in a chain (``loops_in_chains``).
        shaped: number of loops that are increased or decreased.
        quality: the quality.
    """
    loops = stitches + POINTS_PER_BIND_OFF * bind_off + POINTS_PER_SHAPED_LOOP * shaped
    return round(quality.control_points_per_stitch * loops)


def loops_in_chains(mesh: StitchMesh, loops: IntArray) -> int:
    """Return the number of loops that are bound off in a chain, without small rings, which a yarn is drawn through.

    Args:
        mesh: a labeled mesh or a fabric.
        loops: number of loops along each side, shape (C,).
    """
    bound = 0
    for border in mesh.boundary_loops:
        is_top = mesh.side_role[border] == TOP
        count = int(loops[border[is_top]].sum())
        bound += 0 if is_top.all() and count <= SMALL_RING_LOOPS else count
    return bound


def _yarn_length(labeled: StitchMesh, planned: PlannedStitches, bind_off: int) -> float:
    """Length of all yarns [cm]."""
    width, height = _stitch_sizes(labeled, planned)
    loops = YARN_PER_WIDTH * width + YARN_PER_HEIGHT * height
    return float(planned.in_panel @ loops + YARN_PER_BIND_OFF * bind_off * width.mean())


def _stitch_sizes(labeled: StitchMesh, planned: PlannedStitches) -> tuple[FloatArray, FloatArray]:
    """Mean width and height of the stitches of each panel [cm], shape (F,) each."""
    first, loops = labeled.face_start[:-1], planned.along[labeled.side_edge]
    course = (labeled.side_role == BOTTOM) | (labeled.side_role == TOP)
    length = np.add.reduceat(np.where(course, labeled.side_length, 0.0), first)
    width = length / np.add.reduceat(np.where(course, loops, 0), first)
    wales = labeled.side_length[labeled.left_wale] + labeled.side_length[labeled.right_wale]
    return width, wales / 2 / planned.courses


def _stages(stitches: int, points: int, iterations: float, quality: Quality, device: str) -> dict[str, StageCost]:
    seconds = {name: time * stitches for name, time in SECONDS_PER_STITCH.items()}
    seconds["yarngen"] = SECONDS_OF_YARNGEN[0] + SECONDS_OF_YARNGEN[1] * points
    work = quality.contact_samples / PRESETS["draft"].contact_samples * (2.0 if quality.precision == "float64" else 1.0)
    together = thread_count() ** GAIN_OF_THREADS if device == "cpu" else 1.0
    an_iteration = SECONDS_PER_ITERATION[device] + SECONDS_PER_POINT_ITERATION[device] * points * work / together
    seconds["yarnrelax"] = SECONDS_TO_START[device] + iterations * an_iteration
    memory = stage_memory(stitches, points, quality)
    return {name: StageCost(seconds=time, memory=memory[name]) for name, time in seconds.items()}


def _iterations(labeled: StitchMesh, stitches: int, quality: Quality) -> float:
    """Iterations until the yarns are at rest, with the shape kept."""
    draft, smaller = PRESETS["draft"], LARGE_GARMENT / max(stitches, 1)
    ends = labeled.row[labeled.twin[labeled.left_wale] < 0]
    if np.isin(labeled.row, ends).all():  # a flat panel: every row has ends
        needed = ITERATIONS_OF_PANELS * smaller**SMALLER_PANELS_NEED_MORE
        needed *= (draft.tolerance / quality.tolerance) ** FINER_PANELS_NEED_MORE
    else:
        needed = ITERATIONS * smaller**SMALLER_NEEDS_MORE
        needed *= (draft.largest_change / quality.largest_change) ** FINER_NEEDS_MORE
    return min(needed, float(quality.max_iterations))
