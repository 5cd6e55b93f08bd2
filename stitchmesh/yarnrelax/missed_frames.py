# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Why yarns cannot follow a cloth to a frame, in one line.

The reasons are asked for in this order, each where the one before does not hold: the cloth cuts through itself; it is
folded more tightly than a stitch, which means that two neighbouring stitches turn from each other by more than
``SHARPEST``; the guard stopped two yarns. Every text names the two stitches that the guard stopped.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.collision.step_limit import yarn_place
from stitchmesh.yarnrelax.motion.self_cuts import SelfCut

SHARPEST = np.radians(90.0)
"""Angle between the normals of two neighbouring stitches beyond which a fold is tighter than a stitch."""


def why_missed(yarns: YarnSet, fabric: StitchMesh, points: tuple[int, int], cut: SelfCut | None) -> str:
    """Return why yarns did not reach a frame.

    Args:
        yarns: the yarns.
        fabric: the fabric as the cloth of the frame carries it.
        points: two control points of the yarns that the guard stopped.
        cut: where the cloth of the frame cuts through itself, if it does.
    """
    one, other = (yarn_place(yarns, point) for point in points)
    stopped = f"the guard stopped {one} before {other}; give the cloth more frames there, or deform it less"
    if cut is not None:
        return f"cloth in cloth {cut}; {stopped}"
    first, second, angle = sharpest_fold(fabric)
    if angle > SHARPEST:
        turn = f"stitch faces {first} and {second} turn from each other by {np.degrees(angle):.0f} degrees"
        return f"a fold tighter than a stitch: {turn}; {stopped}"
    return stopped


def sharpest_fold(fabric: StitchMesh) -> tuple[int, int, float]:
    """Return the two neighbouring faces of a fabric whose normals differ most, and their angle [rad]."""
    area = fabric.face_vector_area
    size = np.linalg.norm(area, axis=1, keepdims=True)
    normal = area / np.where(size > 0.0, size, 1.0)
    sides = np.flatnonzero(fabric.twin != BORDER)
    pairs = np.stack([fabric.side_face[sides], fabric.side_face[fabric.twin[sides]]], axis=1)
    if not len(pairs):
        return 0, 0, 0.0
    cosine = np.einsum("nd,nd->n", normal[pairs[:, 0]], normal[pairs[:, 1]])
    worst = int(cosine.argmin())
    first, second = pairs[worst].tolist()
    return first, second, float(np.arccos(np.clip(cosine[worst], -1.0, 1.0)))
