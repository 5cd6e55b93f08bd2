# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Damping: the dissipation of moving yarns (Kaldor 2008; L eqs 11 and 12).

Dissipation of segments with velocities v(s), each unordered pair in contact counted once:

    D_global  = k_global int v . v ds                                                           [erg / s]
    D_contact = l_i l_j int int [k_dt |dv|^2 - (k_dt - k_dn) (n . dv)^2] ds ds'

with dv the relative velocity of the pair and n the direction between its samples. As in L's Algorithm 1 a damping force
is minus the derivative of D by the velocity, so yarns lose the power 2 D. (A Rayleigh function would be half of D.) On
control points and contact samples, the forces are:

    F_j = - 2 k_global sum over segments and their slots k of  int B_j B_k ds  v_k
    F_p = - sum over q of  2 w_p w_q [k_dt dv - (k_dt - k_dn) (n . dv) n],   dv = v_p - v_q

where w = l / samples per segment. On the device k_global |v|^2 and w^2 k_dt |dv|^2 keep their values, because the
material is scaled with the lengths (``constants``).

Pairs are in contact if their contact energy is not zero. Both samples of a pair compute its force from the same
numbers, so contact damping conserves momentum. The kernels also find row sums of the damping, for the time step.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3, Vec4, load_vector, store_vector
from stitchmesh.yarn import basis
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import sample_number
from stitchmesh.yarnrelax.model.spline import from_entry, weight_row
from stitchmesh.yarnrelax.model.state import State


@wp.func
def drag_on(model: YarnConstants, drag: wp.array[Vec4], velocity: wp.array[Vec3], s: int, slot: int) -> Any:
    """Global damping of a segment on the control point in a slot."""
    corner = model.segment_points[s]
    row = drag[slot]
    pull = velocity[corner[0]] * row[0] + velocity[corner[1]] * row[1]
    return -(pull + velocity[corner[2]] * row[2] + velocity[corner[3]] * row[3])


@kernel
def sample_velocities(
    # model
    model: YarnConstants,
    # state in
    velocity: wp.array[Vec3],
    # state out
    sample_velocity: wp.array[Vec4],
) -> None:
    """Velocity [unit / s] of each contact sample, and 0."""
    s = wp.tid()
    corner = model.segment_points[s]
    v0, v1, v2, v3 = velocity[corner[0]], velocity[corner[1]], velocity[corner[2]], velocity[corner[3]]
    first = model.sample_start[s]
    count = model.sample_start[s + 1] - first
    row = weight_row(model, count, 0)
    for k in range(count):
        weight = model.sample_basis[row + k]
        v = v0 * weight[0] + v1 * weight[1] + v2 * weight[2] + v3 * weight[3]
        store_vector(sample_velocity, first + k, type(sample_velocity[0])(v[0], v[1], v[2], v[0] - v[0]))


@kernel
def contact_damping(
    # model
    model: YarnConstants,
    k_dt: Scalar,
    k_dn: Scalar,
    # state in
    samples: wp.array[Vec4],
    sample_velocity: wp.array[Vec4],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    sample_damping: wp.array[Vec4],
) -> None:
    """Contact damping on each sample [erg / unit], and the row sum of its own coefficients."""
    p = wp.tid()
    here, moving = load_vector(samples, p), load_vector(sample_velocity, p)
    loss = type(here)()
    for c in range(candidate_count[p]):
        entry = candidates[p, c]
        apart = from_entry(model.images, samples, p, here, entry)
        distance2 = apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]
        if distance2 < apart[3] * apart[3]:
            q = sample_number(model.images, entry)
            dv = moving - load_vector(sample_velocity, q)
            nearing = (apart[0] * dv[0] + apart[1] * dv[1] + apart[2] * dv[2]) / distance2 * (k_dt - k_dn)
            pull = apart * nearing - dv * k_dt
            largest = wp.max(k_dt, k_dn)
            loss += type(loss)(pull[0], pull[1], pull[2], largest) * model.sample_weight[q]
    store_vector(sample_damping, p, loss * (model.sample_weight[p] * type(k_dt)(2.0)))


class ContactDamping:
    """Damping of contacts on a device; a material without contact damping costs nothing."""

    def __init__(self, model: Model) -> None:
        """Allocate the arrays on a model's device."""
        count = model.sample_count if max(model.material.k_dt, model.material.k_dn) > 0.0 else 0
        self.model = model
        self.velocity = model.empty(count, 4)
        self.force = model.empty(count, 4)
        """Damping on each sample and the row sum of its coefficients [erg s / unit^2], shape (P, 4) or empty."""

    def launches(self, state: State, candidates: Candidates, velocity: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Return the launches that leave the damping for given velocities in ``force``; the samples must be placed."""
        if len(self.force) == 0:
            return []
        model = self.model
        inputs = [model.constants, model.number(model.material.k_dt), model.number(model.material.k_dn),
                  state.samples, self.velocity, candidates.count, candidates.lists]  # fmt: skip
        return [
            launcher(sample_velocities, model.segment_count, [model.constants, velocity], [self.velocity]),
            launcher(contact_damping, model.sample_count, inputs, [self.force]),
        ]


def segment_drag(model: Model) -> NDArray[np.float64]:
    """Return the coefficients of global damping between the slots of a segment [erg s / unit^2], shape (4, 4)."""
    nodes, weights = np.polynomial.legendre.leggauss(4)  # exact for products of cubics
    value = basis((nodes + 1) / 2)
    return 2.0 * model.material.k_global * np.einsum("g,gi,gj->ij", weights / 2, value, value)


def drag_rows(model: Model) -> NDArray[np.float64]:
    """Return the row sums of global damping at the control points [erg s / unit^2], shape (N,)."""
    rows = np.broadcast_to(segment_drag(model).sum(axis=1), (model.segment_count, 4))
    corners = model.yarns.segment_points.ravel()
    return np.bincount(corners, weights=rows.ravel(), minlength=model.point_count).astype(np.float64)
