# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stress and bending moment of a periodic cell in its current state.

Take the frame and the strains of ``cell_strain``, and let W be the forces on the strains. The tension of the fabric is
-W over the area of the cell [dyn/cm]; it is positive where the cell would shrink. When the fabric is bent to a
curvature k along e1, places move by

    u = -k x z e1 + k x^2 / 2 n,    x along e1, z along the normal n

and the energy falls by Q k to first order, where Q sums over the legs of the yarns and over pairs in contact

    Q = sum of  -z f_1 d_1 + x (f_3 d_1 - f_1 d_3)

where d is the leg from control point to control point, or the gap between two samples, f is the force on its end, and z
and x belong to its middle. x is relative to the middle of the leg's segment; this makes no difference, because no
segment exerts a torque. Pairs push along their gap, and add to the first term only. Yarns at rest deform to first order
without a change of energy, so the moment of the fabric is Q over the area [dyn]. Where it is positive, a free edge
across e1 curls towards the normal, the right side. Under tension the moment depends on the plane in which z is zero;
here this plane goes through the middle of the yarn. The twist of yarns adds to the forces on the strains. Its torque on
each segment would make the choice of x matter, so that the moments leave it out; where they are at rest, this share is
of the second order in the torque.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.device import alone
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Vec5
from stitchmesh.compute.shared_work import shared
from stitchmesh.errors import ParameterError
from stitchmesh.lattice import lattice_frame
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.energies import evaluation
from stitchmesh.yarnrelax.energies.contact import contact_force_scale
from stitchmesh.yarnrelax.energies.twist import Twist
from stitchmesh.yarnrelax.evaluate import put_evaluations
from stitchmesh.yarnrelax.model.cells import PeriodicCell
from stitchmesh.yarnrelax.model.constants import ExactConstants
from stitchmesh.yarnrelax.model.lattice_images import cell_of, cell_of_sample, sample_number
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.model.spline import from_entry, segment_corners

SUMS = 5
"""W_11, W_22, W_12, and Q along the courses and along the wales."""

Shares = wp.types.vector(length=SUMS, dtype=wp.float64)


@dataclass(frozen=True)
class CellStress:
    """Forces and moments on the borders of a cell that would keep its shape."""

    course: float
    """Tension along the courses, on a cut along the wales [dyn/cm]."""
    wale: float
    """Tension along the wales [dyn/cm]."""
    shear: float
    """Shear [dyn/cm]."""
    course_moment: float
    """Moment that would curl the courses towards the right side [dyn]."""
    wale_moment: float
    """Moment that would curl the wales towards the right side [dyn]."""


@wp.func
def with_element(share: Vec5, frame: wp.mat33d, offset: wp.vec3d, middle: wp.vec3d, d: wp.vec3d, f: wp.vec3d) -> Any:
    """Add an element to the five sums; rows of ``frame`` are e1, e2, n; ``offset`` is relative to its segment."""
    along, force, out = frame * d, frame * f, frame * offset
    height = (frame * middle)[2]
    first = out[0] * (force[2] * along[0] - force[0] * along[2]) - height * force[0] * along[0]
    second = out[1] * (force[2] * along[1] - force[1] * along[2]) - height * force[1] * along[1]
    return share + type(share)(force[0] * along[0], force[1] * along[1], force[0] * along[1], first, second)


@kernel
def segment_shares(
    # model
    model: ExactConstants,
    frames: wp.array[wp.mat33d],
    # state in
    points: wp.array[wp.vec3d],
    leg_force: wp.array2d[wp.vec3d],
    # state out
    shares: wp.array2d[wp.float64],
) -> None:
    """Contribution of each segment to the sums."""
    s = wp.tid()
    frame = frames[cell_of(model.images, s)]
    q0, q1, q2, q3 = segment_corners(model, points, s)
    half = wp.float64(0.5)
    centre = (q1 + q2) * half
    first, last = (q0 + q1) * half, (q2 + q3) * half
    share = with_element(Shares(), frame, first - centre, first, q1 - q0, leg_force[0, s])
    share = with_element(share, frame, centre - centre, centre, q2 - q1, leg_force[1, s])
    share = with_element(share, frame, last - centre, last, q3 - q2, leg_force[2, s])
    for k in range(5):
        shares[k, s] = share[k]


@kernel
def contact_shares(
    # model
    model: ExactConstants,
    frames: wp.array[wp.mat33d],
    # state in
    samples: wp.array[wp.vec4d],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    shares: wp.array2d[wp.float64],
) -> None:
    """Half of the contribution of each pair in contact, at both of its samples."""
    p = wp.tid()
    frame = frames[cell_of_sample(model.images, p)]
    here = samples[p]
    half = wp.float64(0.5)
    stiffness = model.sample_stiffness[p] * half
    share = Shares()
    for c in range(candidate_count[p]):
        entry = candidates[p, c]
        gap4 = from_entry(model.images, samples, p, here, entry)
        gap = wp.vec3d(gap4[0], gap4[1], gap4[2])
        distance2, reach2 = wp.dot(gap, gap), gap4[3] * gap4[3]
        if distance2 < reach2:
            weight = model.sample_weight[sample_number(model.images, entry)]
            size, _stiff, _inverse = contact_force_scale(model.contact, p, distance2, reach2, weight * stiffness)
            middle = wp.vec3d(here[0], here[1], here[2]) - gap * half
            share = with_element(share, frame, wp.vec3d(), middle, gap, gap * size)
    for k in range(5):
        shares[k, p] = share[k]


@shared
@alone()
def cell_stress(
    yarns: YarnSet,
    material: YarnMaterial,
    *,
    quadrature_points: int = 11,
    contact_samples: int = 11,
    device: str | None = None,
    twist: Twist | None = None,
) -> CellStress:
    """Stress and bending moment of yarns on a lattice in their current state, in double precision.

    The arguments are the same as for ``yarn_energies``; use the sampling with which the yarns were relaxed. ``twist``
    adds the tension and shear of twisted yarns.

    Raises:
        ParameterError: the yarns have no lattice.
    """
    return cell_stresses([(yarns, material)], quadrature_points, contact_samples, device, twist)[0]


@alone()
def cell_stresses(
    given: Sequence[tuple[YarnSet, YarnMaterial]], quadrature_points: int, contact_samples: int | Sequence[int],
    device: str | None, twist: Twist | None = None,
) -> list[CellStress]:  # fmt: skip
    """Return the stress and bending moment of many cells, in the same launches; errors as in ``cell_stress``."""
    if any(yarns.lattice is None for yarns, _material in given):
        raise ParameterError("cell stress: the yarns repeat on no lattice")
    model, state, candidates = put_evaluations(given, "float64", quadrature_points, contact_samples, device)
    no_stiffness = model.empty(model.point_count)
    evaluation.force_launches(model, state, candidates, (), no_stiffness, model.launch)
    own = [lattice_frame(yarns.lattice.periods) for yarns, _material in given if yarns.lattice is not None]
    frames = wp.array(np.array(own), dtype=wp.mat33d, device=model.device)
    of_segments = wp.zeros((SUMS, model.segment_count), dtype=wp.float64, device=model.device)
    of_contacts = wp.zeros((SUMS, model.sample_count), dtype=wp.float64, device=model.device)
    inputs = [model.constants, frames, state.points, state.leg_force]
    model.launch(segment_shares, model.segment_count, inputs, [of_segments])
    inputs = [model.constants, frames, state.samples, candidates.count, candidates.lists]
    model.launch(contact_shares, model.sample_count, inputs, [of_contacts])
    first = model.segment_start[:-1]
    sums = np.add.reduceat(of_segments.numpy(), first, axis=1)
    if twist is not None:
        state.leg_force.zero_()
        twist.on(model).forces(state, state.forces, model.launch)
        inputs = [model.constants, frames, state.points, state.leg_force]
        model.launch(segment_shares, model.segment_count, inputs, [of_segments])
        sums[:3] += np.add.reduceat(of_segments.numpy()[:3], first, axis=1)
    sums += np.add.reduceat(of_contacts.numpy(), model.sample_start[first], axis=1)
    return [_stress(cell, frame[2], total) for cell, frame, total in zip(model.cells, own, sums.T, strict=True)]


def _stress(cell: PeriodicCell, normal: NDArray[np.float64], sums: NDArray[np.float64]) -> CellStress:
    """The stress of a cell from its sums."""
    assert cell.yarns.lattice is not None
    w11, w22, w12, first, second = sums.tolist()
    middle = np.concatenate(cell.yarns.sampled(4)).mean(axis=0)
    shift, area = float((middle - cell.origin) / cell.unit @ normal), cell.yarns.lattice.area
    # forces are in erg per unit, so the lever of the moment is in units too
    moments = (first + shift * w11) * cell.unit / area, (second + shift * w22) * cell.unit / area
    return CellStress(-w11 / area, -w22 / area, -w12 / area, *moments)
