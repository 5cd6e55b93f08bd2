# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time of each edit of a large garment, until the new stitch mesh is made and checked, and time to undo the edit.

Every run edits another position, in a stitch mesh without cached values, which is the state after an edit.
"""

from __future__ import annotations

import platform
import time
from collections.abc import Callable
from dataclasses import fields

import numpy as np

from benchmarks.table import Rows
from stitchmesh.editing.edit import Edit, apply_changes, apply_edit
from stitchmesh.errors import StitchMeshError
from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.change import Patch
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.tessellate import tessellate

RUNS = 20
"""Number of positions at which each edit is measured."""

REACH = 15.0
"""Radius of a region that takes a pattern, in mean stitch widths."""

EditAt = Callable[[StitchMesh, int], Edit]


def at_face(name: str, **more: object) -> EditAt:
    """An edit of a face."""
    return lambda fabric, face: Edit(name, {"face": face, **more})


def at_top(name: str, **more: object) -> EditAt:
    """An edit of a face's rightmost top side."""
    return lambda fabric, face: Edit(name, {"side": int(fabric.right_wale[face]) + 1, **more})


def at_wale(name: str, **more: object) -> EditAt:
    """An edit of a face's right wale side."""
    return lambda fabric, face: Edit(name, {"side": int(fabric.right_wale[face]), **more})


def replace_by(pattern: str) -> EditAt:
    """A pattern on the region around a face, whatever stitches the region holds."""
    return lambda fabric, face: Edit("paste_pattern", {"pattern": pattern, "faces": faces_around(fabric, face)})


def faces_around(fabric: StitchMesh, face: int) -> list[int]:
    """Return the faces within ``REACH`` mean stitch widths of a face, about 700 faces."""
    size = np.diff(fabric.face_start)[:, None]
    centre = np.add.reduceat(fabric.vertices[fabric.face_vertex], fabric.face_start[:-1]) / size
    reach = REACH * np.sqrt(np.linalg.norm(fabric.face_vector_area, axis=1).mean())
    return np.flatnonzero(np.linalg.norm(centre - centre[face], axis=1) < reach).tolist()


SPLIT = at_top("split_course_edge")
DIVIDE = at_face("add_wale_edge", below=1, above=1)
CROSS = at_top("cross_cable", left=2, right=2, front="left")
CASES: list[tuple[list[EditAt], EditAt]] = [
    ([], lambda fabric, face: Edit("change_stitch", {"faces": [face], "stitch": "p"})),
    ([], at_top("twist_loop", twist=1)),
    ([], lambda fabric, face: Edit("stripe", {"rows": [int(fabric.row[face])], "yarn": 1})),
    ([], CROSS),
    ([], at_top("set_cable", destinations=[2, 1, 0], layers=[2, 1, 0])),
    ([CROSS], at_top("clear_cable")),
    ([], SPLIT),
    ([SPLIT], at_top("collapse_course_edge")),
    ([SPLIT], DIVIDE),
    ([SPLIT, DIVIDE], at_wale("remove_wale_edge")),
    ([SPLIT], at_wale("shift_wale_edge", end="top", direction="left")),
    ([], at_wale("insert_wale", courses=1)),
    ([], at_wale("insert_wale")),
    ([], at_face("remove_wale")),
    ([], at_face("flip_row")),
    ([], at_face("insert_row")),
    ([], at_face("remove_row")),
    ([], at_face("bobble")),
    ([], at_face("paste_pattern", pattern="eyelet-lace")),
    ([], replace_by("eyelet-lace")),
    ([replace_by("eyelet-lace")], replace_by("feather-and-fan")),
    ([replace_by("rope-cable")], replace_by("mrs-montagues")),
    ([replace_by("half-cardigan")], replace_by("rib2x2")),
]
"""Edits that prepare the mesh, and the edit that is measured."""


def forgetful(fabric: StitchMesh) -> StitchMesh:
    """Return the same stitch mesh without its cached values."""
    fresh = object.__new__(StitchMesh)
    for part in fields(StitchMesh):
        object.__setattr__(fresh, part.name, getattr(fabric, part.name))
    return fresh


def timed(
    fabric: StitchMesh, first: list[EditAt], then: EditAt, face: int, clock: Callable[[], float]
) -> tuple[float, float, int]:
    """Return the times of an edit and of its undo [ms] by a clock, and the number of faces that the edit adds.

    Raises:
        StitchMeshError: the edit is not possible at this face.
    """
    for edit in first:
        fabric = apply_edit(fabric, edit(fabric, face)).fabric
    edit = then(fabric, face)
    fresh = forgetful(fabric)
    start = clock()
    edited = apply_edit(fresh, edit)
    between = clock()
    apply_changes(edited.fabric, edited.inverse)
    end = clock()
    faces = sum(len(change.added_faces) for change in edited.changes if isinstance(change, Patch))
    return 1e3 * (between - start), 1e3 * (end - between), faces


def row_of(
    fabric: StitchMesh, first: list[EditAt], then: EditAt, places: np.ndarray, clock: Callable[[], float]
) -> tuple[object, ...]:
    """One line of the table."""
    runs: list[tuple[float, float, int]] = []
    for face in places.tolist():
        try:
            runs.append(timed(fabric, first, then, face, clock))
        except StitchMeshError:
            continue
        if len(runs) == RUNS:
            break
    edit = then(fabric, int(places[0]))
    name = edit.name + (", 1 course" if "courses" in edit.arguments else "")
    if "faces" in edit.arguments and "pattern" in edit.arguments:
        below = [earlier(fabric, int(places[0])).arguments["pattern"] for earlier in first]
        name = " over ".join([str(edit.arguments["pattern"]), *map(str, below)])
    if not runs:
        return name, "possible nowhere"
    median, slowest = np.median(runs, axis=0), np.max(runs, axis=0)
    return name, *(f"{time:.1f}" for time in (median[0], slowest[0], median[1])), f"{median[2]:.0f}", len(runs)


def edit_latency(
    *, mesh: str = "assets/meshes/dress.obj", stitch_width: float = 0.45, processor_time: bool = False
) -> Rows:
    """Time the edits of one garment.

    Args:
        processor_time: leave out the time of other programs
    """
    clock = time.process_time if processor_time else time.perf_counter
    fabric = tessellate(label(read_mesh(mesh)), stitch_width=stitch_width)
    inner = (fabric.twin[fabric.left_wale] != BORDER) & (fabric.twin[fabric.right_wale] != BORDER)
    places = np.flatnonzero((fabric.stitch == Stitch.KNIT) & inner)
    places = np.random.default_rng(0).permutation(places)[: 10 * RUNS]
    yield f"{mesh}: {fabric.face_count} faces; Python {platform.python_version()}, {platform.machine()}"
    yield "milliseconds", "median", "slowest", "undo", "faces", "runs"
    for first, then in CASES:
        yield row_of(fabric, first, then, places, clock)
