# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Model a standing body that garments are put on, and write ``body.obj`` into the folder ``bodies``.

Usage: python assets/meshes/model_body.py [--out FOLDER]

The body is 1.67 m tall, with arms that are lowered by 45 degrees and slightly bent, and feet apart. It is a closed
surface of quads; coordinates are in centimetres with y upwards, the wearer looks along +z, and the waist is at y = 26.
"""

import argparse
from pathlib import Path

import numpy as np
from quad_mesh import QuadMesh
from smooth_shapes import Shape, ellipsoid, joined, mirrored, round_cone, trunk
from surface_nets import surface_nets

CELL = 2.5  # Side of the lattice cells [cm].
BLEND = 4.0  # Length within which parts flow into one another [cm].
ROUNDS = 20  # Rounds in which points are spread over the surface.
STEP = 1e-3  # Step of differences [cm].
TRUNK = [  # Height, half width, half depth, middle in z [cm].
    (-5.0, 15.5, 8.0, 2.2),
    (0.0, 17.3, 9.9, 1.8),
    (6.0, 17.2, 11.0, 2.0),
    (12.0, 16.3, 10.6, 3.3),
    (18.0, 14.4, 9.3, 4.9),
    (24.0, 12.5, 8.5, 6.0),
    (28.0, 12.0, 8.6, 6.5),
    (34.0, 12.7, 9.3, 6.5),
    (40.0, 13.8, 9.6, 5.6),
    (45.0, 14.8, 8.8, 4.2),
    (50.0, 14.6, 7.4, 2.9),
    (54.0, 12.0, 5.7, 2.0),
    (57.0, 7.6, 4.9, 2.0),
    (60.0, 5.2, 4.6, 2.4),
    (66.0, 4.8, 4.6, 3.4),
]
SHOULDER, ELBOW, WRIST, FIST = (15.5, 50.0, 2.0), (34.0, 32.5, 5.5), (45.5, 19.5, 22.0), (48.5, 14.5, 28.0)
HIP, KNEE, ANKLE = (9.2, 0.0, 2.0), (16.5, -40.0, 2.0), (21.5, -74.0, -0.5)
HEEL, TOES = (21.5, -78.0, -1.0), (24.5, -79.0, 15.0)


def body_shape() -> Shape:
    """Return the body as one shape."""
    arm = joined([round_cone(SHOULDER, ELBOW, 5.4, 4.2), round_cone(ELBOW, WRIST, 4.2, 2.9)], 1.0)
    hand = round_cone(WRIST, FIST, 2.9, 3.6)
    leg = joined([round_cone(HIP, KNEE, 8.4, 5.4), round_cone(KNEE, ANKLE, 5.4, 3.2)], 1.0)
    foot = round_cone(HEEL, TOES, 3.4, 2.6)
    limbs = [mirrored(joined([arm, hand], 2.0)), mirrored(joined([leg, foot], 2.0))]
    head = ellipsoid((0.0, 74.0, 6.0), (7.4, 11.0, 9.0))
    chest = mirrored(ellipsoid((6.5, 38.0, 11.3), (5.4, 5.4, 5.4)))
    return joined([trunk(TRUNK), chest, *limbs, head], BLEND)


def model_body() -> QuadMesh:
    """Return the body."""
    mesh = QuadMesh()
    points, quads = surface_nets(body_shape(), (-56.25, -85.0, -15.0), (56.25, 90.0, 40.0), CELL)
    mesh.add(evened(points, quads, body_shape()))
    mesh.quads.extend(quads)
    return mesh


def evened(points: np.ndarray, quads: list[tuple[int, ...]], shape: Shape) -> np.ndarray:
    """Return points that are spread more evenly over the surface of a shape."""
    sides = np.array(quads)[:, [[0, 1], [1, 2], [2, 3], [3, 0]]].reshape(-1, 2)
    number = np.bincount(sides[:, 0], minlength=len(points))[:, None]
    for _ in range(ROUNDS):
        mean = np.zeros_like(points)
        np.add.at(mean, sides[:, 0], points[sides[:, 1]] / number[sides[:, 0]])
        points = onto_surface(0.5 * (points + mean), shape)
    return points


def onto_surface(points: np.ndarray, shape: Shape) -> np.ndarray:
    """Return points moved along the gradient of a shape to where it is zero, in three steps of Newton's method."""
    for _ in range(3):
        steps = STEP * np.eye(3)
        slope = np.stack([(shape(points + d) - shape(points - d)) / (2.0 * STEP) for d in steps], axis=-1)
        points = points - (shape(points) / np.maximum((slope**2).sum(axis=-1), 1e-6))[:, None] * slope
    return points


def main() -> None:
    """Model and write the body."""
    parser = argparse.ArgumentParser(description="Model a body.")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "bodies", help="output folder")
    out: Path = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    mesh = model_body()
    mesh.write_obj(out / "body.obj", "StitchMesh body")
    x, y, z = np.ptp(np.array(mesh.points), axis=0)
    print(f"body: {len(mesh.quads)} faces, {len(mesh.points)} vertices, {x:.0f} x {y:.0f} x {z:.0f} cm")


if __name__ == "__main__":
    main()
