# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Divide the sweater of assets/meshes into stitches, and let its sleeves follow the bent arms of the body.

Usage: python examples/mixed/knitted/knit_sweater.py

The stitches are those of a stitch mesh from ``stitchmesh.tessellate``. Their positions alone change: each point of a
sleeve keeps its place beside the axis of the sleeve, while the axis becomes the line through shoulder, elbow and wrist
of ``assets/meshes/bodies/body.obj``. The stitches know their size at rest, so that a scene may begin there.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import stitchmesh as sm

HERE = Path(__file__).parent
STITCH_WIDTH = 3.2  # Each stitch stands for several ones, by ``divisions`` in the scene [cm].
SHIFT = np.array([0.0, 0.0, 4.0])  # From the sweater of assets/meshes to the body [cm].
SLEEVE = np.array([[25.9, 44.3, 4.0], [42.5, 28.0, 6.0], [56.0, 10.4, 11.3]])  # Axis of the left sleeve, shifted [cm].
ARM = np.array([[15.5, 50.0, 2.0], [34.0, 32.5, 5.5], [48.5, 14.5, 28.0]])  # Shoulder, elbow and fist [cm].
FIRST = 10.7  # Length of the arm from the shoulder to where the sleeve begins [cm].
ROUNDING = 4.0  # Length of the arm over which the sleeve bends at the elbow [cm].
FROM, TO = 19.0, 28.0  # Distances from the middle between which points begin to follow the arm [cm].


def along(line: np.ndarray, length: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return places on a line of two spans, and its directions there, at lengths from its start: (n,) to (n, 3) twice.

    The direction turns gradually at the middle point.
    """
    spans = np.diff(line, axis=0)
    sizes = np.linalg.norm(spans, axis=1)
    upper, lower = spans / sizes[:, None]
    past = (length - sizes[0])[:, None]
    place = line[1] + past * np.where(past < 0.0, upper, lower)
    share = 0.5 * (1.0 + np.tanh(past / ROUNDING))
    direction = (1.0 - share) * upper + share * lower
    return place, direction / np.linalg.norm(direction, axis=1, keepdims=True)


def on_arm(points: np.ndarray) -> np.ndarray:
    """Return points of the left sleeve beside the arm instead of the axis of the sleeve, shape (n, 3)."""
    lengths = np.linspace(-15.0, 60.0, 751)
    nearest = cKDTree(along(SLEEVE, lengths)[0]).query(points)[1]
    place, direction = along(SLEEVE, lengths[nearest])
    wanted, turned = along(ARM, FIRST + lengths[nearest])
    turns = zip(turned, direction, points - place, strict=True)
    beside = [Rotation.align_vectors([to], [old])[0].apply(each) for to, old, each in turns]
    share = np.clip((points[:, 0] - FROM) / (TO - FROM), 0.0, 1.0)[:, None]
    share = share * share * (3.0 - 2.0 * share)
    return (1.0 - share) * points + share * (wanted + np.array(beside))


def main() -> None:
    """Write ``sweater.smobj`` beside this script."""
    mesh = sm.read_mesh(HERE.parents[2] / "assets" / "meshes" / "sweater.obj")
    stitches = sm.relax_mesh(sm.tessellate(sm.label(mesh), stitch_width=STITCH_WIDTH), surface=mesh).fabric
    points = stitches.vertices + SHIFT
    for side in (1.0, -1.0):
        mirror, sleeve = np.array([side, 1.0, 1.0]), side * points[:, 0] > FROM
        points[sleeve] = mirror * on_arm(mirror * points[sleeve])
    sm.write_stitches(HERE / "sweater.smobj", replace(stitches, vertices=points.round(3)))
    print(f"{stitches.face_count} stitches")


if __name__ == "__main__":
    main()
