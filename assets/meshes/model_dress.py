# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A sleeveless dress: rings up to the underarm, then front and back in open rows.

The middle of front and back ends at the neckline. The shoulder straps continue until the last row
of each front strap and the last row of the back strap share the same edges (grafted shoulders).
"""

import numpy as np
from curves import hermite, oval, unit
from quad_mesh import Garment, QuadMesh, Ring

EDGES = 20  # Front 8, underarm 2, back 8, underarm 2.
PANEL_ROWS = 6
FRONT_NECK = (2, 0.18)  # Row where the neckline begins, and depth of its curve.
BACK_NECK = (4, 0.10)
STRAPS = (slice(0, 3), slice(6, 9))  # Columns of points of the two straps.
BODY = [  # Half width, depth to the front and to the back, height, depth of the folds [cm].
    (26.6, 22.4, 22.8, 0.0, 1.5),
    (25.6, 21.2, 21.8, 6.5, 1.3),
    (24.5, 19.9, 20.7, 13.0, 1.1),
    (23.3, 18.5, 19.4, 19.5, 0.8),
    (22.0, 16.9, 17.9, 26.0, 0.6),
    (20.6, 15.4, 16.4, 32.5, 0.3),
    (18.9, 13.2, 14.4, 39.0, 0.1),
    (17.2, 11.6, 12.4, 45.0, 0.0),
    (15.2, 10.6, 10.6, 51.0, 0.0),
    (14.2, 10.4, 9.6, 56.5, 0.0),
    (14.5, 11.0, 9.6, 61.5, 0.0),
    (15.5, 12.3, 9.9, 66.5, 0.0),
    (16.4, 13.1, 10.3, 71.5, 0.0),
    (16.8, 12.8, 10.5, 76.0, 0.0),
]
SHOULDER_X = np.array([-14.6, -11.6, -8.6, -4.6, 0.0, 4.6, 8.6, 11.6, 14.6])


def model_dress() -> Garment:
    """Return the dress."""
    mesh = QuadMesh()
    rings = [dress_ring(*line) for line in BODY]
    hem = mesh.add(rings[0])
    body = mesh.grow(hem, rings[1:])
    shoulder = shoulder_points()
    tops = [mesh.add(shoulder[strap]) for strap in STRAPS]
    neck = add_panel(mesh, body[:9], shoulder, tops, FRONT_NECK)
    back_tops = [tops[1][::-1], tops[0][::-1]]
    add_panel(mesh, body[10:19], shoulder[::-1], back_tops, BACK_NECK)
    borders = {"hem": hem[0], "left armhole": body[9], "right armhole": body[19], "neck": neck}
    return Garment("dress", mesh, borders)


def dress_ring(
    half_width: float, front: float, back: float, height: float, fold: float
) -> np.ndarray:
    """Return a ring of the skirt or bodice, with smooth folds."""
    ring = oval(EDGES, 1.0, 1.0, height, start=-72.0)
    angles = np.arctan2(ring[:, 0], ring[:, 2])
    depth = np.where(ring[:, 2] > 0.0, front, back)
    waves = (fold * np.cos(5.0 * angles))[:, None]
    outward = ring * [1.0, 0.0, 1.0]
    return ring * np.column_stack([0 * depth + half_width, 0 * depth + 1, depth]) + waves * outward


def shoulder_points() -> np.ndarray:
    """Return the nine points of the shoulder line, where the straps slope down to the outside."""
    slope = 97.0 - 0.32 * (np.abs(SHOULDER_X) - 8.6)
    return np.column_stack([SHOULDER_X, slope, 0.0 * SHOULDER_X - 1.0])


def add_panel(
    mesh: QuadMesh, base: Ring, shoulder: np.ndarray, tops: list[Ring], neck: tuple[int, float]
) -> int:
    """Add the front or the back from the underarm to the shoulders; return a neck vertex."""
    rows = panel_rows(np.array([mesh.points[i] for i in base]), shoulder, *neck)
    neck_row = neck[0]
    ring = mesh.grow(base, rows[:neck_row], closed=False)
    for strap, top in zip(STRAPS, tops, strict=True):
        last = mesh.grow(ring[strap], [row[strap] for row in rows[neck_row:]], closed=False)
        mesh.bridge(last, top, closed=False)
    return ring[len(ring) // 2]


def panel_rows(
    base: np.ndarray, shoulder: np.ndarray, neck_row: int, scoop: float
) -> list[np.ndarray]:
    """Return the rows between the underarm row and the shoulder line, without these two."""
    facing = np.sign(base[4, 2])
    count = len(base)
    span = np.linalg.norm(shoulder - base, axis=1, keepdims=True)
    side = np.abs(np.linspace(-1.0, 1.0, count)) ** 3
    leave = np.column_stack([-0.55 * np.sign(base[:, 0]) * side, np.ones(count), 0 * side])
    arrive = np.column_stack(
        [0.15 * np.sign(base[:, 0]) * side, 0.35 + 0 * side, -facing * (1.0 + 0 * side)]
    )
    dip = scoop * np.clip(1.0 - (np.arange(count) - 4.0) ** 2 / 4.0, 0.0, None)
    rows = []
    for row in range(1, PANEL_ROWS):
        t = row / PANEL_ROWS - dip * row / neck_row
        rows.append(hermite(base, shoulder, span * leave, span * unit(arrive), t))
    return rows
