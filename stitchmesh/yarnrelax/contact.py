# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact: yarns push each other apart where they overlap (L eqs 9, 10; Kaldor 2008).

Energy of two segments of rest lengths l_i, l_j, each unordered pair counted once:

    E = k_contact l_i l_j int int f(|y_i(s) - y_j(s')| / 2r) ds ds'        [erg]
    f(d) = 1/d^2 + d^2 - 2  for d < 1, else 0

with r_i + r_j in place of 2r where radii differ. The integrals are midpoint sums over the contact samples, which
converge fast because the integrand is smooth along yarns that are many samples long. The force on a sample p is

    F_p = sum over q of  2 k_contact w_p w_q (R^4 / d^4 - 1) / R^2 (y_p - y_q),   R = r_p + r_q,  d = |y_p - y_q|

where w = l / samples per segment. It is computed from p's side and from q's side, so that each segment gathers its
own force; both sides use the same numbers, so the forces sum to zero up to rounding.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.yarnrelax.step_limit import distance_of_pieces, pair_clearance, tangent_piece

wp.set_module_options({"enable_backward": False})


@wp.func
def contact_energy(distance2: Any, reach2: Any, stiffness: Any) -> Any:
    """Energy [erg] of two samples at a squared distance below ``reach2`` [cm^2]."""
    d2 = distance2 / reach2
    return stiffness * (type(d2)(1.0) / d2 + d2 - type(d2)(2.0))


@wp.func
def contact_push(distance2: Any, reach2: Any, stiffness: Any) -> Any:
    """Force over the vector from the other sample [dyn / cm]."""
    ratio = reach2 / distance2
    return type(ratio)(2.0) * stiffness * (ratio * ratio - type(ratio)(1.0)) / reach2


@wp.func
def contact_stiffness(distance2: Any, reach2: Any, stiffness: Any) -> Any:
    """Second derivative of the energy by the distance [dyn / cm]."""
    ratio = reach2 / distance2
    return stiffness * (type(ratio)(6.0) * ratio * ratio + type(ratio)(2.0)) / reach2


@wp.kernel(module="unique")
def place_samples(
    # model
    model: Any,
    # state in
    points: wp.array[Any],
    # state out
    samples: wp.array[Any],
    sample_reach: wp.array[Any],
) -> None:
    """Contact samples [cm], and how far the curve they stand for lies from them at most [cm]."""
    s = wp.tid()
    corner = model.segment_points[s]
    q0, q1, q2, q3 = points[corner[0]], points[corner[1]], points[corner[2]], points[corner[3]]
    longest = wp.max(wp.length(q1 - q0), wp.max(wp.length(q2 - q1), wp.length(q3 - q2)))
    reach = longest / type(longest)(2 * model.contact_samples)
    for k in range(model.contact_samples):
        weight = model.sample_basis[k]
        p = s * model.contact_samples + k
        samples[p] = q0 * weight[0] + q1 * weight[1] + q2 * weight[2] + q3 * weight[3]
        sample_reach[p] = reach


@wp.kernel(module="unique")
def add_contact_forces(
    # model
    model: Any,
    watch: Any,
    # state in
    points: wp.array[Any],
    samples: wp.array[Any],
    sample_reach: wp.array[Any],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    segment_force: wp.array[Any],
    segment_stiffness: wp.array[Any],
    segment_clearance: wp.array[Any],
) -> None:
    """Add contact forces [dyn]; row sums of their stiffness [dyn / cm]; clearance where below ``watch`` [cm]."""
    s = wp.tid()
    force0, force1 = type(samples[0])(), type(samples[0])()
    force2, force3 = type(samples[0])(), type(samples[0])()
    stiffness = model.sample_basis[0] * type(watch)(0.0)
    first = s * model.contact_samples
    clearance = wp.min(watch, type(watch)(2.0) * (model.sample_radius[first] - sample_reach[first]))
    for k in range(model.contact_samples):
        p = first + k
        here = samples[p]
        radius, weight = model.sample_radius[p], model.sample_weight[p] * model.k_contact
        push = type(here)()
        stiff = type(watch)(0.0)
        for c in range(candidate_count[p]):
            q = candidates[p, c]
            apart = here - samples[q]
            distance2 = wp.dot(apart, apart)
            reach = radius + model.sample_radius[q]
            if distance2 < reach * reach:
                pair_weight = weight * model.sample_weight[q]
                push += apart * contact_push(distance2, reach * reach, pair_weight)
                stiff += contact_stiffness(distance2, reach * reach, pair_weight)
                gap = wp.sqrt(distance2) - sample_reach[p] - sample_reach[q]
                if gap < clearance:
                    clearance = wp.min(clearance, pair_clearance(model, points, p, q, apart, gap))
        basis = model.sample_basis[k]
        force0 += push * basis[0]
        force1 += push * basis[1]
        force2 += push * basis[2]
        force3 += push * basis[3]
        stiffness += basis * (type(stiff)(2.0) * stiff)
    segment_force[4 * s] += force0
    segment_force[4 * s + 1] += force1
    segment_force[4 * s + 2] += force2
    segment_force[4 * s + 3] += force3
    segment_stiffness[s] = stiffness
    segment_clearance[s] = clearance


@wp.kernel(module="unique")
def contact_energies(
    # model
    model: Any,
    # state in
    samples: wp.array[Any],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    sample_energy: wp.array[Any],
) -> None:
    """Half of each pair's energy [erg], at both of its samples."""
    p = wp.tid()
    here = samples[p]
    energy = model.k_contact - model.k_contact
    weight = model.sample_weight[p] * model.k_contact
    for c in range(candidate_count[p]):
        q = candidates[p, c]
        apart = here - samples[q]
        distance2 = wp.dot(apart, apart)
        reach = model.sample_radius[p] + model.sample_radius[q]
        if distance2 < reach * reach:
            energy += contact_energy(distance2, reach * reach, weight * model.sample_weight[q])
    sample_energy[p] = energy * type(energy)(0.5)


@wp.kernel(module="unique")
def nearest_arcs(
    # model
    model: Any,
    # state in
    points: wp.array[Any],
    samples: wp.array[Any],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    sample_nearest: wp.array[Any],
) -> None:
    """Smallest distance of the arc of a sample to others, over the mean radius; 2 where nothing touches it."""
    p = wp.tid()
    nearest = model.sample_radius[p] / model.sample_radius[p]
    half1, _sag1 = tangent_piece(model, points, p)
    for c in range(candidate_count[p]):
        q = candidates[p, c]
        half2, _sag2 = tangent_piece(model, points, q)
        distance = distance_of_pieces(samples[p] - samples[q], half1, half2)
        nearest = wp.min(nearest, distance / (model.sample_radius[p] + model.sample_radius[q]))
    sample_nearest[p] = nearest * type(nearest)(2.0)
