# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time of each step of labeling on large meshes, and of the whole labeling.

The meshes are a tube as high as it is wide, a tube with eight times as many faces in a row, and a flat piece. Every
step starts from a mesh whose derived tables are cached, as they are after the first step. The undo of a step is the old
value and costs nothing.
"""

from __future__ import annotations

import platform
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.table import Rows
from benchmarks.timing import milliseconds
from stitchmesh.editing.edit import Edit, apply_changes, apply_edit
from stitchmesh.labeling import PartialLabeling, label, start_labeling
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.orientation import mean_winding_number
from stitchmesh.tessellate import tessellate

RUNS = 9
"""Number of times that each step is measured."""

Step = Callable[[PartialLabeling], object]


def grid_of_quads(columns: int, rows: int, *, around: bool) -> Mesh:
    """A flat piece of quads, or a tube of quads, whose sides are about 1 cm long."""
    count = columns if around else columns + 1
    angle = 2.0 * np.pi * np.arange(count) / count
    height = np.repeat(np.arange(rows + 1.0), count)
    radius = columns / (2.0 * np.pi)
    if around:
        flat = np.stack([radius * np.sin(angle), radius * np.cos(angle)], axis=1)
    else:
        flat = np.stack([np.arange(count, dtype=float), np.zeros(count)], axis=1)
    x, z = np.tile(flat, (rows + 1, 1)).T
    row, column = (grid.ravel() for grid in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    after = (column + 1) % count
    corners = np.stack([column, after, after + count, column + count], axis=1) + (row * count)[:, None]
    return Mesh.from_polygons(np.stack([x, height, z], axis=1), corners.tolist())


def meshes(faces: int) -> dict[str, Mesh]:
    """Meshes with about this number of faces: a tube as high as wide, a wide and short tube, and a flat piece."""
    side = round(faces**0.5)
    return {
        "tube": grid_of_quads(side, faces // side, around=True),
        "wide tube": grid_of_quads(8 * side, faces // (8 * side), around=True),
        "flat piece": grid_of_quads(side, faces // side, around=False),
    }


def fresh(mesh: Mesh) -> Mesh:
    """Return the same mesh without its cached tables."""
    return Mesh(mesh.vertices, mesh.face_start, mesh.face_vertex, mesh.twin)


def inner_edge(mesh: Mesh, labeling: PartialLabeling) -> tuple[int, int]:
    """The vertices of a course edge of a row in the middle of the mesh."""
    row = labeling.row_count // 2
    face = int(np.flatnonzero(labeling.row == row)[0])
    side = int(mesh.side_next[labeling.left_wale[face]])
    return int(mesh.face_vertex[side]), int(mesh.face_vertex[mesh.side_next[side]])


def steps_of(mesh: Mesh) -> dict[str, Callable[[], object]]:
    """The steps that are measured, by name."""
    loop = mesh.boundary_loops[0]
    border = int(mesh.face_vertex[loop[0]]), int(mesh.face_vertex[mesh.side_next[loop[0]]])
    empty = start_labeling(mesh)
    started = empty.start_at_edge(border)
    half = started.label_rows(max(started.mesh.face_count // (2 * np.count_nonzero(started.labeled)), 1))
    whole = half.label_all()
    edge = inner_edge(mesh, whole)
    opened = whole.set_edge(edge, "wale")
    face = mesh.face_count // 2
    return {
        "start at a border": lambda: empty.start_at_edge(border),
        "start at the whole border": lambda: empty.start_at_border(border),
        "start at an edge loop": lambda: empty.start_at_edge(edge),
        "one row more": lambda: half.label_rows(1),
        "first row, automatic start": lambda: empty.label_rows(1),
        "set an edge to wale": lambda: whole.set_edge(edge, "wale"),
        "set it back to course": lambda: opened.set_edge(edge, "course"),
        "clear an edge": lambda: whole.set_edge(edge, None),
        "flip a row": lambda: whole.flip_row(face),
        "faults": lambda: opened.faults,
        "all rows": empty.label_all,
        "finish": whole.finish,
        "label": lambda: label(mesh),
        "label, first time": lambda: label(fresh(mesh)),
        "inside out?": lambda: mean_winding_number(mesh),
    }


def flip_after_tessellation(fabric: StitchMesh) -> tuple[Callable[[], object], Callable[[], object]]:
    """The edit that flips a row of stitches, and its undo."""
    edit = Edit("flip_row", {"face": fabric.face_count // 2})
    edited = apply_edit(fabric, edit)
    return lambda: apply_edit(fabric, edit), lambda: apply_changes(edited.fabric, edited.inverse)


@dataclass(frozen=True)
class Options:
    """What is measured."""

    faces: tuple[int, ...] = (20000, 65000)


def labeling_steps(arguments: Options) -> Rows:
    """Time the steps and print a table for each mesh."""
    yield f"Python {platform.python_version()}, {platform.machine()}; milliseconds, median and longest of {RUNS}"
    for faces in arguments.faces:
        for name, mesh in meshes(faces).items():
            yield f"{name}, {mesh.face_count} faces"
            yield "step", "median ms", "longest ms"
            for step, run in steps_of(mesh).items():
                times = milliseconds(lambda _, run=run: run(), RUNS)
                yield step, f"{np.median(times):.1f}", f"{times.max():.1f}"
        fabric = tessellate(label(meshes(faces)["tube"]), stitch_width=1.0, stitch_height=1.0)
        for step, run in zip(("flip a row of stitches", "undo it"), flip_after_tessellation(fabric), strict=True):
            times = milliseconds(lambda _, run=run: run(), RUNS)
            yield step, f"{np.median(times):.1f}", f"{times.max():.1f}"
