# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Times of edits, selections, captures, patterns and steps of labeling on large fabrics, in milliseconds.

Every run of an edit, a selection or a capture sees a stitch mesh without cached values, which is the state after an
edit; the time holds the check of the result. Every run of an edit is at another place. A step of labeling starts from a
mesh whose derived tables are cached, as they are after the first step.
"""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterator
from dataclasses import fields

import numpy as np

from benchmarks.places import ROOT
from benchmarks.scenes.garments import Garment
from benchmarks.scenes.large_pieces import meshes_of_quads, pattern_piece
from benchmarks.table import Rows
from benchmarks.timing import median_and_largest, milliseconds
from stitchmesh.editing.edit import Edit, apply_changes, apply_edit
from stitchmesh.errors import StitchMeshError
from stitchmesh.labeling import PartialLabeling, label, start_labeling
from stitchmesh.mesh import BORDER, Mesh, StitchMesh
from stitchmesh.mesh.change import Patch
from stitchmesh.mesh.orientation import mean_winding_number
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import (
    capture_pattern,
    format_pattern,
    lay_pattern,
    parse_pattern,
    pattern_names,
    read_pattern,
    smallest_repeat,
)
from stitchmesh.patterns.placement.columns import keeps_counts
from stitchmesh.selection import borders, select
from stitchmesh.tessellate import tessellate

MACHINE = f"Python {platform.python_version()}, {platform.machine()}"


def forgetful(fabric: StitchMesh) -> StitchMesh:
    """Return the same stitch mesh without its cached values."""
    fresh = object.__new__(StitchMesh)
    for part in fields(StitchMesh):
        object.__setattr__(fresh, part.name, getattr(fabric, part.name))
    return fresh


def times_of(work: Callable[[StitchMesh], object], fabric: StitchMesh, runs: int) -> tuple[str, str]:
    """Return the median and the longest time of some work on a fabric without cached values."""
    return median_and_largest(milliseconds(work, runs, lambda: forgetful(fabric)))


EditAt = Callable[[StitchMesh, int], Edit]
"""From a fabric and a face to an edit there."""
PLACES = 20
"""Number of places at which each edit is measured."""
REACH = 15.0
"""Radius of a region that takes a pattern, in mean stitch widths."""


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
EDITS: list[tuple[list[EditAt], EditAt]] = [
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


def edits(*, stitch_width: float = 0.45) -> Rows:
    """Time the edits of the dress, and their undo."""
    fabric = Garment("dress", stitch_width).divided()
    inner = (fabric.twin[fabric.left_wale] != BORDER) & (fabric.twin[fabric.right_wale] != BORDER)
    places = np.flatnonzero((fabric.stitch == Stitch.KNIT) & inner)
    places = np.random.default_rng(0).permutation(places)[: 10 * PLACES]
    yield f"dress: {fabric.face_count} faces; {MACHINE}"
    yield "edit", "median", "slowest", "undo", "faces", "runs"
    for first, then in EDITS:
        runs = list(runs_of(fabric, first, then, places))
        name = name_of(fabric, first, then, int(places[0]))
        if not runs:
            yield name, "possible nowhere"
            continue
        made, undone, faces = np.array(runs).T
        yield name, *median_and_largest(made), f"{np.median(undone):.1f}", f"{np.median(faces):.0f}", len(runs)


def runs_of(
    fabric: StitchMesh, first: list[EditAt], then: EditAt, places: np.ndarray
) -> Iterator[tuple[float, float, int]]:
    """Yield the times of an edit and of its undo [ms], and the number of faces that it adds, where it is possible."""
    done = 0
    for face in places.tolist():
        prepared = fabric
        try:
            for earlier in first:
                prepared = apply_edit(prepared, earlier(prepared, face)).fabric
            edit = then(prepared, face)
            fresh = forgetful(prepared)
            start = time.perf_counter()
            edited = apply_edit(fresh, edit)
        except StitchMeshError:
            continue
        between = time.perf_counter()
        apply_changes(edited.fabric, edited.inverse)
        end = time.perf_counter()
        faces = sum(len(change.added_faces) for change in edited.changes if isinstance(change, Patch))
        yield 1e3 * (between - start), 1e3 * (end - between), faces
        done += 1
        if done == PLACES:
            return


def name_of(fabric: StitchMesh, first: list[EditAt], then: EditAt, face: int) -> str:
    """Return the name of an edit; that of a pattern on a region says what lies below it."""
    edit = then(fabric, face)
    if "faces" in edit.arguments and "pattern" in edit.arguments:
        below = [earlier(fabric, face).arguments["pattern"] for earlier in first]
        return " over ".join([str(edit.arguments["pattern"]), *map(str, below)])
    return edit.name + (", 1 course" if "courses" in edit.arguments else "")


SELECTIONS = (
    "all", "rows 10-60 step 4", "last 6 rows", "hem 6", "cuffs 6", "neck 6", "border 0 40", "cuffs 7- step 8 height 4",
    "front", "back", "left", "sleeves", "left sleeve", "body", "front panel 20", "left panel 8", "stitch k",
    "decreases", "cast-on", "yarn 0", "faces 10-400", "wale 3000", "ring 3000 up 6", "rectangle 3000 20x30",
    "sleeves and cuffs 7- step 8 height 4", "front panel 20 and hem 10-57 and not cast-on",
)  # fmt: skip
EDITS_ON = (
    Edit("stripe", {"on": "rows 10-60 step 4", "yarn": 1}),
    Edit("change_stitch", {"on": "front panel 20 and hem 10-57 and not (increases or decreases)", "stitch": "p"}),
    Edit("stripe", {"on": "sleeves and cuffs 7- step 8 height 4", "yarn": 1}),
)
PATTERNS_ON = (
    ("rib2x2", "hem 6 or cuffs 6 or neck 5"),
    ("eyelet-lace", "front panel 20 and hem 10-57"),
    ("moss", "sleeves"),
)


def selections(*, stitch_width: float = 0.8) -> Rows:
    """Time the selections on the sweater, and edits and patterns on selections."""
    runs, fabric = 5, Garment("sweater", stitch_width).divided()
    yield f"sweater: {fabric.face_count} faces; {MACHINE}"
    yield "selection", "median", "slowest", "faces"
    yield "borders", *times_of(borders, fabric, runs), fabric.face_count
    for text in SELECTIONS:
        times = times_of(lambda fresh, text=text: select(fresh, text), fabric, runs)  # type: ignore[misc]
        yield text, *times, len(select(fabric, text))
    for edit in EDITS_ON:
        on, edited = str(edit.arguments["on"]), apply_edit(fabric, edit)
        faces = len(select(fabric, on))
        times = times_of(lambda fresh, edit=edit: apply_edit(fresh, edit), fabric, runs)  # type: ignore[misc]
        yield f"{edit.name} on {on}", *times, faces
        undone = edited.inverse
        times = times_of(lambda fresh, undone=undone: apply_changes(fresh, undone), edited.fabric, runs)  # type: ignore[misc]
        yield "undo", *times, faces
    for pattern, on in PATTERNS_ON:

        def lay(fresh: StitchMesh, pattern: str = pattern, on: str = on) -> object:
            return lay_pattern(fresh, pattern, faces=select(fresh, on))

        laid = lay_pattern(fabric, pattern, faces=select(fabric, on))
        yield f"{pattern} on {on}", *times_of(lay, fabric, runs), laid.faces_laid


CAPTURED = ("rib2x2", "jacquard1", "rope-cable", "eyelet-lace")
LAID_ON = 600
"""Number of stitches on which a captured repeat is laid."""


LARGE, RUNS = (20_000, 65_000), 9
"""Approximate numbers of faces of pieces, and runs of each action on them."""


def captures() -> Rows:
    """Time the capture of a whole piece and of one repeat, which is laid elsewhere and taken back."""
    yield f"{MACHINE}, medians of {RUNS} runs"
    yield "pattern", "piece", "faces", "whole", "part", "lay", "undo"
    for size in LARGE:
        for name in CAPTURED:
            for shape in ("flat", "tube"):
                pattern = read_pattern(name)
                fabric = pattern_piece(pattern, size, closed=shape == "tube")
                worked = np.flatnonzero(fabric.stitch != Stitch.CAST_ON)
                band = np.flatnonzero((fabric.row > 0) & (fabric.row <= pattern.height))
                repeat = smallest_repeat(capture_pattern(fabric, band))
                region = np.flatnonzero((fabric.row > 1) & (fabric.row <= 1 + 2 * repeat.height))
                text, on = format_pattern(repeat), region[:LAID_ON].tolist()
                edited = apply_edit(fabric, edit := Edit("paste_pattern", {"pattern": text, "faces": on}))
                works: list[tuple[Callable[[StitchMesh], object], StitchMesh]] = [
                    (lambda fresh, worked=worked: capture_pattern(fresh, worked), fabric),  # type: ignore[misc]
                    (lambda fresh, band=band: capture_pattern(fresh, band), fabric),  # type: ignore[misc]
                    (lambda fresh, edit=edit: apply_edit(fresh, edit), fabric),  # type: ignore[misc]
                    (lambda fresh, edited=edited: apply_changes(fresh, edited.inverse), edited.fabric),  # type: ignore[misc]
                ]
                yield name, shape, fabric.face_count, *(times_of(*work, RUNS)[0] for work in works)


def patterns(*, stitch_width: float = 0.45) -> Rows:
    """Time to read each pattern of the library and to lay it on the dress.

    Args:
        stitch_width: [cm]
    """
    fabric = Garment("dress", stitch_width).divided()
    yield f"dress, {fabric.face_count} faces"
    yield "pattern", "size", "faces", "read [ms]", "lay [s]", "laid"
    for name in pattern_names():
        text = (ROOT / "assets" / "patterns" / f"{name}.knit").read_text()
        begin = time.perf_counter()
        pattern = parse_pattern(text, name)
        parsed = time.perf_counter()
        laid = lay_pattern(fabric, pattern)
        applied = time.perf_counter()
        size = f"{sum(pattern.rows[0].bottoms)} x {pattern.height}"
        kind = "stay" if keeps_counts(pattern) else "replaced"
        yield name, size, kind, f"{1e3 * (parsed - begin):.2f}", f"{applied - parsed:.3f}", laid.faces_laid


def labeling() -> Rows:
    """Time the steps of labeling, and the whole labeling."""
    yield f"{MACHINE}; median and longest of {RUNS}"
    for size in LARGE:
        meshes = meshes_of_quads(size)
        for name, mesh in meshes.items():
            yield f"{name}, {mesh.face_count} faces"
            yield "step", "median ms", "longest ms"
            for step, run in steps_of(mesh).items():
                yield step, *median_and_largest(milliseconds(lambda _, run=run: run(), RUNS))
        fabric = tessellate(label(meshes["tube"]), stitch_width=1.0, stitch_height=1.0)
        edited = apply_edit(fabric, flip := Edit("flip_row", {"face": fabric.face_count // 2}))
        again = milliseconds(lambda _: apply_edit(fabric, flip), RUNS)  # noqa: B023
        yield "flip a row of stitches", *median_and_largest(again)
        undone = milliseconds(lambda _: apply_changes(edited.fabric, edited.inverse), RUNS)  # noqa: B023
        yield "undo it", *median_and_largest(undone)


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
        "label, first time": lambda: label(Mesh(mesh.vertices, mesh.face_start, mesh.face_vertex, mesh.twin)),
        "inside out?": lambda: mean_winding_number(mesh),
    }


def inner_edge(mesh: Mesh, labeling: PartialLabeling) -> tuple[int, int]:
    """The vertices of a course edge of a row in the middle of the mesh."""
    row = labeling.row_count // 2
    face = int(np.flatnonzero(labeling.row == row)[0])
    side = int(mesh.side_next[labeling.left_wale[face]])
    return int(mesh.face_vertex[side]), int(mesh.face_vertex[mesh.side_next[side]])


ACTIONS = (edits, selections, captures, patterns, labeling)
