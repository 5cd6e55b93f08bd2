# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The step limit that forbids pull-through (Y 6.3, eqs 8 to 10; L appendix A).

Cut each segment of a yarn into one arc for each contact sample. An arc stays within its *reach*

    e = longest leg / (2 samples)

of its sample, because |y'| is at most the longest leg between control points. More sharply, it stays within its *sag*

    g = (half a sample's parameter range)^2 / 2 * largest difference of legs

of the straight tangent piece through the sample, because |y''| is at most the largest difference of legs. So two arcs
that do not neighbour each other along a yarn are at least their *clearance*

    c = |y_p - y_q| - e_p - e_q        or        c = distance of the tangent pieces - g_p - g_q

apart; the second, dearer one is used where the first is too small to be of use.

Let control points move in straight lines by vectors of length at most m. The weights of the spline are not negative and
sum to one, so every point of a curve, at every moment of the move, is displaced by at most the largest m of its four
control points. If each control point moves by less than half the clearance of every arc it takes part in, two arcs
approach by less than their clearance and cannot touch, at no moment: no yarn passes through another. Here a control
point moves by at most 0.45 of it, so that a clearance that was positive stays so.

Only pairs in the candidate lists are looked at. The lists hold all pairs up to the contact distance plus a margin, and
no control point moves by more than half the margin before the lists are made again; samples that are not listed are
thus at least the contact distance r_p + r_q apart, and their arcs (r_p - e_p) + (r_q - e_q). So 2 (r - e) serves as
the clearance of an arc towards all of them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.errors import SolverError
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.curve import segment_legs
from stitchmesh.yarnrelax.model import Model
from stitchmesh.yarnrelax.reduction import minimum
from stitchmesh.yarnrelax.state import State

wp.set_module_options({"enable_backward": False})

SAFETY = 0.45
"""Part of the clearance that one control point may use up in an iteration; below one half."""
SMALLEST_CLEARANCE = 1e-3
"""Clearance over the yarn radius below which a relaxation gives up."""
LARGEST_REACH = 0.85
"""Largest reach of a contact sample over the yarn radius at the start; it leaves room for yarns that stretch."""


@wp.func
def distance_of_pieces(centre: Any, half1: Any, half2: Any) -> Any:
    """Distance of two straight pieces whose middles are ``centre`` apart and whose half lengths are vectors."""
    zero = centre[0] - centre[0]
    one = type(zero)(1.0)
    a, b, e = wp.dot(half1, half1), wp.dot(half1, half2), wp.dot(half2, half2)
    c, f = wp.dot(half1, centre), wp.dot(half2, centre)
    determinant = a * e - b * b
    # parallel pieces: any point of the first serves, the clamps below find its partner
    s = zero
    if determinant > type(zero)(1.0e-6) * a * e:
        s = wp.clamp((b * f - c * e) / determinant, -one, one)
    t = wp.clamp((b * s + f) / wp.max(e, type(zero)(1.0e-30)), -one, one)
    s = wp.clamp((b * t - c) / wp.max(a, type(zero)(1.0e-30)), -one, one)
    t = wp.clamp((b * s + f) / wp.max(e, type(zero)(1.0e-30)), -one, one)
    return wp.length(centre + half1 * s - half2 * t)


@wp.func
def tangent_piece(model: Any, points: wp.array[Any], p: int) -> tuple[Any, Any]:
    """Half of the tangent piece of an arc, and the arc's sag."""
    s = p // model.contact_samples
    weight = model.sample_legs[p - s * model.contact_samples]
    corner = model.segment_points[s]
    leg0, leg1, leg2 = segment_legs(points, corner)
    half = type(weight[0])(0.5) / type(weight[0])(model.contact_samples)
    turn = wp.max(wp.length(leg1 - leg0), wp.length(leg2 - leg1))
    tangent = leg0 * weight[0] + leg1 * weight[1] + leg2 * weight[2]
    return tangent * half, turn * (half * half * type(half)(0.5))


@wp.func
def pair_clearance(model: Any, points: wp.array[Any], p: int, q: int, apart: Any, gap: Any) -> Any:
    """The better of the two bounds on the distance of two arcs [cm]."""
    half1, sag1 = tangent_piece(model, points, p)
    half2, sag2 = tangent_piece(model, points, q)
    return wp.max(gap, distance_of_pieces(apart, half1, half2) - sag1 - sag2)


@wp.func
def largest_step(model: Any, segment_clearance: wp.array[Any], i: int, step_fraction: Any, room: Any) -> Any:
    """How far control point ``i`` may move in this iteration [cm]."""
    limit = wp.min(step_fraction * model.point_radius[i], room)
    slots = model.point_segments[i]
    for slot in range(4):
        if slots[slot] >= 0:
            limit = wp.min(limit, segment_clearance[slots[slot]] * type(room)(SAFETY))
    return wp.max(limit, room - room)


@wp.func
def shortened(step: Any, limit: Any) -> Any:
    """The step, no longer than the limit."""
    length = wp.length(step)
    if length > limit:
        return step * (limit / length)
    return step


def samples_needed(yarns: YarnSet, contact_samples: int) -> int:
    """Contact samples a segment, at least as many as given, that leave no gap between samples.

    Leaf et al. (3.1) ask for spheres that touch, a reach of one radius.
    """
    corners = yarns.points[yarns.segment_points]
    leg = np.linalg.norm(np.diff(corners, axis=1), axis=2).max(axis=1)
    reach = np.maximum(leg, yarns.rest_length) / (2 * yarns.radius[yarns.segment_yarn])
    return max(contact_samples, int(np.ceil(reach.max() / LARGEST_REACH)))


def check_clearance(model: Model, state: State) -> None:
    """No two arcs may be so close, or a segment so stretched, that the bounds leave no room to move.

    Raises:
        SolverError: the clearance of a segment is used up; it names the yarn and the stitch face.
    """
    smallest = SMALLEST_CLEARANCE * float(model.yarns.radius.min())
    if not minimum(state.segment_clearance) < smallest:
        return
    segment = int(state.segment_clearance.numpy().argmin())
    place = yarn_place(model.yarns, int(model.yarns.segment_points[segment, 1]))
    found = f"too close to another yarn, or stretched too far, for {model.contact_samples} contact samples a segment"
    raise SolverError(f"{place}: {found} to tell it from touching; move the yarns apart or raise contact_samples")


def yarn_place(yarns: YarnSet, point: int) -> str:
    """How messages name a place on a yarn."""
    face = f", stitch face {yarns.face[point]}" if yarns.face[point] >= 0 else ""
    return f"yarn {yarns.point_yarn[point]} (control point {point}{face})"
