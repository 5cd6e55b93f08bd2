# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Small meshes that tests share, including irregular ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stitchmesh.mesh import Mesh

ROOT = Path(__file__).resolve().parent.parent
"""Root folder of the project."""
GARMENTS = sorted((ROOT / "assets" / "meshes").glob("*.obj"))
"""Mesh files of the garments of the project."""
SHARED = ROOT.parent / "shared" / "data"
"""Folder of real data beside the project, which need not exist."""


def shared(name: str) -> Path:
    """Return the path of a file of real data, or skip the test if the file does not exist."""
    path = SHARED / name
    if not path.exists():
        pytest.skip(f"real data {name} is not in the folder beside the project (shared)")
    return path


def grid(columns: int, rows: int, *, width: float = 1.0, height: float = 1.0) -> Mesh:
    """A flat rectangle of quads in the x-y plane."""
    x, y = np.meshgrid(np.arange(columns + 1) * width, np.arange(rows + 1) * height)
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    stride = columns + 1
    faces = [
        [r * stride + c, r * stride + c + 1, (r + 1) * stride + c + 1, (r + 1) * stride + c]
        for r in range(rows)
        for c in range(columns)
    ]
    return Mesh.from_polygons(vertices, faces)


def tube(around: int, rows: int, *, radius: float = 3.0, height: float = 1.0, top_radius: float | None = None) -> Mesh:
    """An upright tube of quads with outward normals."""
    radii = np.linspace(radius, radius if top_radius is None else top_radius, rows + 1)
    angle = 2 * np.pi * np.arange(around) / around
    rings = [np.stack([r * np.sin(angle), np.full(around, k * height), r * np.cos(angle)], axis=1)
             for k, r in enumerate(radii)]  # fmt: skip
    faces = [
        [k * around + c, k * around + (c + 1) % around, (k + 1) * around + (c + 1) % around, (k + 1) * around + c]
        for k in range(rows)
        for c in range(around)
    ]
    return Mesh.from_polygons(np.concatenate(rings), faces)


def closed_cone(around: int) -> Mesh:
    """One row of a tube, closed by triangles that meet in a pole."""
    body = tube(around, 1, radius=3.0, height=2.0)
    pole = len(body.vertices)
    ring = [around + c for c in range(around)]
    faces = body.face_vertex.reshape(-1, 4).tolist()
    faces += [[ring[c], ring[(c + 1) % around], pole] for c in range(around)]
    return Mesh.from_polygons(np.concatenate([body.vertices, [[0.0, 4.0, 0.0]]]), faces)


def pentagon_row() -> Mesh:
    """A row of two pentagons below a row of quads; each pentagon has one bottom edge and two top edges."""
    vertices = [[0, 0, 0], [2, 0, 0], [4, 0, 0], [4, 2, 0], [3, 2.2, 0], [2, 2, 0], [1, 2.2, 0], [0, 2, 0],
                [0, 4, 0], [1, 4, 0], [2, 4, 0], [3, 4, 0], [4, 4, 0]]  # fmt: skip
    faces = [[0, 1, 5, 6, 7], [1, 2, 3, 4, 5], [7, 6, 9, 8], [6, 5, 10, 9], [5, 4, 11, 10], [4, 3, 12, 11]]
    return Mesh.from_polygons(np.array(vertices, dtype=float), faces)


def torus(around: int, along: int) -> Mesh:
    """A torus of quads, without a border."""
    a, b = np.meshgrid(2 * np.pi * np.arange(around) / around, 2 * np.pi * np.arange(along) / along)
    ring = 3.0 + np.cos(a)
    vertices = np.stack([ring * np.cos(b), ring * np.sin(b), np.sin(a)], axis=-1).reshape(-1, 3)
    faces = [
        [j * around + i, ((j + 1) % along) * around + i,
         ((j + 1) % along) * around + (i + 1) % around, j * around + (i + 1) % around]
        for j in range(along)
        for i in range(around)
    ]  # fmt: skip
    return Mesh.from_polygons(vertices, faces)


def odd_corner() -> Mesh:
    """Three quads around an inner vertex: every strip of quads crosses itself, so that the labels contradict."""
    vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [-0.8, 1.2, 0], [-1, 0.2, 0], [0.3, -1, 0]]
    faces = [[0, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 1]]
    return Mesh.from_polygons(np.array(vertices, dtype=float), faces)


def two_tubes() -> Mesh:
    """Two separate tubes side by side in one mesh."""
    first, second = tube(6, 2), tube(5, 3)
    offset = len(first.vertices)
    faces = first.face_vertex.reshape(-1, 4).tolist() + (second.face_vertex.reshape(-1, 4) + offset).tolist()
    return Mesh.from_polygons(np.concatenate([first.vertices, second.vertices + np.array([20.0, 0, 0])]), faces)


def moebius(count: int = 8) -> tuple[np.ndarray, list[list[int]]]:
    """Vertices and faces of a Moebius strip."""
    angle = 2 * np.pi * np.arange(count) / count
    out = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    tilt = np.cos(angle / 2)[:, None] * out + np.sin(angle / 2)[:, None] * np.array([0.0, 0.0, 1.0])
    vertices = np.concatenate([3 * out - tilt, 3 * out + tilt])
    faces = [[k, k + 1, count + k + 1, count + k] for k in range(count - 1)]
    faces.append([count - 1, count, 0, 2 * count - 1])
    return vertices, faces


FLAT_AND_ROUND = {
    "one quad": lambda: grid(1, 1),
    "flat": lambda: grid(3, 4),
    "tube": lambda: tube(8, 3),
    "narrowing tube": lambda: tube(8, 3, radius=4.0, top_radius=2.0),
    "three around": lambda: tube(3, 2),
    "closed cone": lambda: closed_cone(6),
    "pentagons": pentagon_row,
    "two tubes": two_tubes,
}
"""Meshes with borders that can be divided into rows."""
