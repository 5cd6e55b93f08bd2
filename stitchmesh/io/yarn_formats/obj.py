# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Wavefront OBJ polylines: one ``l`` element for each yarn; a closed yarn ends with its first vertex."""

from __future__ import annotations

from os import fspath

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, read_lines
from stitchmesh.io.obj_elements import element_lines, vertex_index, vertex_position
from stitchmesh.mesh import FloatArray


def read_obj_polylines(path: FilePath) -> tuple[list[FloatArray], list[bool]]:
    """Read polylines.

    Returns:
        Points of each polyline in the file's unit, shape (n, 3) each, where a closed polyline does not repeat its first
        point; and whether each polyline is closed.

    Raises:
        FileError: the file cannot be read, a line is malformed, a vertex does not exist, a polyline has too few points,
            or there are no polylines. The message names the line.
    """
    name = fspath(path)
    vertices: list[tuple[float, float, float]] = []
    lines: list[tuple[int, list[int]]] = []
    for number, fields in element_lines(read_lines(path)):
        if fields[0] == "v":
            vertices.append(vertex_position(name, number, fields))
        elif fields[0] == "l":
            lines.append((number, [vertex_index(name, number, text, len(vertices)) for text in fields[1:]]))
    if not lines:
        raise FileError(f"{name}: has no 'l' elements; expected polylines, one for each yarn")
    positions = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    curves = [_polyline(name, number, indices, positions) for number, indices in lines]
    return [curve for curve, _ in curves], [closed for _, closed in curves]


def write_obj_polylines(path: FilePath, curves: list[FloatArray], closed: list[bool]) -> None:
    """Write polylines; coordinates have all digits that are needed to read the same numbers again.

    Args:
        path: an ``.obj`` file.
        curves: points of each polyline in the file's unit, shape (n, 3) each.
        closed: whether each polyline is closed.

    Raises:
        FileError: the file cannot be written.
    """
    lines = ["# StitchMesh"]
    lines += [f"v {x!r} {y!r} {z!r}" for curve in curves for x, y, z in curve.tolist()]
    first = 1
    for curve, returns in zip(curves, closed, strict=True):
        numbers = [*range(first, first + len(curve)), *([first] if returns else [])]
        lines.append("l " + " ".join(map(str, numbers)))
        first += len(curve)
    write_text(path, "\n".join(lines) + "\n")


def _polyline(name: str, number: int, indices: list[int], positions: FloatArray) -> tuple[FloatArray, bool]:
    bad = [index for index in indices if index >= len(positions)]
    if bad:
        where = f"{name}: line {number}: vertex {bad[0] + 1} does not exist"
        raise FileError(f"{where}; the file has {len(positions)} vertices, perhaps it was cut short")
    closed = len(indices) > 2 and indices[0] == indices[-1]
    corners = indices[:-1] if closed else indices
    least = 3 if closed else 2
    if len(corners) < least:
        raise FileError(f"{name}: line {number}: got a polyline of {len(corners)} points; expected at least {least}")
    return positions[corners], closed
