# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitch meshes in ``.smobj`` files, the text format of augmented stitch meshes (github.com/textiles-lab/smobj).

The lines of the format are, with all numbers counted from 1:

- ``L name labels``: a kind of face and its sides, counter-clockwise from the lower left. A side is ``l`` for loops or
  ``y`` for yarn, with ``+`` if they leave the face and ``-`` if they enter it.
- ``v x y z``: a vertex.
- ``f``: the vertices of a face, and ``T``: the kind of this face.
- ``e``: two sides that are the same edge; the second side has the opposite direction. Only ``e`` lines connect faces,
  because the same vertex may occur several times.

Faces have the names of the library ``illustration.sf``; stitches that the library does not contain have names in the
same style (``FACE_NAMES``). Data for which the format has no place are written as comments, which other programs
ignore: the row and yarn of a face, twisted loops, cables, and the periods of a lattice. Stretch is not written.

The stitch mesh of a face mesh consists of its stitches, without faces that only end loops or lead yarn from row to row.
A stitch mesh needs no such faces: loops on an upper border are live, and rows are joined at their ends when yarns are
made.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from os import fspath

import numpy as np

from stitchmesh.errors import FileError, StitchMeshError
from stitchmesh.faces.face_type import (
    EMPTY_ABOVE,
    EMPTY_BELOW,
    FACE_NAMES,
    LEAVING,
    LOOP,
    NOTHING,
    STITCHES_OF_NAMES,
    YARN,
    FaceType,
    is_framed,
    stitch_of,
)
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath
from stitchmesh.io.stitch_formats.face_meshes import COMMENT_WORD, OwnComment, SurfaceRecords, read_surface
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import BORDER, PER_SIDE, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.connectivity import find_fans, next_sides
from stitchmesh.mesh.courses import course_of_faces, courses_below, find_courses, knitting_order
from stitchmesh.mesh.stitch import Stitch

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class FaceKind:
    """A stitch with the numbers of its lower and upper sides."""

    stitch: Stitch
    n_bottom: int
    n_top: int


@dataclass
class JoinedStitches:
    """Stitches as separate faces, and which of their sides are the same edge. All numbers are counted from 0."""

    kinds: list[FaceKind] = field(default_factory=list)
    """Kind of each face."""
    vertices: list[tuple[float, float, float]] = field(default_factory=list)
    """Positions [cm], images of vertices included."""
    faces: list[list[int]] = field(default_factory=list)
    """Vertices of each face."""
    connections: dict[tuple[int, int], tuple[int, int]] = field(default_factory=dict)
    """For each connected side, as face and place in the face: the other side of the same edge."""
    image_of: dict[int, tuple[int, int, int]] = field(default_factory=dict)
    """For each vertex that is a lattice image: the vertex in the cell, and the two lattice steps to the image."""
    periods: list[list[float]] | None = None
    """Lattice vectors [cm], shape (2, 3); None if the mesh is not periodic."""
    counts: tuple[int, int] | None = None
    """Numbers of faces and connections that a file states."""
    marks: list[tuple[int, int, list[int]]] = field(default_factory=list)
    """Line number, face and numbers of each comment about a face."""


def write_smobj(path: FilePath, fabric: StitchMesh) -> None:
    """Write a stitch mesh; coordinates [cm] have all digits that are needed to read the same numbers again.

    Raises:
        FileError: the file cannot be written.
    """
    labels = [_labels(fabric, face) for face in range(fabric.face_count)]
    library = {kind: number for number, kind in enumerate(dict.fromkeys(labels), start=1)}
    inner = int((fabric.twin != BORDER).sum()) // 2
    lines = ["# stitch mesh, lengths in cm", f"{COMMENT_WORD} counts {fabric.face_count} {inner}"]
    lines += [f"L {kind}" for kind in library]
    lines += _lattice_lines(fabric)
    vertex_lines, corners = _vertex_lines(fabric)
    lines += vertex_lines
    starts = fabric.face_start.tolist()
    marks = _mark_lines(fabric)
    for face, kind in enumerate(labels):
        indices = " ".join(map(str, corners[starts[face] : starts[face + 1]]))
        lines += [f"f {indices}", f"T {library[kind]}", marks[face]]
    place, face_of = (fabric.side_place + 1).tolist(), (fabric.side_face + 1).tolist()
    for side, other in enumerate(fabric.twin.tolist()):
        if side < other:
            lines.append(f"e {face_of[side]}/{place[side]} {face_of[other]}/-{place[other]}")
    write_text(path, "\n".join(lines) + "\n")


def read_smobj(path: FilePath) -> StitchMesh:
    """Read the stitches of a file, and log which faces are left out.

    If the file has no row numbers, rows are numbered in knitting order.

    Raises:
        FileError: the file is missing, a folder, empty, binary or malformed, a face is no stitch and cannot be left
            out, no face is a stitch, or the stitches form no stitch mesh.
    """
    name = fspath(path)
    read = read_surface(path)
    mesh, kinds = read.mesh, _stitches_of_types(read, name)
    try:
        stitches = _joined_stitches(read, kinds)
        if len(stitches.faces) == mesh.face_count:  # The comments are about all faces.
            for comment in read.comments:
                _read_comment(stitches, comment)
        found = mesh.face_count, len(mesh.joins)
        if stitches.counts is not None and stitches.counts != found:
            expected = f"{stitches.counts[0]} and {stitches.counts[1]}"
            raise ValueError(f"got {found[0]} faces and {found[1]} connections of {expected}; the file was cut short")
        return stitch_mesh_of(stitches)
    except (StitchMeshError, ValueError, IndexError) as error:
        raise FileError(f"{name}: {error}") from error


def _stitches_of_types(read: SurfaceRecords, name: str) -> list[Stitch | None]:
    """Return the stitch of each type of face, and log which faces are no stitches.

    Raises:
        FileError: a face is no stitch and cannot be left out, or no face is a stitch.
    """
    mesh = read.mesh
    for number in dict.fromkeys(mesh.face_type.tolist()):
        kind = mesh.types[number]
        if kind.name in STITCHES_OF_NAMES and not is_framed(kind):
            found = f"line {read.type_line[number]}: {kind.name}: got sides {' '.join(kind.labels)[:60]}"
            expected = "loops in (-l), yarn (y), loops out (+l), yarn, counter-clockwise from the lower left"
            raise FileError(f"{name}: {found}; expected {expected}")
    used = [mesh.types[k] for k in mesh.face_type.tolist()]
    foreign = [kind for kind in used if stitch_of(kind) is None]
    needed = [kind for kind in foreign if not _may_be_left_out(kind)]
    if needed or len(foreign) == len(used):
        found = _counted(needed or used)
        raise FileError(f"{name}: {found} are no stitches; `stitchmesh yarns` draws the faces as they are")
    if foreign:
        logger.info("%s: without %s, which only end loops or lead the yarn on", name, _counted(foreign))
    return [stitch_of(kind) for kind in mesh.types]


def _may_be_left_out(kind: FaceType) -> bool:
    """Return whether no loop leaves a face, and either loops or yarn enter it."""
    words = {side.kind for side in kind.sides if side.strands}
    makes = any(side.kind == LOOP and side.direction == LEAVING and side.strands for side in kind.sides)
    return not makes and words <= {LOOP, YARN, NOTHING} and len(words) == 1


def _counted(kinds: Iterable[FaceType]) -> str:
    return ", ".join(f"{count} {name}" for name, count in Counter(kind.name for kind in kinds).most_common(8))


def _joined_stitches(read: SurfaceRecords, stitches: Sequence[Stitch | None]) -> JoinedStitches:
    """Return the faces that are stitches, with their joins.

    Args:
        read: the faces and their joins.
        stitches: the stitch of each type of face.

    Raises:
        ValueError: two stitches are joined without reversal.
    """
    mesh = read.mesh
    found = JoinedStitches(vertices=[(x, y, z) for x, y, z in mesh.vertices.tolist()])
    number: dict[int, int] = {}
    corners = np.split(mesh.face_vertex, mesh.face_start[1:-1])
    for face, kind in enumerate(mesh.face_type.tolist()):
        stitch, sides = stitches[kind], mesh.types[kind].sides
        if stitch is not None:
            number[face] = len(number)
            n_bottom = next(k for k, side in enumerate(sides) if side.kind == YARN)
            found.kinds.append(FaceKind(stitch, n_bottom, len(sides) - n_bottom - 2))
            found.faces.append(corners[face].tolist())
    faces = np.searchsorted(mesh.face_start, mesh.joins, side="right") - 1
    places = mesh.joins - mesh.face_start[faces]
    for (face, other), (side, across), reverses, line in zip(
        faces.tolist(), places.tolist(), mesh.reverses.tolist(), read.join_line, strict=True
    ):
        if face in number and other in number:
            if not reverses:
                what = f"line {line}: faces {face + 1} and {other + 1} are joined without reversal"
                raise ValueError(f"{what}; the stitches of a stitch mesh face the same way")
            found.connections[number[face], side] = number[other], across
            found.connections[number[other], across] = number[face], side
    return found


def _read_comment(stitches: JoinedStitches, comment: OwnComment) -> None:
    """Read a comment that ``write_smobj`` wrote.

    Raises:
        ValueError: it is no such comment.
    """
    words = comment.words
    try:
        if words[0] == "lattice" and len(words) == 7:
            stitches.periods = [[float(x) for x in words[1:4]], [float(x) for x in words[4:]]]
        elif words[0] == "counts" and len(words) == 3:
            stitches.counts = int(words[1]), int(words[2])
        elif words[0] == "image" and len(words) == 4:
            vertex, a, b = (_small_number(text) for text in words[1:])
            stitches.image_of[comment.vertex] = (vertex - 1, a, b)
        elif words[0] == "face" and len(words) >= 3 and len(words) % 4 == 3:
            stitches.marks.append((comment.line, comment.face, [_small_number(text) for text in words[1:]]))
        else:
            raise ValueError
    except (ValueError, IndexError) as error:
        found = f"line {comment.line}: got {COMMENT_WORD} {' '.join(words)[:40]!r}"
        raise ValueError(f"{found}; expected counts, lattice, image or face, and numbers") from error


def _small_number(text: str) -> int:
    """Return a whole number of a comment, such as a row or a lattice step.

    Raises:
        ValueError: it is no whole number, or too large to count anything.
    """
    number = int(text)
    if abs(number) > 2**31 - 1:
        raise ValueError(f"{text[:20]} is too large")
    return number


def _labels(fabric: StitchMesh, face: int) -> str:
    """Return the name and the labels of the kind of a face."""
    stitch = Stitch(int(fabric.stitch[face]))
    below = ["-l0" if stitch in EMPTY_BELOW else "-l1"] * int(fabric.n_bottom[face])
    above = ["+l0" if stitch in EMPTY_ABOVE else "+l1"] * int(fabric.n_top[face])
    return " ".join([FACE_NAMES[stitch], *below, "+y1", *above, "-y1"])


def _lattice_lines(fabric: StitchMesh) -> list[str]:
    if fabric.lattice is None:
        return []
    return [f"{COMMENT_WORD} lattice " + " ".join(repr(float(x)) for x in np.ravel(fabric.lattice.periods))]


def _vertex_lines(fabric: StitchMesh) -> tuple[list[str], list[int]]:
    """Return the lines of the vertices and of their lattice images, and the vertex of each corner, counted from 1."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in fabric.vertices.tolist()]
    if fabric.corner_image is None:
        return lines, (fabric.face_vertex + 1).tolist()
    numbers = {(vertex, 0, 0): vertex + 1 for vertex in range(len(fabric.vertices))}
    corners = []
    positions = fabric.corner_position.tolist()
    images = fabric.corner_image.tolist()
    for corner, vertex in enumerate(fabric.face_vertex.tolist()):
        key = (vertex, *images[corner])
        if key not in numbers:
            numbers[key] = len(numbers) + 1
            x, y, z = positions[corner]
            lines += [f"v {x!r} {y!r} {z!r}", f"{COMMENT_WORD} image {vertex + 1} {key[1]} {key[2]}"]
        corners.append(numbers[key])
    return lines, corners


def _mark_lines(fabric: StitchMesh) -> list[str]:
    """Return the comment of each face: its row and yarn, then place, twist, shift and layer of each marked side."""
    rows_and_yarns = zip(fabric.row.tolist(), fabric.yarn.tolist(), strict=True)
    lines = [f"{COMMENT_WORD} face {row} {yarn}" for row, yarn in rows_and_yarns]
    marked = np.flatnonzero((fabric.twist != 0) | (fabric.cable_shift != 0) | (fabric.cable_layer != 0))
    for side in marked.tolist():
        marks = fabric.twist[side], fabric.cable_shift[side], fabric.cable_layer[side]
        lines[fabric.side_face[side]] += f" {fabric.side_place[side] + 1} " + " ".join(map(str, marks))
    return lines


def stitch_mesh_of(stitches: JoinedStitches) -> StitchMesh:
    """Return the stitch mesh of joined stitches.

    Raises:
        StitchMeshError: the faces do not form a stitch mesh.
        ValueError: the marks do not fit the faces.
    """
    start = np.concatenate([[0], np.cumsum([len(face) for face in stitches.faces])])
    twin = connected_twins(stitches, start)
    written = np.array([vertex for face in stitches.faces for vertex in face])
    if stitches.periods is None:
        vertices, corner_vertex = _merge_vertices(stitches, written, start, twin)
        lattice, images = None, None
    else:
        lattice = Lattice(np.array(stitches.periods))
        vertices, corner_vertex, images = _vertices_of_cell(stitches, written)
    kinds = stitches.kinds
    fabric = StitchMesh(
        vertices, start, corner_vertex, twin, lattice=lattice, corner_image=images,
        n_bottom=[kind.n_bottom for kind in kinds],  # type: ignore[arg-type]
        n_top=[kind.n_top for kind in kinds],  # type: ignore[arg-type]
        stitch=[kind.stitch for kind in kinds],  # type: ignore[arg-type]
        row=np.zeros(len(kinds), dtype=np.int64),
    )  # fmt: skip
    return _with_marks(stitches, fabric)


def connected_twins(stitches: JoinedStitches, start: IntArray) -> IntArray:
    """Return the opposite side of each side by the connections of stitches, shape (C,).

    Args:
        stitches: the stitches.
        start: first corner of each face, and the number of corners, shape (F + 1,).
    """
    twin = np.full(start[-1], BORDER)
    for (face, side), (other, across) in stitches.connections.items():
        twin[start[face] + side] = start[other] + across
    return twin


def _merge_vertices(
    stitches: JoinedStitches, written: IntArray, start: IntArray, twin: IntArray
) -> tuple[FloatArray, IntArray]:
    """Merge the vertices of all corners that are the same point because their faces are connected.

    Args:
        stitches: the stitches.
        written: vertex of each corner in the file, shape (C,).
        start: first corner of each face, and the number of corners, shape (F + 1,).
        twin: opposite side of each side, shape (C,).

    Returns:
        Merged vertices [cm], shape (V, 3), and the merged vertex of each corner, shape (C,). The position of a merged
        vertex is the mean of its different vertices in the file; a single position is kept exactly.
    """
    group = find_fans(np.where(twin == BORDER, BORDER, next_sides(start)[twin]))
    first = np.unique(group, return_index=True)[1]
    order = np.argsort(written[first], kind="stable")  # The vertices keep the order of the file.
    number = np.empty(len(first), dtype=np.int64)
    number[order] = np.arange(len(first))
    corner_vertex = number[group]
    pairs = np.unique(np.stack([corner_vertex, written], axis=1), axis=0)
    points = np.array(stitches.vertices)
    vertices = np.zeros((len(first), 3))
    np.add.at(vertices, pairs[:, 0], points[pairs[:, 1]])
    return vertices / np.bincount(pairs[:, 0])[:, None], corner_vertex


def _vertices_of_cell(stitches: JoinedStitches, written: IntArray) -> tuple[FloatArray, IntArray, IntArray]:
    """Return the vertices of one cell [cm], shape (V, 3), and the vertex and the lattice image of each corner."""
    count = len(stitches.vertices) - len(stitches.image_of)
    places = np.array([stitches.image_of.get(vertex, (vertex, 0, 0)) for vertex in range(len(stitches.vertices))])
    return np.array(stitches.vertices[:count]), places[written, 0], places[written, 1:]


def _with_marks(stitches: JoinedStitches, fabric: StitchMesh) -> StitchMesh:
    """Set rows, yarns and marks from the comments; without comments, number the rows in knitting order."""
    if not stitches.marks:
        return replace(fabric, row=_rows(fabric))
    sides = {name: np.zeros(fabric.side_count, dtype=np.int64) for name in PER_SIDE}
    row, yarn = np.zeros((2, fabric.face_count), dtype=np.int64)
    for line, face, (own_row, own_yarn, *marks) in stitches.marks:
        row[face], yarn[face] = own_row, own_yarn
        for place, *values in zip(*(marks[k::4] for k in range(4)), strict=True):
            side = int(fabric.face_start[face]) + place - 1
            if not fabric.face_start[face] <= side < fabric.face_start[face + 1]:
                raise ValueError(f"line {line}: side {place} has marks but does not exist")
            for name, value in zip(sides, values, strict=True):
                sides[name][side] = value
    return replace(fabric, row=row, yarn=yarn, **sides)  # type: ignore[arg-type]


def _rows(fabric: StitchMesh) -> IntArray:
    """Return the row of each face: one row for each course, in knitting order.

    Courses without a knitting order come last: they form a circle in which each lies above another one.
    """
    courses = find_courses(fabric)
    order, rest = knitting_order(courses_below(fabric, courses))
    number = np.empty(len(courses), dtype=np.int64)
    number[[*order, *rest]] = np.arange(len(courses))
    return number[course_of_faces(fabric, courses)]
