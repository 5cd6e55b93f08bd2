# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bends that stay in a yarn: what steam or a wash sets, and what sharp bends leave.

The yarn has the curvature kappa, and at rest it would have the natural curvature k. Its bending moment is
EI (kappa - k), for curvatures in one plane.

Set: heat and water loosen the bonds within fibres, which form again in the bent shape. With the share s,

    k  becomes  k + s (kappa - k)

so that a straight yarn that was bent to kappa keeps s kappa, and carries (1 - s) of its moment.

Yield: fibres slide where the moment is larger than EI k_y, with the yield curvature k_y, and the moment stays at this
bound. The return mapping of an elastic, perfectly plastic rod (Simo and Hughes 1998, section 1.4) is

    k  becomes  kappa - k_y  where  kappa - k > k_y,    kappa + k_y  where  kappa - k < -k_y

A yarn that was bent straight to kappa and let go therefore keeps kappa - M / EI, with M = EI k_y.

Both hold in each place of the yarn. The natural curvature has no direction of its own: the bending energy
(``yarnrelax.energies.segment_forces``) turns it about the axis of the yarn to where it costs least. Natural curvature
stands at the knots between segments, with a sign that changes where the direction of bending turns by more than a right
angle from knot to knot, as in a wave.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.errors import ParameterError, check_positive
from stitchmesh.mesh import FloatArray
from stitchmesh.yarn.yarn_set import YarnSet


def bend_at_knots(yarns: YarnSet) -> FloatArray:
    """Return the present curvature where segments meet, with the signs of ``YarnSet.natural_curvature`` [1/cm], (N,).

    The first value of a yarn is positive. Values that a yarn does not use are zero.
    """
    corners = yarns.points[yarns.segment_points]
    if yarns.point_shift is not None:
        corners = corners + yarns.point_shift
    binormal = np.zeros((len(yarns.points), 3))
    for slot in (1, 2):
        before, here, after = corners[:, slot - 1], corners[:, slot], corners[:, slot + 1]
        along = (after - before) / 2.0
        speed = np.linalg.norm(along, axis=1, keepdims=True)
        found = np.cross(along, before - 2.0 * here + after)
        binormal[yarns.segment_points[:, slot]] = found / np.where(speed > 0.0, speed, 1.0) ** 3
    turns_over = np.zeros(len(binormal), dtype=np.int64)
    turns_over[1:] = (binormal[1:] * binormal[:-1]).sum(axis=1) < 0.0
    turns_over[yarns.start[:-1]] = 0
    count = np.cumsum(turns_over)
    odd = (count - count[yarns.start[:-1]][yarns.point_yarn]) % 2 == 1
    curvature: FloatArray = np.where(odd, -1.0, 1.0) * np.linalg.norm(binormal, axis=1)
    return curvature


def set_yarns(yarns: YarnSet, share: float) -> YarnSet:
    """Return yarns after steam or a wash has set a share of their bending, in [0, 1], where they lie.

    Raises:
        ParameterError: the share is not in [0, 1].
    """
    if not 0.0 <= share <= 1.0:
        raise ParameterError(f"set: got a share of {share}; expected a number from 0 to 1")
    bend = bend_at_knots(yarns)
    natural = np.abs(yarns.natural_curvature)
    return replace(yarns, natural_curvature=np.copysign(natural + share * (np.abs(bend) - natural), bend))


def yielded_yarns(yarns: YarnSet, yield_curvature: float) -> YarnSet:
    """Return yarns after their fibres have slid where they are bent by more than a yield curvature [1/cm].

    Raises:
        ParameterError: the yield curvature is not a positive number.
    """
    check_positive("yield curvature", yield_curvature, "1/cm")
    bend = bend_at_knots(yarns)
    natural = np.abs(yarns.natural_curvature)
    elastic = np.clip(np.abs(bend) - natural, -yield_curvature, yield_curvature)
    slid = np.abs(np.abs(bend) - natural) > yield_curvature
    after = np.where(slid, np.copysign(np.abs(bend) - elastic, bend), yarns.natural_curvature)
    return replace(yarns, natural_curvature=after)
