# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A sweater for a sheep, knitted in rounds from the rear to the neck, with a slit for each leg.

The animal stands on its legs and looks along +z. Each pair of slits parts the rounds into belly and back, which are
open rows there.
"""

import numpy as np
from quad_mesh import Garment, QuadMesh, Ring

EDGES = 24
LEG = 3  # Vertex of the slit on the left, counted from the middle of the belly.
OPENING = 4.5  # Largest half width of a slit [cm].
RINGS = [  # Half width, half height, height of the middle and distance from the rear [cm].
    (15.0, 17.0, 2.0, 0.0),
    (19.0, 20.5, 1.0, 4.5),
    (21.0, 22.0, 0.5, 9.5),
    (22.0, 22.5, 0.0, 14.5),
    (22.5, 23.0, -0.3, 19.5),
    (23.0, 23.2, -0.5, 24.5),
    (23.2, 23.5, -0.6, 29.5),
    (23.5, 23.7, -0.7, 34.5),
    (23.5, 23.7, -0.7, 39.5),
    (23.2, 23.5, -0.6, 44.5),
    (22.7, 23.2, -0.4, 49.5),
    (21.8, 22.8, 0.2, 54.5),
    (20.8, 22.2, 1.0, 59.5),
    (19.5, 21.4, 2.2, 64.5),
    (17.6, 19.8, 4.6, 69.2),
    (15.2, 17.4, 8.4, 73.4),
    (12.8, 15.0, 12.8, 77.0),
    (11.2, 13.2, 17.0, 80.6),
]
HIND, FRONT = (2, 6), (10, 14)  # Rings between which the legs leave.


def model_sheep() -> Garment:
    """Return the sweater of the sheep."""
    mesh = QuadMesh()
    rings = [ring(*sizes) for sizes in RINGS]
    rear = mesh.add(rings[0])
    round_before = mesh.grow(rear, rings[1 : HIND[0] + 1])
    hind, round_after = add_legs(mesh, round_before, rings[HIND[0] + 1 : HIND[1] + 1])
    round_before = mesh.grow(round_after, rings[HIND[1] + 1 : FRONT[0] + 1])
    front, round_after = add_legs(mesh, round_before, rings[FRONT[0] + 1 : FRONT[1] + 1])
    neck = mesh.grow(round_after, rings[FRONT[1] + 1 :])
    borders = {"rear": rear[0], "neck": neck[0]}
    for name, legs in (("hind", hind), ("front", front)):
        borders |= {f"left {name} leg": legs[0], f"right {name} leg": legs[1]}
    return Garment("sheep", mesh, borders)


def ring(half_width: float, half_height: float, middle: float, distance: float) -> np.ndarray:
    """Return an upright oval ring, counter-clockwise as seen from the front; the first point is under the belly."""
    angles = np.radians(-90.0 + 360.0 * np.arange(EDGES) / EDGES)
    x, y = half_width * np.cos(angles), middle + half_height * np.sin(angles)
    return np.column_stack([x, y, np.full(EDGES, distance)])


def add_legs(mesh: QuadMesh, lower: Ring, rings: list[np.ndarray]) -> tuple[tuple[int, int], Ring]:
    """Add back and belly in open rows between a ring of the mesh and the last one of some rings.

    Return one vertex of the left and of the right slit, and the last ring.
    """
    *between, last_ring = rings
    upper = mesh.add(last_ring)
    slits = []
    for first, last, sign in ((LEG, EDGES - LEG, 1.0), (-LEG, LEG, -1.0)):
        columns = [place % EDGES for place in range(first, last + 1)]
        rows = [opened(points, columns, sign, (place + 1) / len(rings)) for place, points in enumerate(between)]
        line = mesh.grow([lower[i] for i in columns], rows, closed=False)
        mesh.bridge(line, [upper[i] for i in columns], closed=False)
        slits.append((line[0], line[-1]))
    return slits[0], upper


def opened(points: np.ndarray, columns: list[int], sign: float, along: float) -> np.ndarray:
    """Return a row whose ends are moved away from the slits: upwards (``sign`` 1) for the back, or downwards (-1)."""
    row, size = points[columns].copy(), OPENING * np.sin(np.pi * along)
    for end, inner in ((0, 1), (-1, -2)):
        away = sign * size * np.array([0.5 * np.sign(row[end, 0]), 0.8, 0.0])
        row[end] += away
        row[inner] += 0.35 * away
    return row
