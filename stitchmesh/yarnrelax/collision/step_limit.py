# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The step limit that excludes pull-through (Y 6.3, eqs 8 to 10; L appendix A).

Divide each segment of a yarn into one arc for each contact sample. An arc stays within its *reach*

    e = longest leg / (2 samples)

of its sample, because |y'| is at most the longest leg between control points. A sharper bound says that the arc stays
within its *sag*

    g = (half a sample's parameter range)^2 / 2 * largest difference of legs

of the straight tangent piece through the sample, because |y''| is at most the largest difference of legs. Two arcs that
are not neighbours along a yarn are therefore at least their *clearance* apart:

    c = |y_p - y_q| - e_p - e_q        or        c = distance of the tangent pieces - g_p - g_q

The second form costs more. It is used where the first is too small to be useful.

Let every control point stay within a ball around its place x0 at the time when the candidate lists were made. The
weights of the spline are not negative and sum to one, so every point of a curve is displaced by at most the largest
displacement of its four control points. Let each control point stay closer to x0 than half the clearance of every arc
that contains it. Then two arcs approach by less than their clearance and cannot touch, at any moment and after any
number of iterations. No yarn passes through another. The radius of the ball is the point's *budget*,

    min(margin / 2,  0.45 * smallest clearance of its arcs)

and new lists give a new budget. If the cell deforms too (``cell_strain``), displacements are measured from places that
follow the deformation, and two arcs at the distance D approach by at most the strain times D. The control points and
the strain then share the clearance,

    0.7 * 0.45    and    0.35 * smallest clearance / D,    D the range of the lists and both arcs,

because arcs beyond that range gain more by their distance than they lose. They share the margin in the same way. A
straight move within the ball never leaves the ball, because a ball is convex.

Only pairs in the candidate lists are examined. The lists contain all pairs up to the contact distance plus a margin.
Samples that are not listed are farther apart, and the clearance of their arcs is at least
(r_p - e_p) + (r_q - e_q) + margin. Therefore 2 (r - e) + margin is the clearance of an arc towards all of them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec2, Vec3, Vec4
from stitchmesh.compute.reduction import minima_over
from stitchmesh.quality import MORE_DIGITS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import cell_of, cell_of_sample, rests, sample_number
from stitchmesh.yarnrelax.model.spline import LARGEST_REACH, from_entry, segment_corners, weight_row
from stitchmesh.yarnrelax.model.state import State

SAFETY = wp.constant(0.45)
"""Part of the clearance that one control point may use; it is below one half."""
PART_BESIDE_STRAIN = 0.7
"""Part of the step budget that remains for control points if the cell deforms too."""
STRAIN_CLEARANCE = wp.constant(wp.float64(PART_BESIDE_STRAIN / 2.0))
"""Part of the smallest clearance that the strain of a cell may use."""
STRAIN_MARGIN = wp.constant(wp.float64(0.3))
"""Part of the margin that the strain of a cell may use: 1 - ``PART_BESIDE_STRAIN``."""
LARGEST_STRAIN_STEP = wp.constant(wp.float64(0.05))
"""Largest strain on one set of lists; its square is neglected, because it is a small part of a clearance."""
STRAIN_UNIT = wp.constant(10.0)
"""Length that stands for a strain of 1, in mean radii: a limit of 0.1 radii on moves is a limit of 1 % on strains."""
FINER = "take quality reference, which has more contact samples"
"""Advice for yarns whose contact is sampled too coarsely."""
SMALLEST_CLEARANCE = 1e-3
"""A relaxation ends if a clearance, over the mean yarn radius, is below this."""


@kernel
def measure_budget_use(
    # state in
    points: wp.array[Vec3],
    listed_points: wp.array[Vec3],
    budget: wp.array[Scalar],
    # state out
    used: wp.array[Scalar],
) -> None:
    """Part of its budget that each control point has used."""
    i = wp.tid()
    used[i] = wp.length(points[i] - listed_points[i]) / budget[i]


@wp.func
def distance_of_pieces(centre: Vec3, half1: Vec3, half2: Vec3) -> Any:
    """Distance of two straight pieces whose middles are ``centre`` apart and whose half lengths are vectors."""
    zero = centre[0] - centre[0]
    one = type(zero)(1.0)
    a, b, e = wp.dot(half1, half1), wp.dot(half1, half2), wp.dot(half2, half2)
    c, f = wp.dot(half1, centre), wp.dot(half2, centre)
    determinant = a * e - b * b
    # parallel pieces: any point of the first one is suitable, and the clamps below find its partner
    s = zero
    if determinant > type(zero)(1.0e-6) * a * e:
        s = wp.clamp((b * f - c * e) / determinant, -one, one)
    t = wp.clamp((b * s + f) / wp.max(e, type(zero)(1.0e-30)), -one, one)
    s = wp.clamp((b * t - c) / wp.max(a, type(zero)(1.0e-30)), -one, one)
    t = wp.clamp((b * s + f) / wp.max(e, type(zero)(1.0e-30)), -one, one)
    return wp.length(centre + half1 * s - half2 * t)


@kernel
def measure_arcs(
    # model
    model: YarnConstants,
    # state in
    points: wp.array[Vec3],
    # state out
    half_tangent: wp.array[Vec3],
    slack: wp.array[Vec2],
) -> None:
    """Half of each arc's tangent piece; its reach and its sag."""
    s = wp.tid()
    if rests(model.images, cell_of(model.images, s)):
        return
    q0, q1, q2, q3 = segment_corners(model, points, s)
    leg0, leg1, leg2 = q1 - q0, q2 - q1, q3 - q2
    first = model.sample_start[s]
    count = model.sample_start[s + 1] - first
    row = weight_row(model, count, 0)
    longest = wp.max(wp.length(leg0), wp.max(wp.length(leg1), wp.length(leg2)))
    turn = wp.max(wp.length(leg1 - leg0), wp.length(leg2 - leg1))
    half = type(longest)(0.5) / type(longest)(count)
    for k in range(count):
        weight = model.sample_legs[row + k]
        half_tangent[first + k] = (leg0 * weight[0] + leg1 * weight[1] + leg2 * weight[2]) * half
        slack[first + k] = type(slack[0])(longest * half, turn * (half * half * type(half)(0.5)))


@kernel
def arc_clearances(
    # model
    model: YarnConstants,
    margins: wp.array[wp.float64],
    # state in
    samples: wp.array[Vec4],
    half_tangent: wp.array[Vec3],
    slack: wp.array[Vec2],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    clearance: wp.array[Scalar],
) -> None:
    """Clearance of each sample's arc; exact only where it limits a budget."""
    p = wp.tid()
    cell = cell_of_sample(model.images, p)
    if rests(model.images, cell):
        return
    here = samples[p]
    reach, sag = slack[p][0], slack[p][1]
    margin = type(reach)(margins[cell])
    least = type(margin)(2.0) * (here[3] - reach) + margin
    enough = margin / type(margin)(2.0 * SAFETY)
    for c in range(wp.min(candidate_count[p], candidates.shape[1])):  # a list beyond its capacity is made again
        entry = candidates[p, c]
        q = sample_number(model.images, entry)
        apart4 = from_entry(model.images, samples, p, here, entry)
        apart = type(half_tangent[0])(apart4[0], apart4[1], apart4[2])
        gap = wp.length(apart) - reach - slack[q][0]
        if gap < wp.min(least, enough):
            close = distance_of_pieces(apart, half_tangent[p], half_tangent[q]) - sag - slack[q][1]
            least = wp.min(least, wp.max(gap, close))
    clearance[p] = least


@kernel
def set_budgets(
    # model
    model: YarnConstants,
    margins: wp.array[wp.float64],
    part_of_margin: wp.float64,
    part: Scalar,
    # state in
    clearance: wp.array[Scalar],
    # state out
    budget: wp.array[Scalar],
) -> None:
    """Budget of each control point."""
    i = wp.tid()
    slots = model.point_segments[i]
    cell = cell_of(model.images, wp.max(slots))
    if rests(model.images, cell):
        return
    least = type(part)(part_of_margin * margins[cell])
    for slot in range(4):
        s = slots[slot]
        if s >= 0:
            for p in range(model.sample_start[s], model.sample_start[s + 1]):
                least = wp.min(least, clearance[p] * part)
    budget[i] = wp.max(least, least - least)


@wp.func
def strain_budget(clearance: wp.float64, margin: wp.float64, apart: wp.float64) -> wp.float64:
    """Budget of the strains of a cell, in the unit of their entry."""
    part = wp.min(clearance * STRAIN_CLEARANCE, margin * STRAIN_MARGIN) / apart
    return wp.clamp(part, wp.float64(0.0), LARGEST_STRAIN_STEP) * wp.float64(STRAIN_UNIT)


@kernel
def set_strain_budgets(
    # model
    point_count: int,
    margins: wp.array[wp.float64],
    apart: wp.array[wp.float64],
    # state in
    least: wp.array[wp.float64],
    # state out
    budget: wp.array[Scalar],
) -> None:
    """Budget of the strains of each cell."""
    cell = wp.tid()
    margin = margins[cell]
    budget[point_count + cell] = type(budget[0])(strain_budget(least[cell], margin, apart[cell] + margin))


@kernel
def nearest_arcs(
    # model
    model: YarnConstants,
    # state in
    samples: wp.array[Vec4],
    half_tangent: wp.array[Vec3],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    nearest: wp.array[Scalar],
) -> None:
    """Smallest distance of the arc of a sample to others, over the mean radius of both; 2 where nothing touches it."""
    p = wp.tid()
    here = samples[p]
    least = here[3] / here[3]
    for c in range(candidate_count[p]):
        entry = candidates[p, c]
        q = sample_number(model.images, entry)
        apart = from_entry(model.images, samples, p, here, entry)
        centre = type(half_tangent[0])(apart[0], apart[1], apart[2])
        least = wp.min(least, distance_of_pieces(centre, half_tangent[p], half_tangent[q]) / apart[3])
    nearest[p] = least * type(least)(2.0)


@kernel
def nearest_entry(
    # model
    model: YarnConstants,
    sample: int,
    # state in
    samples: wp.array[Vec4],
    half_tangent: wp.array[Vec3],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    nearest: wp.array[wp.int32],
    distance: wp.array[Scalar],
) -> None:
    """The listed sample whose arc is nearest to that of ``sample``, -1 where there is none; one thread."""
    here = samples[sample]
    nearest[0] = -1
    for c in range(candidate_count[sample]):
        entry = candidates[sample, c]
        q = sample_number(model.images, entry)
        apart = from_entry(model.images, samples, sample, here, entry)
        centre = type(half_tangent[0])(apart[0], apart[1], apart[2])
        found = distance_of_pieces(centre, half_tangent[sample], half_tangent[q])
        if nearest[0] < 0 or found < distance[0]:
            nearest[0] = q
            distance[0] = found


def clearance_launches(model: Model, state: State, candidates: Candidates, clearance: wp.array[Any]) -> list[Any]:
    """Return the launches that find each arc's clearance where it limits a budget; samples and lists are up to date."""
    half_tangent, slack = model.empty(model.sample_count, 3), model.empty(model.sample_count, 2)
    inputs = [model.constants, candidates.margins_there, state.samples, half_tangent, slack, candidates.count,
              candidates.lists]  # fmt: skip
    return [
        model.prepare(measure_arcs, model.segment_count, [model.constants, state.points], [half_tangent, slack]),
        model.prepare(arc_clearances, model.sample_count, inputs, [clearance]),
    ]


def budget_launch(model: Model, state: State, candidates: Candidates, clearance: wp.array[Any]) -> Any:
    """Return the launch that sets the budgets of all control points."""
    beside = PART_BESIDE_STRAIN if state.cell_relaxes else 1.0
    numbers = [wp.float64(beside / 2.0), model.number(beside * SAFETY)]
    inputs = [model.constants, candidates.margins_there, *numbers, clearance]
    return model.prepare(set_budgets, model.point_count, inputs, [state.budget])


def strain_budget_launches(model: Model, state: State, candidates: Candidates, least: wp.array[Any]) -> list[Any]:
    """Return the launch that sets the budgets of the strains of relaxing cells, from each cell's smallest clearance."""
    if not state.cell_relaxes:
        return []
    radii = np.maximum.reduceat(model.radius, model.yarn_start[:-1])
    apart = wp.array(2.0 * (radii + LARGEST_REACH), dtype=wp.float64, device=model.device)
    inputs = [model.point_count, candidates.margins_there, apart, least]
    return [model.prepare(set_strain_budgets, model.cell_count, inputs, [state.budget])]


def too_close_cells(
    model: Model, state: State, candidates: Candidates, clearance: wp.array[Any], cells: NDArray[np.bool_]
) -> dict[int, str]:
    """Return a message for each of some cells, in which the clearance of an arc is used up; it names the place."""
    failed = {}
    for cell in np.flatnonzero(cells).tolist():
        first, last = model.sample_start[model.segment_start[cell : cell + 2]]
        worst = int(first + clearance.numpy()[first:last].argmin())
        failed[cell] = _too_close(model, state, candidates, worst, float(candidates.margins[cell]))
    return failed


def smallest_distances(model: Model, state: State, candidates: Candidates) -> NDArray[np.float64]:
    """Return the smallest distance of each cell's yarns over their radius, 2 if none touch, shape (C,).

    The error is at most the sag of the arcs.
    """
    half_tangent, _slack = _arcs(model, state)
    nearest = model.empty(model.sample_count)
    inputs = [model.constants, state.samples, half_tangent, candidates.count, candidates.lists]
    model.launch(nearest_arcs, model.sample_count, inputs, [nearest])
    return minima_over(nearest, model.cell_samples, model.largest_cell)


def _arcs(model: Model, state: State) -> tuple[wp.array[Any], wp.array[Any]]:
    half_tangent, slack = model.empty(model.sample_count, 3), model.empty(model.sample_count, 2)
    model.launch(measure_arcs, model.segment_count, [model.constants, state.points], [half_tangent, slack])
    return half_tangent, slack


def _too_close(model: Model, state: State, candidates: Candidates, sample: int, margin: float) -> str:
    half_tangent, slack = _arcs(model, state)
    segment = _segment(model, sample)
    place = yarn_place(model.yarns, int(model.yarns.segment_points[segment, 1]))
    count = int(np.diff(model.sample_start)[segment])
    reach = float(slack.numpy()[sample, 0])
    if not np.isfinite(reach):
        return f"{place}: its control points are not finite; {MORE_DIGITS}"
    if 2.0 * (model.radius[model.yarns.segment_yarn[segment]] - reach) + margin < SMALLEST_CLEARANCE:
        found = f"{2 * reach * count:.3g} yarn radii between control points, too many for {count} contact samples"
        return f"{place}: {found}; give it longer rest lengths, or {FINER}"
    nearest, distance = model.integers(np.array([-1])), model.empty(1)
    inputs = [model.constants, sample, state.samples, half_tangent, candidates.count, candidates.lists]
    model.launch(nearest_entry, 1, inputs, [nearest, distance])
    other = yarn_place(model.yarns, int(model.yarns.segment_points[_segment(model, int(nearest.numpy()[0])), 1]))
    found = f"{float(distance.numpy()[0]):.2g} yarn radii between the axes, and {count} contact samples a segment"
    remedy = f"take thinner yarn, change rest lengths in steps of a fifth, raise k_contact (--stiffness), or {FINER}"
    return f"{place}: too close to {other} for the contact energy to separate them, {found}; move them apart, {remedy}"


def _segment(model: Model, sample: int) -> int:
    """The segment of a contact sample."""
    return int(np.searchsorted(model.sample_start, sample, side="right") - 1)


def yarn_place(yarns: YarnSet, point: int) -> str:
    """Name of a place on a yarn for messages."""
    face = f", stitch face {yarns.face[point]}" if yarns.face[point] >= 0 else ""
    return f"yarn {yarns.point_yarn[point]} (control point {point}{face})"
