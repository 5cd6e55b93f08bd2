# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A body that walks in place, and a skirt for it.

The body stands upright, y up, looks along z, and is symmetric in x; its legs are apart, and bend at hips and knees.
Joints are given in parts of its height, as on the base mesh of MakeHuman. A vertex turns about the hip, and below the
knee about the knee too, by the angle of the joint times a weight that rises smoothly over a length around the joint.
The steps begin from standing still.

The skirt, elliptic rings of quads from the hem to the waist, is for the body of assets/meshes/bodies. Its waist is 1.5
cm too narrow, so that the skirt cuts the body and has to be put round it (docs/how-to/follow.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import stitchmesh as sm
from stitchmesh.mesh import FloatArray, Mesh

FRAMES_PER_SECOND = 30.0
STEPS_PER_SECOND, RAMP = 1.0, 0.5
"""Walking cycles for each second, and time in which the steps grow to their full size [s]."""
HIP_ANGLE, KNEE_ANGLE = 20.0, 35.0
"""Largest angles [degrees]: of the thigh forwards and backwards, and of the knee while the leg swings forwards."""


@dataclass(frozen=True)
class Joint:
    """A joint of a leg; a body of height 1 stands on y = 0."""

    side: float
    """Distance from the middle of the body."""
    height: float
    """Height."""
    blend: float
    """Length over which the weight rises from 0 above the joint to 1 below it."""


HIP, KNEE = Joint(0.06, 0.485, 0.17), Joint(0.1, 0.245, 0.08)
CROTCH = 0.03
"""Distance from the middle over which the motion of a leg begins."""


def smooth_step(values: FloatArray) -> FloatArray:
    """0 below 0, 1 above 1, and between them a polynomial without a jump of the second derivative."""
    t = np.clip(values, 0.0, 1.0)
    result: FloatArray = t**3 * (10.0 - 15.0 * t + 6.0 * t**2)
    return result


def turned(points: FloatArray, centre: FloatArray, angles: FloatArray) -> FloatArray:
    """Points turned about a line along x, each by its own angle [rad]; a positive one takes -y forwards, to z."""
    y, z = points[:, 1] - centre[1], points[:, 2] - centre[2]
    sine, cosine = np.sin(angles), np.cos(angles)
    return np.column_stack([points[:, 0], centre[1] + y * cosine + z * sine, centre[2] - y * sine + z * cosine])


def bent(standing: FloatArray, side: int, hip_angle: float, knee_angle: float) -> FloatArray:
    """The body with one leg bent at hip and knee [rad]; ``side`` is 1 or -1."""
    low, tall = standing[:, 1].min(), np.ptp(standing[:, 1])
    leg = smooth_step(side * standing[:, 0] / (CROTCH * tall))
    moved = standing
    for joint, angle in ((KNEE, -knee_angle), (HIP, hip_angle)):
        centre = np.array([side * joint.side * tall, low + joint.height * tall, 0.01 * tall])
        below = smooth_step(0.5 + (centre[1] - standing[:, 1]) / (joint.blend * tall))
        moved = turned(moved, centre, angle * below * leg)
    return moved


def walking(body: Mesh, frames: int) -> sm.MovingMesh:
    """The body at some frames of walking in place."""
    times = np.arange(frames) / FRAMES_PER_SECOND
    places = []
    for time in times.tolist():
        size, phase = float(smooth_step(np.array(time / RAMP))), 2.0 * np.pi * STEPS_PER_SECOND * time
        moved = np.asarray(body.vertices)
        for side, shift in ((1, 0.0), (-1, np.pi)):
            hip = np.radians(HIP_ANGLE) * np.sin(phase + shift)
            knee = np.radians(KNEE_ANGLE) * 0.5 * (1.0 + np.cos(phase + shift))
            moved = bent(moved, side, size * hip, size * knee)
        places.append(moved)
    return sm.MovingMesh(body, sm.VertexMotion(times, np.array(places)))


ROWS, COLUMNS = 12, 20
HEIGHTS = (-38.0, 0.0, 18.0)
"""Heights of hem, hip and waist [cm]."""
HALF_WIDTHS, HALF_DEPTHS = (30.0, 20.0, 14.5), (20.0, 11.5, 9.5)
"""Half of the axes of the ellipses there [cm]."""
MIDDLE = 3.5
"""z of the middle of the ellipses [cm]."""


def skirt() -> Mesh:
    """The skirt."""
    height = np.linspace(HEIGHTS[0], HEIGHTS[-1], ROWS + 1)[:, None]
    angle = np.linspace(0.0, 2.0 * np.pi, COLUMNS, endpoint=False)
    x = np.interp(height, HEIGHTS, HALF_WIDTHS) * np.sin(angle)
    z = np.interp(height, HEIGHTS, HALF_DEPTHS) * np.cos(angle) + MIDDLE
    vertices = np.stack([x, height + 0.0 * angle, z], axis=-1).reshape(-1, 3)
    ring = np.arange(len(vertices)).reshape(ROWS + 1, COLUMNS)
    after = np.roll(ring, -1, axis=1)
    faces = np.stack([ring[:-1], after[:-1], after[1:], ring[1:]], axis=-1).reshape(-1, 4)
    return Mesh.from_polygons(vertices, faces.tolist())
