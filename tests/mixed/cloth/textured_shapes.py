# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""OBJ files with texture coordinates that tests write."""

from __future__ import annotations

from pathlib import Path

import numpy as np


def write_obj(path: Path, vertices, texture, faces) -> Path:
    """Write an OBJ file.

    Args:
        path: the file.
        vertices: positions, shape (V, 3).
        texture: texture coordinates, shape (U, 2).
        faces: for each face its corners (vertex, texture coordinate), from 0.
    """
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(vertices, dtype=float).tolist()]
    lines += [f"vt {u!r} {v!r}" for u, v in np.asarray(texture, dtype=float).tolist()]
    lines += ["f " + " ".join(f"{v + 1}/{t + 1}" for v, t in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")
    return path


def globe(path: Path, *, radius: float = 5.0, around: int = 24, rings: int = 6, unit: float = 1.0) -> Path:
    """A sphere of two islands, its upper and its lower half, both seen from above, so that the lower one is mirrored.

    Texture coordinates are the length of the meridian, in ``unit`` cm.
    """
    vertices: list[list[float]] = [[0.0, 0.0, radius], [0.0, 0.0, -radius]]
    texture: list[list[float]] = []
    number: dict[tuple[int, int, int], int] = {}
    angle = 2 * np.pi * np.arange(around) / around
    for half in (0, 1):
        texture.append([3.0 * half, 0.0])
    for ring in range(1, rings + 1):
        lean = ring / rings * np.pi / 2
        for half in (0, 1):
            for k in range(around):
                if ring < rings or half == 0:
                    number[half, ring, k] = len(vertices)
                    height = radius * np.cos(lean) * (1 - 2 * half)
                    vertices.append([radius * np.sin(lean) * np.cos(angle[k]), radius * np.sin(lean) * np.sin(angle[k]),
                                     height])  # fmt: skip
                else:
                    number[half, ring, k] = number[0, ring, k]

    def corner(half: int, ring: int, k: int) -> tuple[int, int]:
        k %= around
        if ring == 0:
            return half, half
        along = radius * ring / rings * np.pi / 2 / unit
        texture.append([3.0 * radius / unit * half + along * np.cos(angle[k]), along * np.sin(angle[k])])
        return number[half, ring, k], len(texture) - 1

    texture[1][0] = 3.0 * radius / unit
    faces = []
    for half in (0, 1):
        for ring in range(rings):
            for k in range(around):
                corners = [corner(half, ring, k), corner(half, ring + 1, k), corner(half, ring + 1, k + 1)]
                if ring:
                    corners.append(corner(half, ring, k + 1))
                faces.append(corners if half == 0 else corners[::-1])
    return write_obj(path, vertices, texture, faces)


def cylinder(path: Path, *, around: int = 12, rows: int = 4) -> Path:
    """A tube of radius 2 and height 4, cut open along a line of its one island, which is 1 wide in the texture."""
    angle = 2 * np.pi * np.arange(around) / around
    vertices = [[2 * np.sin(a), 4 * r / rows, 2 * np.cos(a)] for r in range(rows + 1) for a in angle]
    texture = [[k / around, r / rows / np.pi] for r in range(rows + 1) for k in range(around + 1)]

    def corner(r: int, k: int) -> tuple[int, int]:
        return r * around + k % around, r * (around + 1) + k

    faces = [
        [corner(r, k), corner(r, k + 1), corner(r + 1, k + 1), corner(r + 1, k)]
        for r in range(rows)
        for k in range(around)
    ]
    return write_obj(path, vertices, texture, faces)
