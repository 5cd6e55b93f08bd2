# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Simple garments: a flat swatch, and garments knitted in the round without branches."""

from itertools import pairwise

import numpy as np
from curves import hermite, oval, smooth_step, unit
from quad_mesh import Garment, QuadMesh

HAT_PROFILE = [  # Radius, height and displacement to the back [cm].
    (9.1, 0.0, 0.0),
    (9.0, 3.0, 0.0),
    (9.3, 5.9, 0.0),
    (9.5, 8.8, -0.1),
    (9.4, 11.8, -0.3),
    (8.8, 14.7, -0.7),
    (7.6, 17.2, -1.2),
    (5.9, 19.1, -1.7),
    (3.7, 20.3, -2.1),
    (1.5, 20.7, -2.2),
]
COZY_PROFILE = [  # Radius and height [cm].
    (7.8, 0.0),
    (8.5, 2.0),
    (9.0, 4.2),
    (9.3, 6.5),
    (9.4, 8.9),
    (9.1, 11.3),
    (8.4, 13.6),
    (7.2, 15.7),
    (5.6, 17.5),
    (3.6, 18.9),
    (1.5, 20.0),
]
COZY_SLIT = (2, 6)  # Rings between which the cozy is open for spout and handle.
COZY_EDGES = 16
SOCK_RINGS = [  # Shin or instep (y, z), calf or sole (y, z), half width [cm].
    (29.0, 4.4, 29.0, -4.6, 4.3),
    (26.4, 4.4, 26.4, -4.7, 4.3),
    (23.8, 4.4, 23.8, -4.8, 4.3),
    (21.2, 4.3, 21.2, -4.8, 4.2),
    (18.6, 4.1, 18.6, -4.6, 4.0),
    (16.0, 3.8, 16.0, -4.4, 3.8),
    (13.6, 3.6, 13.4, -4.2, 3.6),
    (11.6, 3.7, 10.8, -4.2, 3.5),
    (10.2, 4.2, 8.2, -4.6, 3.5),
    (9.2, 4.9, 5.6, -5.4, 3.6),
    (8.5, 5.6, 3.0, -6.0, 3.7),
    (8.0, 6.3, 0.8, -5.2, 3.6),
    (7.5, 7.1, -0.1, -3.0, 3.5),
    (7.0, 8.1, -0.1, -0.2, 3.5),
    (6.5, 9.4, 0.1, 2.7, 3.6),
    (6.0, 10.9, 0.2, 5.6, 3.8),
    (5.5, 12.6, 0.1, 8.6, 4.0),
    (5.0, 14.3, 0.0, 11.6, 4.2),
    (4.4, 16.0, 0.0, 14.4, 4.2),
    (3.6, 17.5, 0.1, 16.8, 3.8),
]
SOCK_TOE = [
    (3.1, 18.5, 0.4, 18.1, 3.0),
    (2.6, 19.2, 0.9, 19.0, 2.0),
    (2.1, 19.5, 1.4, 19.4, 1.0),
]
SOCK_EDGES = 12
PONCHO_EDGES = 32
PONCHO_ROWS = 11


def model_swatch() -> Garment:
    """Return a flat square of 20 x 20 cm and 5 x 5 quads, with the normal +z."""
    mesh, steps = QuadMesh(), np.linspace(0.0, 20.0, 6)
    rows = [np.column_stack([steps, np.full(6, y), np.zeros(6)]) for y in steps]
    first = mesh.add(rows[0])
    mesh.grow(first, rows[1:], closed=False)
    return Garment("swatch", mesh, {"edge": first[0]}, list(pairwise(first)))


def model_hat() -> Garment:
    """Return a beanie: rings of 12 edges from the brim to a small open crown."""
    rings = []
    for radius, height, lean in HAT_PROFILE:
        depth = radius * (1.0 + 0.12 * (radius - 1.5) / 8.0)  # A head is longer than wide.
        rings.append(oval(12, 0.94 * radius, depth, height) + np.array([0.0, 0.0, lean]))
    mesh = QuadMesh()
    brim = mesh.add(rings[0])
    crown = mesh.grow(brim, rings[1:])
    return Garment("hat", mesh, {"brim": brim[0], "crown": crown[0]})


def model_tea_cozy() -> Garment:
    """Return a round tea cozy, which is open at both sides for spout and handle."""
    low, high = COZY_SLIT
    rings = [oval(COZY_EDGES, r, r, y) for r, y in COZY_PROFILE]
    mesh = QuadMesh()
    bottom = mesh.add(rings[0])
    lower = mesh.grow(bottom, rings[1 : low + 1])
    slits, upper = cozy_halves(mesh, lower, rings[low + 1 : high], mesh.add(rings[high]))
    crown = mesh.grow(upper, rings[high + 1 :])
    borders = {"bottom": bottom[0], "crown": crown[0], "spout": slits[0], "handle": slits[1]}
    return Garment("tea_cozy", mesh, borders)


def cozy_halves(
    mesh: QuadMesh, lower: list[int], between: list[np.ndarray], upper: list[int]
) -> tuple[list[int], list[int]]:
    """Add front and back in open rows between two closed rings.

    Return one vertex of each slit, and the upper ring.
    """
    half, slits = COZY_EDGES // 2, []
    openings = 1.0 * np.sin(np.pi * np.arange(1, len(between) + 1) / (len(between) + 1))
    for begin, side in ((0, 1.0), (half, -1.0)):
        columns = [(begin + i) % COZY_EDGES for i in range(half + 1)]
        rows = [ring[columns] for ring in between]
        for row, opening in zip(rows, openings, strict=True):
            row[[0, -1], 2] += side * opening
            row[[1, -2], 2] += 0.35 * side * opening
        last = mesh.grow([lower[i] for i in columns], rows, closed=False)
        mesh.bridge(last, [upper[i] for i in columns], closed=False)
        slits.append(last[0])
    return slits, upper


def model_sock() -> Garment:
    """Return a sock: a bent tube from cuff to toe; the yarn of the last row closes the toe."""
    rings = [sock_ring(np.array(line)) for line in SOCK_RINGS + SOCK_TOE]
    mesh = QuadMesh()
    cuff = mesh.add(rings[0])
    toe = mesh.grow(cuff, rings[1:])
    return Garment("sock", mesh, {"cuff": cuff[0], "toe": toe[0]})


def sock_ring(line: np.ndarray) -> np.ndarray:
    """Return the ring through an upper and a lower point in the symmetry plane x = 0."""
    upper, lower, half_width = line[0:2], line[2:4], line[4]
    angles = 2.0 * np.pi * np.arange(SOCK_EDGES) / SOCK_EDGES
    middle, spoke = (upper + lower) / 2, (upper - lower) / 2
    yz = middle + np.sin(angles)[:, None] * spoke
    return np.column_stack([half_width * np.cos(angles), yz])


def model_poncho() -> Garment:
    """Return a poncho: rings of 32 edges from a hem with four rounded corners up to the neck."""
    mesh = QuadMesh()
    rings = [poncho_ring(1.0 - row / PONCHO_ROWS) for row in range(PONCHO_ROWS + 1)]
    hem = mesh.add(rings[0])
    neck = mesh.grow(hem, rings[1:])
    return Garment("poncho", mesh, {"hem": hem[0], "neck": neck[0]})


def poncho_ring(t: float) -> np.ndarray:
    """Return the ring at t from 0 (neck) to 1 (hem); rings pass over the shoulders and then hang down."""
    angles = np.radians(-90.0 + 360.0 * np.arange(PONCHO_EDGES) / PONCHO_EDGES)
    outward = np.column_stack([np.sin(angles), 0.0 * angles, np.cos(angles)])
    corner = np.abs(np.cos(2.0 * angles)) * (np.cos(4.0 * angles) + 1.0) / 2.0
    sideways = np.sin(angles)[:, None] ** 2
    up = np.array([0.0, 1.0, 0.0])
    neck = oval(PONCHO_EDGES, 9.3, 8.6, 66.0) + up * (-3.0 * np.cos(angles)[:, None] + 1.0)
    reach = 25.0 + 10.0 * sideways + 4.0 * corner[:, None]
    drop = 50.0 - 4.0 * sideways + 12.0 * corner[:, None]
    hem = outward * reach + up * (66.0 - drop)
    leave = outward * (36.0 + 48.0 * sideways) - up * (14.0 + 4.0 * sideways)
    arrive = outward * (14.0 + 12.0 * sideways) - up * drop * 1.4
    ring = hermite(neck, hem, leave, arrive, t)
    folds = smooth_step((t - 0.3) / 0.7) * 1.2 * np.cos(8.0 * angles)[:, None]
    return ring + unit(outward) * folds
