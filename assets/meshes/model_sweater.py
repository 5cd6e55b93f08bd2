# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A sweater with sleeves and a seamless yoke, knitted from the bottom up.

Body and sleeves are tubes. Under each arm, two edges of the top ring of the body are also edges of
the top ring of the sleeve (the grafted underarm). All other edges of the three top rings form the
first ring of the yoke, which ends at the neck.
"""

import numpy as np
from curves import hermite, oval, smooth_step, unit
from quad_mesh import Garment, QuadMesh, Ring

FRONT = 8  # Number of edges of the front, and of the back, between the underarms.
UNDERARM = 2
BODY_EDGES = 2 * (FRONT + UNDERARM)
SLEEVE_EDGES = 8
YOKE_ROWS = 6
SLEEVE_ROWS = 9
BODY = [  # Half width, half depth and height [cm].
    (19.6, 12.4, 0.0),
    (19.4, 12.2, 4.0),
    (20.4, 12.8, 8.5),
    (20.4, 12.8, 13.5),
    (20.3, 12.7, 18.5),
    (20.3, 12.6, 23.5),
    (20.5, 12.6, 28.5),
    (20.8, 12.6, 33.5),
    (21.0, 12.6, 38.5),
]
CORNER_SHIFT = np.array([0.8, 1.3, 0.8])  # Outward and up, where body, sleeve and yoke meet.
SLEEVE_ANGLE = np.radians(40.0)  # Angle below the horizontal.
SLEEVE_LENGTH = 46.0
MIRROR = np.array([-1.0, 1.0, 1.0])
MIRROR_ORDER = [2, 1, 0, 7, 6, 5, 4, 3]


def model_sweater() -> Garment:
    """Return the sweater."""
    mesh = QuadMesh()
    rings = [oval(BODY_EDGES, a, b, y, start=-72.0) for a, b, y in BODY]
    corners = [0, FRONT, FRONT + UNDERARM, 2 * FRONT + UNDERARM]
    rings[-1][corners] += np.sign(rings[-1][corners]) * CORNER_SHIFT
    hem = mesh.add(rings[0])
    body = mesh.grow(hem, rings[1:])
    left, left_cuff = add_sleeve(mesh, body[8:11], mirrored=False)
    right, right_cuff = add_sleeve(mesh, [body[18], body[19], body[0]], mirrored=True)
    yoke = body[:9] + left + body[10:19] + right
    neck = add_yoke(mesh, yoke)
    borders = {"hem": hem[0], "left cuff": left_cuff, "right cuff": right_cuff, "neck": neck[0]}
    return Garment("sweater", mesh, borders)


def add_sleeve(mesh: QuadMesh, underarm: Ring, mirrored: bool) -> tuple[Ring, int]:
    """Add a sleeve; return the five inner vertices of its outer top edges and a cuff vertex.

    The vertices have the order of the first ring of the yoke.
    """
    rings = sleeve_rings(np.array([mesh.points[i] for i in underarm]), mirrored)
    outer = mesh.add(rings[-1][3:])
    cuff = mesh.add(rings[0])
    last = mesh.grow(cuff, rings[1:-1])
    mesh.bridge(last, underarm[::-1] + outer)
    return outer, cuff[0]


def sleeve_rings(underarm: np.ndarray, mirrored: bool) -> list[np.ndarray]:
    """Return the rings of a sleeve from the cuff to the underarm.

    Each ring begins with the three underarm points, from back to front on the left side.
    """
    if mirrored:
        rings = sleeve_rings(underarm[::-1] * MIRROR, mirrored=False)
        return [ring[MIRROR_ORDER] * MIRROR for ring in rings]
    along = np.linspace(1.0, 0.0, SLEEVE_ROWS + 1)
    rings = [sleeve_ring(underarm, t) for t in along]
    rings[-1][:3] = underarm[::-1]
    return rings


def sleeve_ring(underarm: np.ndarray, t: float) -> np.ndarray:
    """Return the ring of the left sleeve at t from 0 (underarm) to 1 (cuff)."""
    angle = SLEEVE_ANGLE + 0.16 * t  # The arm hangs down and bends slightly to the front.
    down = np.array([np.cos(angle), -np.sin(angle), 0.16 * t])
    up = np.array([np.sin(SLEEVE_ANGLE), np.cos(SLEEVE_ANGLE), 0.0])
    tall = np.interp(t, [0.0, 0.25, 0.9, 1.0], [7.6, 6.9, 4.6, 4.0])
    deep = np.interp(t, [0.0, 0.25, 0.9, 1.0], [7.0, 6.6, 4.6, 4.0])
    centre = underarm[1] + 7.6 * up + 0.6 * t * up + SLEEVE_LENGTH * t * unit(down)
    turns = np.radians(-45.0 + 45.0 * np.arange(SLEEVE_EDGES))[:, None]
    front = np.array([0.0, 0.0, 1.0])
    return centre - tall * np.cos(turns) * up + deep * np.sin(turns) * front


def add_yoke(mesh: QuadMesh, ring: Ring) -> Ring:
    """Add the yoke on its first ring (front, left sleeve, back, right sleeve)."""
    start = np.array([mesh.points[i] for i in ring])
    count = len(ring)
    turns = 2.0 * np.pi * (np.arange(count) - FRONT // 2) / count
    neck = oval(count, 9.6, 8.6, 60.5, start=-360.0 * (FRONT // 2) / count)
    neck += np.column_stack([0 * turns, -2.6 * np.cos(turns), 0 * turns - 0.8])
    inward = -np.column_stack([np.sin(turns), 0 * turns, np.cos(turns)])
    up = np.array([0.0, 1.0, 0.0])
    span = np.linalg.norm(neck - start, axis=1, keepdims=True)
    sleeve = smooth_step((start[:, :1] ** 2 - 19.0**2) / (28.0**2 - 19.0**2))
    back_up = np.sign(start[:, :1]) * [-np.cos(SLEEVE_ANGLE), 0.0, 0.0]
    back_up = back_up + up * np.sin(SLEEVE_ANGLE)
    leave = span * (1.0 - 0.22 * sleeve) * unit(sleeve * back_up + (1.0 - sleeve) * up)
    arrive = span * unit((0.8 + 0.2 * sleeve) * inward + (0.6 - 0.25 * sleeve) * up)
    rows = [hermite(start, neck, leave, arrive, k / YOKE_ROWS) for k in range(1, YOKE_ROWS + 1)]
    return mesh.grow(ring, rows)
