# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxation of large fabrics: time, number of iterations, and remaining stretch.

The target is 65,000 faces within 60 seconds on two cores. The time is that of the whole stage: subdivision, the first
closest points, the relaxation, and the loading of the kernel, which is compiled once on each machine.
"""

from __future__ import annotations

import numpy as np

from benchmarks.table import Rows
from stitchmesh.labeling import label
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING, tessellate


def tube() -> Mesh:
    """A straight tube whose coarse quads are unevenly wide and high."""
    angle, height = _uneven_turn(24), 80.0 * _uneven_climb(16)
    return _rings(np.full((17, 24), 20.0), np.broadcast_to(angle, (17, 24)), height)


def flared_skirt() -> Mesh:
    """A skirt from a waist of 12 cm radius to a waved hem of about 30 cm."""
    angle, climb = _uneven_turn(40), _uneven_climb(16)
    radius = 12.0 + 18.0 * climb[:, None] ** 1.5 * (1.0 + 0.15 * np.cos(5.0 * angle))
    return _rings(radius, np.broadcast_to(angle, radius.shape), 60.0 * climb)


def _uneven_turn(count: int) -> FloatArray:
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return angle + 0.05 * np.sin(3.0 * angle)


def _uneven_climb(count: int) -> FloatArray:
    climb = np.linspace(0.0, 1.0, count + 1)
    return climb + 0.05 * np.sin(2.0 * np.pi * climb)


def _rings(radius: FloatArray, angle: FloatArray, height: FloatArray) -> Mesh:
    rows, around = radius.shape
    levels = np.broadcast_to(height[:, None], radius.shape)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), levels], axis=2)
    row, column = (index.ravel() for index in np.indices((rows - 1, around)))
    following = (column + 1) % around
    first, second = row * around, (row + 1) * around
    faces = np.stack([first + column, first + following, second + following, second + column], axis=1)
    return Mesh.from_polygons(points.reshape(-1, 3), faces.tolist())


SCENES = {"tube": tube, "flared_skirt": flared_skirt}


def mesh_relaxation(*, faces: int = 65000, device: str = "cpu") -> Rows:
    """Run every scene and print one line of results each.

    Args:
        faces: stitch faces of each fabric, about
        device: Warp's name of the device that finds closest points
    """
    yield "scene", "faces", "s", "iterations", "at rest", "residual", "rms stretch", "largest", "smallest"
    for name, build in SCENES.items():
        mesh = build()
        area = float(np.linalg.norm(mesh.face_vector_area, axis=1).sum())
        width = float(np.sqrt(area / (faces * COURSE_OVER_WALE_SPACING)))
        fabric = tessellate(label(mesh), stitch_width=width)
        made = relax_mesh(fabric, surface=mesh, device=device)
        relaxed, report = made.fabric, made.report
        assert relaxed.stretch is not None  # the relaxation fills it
        stretches = (report.rms_stretch, report.max_stretch, relaxed.stretch.min())
        yield (
            name, fabric.face_count, f"{report.seconds:.1f}", report.iterations, report.converged,
            f"{report.residual:.1e}", *(f"{stretch:.3f}" for stretch in stretches),
        )  # fmt: skip
