# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far yarns may travel along given straight ways before one of them could pass through another one.

A cloth moves by many yarn radii from one frame to the next, but neighbouring yarns move nearly together. The guard
therefore bounds how two arcs approach *each other*. Let every control point i travel by s D_i, 0 <= s <= 1. The point
of a curve travels by the same spline with the control points D_i, so the arc of sample p (``collision.step_limit``)
stays within the spread e_p(D) = longest leg of D / (2 samples) of the travel D_p of its sample. The arcs of two
samples, at the distance vector d, with reaches R_p and R_q, cannot touch on the whole way if

    min over s of |d + s (D_p - D_q)|  >  R_p + R_q + e_p(D) + e_q(D)                                           (1)

Otherwise they approach by at most s (|D_p - D_q| + e_p(D) + e_q(D)), and cannot touch while this is less than their
clearance. (1) is sharp for yarns that turn about each other, the bound by the clearance for yarns that touch. Both are
tested for all listed pairs, whose clearance is that of their tangent pieces.

Pairs that are not listed are found by runs: up to ``RUN`` neighbouring segments of a yarn. A run A lies in a ball
(m_A, r_A), and its control points travel by T_A, with differences of at most v_A. Arcs of the runs A and B may touch
only if

    min over s of |m_A - m_B + s (T_A - T_B)|  <=  r_A + r_B + v_A + v_B

which a tree of boxes around the ways of the balls finds. Each segment asks the tree for the runs that it may meet, then
each segment of such a run, and in the end the arcs of both, as above. Arcs of one strand that are neighbours along it
are left out, as in the search for contacts. The balls are in single precision, with a thousandth for rounding.

The yarns travel by the largest s <= 1 with which every approach is at most ``PART`` of the clearance, or not at all if
it is below ``LEAST_STEP``: the last clearances would be used up for nothing. Candidate lists must be new at the start.
After the travel they are out of date.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec2, Vec3, Vec4
from stitchmesh.compute.thread_block import THREADS, largest_over_block
from stitchmesh.simulation.bodies.body_surface import single
from stitchmesh.yarnrelax.collision.broad_phase import may_collide
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.collision.step_limit import distance_of_pieces, measure_arcs
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import sample_number
from stitchmesh.yarnrelax.model.spline import from_entry, segment_corners, weight_row
from stitchmesh.yarnrelax.model.state import State
from stitchmesh.yarnrelax.motion.moving_surface import Refit

PART = wp.constant(0.9)
"""Part of a clearance that two arcs may use up in one travel; the rest is for rounding."""
LEAST_STEP = wp.constant(wp.float64(0.01))
"""Yarns do not travel if they could only pass less than this part of the way: they would be pressed together for it."""
RUN = 8
"""Largest number of segments of a run."""
PARTS = 256
"""Blocks of threads that find the largest need, each of a part."""
SMALLEST = wp.constant(1.0e-6)
"""Clearance in mean radii that stands for none."""
PASSED, STEP, LARGEST_NEED = wp.constant(0), wp.constant(1), wp.constant(2)
"""Entries of ``TravelGuard.progress``: the part of the whole way that is passed, the part s of the last travel, and the
largest 1 / s since the beginning of the way."""


@wp.func
def approach_of_arcs(travel: wp.array[Vec4], p: int, q: int) -> Any:
    """Largest distance by which two arcs approach on the whole way."""
    here, there = travel[p], travel[q]
    apart = here - there
    across = apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]
    return wp.sqrt(across) + here[3] + there[3]


@wp.func
def nearest_on_way(apart: Vec3, way: Vec3) -> Any:
    """Smallest distance of two points whose difference moves from ``apart`` by ``way``."""
    square = wp.dot(way, way)
    part = square - square
    if square > part:
        part = wp.clamp(-wp.dot(apart, way) / square, type(square)(0.0), type(square)(1.0))
    return wp.length(apart + way * part)


@wp.func
def stay_apart(travel: wp.array[Vec4], p: int, q: int, apart: Vec3, reach: Scalar) -> bool:
    """Whether two arcs cannot touch on the whole way, by (1); ``apart`` leads from q to p."""
    here, there = travel[p], travel[q]
    between = type(apart)(here[0] - there[0], here[1] - there[1], here[2] - there[2])
    # a thousandth allows for rounding
    return nearest_on_way(apart, between) > (reach + here[3] + there[3]) * type(reach)(1.001)


@kernel
def travel_of_samples(
    # model
    model: YarnConstants,
    # state in
    way: wp.array[Vec3],
    # state out
    travel: wp.array[Vec4],
) -> None:
    """Travel of each sample on the whole way, and the spread of the travel within its arc."""
    s = wp.tid()
    d0, d1, d2, d3 = segment_corners(model, way, s)
    first = model.sample_start[s]
    count = model.sample_start[s + 1] - first
    row = weight_row(model, count, 0)
    longest = wp.max(wp.length(d1 - d0), wp.max(wp.length(d2 - d1), wp.length(d3 - d2)))
    spread = longest * type(longest)(0.5) / type(longest)(count)
    for k in range(count):
        weight = model.sample_basis[row + k]
        moved = d0 * weight[0] + d1 * weight[1] + d2 * weight[2] + d3 * weight[3]
        travel[first + k] = type(travel[0])(moved[0], moved[1], moved[2], spread)


@kernel
def need_of_pairs(
    # model
    model: YarnConstants,
    # state in
    samples: wp.array[Vec4],
    half_tangent: wp.array[Vec3],
    slack: wp.array[Vec2],
    travel: wp.array[Vec4],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    need: wp.array[Scalar],
    partner: wp.array[wp.int32],
) -> None:
    """Largest approach of each sample's arc to a listed one, over the part of their clearance; and that one."""
    p = wp.tid()
    here = samples[p]
    reach, sag = slack[p][0], slack[p][1]
    most = reach - reach
    part, least = type(most)(PART), type(most)(SMALLEST)
    nearest = p
    for c in range(wp.min(candidate_count[p], candidates.shape[1])):
        entry = candidates[p, c]
        q = sample_number(model.images, entry)
        approach = approach_of_arcs(travel, p, q)
        apart4 = from_entry(model.images, samples, p, here, entry)
        apart = type(half_tangent[0])(apart4[0], apart4[1], apart4[2])
        clearance = wp.length(apart) - reach - slack[q][0]
        # the sharper bounds cost more, and matter only where the first one would limit the travel
        limits = approach > wp.max(most, type(most)(0.5)) * part * clearance
        if limits and not stay_apart(travel, p, q, apart, reach + slack[q][0]):
            close = distance_of_pieces(apart, half_tangent[p], half_tangent[q]) - sag - slack[q][1]
            clearance = wp.max(clearance, close)
            found = approach / (part * wp.max(clearance, least))
            if found > most:
                most = found
                nearest = q
    need[p] = most
    partner[p] = nearest


@wp.func
def box_of_way(middle: wp.vec3, moved: wp.vec4, size: float) -> tuple[wp.vec3, wp.vec3]:
    """Lower and upper corner of the box around the way of a ball; ``moved`` is the travel in it, with its spread."""
    # a thousandth allows for rounding
    wide = (size + moved[3]) * 1.001
    around, end = wp.vec3(wide, wide, wide), middle + wp.vec3(moved[0], moved[1], moved[2])
    return wp.min(middle, end) - around, wp.max(middle, end) + around


@kernel
def bound_runs(
    # model
    model: YarnConstants,
    run_start: wp.array[wp.int32],
    # state in
    centre: wp.array[Vec3],
    extent: wp.array[Scalar],
    way: wp.array[Vec3],
    # state out
    ball: wp.array[wp.vec4],
    travel: wp.array[wp.vec4],
    low: wp.array[wp.vec3],
    high: wp.array[wp.vec3],
) -> None:
    """Ball and travel of each run, and the box around the way of its ball."""
    run = wp.tid()
    first, last = run_start[run], run_start[run + 1]
    middle = (centre[first] + centre[last - 1]) * type(extent[0])(0.5)
    moved = way[model.segment_points[(first + last) // 2][1]]
    size, spread = extent[first] - extent[first], extent[first] - extent[first]
    for s in range(first, last):
        size = wp.max(size, wp.length(centre[s] - middle) + extent[s])
        corner = model.segment_points[s]
        for k in range(4):
            spread = wp.max(spread, wp.length(way[corner[k]] - moved))
    ball[run] = wp.vec4(float(middle[0]), float(middle[1]), float(middle[2]), float(size))
    travel[run] = wp.vec4(float(moved[0]), float(moved[1]), float(moved[2]), float(spread))
    lower, upper = box_of_way(single(middle), travel[run], float(size))
    low[run] = lower
    high[run] = upper


@wp.func
def travel_of_segment(model: YarnConstants, way: wp.array[Vec3], s: int) -> Any:
    """Travel of a segment, and the largest difference of the travels of its control points."""
    corner = model.segment_points[s]
    moved = way[corner[1]]
    spread = wp.max(wp.length(way[corner[0]] - moved), wp.length(way[corner[2]] - moved))
    spread = wp.max(spread, wp.length(way[corner[3]] - moved))
    return wp.vec4(float(moved[0]), float(moved[1]), float(moved[2]), float(spread))


@wp.func
def balls_meet(apart: wp.vec3, here: wp.vec4, there: wp.vec4, size: float) -> bool:
    """Whether two moving balls may touch; ``here`` and ``there`` are the travels of what they hold, with its spread.

    Args:
        apart: difference of the middles at the start.
        here: travel of the first ball, and the largest difference of the travels in it.
        there: the same of the second ball.
        size: sum of the radii.
    """
    between = wp.vec3(here[0] - there[0], here[1] - there[1], here[2] - there[2])
    # a thousandth allows for rounding
    return nearest_on_way(apart, between) <= (size + here[3] + there[3]) * 1.001


@wp.func
def need_of_arcs(
    model: YarnConstants, samples: wp.array[Vec4], slack: wp.array[Vec2], travel: wp.array[Vec4], margin: Scalar,
    s: int, t: int
) -> float:  # fmt: skip
    """Largest approach of unlisted arcs of two segments that may touch, over the clearance that it may use."""
    most = float(0.0)
    for p in range(model.sample_start[s], model.sample_start[s + 1]):
        here4 = samples[p]
        here = single_place(here4)
        for q in range(model.sample_start[t], model.sample_start[t + 1]):
            there4 = samples[q]
            apart = here - single_place(there4)
            distance = wp.length(apart)
            listed = float(here4[3] + there4[3] + margin)
            reach = float(slack[p][0] + slack[q][0])
            # listed arcs have their own kernel; a thousandth allows for rounding
            if distance > listed * 0.999 and not single_stay_apart(travel[p], travel[q], apart, reach):
                clearance = wp.max(distance - reach, SMALLEST)
                most = wp.max(most, float(approach_of_arcs(travel, p, q)) / (PART * clearance))
    return most


@wp.func
def single_place(sample: Vec4) -> wp.vec3:
    """The place of a sample in single precision."""
    return wp.vec3(float(sample[0]), float(sample[1]), float(sample[2]))


@wp.func
def single_stay_apart(here: Vec4, there: Vec4, apart: wp.vec3, reach: float) -> bool:
    """``stay_apart`` in single precision."""
    between = single_place(here) - single_place(there)
    return nearest_on_way(apart, between) > (reach + float(here[3] + there[3])) * 1.001


@kernel
def need_of_segments(
    # model
    model: YarnConstants,
    run_start: wp.array[wp.int32],
    margin: Scalar,
    # state in
    tree: wp.uint64,
    ball: wp.array[wp.vec4],
    run_travel: wp.array[wp.vec4],
    centre: wp.array[Vec3],
    extent: wp.array[Scalar],
    samples: wp.array[Vec4],
    slack: wp.array[Vec2],
    travel: wp.array[Vec4],
    way: wp.array[Vec3],
    # state out
    need: wp.array[wp.float32],
    nearest: wp.array[wp.int32],
) -> None:
    """Largest need of the unlisted arcs of a segment and of the later ones that it may meet; and that segment."""
    s = wp.tid()
    most = float(0.0)
    other = s
    here, own, size = single(centre[s]), travel_of_segment(model, way, s), float(extent[s])
    low, high = box_of_way(here, own, size)
    query = wp.bvh_query_aabb(tree, low, high)
    b = wp.int32(0)
    while wp.bvh_query_next(query, b):
        there = ball[b]
        if balls_meet(here - wp.vec3(there[0], there[1], there[2]), own, run_travel[b], size + there[3]):
            for t in range(wp.max(run_start[b], s), run_start[b + 1]):
                between = here - single(centre[t])
                both = size + float(extent[t])
                if balls_meet(between, own, travel_of_segment(model, way, t), both) and may_collide(model, s, t, 0):
                    found = need_of_arcs(model, samples, slack, travel, margin, s, t)
                    if found > most:
                        most = found
                        other = t
    need[s] = most
    nearest[s] = other


@wp.func
def more_needed(most: wp.float64, need: Scalar) -> wp.float64:
    """The larger of two needs; infinite if the second one is not a number."""
    if need == need:
        return wp.max(most, wp.float64(need))
    return wp.float64(wp.inf)


@kernel(tile=THREADS)
def largest_needs(
    # state in
    of_pairs: wp.array[Scalar],
    of_segments: wp.array[wp.float32],
    # state out
    largest: wp.array[wp.float64],
) -> None:
    """Largest need of each part; infinite if one is not a number."""
    part, lane = wp.tid()
    most = wp.float64(0.0)
    first, stride = part * wp.block_dim() + lane, largest.shape[0] * wp.block_dim()
    for k in range(first, of_pairs.shape[0], stride):
        most = more_needed(most, of_pairs[k])
    for k in range(first, of_segments.shape[0], stride):
        most = more_needed(most, of_segments[k])
    whole = largest_over_block(most)
    if lane == 0:
        largest[part] = whole


@kernel
def choose_step(
    # state in
    largest: wp.array[wp.float64],
    # state in and out
    progress: wp.array[wp.float64],
) -> None:
    """The part of the way that the yarns travel next; one thread."""
    one, most = wp.float64(1.0), wp.float64(0.0)
    for k in range(largest.shape[0]):
        most = wp.max(most, largest[k])
    step = one / wp.max(most, one)
    if step < LEAST_STEP:
        step = wp.float64(0.0)
    progress[STEP] = step
    progress[PASSED] = one - (one - progress[PASSED]) * (one - step)
    progress[LARGEST_NEED] = wp.max(progress[LARGEST_NEED], most)


@kernel
def travel_on(
    # state in
    progress: wp.array[wp.float64],
    target: wp.array[Vec3],
    # state in and out
    way: wp.array[Vec3],
    points: wp.array[Vec3],
) -> None:
    """Move each control point along its way by the step; what is left of the way leads to the target."""
    i = wp.tid()
    step = type(way[0][0])(progress[STEP])
    point = points[i] + way[i] * step
    if progress[STEP] == wp.float64(1.0):
        point = target[i]
    points[i] = point
    way[i] = target[i] - point


class TravelGuard:
    """Moves yarns without a lattice along straight ways, as far as none of them can pass through another one."""

    def __init__(self, model: Model, state: State, candidates: Candidates) -> None:
        """Allocate the arrays.

        Args:
            model: the yarns.
            state: their state, whose samples are up to date when the launches run.
            candidates: their candidate lists, which are new then.
        """
        self.model, self.state, self.candidates = model, state, candidates
        self.way = model.empty(model.point_count, 3)
        """What is left of the way of each control point [units], shape (N, 3)."""
        self.progress = wp.zeros(3, dtype=wp.float64, device=model.device)
        """The numbers of ``PASSED``, ``STEP`` and ``LARGEST_NEED``."""
        start = _run_starts(model.yarns.segment_yarn)
        self.run_start, self.run_count = model.integers(start), len(start) - 1
        self.half_tangent, self.slack = model.empty(model.sample_count, 3), model.empty(model.sample_count, 2)
        self.travel = model.empty(model.sample_count, 4)
        self.pair_need, self.partner = model.empty(model.sample_count), model.integers(np.zeros(model.sample_count))
        types = wp.vec4, wp.vec4, wp.vec3, wp.vec3
        of_runs = [wp.zeros(self.run_count, dtype=each, device=model.device) for each in types]
        self.ball, self.run_travel, self.low, self.high = of_runs
        self.segment_need = wp.zeros(model.segment_count, dtype=wp.float32, device=model.device)
        self.nearest = model.integers(np.zeros(model.segment_count))
        for each in self._bound_launches():
            each.launch()
        self.tree = wp.Bvh(self.low, self.high, constructor="sah")  # the same tree on every device
        self.largest = wp.zeros(PARTS, dtype=wp.float64, device=model.device)

    def launches(self, target: wp.array[Any]) -> list[Any]:
        """Return the launches of one travel along the ways to ``target``; then the lists are out of date."""
        model, state, prepare = self.model, self.state, self.model.prepare
        listed = [self.candidates.count, self.candidates.lists]
        arcs = [model.constants, state.samples, self.half_tangent, self.slack, self.travel, *listed]
        near = self.candidates.near
        margin = model.number(float(self.candidates.margins.max()))
        runs = [model.constants, self.run_start, margin, wp.uint64(self.tree.id), self.ball, self.run_travel,
                near.centre, near.extent, state.samples, self.slack, self.travel, self.way]  # fmt: skip
        return [
            *self._bound_launches(),
            Refit(self.tree),
            prepare(travel_of_samples, model.segment_count, [model.constants, self.way], [self.travel]),
            prepare(need_of_pairs, model.sample_count, arcs, [self.pair_need, self.partner]),
            prepare(need_of_segments, model.segment_count, runs, [self.segment_need, self.nearest]),
            prepare(largest_needs, PARTS, [self.pair_need, self.segment_need], [self.largest]),
            prepare(choose_step, 1, [self.largest], [self.progress]),
            prepare(travel_on, model.point_count, [self.progress, target], [self.way, state.points]),
        ]

    def arc_launch(self) -> Any:
        """Return the launch that finds the tangent pieces, reaches and sags of all arcs."""
        model, made = self.model, [self.half_tangent, self.slack]
        return model.prepare(measure_arcs, model.segment_count, [model.constants, self.state.points], made)

    def _bound_launches(self) -> list[Any]:
        model, near, prepare = self.model, self.candidates.near, self.model.prepare
        inputs = [model.constants, self.run_start, near.centre, near.extent, self.way]
        outputs = [self.ball, self.run_travel, self.low, self.high]
        return [
            self.arc_launch(),
            prepare(bound_runs, self.run_count, inputs, outputs),
        ]

    def stopping_points(self) -> tuple[int, int]:
        """Return the control points of two arcs that limited the last travel most."""
        pairs, unlisted = self.pair_need.numpy(), self.segment_need.numpy()
        segments = [int(unlisted.argmax()), int(self.nearest.numpy()[unlisted.argmax()])]
        if unlisted.max() <= pairs.max():
            samples = [int(pairs.argmax()), int(self.partner.numpy()[pairs.argmax()])]
            segments = (self.model.sample_start.searchsorted(samples, side="right") - 1).tolist()
        one, other = self.model.yarns.segment_points[segments, 1].tolist()
        return one, other


def _run_starts(segment_yarn: Any) -> Any:
    """Return where each run of segments starts, and the number of segments, shape (R + 1,)."""
    yarn_first = np.flatnonzero(np.diff(segment_yarn, prepend=-1))
    within = np.arange(len(segment_yarn)) - np.repeat(yarn_first, np.diff(np.append(yarn_first, len(segment_yarn))))
    return np.append(np.flatnonzero(within % RUN == 0), len(segment_yarn))
