# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A skirt that swings, twists and waves while its wearer walks and turns, in closed form.

The skirt is a straight tube of stockinette; a cloth of quads, three stitches wide and high, lies on the same surface.
A place of the tube is at the angle a around it and at the depth d below the waist, in parts of the height H. With the
amplitudes that grow smoothly over the first half second, at the time t

- the angle is turned by TWIST d sin(2 pi t / 1.5 s),
- the radius is multiplied by 1 + WAVE d^2 cos(FOLDS a + 2 pi t / 2 s),
- the axis is bent to an arc, whose direction changes along it by SWING sin(2 pi t / 2 s) in all,
- everything turns about the axis by a turn in 8 s, and walks along x at 60 cm/s.

Stitches along the hem are stretched and compressed by up to a tenth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import stitchmesh as sm
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh

FRAMES_PER_SECOND = 30.0
STITCH_WIDTH, STITCH_HEIGHT = 0.5, 0.45
"""Size of a stitch [cm]."""
TWIST, WAVE, FOLDS, SWING = np.radians(25.0), 0.06, 5, np.radians(30.0)
RAMP = 0.5
"""Time in which the amplitudes grow [s]."""
QUADS = 48
"""Quads of the cloth around the skirt, and along it."""


@dataclass(frozen=True, eq=False)
class SwingingSkirt:
    """A fabric, and a cloth that lies on the same surface and moves."""

    fabric: StitchMesh
    cloth: sm.MovingMesh


def swinging_skirt(stitches: int, frames: int) -> SwingingSkirt:
    """Return a skirt of about a number of stitches, about as high as three quarters of its girth."""
    around = max(round(stitches**0.5), 3)
    rows = round(stitches / around)
    pattern = sm.read_pattern("stockinette")
    fabric = sm.pattern_tube(
        pattern, around // pattern.width, (rows - 1) // pattern.height,
        stitch_width=STITCH_WIDTH, stitch_height=STITCH_HEIGHT,
    )  # fmt: skip
    height = STITCH_HEIGHT * fabric.face_count / around
    radius = around * STITCH_WIDTH / (2.0 * np.pi)
    angle, level, faces = _grid(QUADS, QUADS, height)
    times = np.arange(frames) / FRAMES_PER_SECOND
    places = np.array([placed(angle, level, radius, height, time) for time in times.tolist()])
    cloth = sm.MovingMesh(Mesh.from_polygons(places[0], faces), sm.VertexMotion(times, places))
    return SwingingSkirt(fabric, cloth)


def placed(angle: FloatArray, level: FloatArray, radius: float, height: float, time: float) -> FloatArray:
    """Places of the surface [cm], shape (n, 3), at a time [s].

    Args:
        angle: angle around the axis, shape (n,).
        level: height above the hem [cm], shape (n,).
        radius: radius of the tube [cm].
        height: height of the tube [cm].
        time: the time.
    """
    begun = min(time / RAMP, 1.0)
    size = begun**2 * (3.0 - 2.0 * begun)
    down = 1.0 - level / height
    turned = angle + size * TWIST * down * np.sin(2.0 * np.pi * time / 1.5)
    wide = radius * (1.0 + size * WAVE * down**2 * np.cos(FOLDS * angle + np.pi * time))
    out, across = wide * np.sin(turned), wide * np.cos(turned)
    bend = size * SWING * np.sin(np.pi * time)
    x, y = _on_arc(out, level - height, bend, height)
    whole = 2.0 * np.pi * time / 8.0
    return np.stack([
        x * np.cos(whole) + across * np.sin(whole) + 60.0 * time, y + height, across * np.cos(whole) - x * np.sin(whole)
    ], axis=1)  # fmt: skip


def _on_arc(out: FloatArray, below: FloatArray, bend: float, height: float) -> tuple[FloatArray, FloatArray]:
    """Place in the plane of the swing, ``out`` beside the axis and ``below`` the waist."""
    if abs(bend) < 1e-9:
        return out, below
    length, turn = height / bend, bend * below / height
    return length * (1.0 - np.cos(turn)) + out * np.cos(turn), length * np.sin(turn) - out * np.sin(turn)


def _grid(around: int, rows: int, height: float) -> tuple[FloatArray, FloatArray, list[list[int]]]:
    """Angles, levels and faces of the quads of a tube."""
    angle = np.tile(2.0 * np.pi * np.arange(around) / around, rows + 1)
    level = np.repeat(height * np.arange(rows + 1) / rows, around)
    row, column = (index.ravel() for index in np.indices((rows, around)))
    lower, after = row * around, (column + 1) % around
    faces = np.stack([lower + column, lower + after, lower + after + around, lower + column + around], axis=1)
    return angle, level, faces.tolist()
