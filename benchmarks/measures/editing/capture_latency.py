# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time to capture a region of a fabric as a pattern, to lay the pattern elsewhere, and to undo that.

Each fabric is a flat piece or a tube of a pattern of the library. The whole of it is captured, and then the rows of
one repeat, which are laid on 600 stitches at another place. Every run sees a stitch mesh without cached values, which
is the state after an edit.
"""

from __future__ import annotations

import platform
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.measures.editing.edit_latency import forgetful
from benchmarks.table import Rows
from benchmarks.timing import milliseconds
from stitchmesh.editing.edit import Edit, apply_changes, apply_edit
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import Pattern, apply_pattern, capture_pattern, format_pattern, read_pattern, smallest_repeat
from stitchmesh.patterns.swatch_mesh import plain_piece

SIZES = (20_000, 65_000)
"""Numbers of faces, approximately."""
PATTERNS = ("rib2x2", "jacquard1", "rope-cable", "eyelet-lace")
RUNS = 9
REGION = 600
"""Number of stitches on which the captured pattern is laid."""


def piece(pattern: Pattern, faces: int, *, closed: bool) -> StitchMesh:
    """Return a piece of a pattern with about ``faces`` faces, flat or as a tube."""
    columns = pattern.width * max(round(faces**0.5 / pattern.width), 1)
    rows = 1 + pattern.height * max(round(faces / columns / pattern.height), 1)
    plain = plain_piece(columns, rows, 1.0, 1.0)
    return apply_pattern(rolled_up(plain, columns, rows) if closed else plain, pattern, remainder="refuse")


def rolled_up(plain: StitchMesh, columns: int, rows: int) -> StitchMesh:
    """Return a flat piece as a tube: the last column joins the first."""
    angle = 2 * np.pi * np.arange(columns) / columns
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1) * columns / (2 * np.pi)
    points = np.concatenate([np.tile(ring, (rows + 1, 1)), np.repeat(np.arange(rows + 1.0), columns)[:, None]], axis=1)
    level, place = np.divmod(plain.face_vertex, columns + 1)
    corners = level * columns + place % columns
    twin = find_twins(plain.face_start, corners, len(points))
    return replace(plain, vertices=points, face_vertex=corners, twin=twin)


def median_ms(what: Callable[[StitchMesh], object], fabric: StitchMesh) -> float:
    """Return the median time of a function of a mesh without cached values [ms]."""
    return float(np.median(milliseconds(what, RUNS, lambda: forgetful(fabric))))


def row_of(name: str, faces: int, *, closed: bool) -> tuple[object, ...]:
    """One line of the table."""
    pattern = read_pattern(name)
    fabric = piece(pattern, faces, closed=closed)
    worked = np.flatnonzero(fabric.stitch != Stitch.CAST_ON)
    whole = median_ms(lambda mesh: capture_pattern(mesh, worked), fabric)
    band = np.flatnonzero((fabric.row > 0) & (fabric.row <= pattern.height))
    part = median_ms(lambda mesh: capture_pattern(mesh, band), fabric)
    repeat = smallest_repeat(capture_pattern(fabric, band))
    region = np.flatnonzero((fabric.row > 1) & (fabric.row <= 1 + 2 * repeat.height))
    edit = Edit("paste_pattern", {"pattern": format_pattern(repeat), "faces": region[:REGION].tolist()})
    lay = median_ms(lambda mesh: apply_edit(mesh, edit), fabric)
    edited = apply_edit(fabric, edit)
    undo = median_ms(lambda mesh: apply_changes(mesh, edited.inverse), edited.fabric)
    shape = "tube" if closed else "flat"
    return name, shape, fabric.face_count, *(f"{time:.1f}" for time in (whole, part, lay, undo))


def capture_latency() -> Rows:
    """Yield the table."""
    yield f"Python {platform.python_version()}, {platform.machine()}, medians of {RUNS} runs in milliseconds"
    yield "pattern", "piece", "faces", "whole", "part", "lay", "undo"
    for faces in SIZES:
        for name in PATTERNS:
            for closed in (False, True):
                yield row_of(name, faces, closed=closed)
