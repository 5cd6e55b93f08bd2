# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A glove for the right hand, with the palm to the front (+z) and the thumb at +x.

A ring is divided where the thumb and the fingers begin: neighbouring tubes share the edges of the
web between them, from front to back. Each tip ends in a small ring, which the yarn of the last row
closes.
"""

import numpy as np
from curves import oval, smooth_step, unit
from quad_mesh import Garment, QuadMesh, Ring

WRIST_HEIGHT, THUMB_HEIGHT = 6.6, 12.6
CUFF = [(4.0, 2.9, 0.0), (3.9, 2.8, 2.2), (3.8, 2.6, 4.4), (3.7, 2.4, 6.6)]
WEB_X = np.array([-4.75, -2.4, 0.0, 2.4, 4.75])  # Centres of the webs at the top of the palm.
WEB_Y = np.array([16.9, 17.9, 18.5, 18.3, 17.3])
FRONT_X = np.array([-4.25, -2.4, 0.0, 2.4, 4.25])
FINGERS = [  # Length [cm], angle towards the thumb [degrees], rows, half width [cm].
    (5.9, -15.0, 4, 1.05),
    (7.4, -5.5, 5, 1.12),
    (8.1, 1.5, 6, 1.15),
    (7.3, 9.0, 5, 1.15),
]
CURL = 0.22  # Angle by which a finger bends towards the palm [radians].
THUMB = (6.6, 33.0, 4, 1.35)  # As for a finger.


def model_glove() -> Garment:
    """Return the glove."""
    mesh = QuadMesh()
    rings = [oval(14, a, b, y) for a, b, y in CUFF]
    rings += [gusset_ring(t) for t in (1 / 3, 2 / 3, 1.0)]
    cuff = mesh.add(rings[0])
    hand = mesh.grow(cuff, rings[1:])
    front, thumb, back = hand[1:6], hand[6:9], hand[9:14]  # hand[0] is at the little finger.
    (web,) = mesh.add([[4.35, THUMB_HEIGHT + 0.9, 0.25]])
    borders = {"cuff": cuff[0]}
    borders["thumb tip"] = add_finger(mesh, [web, front[4], *thumb, back[0]], *THUMB)[0]
    tips = add_palm(mesh, [hand[0], *front, web, *back])
    borders |= {f"finger tip {number}": tip[0] for number, tip in enumerate(tips, 1)}
    return Garment("glove", mesh, borders)


def gusset_ring(t: float) -> np.ndarray:
    """Return a ring of 14 points between the wrist (t = 0) and the base of the thumb (t = 1)."""
    front_x = np.array([-4.2, -2.2, 0.0, 2.2, 4.2])
    front_z = np.array([1.05, 1.45, 1.5, 1.5, 1.35])
    x = np.concatenate([[-4.7], front_x, [5.7, 6.5, 5.7], front_x[::-1]])
    z = np.concatenate([[0.0], front_z, [1.35, 0.35, -0.75], -0.9 * front_z[::-1]])
    y = np.concatenate([np.zeros(5), [-0.1, -0.6, -1.2, -0.6, -0.1], np.zeros(4)])
    top = np.column_stack([x, THUMB_HEIGHT + y, z])
    a, b, height = CUFF[-1]
    ring = (1.0 - t) * oval(14, a, b, height) + t * top
    ring[:, 0] += 0.6 * np.sin(np.pi * t) * np.sign(x) * smooth_step(np.abs(x) / 4.0)
    return ring


def add_palm(mesh: QuadMesh, ring: Ring) -> list[Ring]:
    """Add the palm above the thumb, and the four fingers on it; return the rings at their tips."""
    start = np.array([mesh.points[i] for i in ring])
    top = palm_top()
    rows = [start + t * (top - start) for t in (1 / 3, 2 / 3, 1.0)]
    ring = mesh.grow(ring, rows)
    front, back = ring[1:6], ring[:6:-1]
    inner = np.column_stack([WEB_X, WEB_Y + 0.35, 0.0 * WEB_X])[1:4]
    webs = [ring[0], *mesh.add(inner), ring[6]]
    tips = []
    for i, finger in enumerate(FINGERS):
        base = [webs[i], front[i], front[i + 1], webs[i + 1], back[i + 1], back[i]]
        tips.append(add_finger(mesh, base, *finger))
    return tips


def palm_top() -> np.ndarray:
    """Return the ring of 12 points at the base of the fingers, a curve over the knuckles."""
    front = np.column_stack([FRONT_X, WEB_Y, [1.0, 1.25, 1.3, 1.25, 1.05]])
    back = front[::-1] * [1.0, 1.0, -1.0]
    sides = np.column_stack([WEB_X, WEB_Y, 0.0 * WEB_X])
    return np.vstack([sides[:1], front, sides[-1:], back])


def add_finger(
    mesh: QuadMesh, base: Ring, length: float, lean: float, rows: int, half_width: float
) -> Ring:
    """Add a finger on a ring of six vertices (web, two front, web, two back).

    Return the ring at its tip.
    """
    start = np.array([mesh.points[i] for i in base])
    tilt = np.radians(lean)
    along = np.array([np.sin(tilt), np.cos(tilt), 0.1])
    across = unit(start[3] - start[0])
    across = unit(across - (across @ unit(along)) * unit(along))
    heights = np.append(np.linspace(0.0, length - 0.7, rows + 1)[1:], [length - 0.15, length])
    taper = np.append(np.linspace(1.0, 0.92, rows - 1), [0.85, 0.62, 0.34])
    rings = []
    for height, scale in zip(heights, taper, strict=True):
        bend = CURL * height / length
        axis = unit(along) + bend * np.cross(across, unit(along))
        centre = start.mean(axis=0) + height * unit(axis)
        rings.append(finger_ring(centre, across, unit(axis), scale * half_width))
    return mesh.grow(base, rings)


def finger_ring(
    centre: np.ndarray, across: np.ndarray, axis: np.ndarray, half_width: float
) -> np.ndarray:
    """Return a ring of six points around a finger."""
    front = 0.95 * half_width * unit(np.cross(across, axis))
    side = half_width * across
    spokes = [-side, front - 0.52 * side, front + 0.52 * side]
    return centre + np.array(spokes + [-spoke for spoke in spokes])

