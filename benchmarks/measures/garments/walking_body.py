# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A body that walks in place: the legs of a standing body bend at hips and knees by smooth weights.

The body stands upright, y up, looks along z, and is symmetric in x; its legs are apart. Joints are given in parts of
its height, as on the base mesh of MakeHuman. A vertex turns about the hip, and below the knee about the knee too, by
the angle of the joint times a weight that rises smoothly over a length around the joint. The steps begin from standing
still.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tyro.conf import Positional

import stitchmesh as sm
from benchmarks.options import Output
from benchmarks.table import Rows
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


@dataclass(frozen=True)
class Options:
    """What is measured."""

    body: Positional[Path]
    output: Output
    unit: str = "cm"
    frames: int = 60


def walking_body(given: Options) -> Rows:
    """Bend the body, and write the frames."""
    body = sm.read_mesh(given.body, unit=given.unit)
    sm.write_moving_mesh(given.output, walking(body, given.frames), frames_per_second=FRAMES_PER_SECOND)
    yield f"{given.output}: {given.frames} frames of {len(body.vertices):,} vertices"
