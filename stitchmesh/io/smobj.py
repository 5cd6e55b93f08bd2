# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitch meshes from and to ``.smobj``, the text format of augmented stitch meshes (github.com/textiles-lab/smobj).

``L name labels`` names a kind of face and its sides counter-clockwise from the lower left: ``l`` for loops, ``y`` for
yarn, ``+`` out of the face, ``-`` into it. ``v x y z`` is a vertex, ``f`` a face by its vertices, ``T`` its kind, ``e``
a pair of sides that are one edge, the second of them reversed; all count from 1. Vertices may be repeated: only ``e``
lines join faces.

Faces have the names of the library ``illustration.sf`` where it has them, and names in its style elsewhere
(``FACE_NAMES``). What other readers have no place for stands in comments, which they pass over: the row and yarn of a
face, twisted loops, cables, the periods of a lattice. Stretch is not written.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field, replace
from os import fspath

import numpy as np

from stitchmesh.courses import course_of_faces, courses_below, find_courses, knitting_order
from stitchmesh.errors import FileError, StitchMeshError, first_few
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, read_lines
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.stitch import VOCABULARY, Stitch

OWN = "#stitchmesh"
"""First word of the comments that carry what the format has no place for."""
PASSED_OVER = frozenset("N U c h vn vt vt2 tex tex2 usemtl mtllib".split())
"""Lines that say nothing about a stitch mesh."""
EMPTY_BELOW = frozenset({Stitch.CAST_ON})
EMPTY_ABOVE = frozenset({Stitch.DRAW_THROUGH, Stitch.BIND_OFF})
"""Stitches whose course sides no loop of theirs crosses: label ``l0``."""

FACE_NAMES: dict[Stitch, str] = {
    **{stitch: f"make-{making.code}+" for stitch, making in VOCABULARY.items() if making.n_top > 1},
    **{stitch: f"decrease-{making.code[1:]}+" for stitch, making in VOCABULARY.items() if making.n_bottom > 1},
    Stitch.PANEL: "panel+",
    Stitch.CAST_ON: "tuck-twist+",
    Stitch.BIND_OFF: "bind-off+",
    Stitch.DRAW_THROUGH: "draw-through+",
    Stitch.KNIT: "knit+",
    Stitch.PURL: "purl+",
    Stitch.YARN_OVER: "tuck+",
    Stitch.SLIP_BACK: "slip-back+",
    Stitch.SLIP_FRONT: "slip-front+",
    Stitch.WRAP: "slip-wrap+",
    Stitch.KY: "make-right-tuck+",
    Stitch.YK: "make-left-tuck+",
    Stitch.KS: "make-left-split+",
    Stitch.SK: "make-right-split+",
    Stitch.D12K: "decrease-right+",
    Stitch.D21K: "decrease-left+",
}  # fmt: skip
"""Name of each stitch as a face; ``+`` says that its row runs from left to right."""

KNITOUT_NAMES = {"knit-to-left": Stitch.KNIT, "knit-to-right": Stitch.KNIT,
                 "purl-to-left": Stitch.PURL, "purl-to-right": Stitch.PURL}  # fmt: skip
"""Names of the library ``knitout.sf`` that are stitches of ours."""

_STITCHES = {
    **{name: stitch for stitch, name in FACE_NAMES.items()},
    **{name[:-1] + "-": stitch for stitch, name in FACE_NAMES.items()},
    **KNITOUT_NAMES,
}
_LABEL = re.compile(r"([+-])?([lyx])([0-9]+|X)?")
_FRAME = re.compile(r"(?P<below>(-l )*)(?P<right>[+-]?y) (?P<above>(\+l )*)(?P<left>[+-]?y) ")
_CONNECTION = re.compile(r"([0-9]+)/(-?)([0-9]+)")


@dataclass(frozen=True)
class _Kind:
    """A line of the library."""

    stitch: Stitch
    n_bottom: int
    n_top: int


@dataclass
class _Contents:
    """What a file holds, as far as it has been read."""

    path: str
    kinds: list[_Kind | str] = field(default_factory=list)
    """A name instead of a kind where it is unknown; an error only if a face has it."""
    kind_line: list[int] = field(default_factory=list)
    vertices: list[tuple[float, float, float]] = field(default_factory=list)
    image_of: dict[int, tuple[int, int, int]] = field(default_factory=dict)
    periods: list[list[float]] | None = None
    counts: tuple[int, int] | None = None
    """Faces and connections that the file should have."""
    faces: list[list[int]] = field(default_factory=list)
    face_line: list[int] = field(default_factory=list)
    face_kind: list[int] = field(default_factory=list)
    joined: dict[tuple[int, int], tuple[int, int]] = field(default_factory=dict)
    marks: list[tuple[int, list[int]]] = field(default_factory=list)
    """Face and numbers of each comment about one."""

    def bad(self, line: int, what: str) -> FileError:
        return FileError(f"{self.path}: line {line}: {what}")


def write_smobj(path: FilePath, fabric: StitchMesh) -> None:
    """Write a stitch mesh with every digit that its coordinates need.

    Raises:
        FileError: the file cannot be written.
    """
    labels = [_labels(fabric, face) for face in range(fabric.face_count)]
    library = {kind: number for number, kind in enumerate(dict.fromkeys(labels), start=1)}
    inner = int((fabric.twin != BORDER).sum()) // 2
    lines = ["# stitch mesh, lengths in cm", f"{OWN} counts {fabric.face_count} {inner}"]
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
    """Read a stitch mesh; rows that the file does not number are numbered in knitting order.

    Raises:
        FileError: the file is missing, a folder, empty, binary or malformed, a face is no stitch of ours or its
            labels do not form our frame, or the faces do not form a stitch mesh. The message names the line.
    """
    contents = _Contents(fspath(path))
    for number, line in enumerate(read_lines(path), start=1):
        fields = line.partition("#")[0].split()
        if line.startswith(OWN):
            _read_own(contents, number, line.split()[1:])
        elif fields:
            _read_line(contents, number, fields)
    _check_whole(contents)
    try:
        return _stitch_mesh(contents)
    except FileError:
        raise
    except (StitchMeshError, ValueError, IndexError) as error:
        raise FileError(f"{contents.path}: {error}") from error


def _labels(fabric: StitchMesh, face: int) -> str:
    """Name and labels of a face's kind."""
    stitch = Stitch(int(fabric.stitch[face]))
    below = ["-l0" if stitch in EMPTY_BELOW else "-l1"] * int(fabric.n_bottom[face])
    above = ["+l0" if stitch in EMPTY_ABOVE else "+l1"] * int(fabric.n_top[face])
    return " ".join([FACE_NAMES[stitch], *below, "+y1", *above, "-y1"])


def _lattice_lines(fabric: StitchMesh) -> list[str]:
    if fabric.lattice is None:
        return []
    return [f"{OWN} lattice " + " ".join(repr(float(x)) for x in np.ravel(fabric.lattice.periods))]


def _vertex_lines(fabric: StitchMesh) -> tuple[list[str], list[int]]:
    """Lines of the vertices and their lattice images, and the vertex of each corner, counted from 1."""
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
            lines += [f"v {x!r} {y!r} {z!r}", f"{OWN} image {vertex + 1} {key[1]} {key[2]}"]
        corners.append(numbers[key])
    return lines, corners


def _mark_lines(fabric: StitchMesh) -> list[str]:
    """The comment of each face: row, yarn, then place, twist, shift and layer of each marked side."""
    lines = [f"{OWN} face {row} {yarn}" for row, yarn in zip(fabric.row.tolist(), fabric.yarn.tolist(), strict=True)]
    marked = np.flatnonzero((fabric.twist != 0) | (fabric.cable_shift != 0) | (fabric.cable_layer != 0))
    for side in marked.tolist():
        marks = fabric.twist[side], fabric.cable_shift[side], fabric.cable_layer[side]
        lines[fabric.side_face[side]] += f" {fabric.side_place[side] + 1} " + " ".join(map(str, marks))
    return lines


def _read_own(contents: _Contents, number: int, fields: list[str]) -> None:
    """A comment that StitchMesh wrote."""
    try:
        if fields[0] == "lattice" and len(fields) == 7:
            contents.periods = [[float(x) for x in fields[1:4]], [float(x) for x in fields[4:]]]
        elif fields[0] == "counts" and len(fields) == 3:
            contents.counts = int(fields[1]), int(fields[2])
        elif fields[0] == "image" and len(fields) == 4:
            vertex, a, b = (int(text) for text in fields[1:])
            contents.image_of[len(contents.vertices) - 1] = (vertex - 1, a, b)
        elif fields[0] == "face" and len(fields) >= 3 and len(fields) % 4 == 3:
            contents.marks.append((len(contents.faces) - 1, [int(text) for text in fields[1:]]))
        else:
            raise ValueError
    except (ValueError, IndexError) as error:
        found = " ".join(fields)[:40]
        what = f"got {OWN} {found!r}; expected counts, lattice, image or face, and numbers"
        raise contents.bad(number, what) from error


def _read_line(contents: _Contents, number: int, fields: list[str]) -> None:
    word = fields[0]
    if word == "L":
        _read_kind(contents, number, fields)
    elif word == "v":
        contents.vertices.append(_position(contents, number, fields))
    elif word == "f":
        _close_face(contents, number)
        contents.faces.append(_corners(contents, number, fields))
        contents.face_line.append(number)
    elif word == "T":
        _read_type(contents, number, fields)
    elif word == "e":
        _read_connection(contents, number, fields)
    elif word not in PASSED_OVER:
        raise contents.bad(number, f"unknown element {word[:20]!r}; expected an .smobj file of L, v, f, T and e lines")


def _read_kind(contents: _Contents, number: int, fields: list[str]) -> None:
    name, labels = fields[1] if len(fields) > 1 else "", fields[2:]
    matches = [_LABEL.fullmatch(label) for label in labels]
    if len(labels) < 3 or not all(matches):
        found = " ".join(fields)[:60]
        raise contents.bad(number, f"got {found!r}; expected L, a name and at least three labels such as -l1 or +y1")
    contents.kind_line.append(number)
    stitch = _STITCHES.get(name)
    if stitch is None:
        contents.kinds.append(name)
        return
    shape = _FRAME.fullmatch(" ".join((match[1] or "") + match[2] for match in matches if match) + " ")
    if shape is None or shape["right"] == shape["left"] != "y":
        found = " ".join(labels)[:60]
        expected = "loops in (-l), yarn (y), loops out (+l), yarn, counter-clockwise from the lower left"
        raise contents.bad(number, f"{name}: got sides {found}; expected {expected}")
    contents.kinds.append(_Kind(stitch, shape["below"].count("l"), shape["above"].count("l")))


def _position(contents: _Contents, number: int, fields: list[str]) -> tuple[float, float, float]:
    try:
        x, y, z = (float(text) for text in fields[1:])
    except ValueError as error:
        found = " ".join(fields)[:40]
        raise contents.bad(number, f"got {found!r}; expected 'v x y z' with three numbers") from error
    if not all(map(math.isfinite, (x, y, z))):
        raise contents.bad(number, f"got {' '.join(fields)[:40]!r}; coordinates must be finite")
    return x, y, z


def _corners(contents: _Contents, number: int, fields: list[str]) -> list[int]:
    try:
        corners = [int(text.partition("/")[0]) for text in fields[1:]]
    except ValueError as error:
        raise contents.bad(number, f"got {' '.join(fields)[:40]!r}; expected 'f' and vertex numbers") from error
    count = len(contents.vertices)
    if len(corners) < 3:
        raise contents.bad(number, f"got a face of {len(corners)} corners; expected at least 3")
    for vertex in corners:
        if not 1 <= vertex <= count:
            raise contents.bad(number, f"vertex {vertex} does not exist; {count} vertices come before this line")
    return [vertex - 1 for vertex in corners]


def _close_face(contents: _Contents, number: int) -> None:
    if len(contents.face_kind) < len(contents.faces):
        line = contents.face_line[-1]
        raise contents.bad(number, f"the face of line {line} has no T line; every face needs its kind")


def _read_type(contents: _Contents, number: int, fields: list[str]) -> None:
    try:
        kind = int(fields[1])
    except (IndexError, ValueError) as error:
        raise contents.bad(number, f"got {' '.join(fields)[:40]!r}; expected 'T' and a number") from error
    if not 1 <= kind <= len(contents.kinds):
        raise contents.bad(number, f"kind {kind} does not exist; {len(contents.kinds)} L lines come before this line")
    if len(contents.face_kind) != len(contents.faces) - 1:
        raise contents.bad(number, "a T line without a face of its own; expected one after each f line")
    contents.face_kind.append(kind - 1)


def _read_connection(contents: _Contents, number: int, fields: list[str]) -> None:
    ends = [_CONNECTION.fullmatch(text) for text in fields[1:]]
    if len(ends) != 2 or ends[0] is None or ends[1] is None:
        raise contents.bad(number, f"got {' '.join(fields)[:40]!r}; expected 'e face/side face/-side'")
    first, second = ((int(end[1]) - 1, int(end[3]) - 1) for end in ends if end)
    for face, side in (first, second):
        if not 0 <= face < len(contents.faces):
            raise contents.bad(number, f"face {face + 1} does not exist; the file has {len(contents.faces)} so far")
        if not 0 <= side < len(contents.faces[face]):
            sides = len(contents.faces[face])
            raise contents.bad(number, f"side {side + 1} of face {face + 1} does not exist; it has {sides} sides")
        if (face, side) in contents.joined:
            raise contents.bad(number, f"side {side + 1} of face {face + 1} is joined twice; an edge has two sides")
    if bool(ends[0][2]) == bool(ends[1][2]):
        what = "joins two sides that run the same way; on an oriented surface exactly one of them is negative"
        raise contents.bad(number, what)
    contents.joined[first], contents.joined[second] = second, first


def _check_whole(contents: _Contents) -> None:
    """What can only be told when all lines have been read."""
    if not contents.faces:
        raise FileError(f"{contents.path}: got no faces; expected an .smobj file of L, v, f, T and e lines")
    _close_face(contents, contents.face_line[-1])
    found = len(contents.faces), len(contents.joined) // 2
    if contents.counts is not None and contents.counts != found:
        what = f"got {found[0]} faces and {found[1]} connections of {contents.counts[0]} and {contents.counts[1]}"
        raise FileError(f"{contents.path}: {what}; the file was cut short")
    names = [contents.kinds[kind] for kind in contents.face_kind]
    unknown = sorted({name for name in names if isinstance(name, str)})
    if unknown:
        line = contents.kind_line[contents.kinds.index(unknown[0])]
        what = f"no stitch of ours has the face name {first_few(unknown, 8)}; rename it in the library"
        raise contents.bad(line, what)
    for face, kind in enumerate(_kinds(contents)):
        sides = kind.n_bottom + kind.n_top + 2
        if sides != len(contents.faces[face]):
            what = f"got {len(contents.faces[face])} corners; its kind has {sides} sides"
            raise contents.bad(contents.face_line[face], what)


def _kinds(contents: _Contents) -> list[_Kind]:
    return [kind for kind in (contents.kinds[index] for index in contents.face_kind) if isinstance(kind, _Kind)]


def _stitch_mesh(contents: _Contents) -> StitchMesh:
    start = np.concatenate([[0], np.cumsum([len(face) for face in contents.faces])])
    twin = np.full(start[-1], BORDER)
    for (face, side), (other, across) in contents.joined.items():
        twin[start[face] + side] = start[other] + across
    written = np.array([vertex for face in contents.faces for vertex in face])
    if contents.periods is None:
        vertices, corner_vertex = _merged(contents, written, start, twin)
        lattice, images = None, None
    else:
        lattice = Lattice(np.array(contents.periods))
        vertices, corner_vertex, images = _on_lattice(contents, written)
    kinds = _kinds(contents)
    fabric = StitchMesh(
        vertices, start, corner_vertex, twin, lattice=lattice, corner_image=images,
        n_bottom=[kind.n_bottom for kind in kinds],  # type: ignore[arg-type]
        n_top=[kind.n_top for kind in kinds],  # type: ignore[arg-type]
        stitch=[kind.stitch for kind in kinds],  # type: ignore[arg-type]
        row=np.zeros(len(kinds), dtype=np.int64),
    )  # fmt: skip
    return _with_marks(contents, fabric)


def _merged(contents: _Contents, written: IntArray, start: IntArray, twin: IntArray) -> tuple[FloatArray, IntArray]:
    """Vertices, one for all corners that connections bring together, and the vertex of each corner.

    A merged vertex has the mean of the positions that it was written with, exactly that one if there is only one.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = len(written)
    following = np.arange(1, count + 1)
    following[start[1:] - 1] = start[:-1]
    inner = np.flatnonzero(twin != BORDER)
    links = coo_array((np.ones(len(inner)), (inner, following[twin[inner]])), shape=(count, count))
    _, group = connected_components(links.tocsr(), directed=False)
    first = np.unique(group, return_index=True)[1]
    order = np.argsort(written[first], kind="stable")  # vertices keep the order they were written in
    number = np.empty(len(first), dtype=np.int64)
    number[order] = np.arange(len(first))
    corner_vertex = number[group]
    pairs = np.unique(np.stack([corner_vertex, written], axis=1), axis=0)
    points = np.array(contents.vertices)
    vertices = np.zeros((len(first), 3))
    np.add.at(vertices, pairs[:, 0], points[pairs[:, 1]])
    return vertices / np.bincount(pairs[:, 0])[:, None], corner_vertex


def _on_lattice(contents: _Contents, written: IntArray) -> tuple[FloatArray, IntArray, IntArray]:
    """Vertices of one cell, the vertex of each corner, and its image."""
    count = len(contents.vertices) - len(contents.image_of)
    places = np.array([contents.image_of.get(vertex, (vertex, 0, 0)) for vertex in range(len(contents.vertices))])
    return np.array(contents.vertices[:count]), places[written, 0], places[written, 1:]


def _with_marks(contents: _Contents, fabric: StitchMesh) -> StitchMesh:
    """Rows, yarns and marks from the comments; rows in knitting order where there are none."""
    if not contents.marks:
        return replace(fabric, row=_rows(fabric))
    sides = {name: np.zeros(fabric.side_count, dtype=np.int64) for name in ("twist", "cable_shift", "cable_layer")}
    row, yarn = np.zeros((2, fabric.face_count), dtype=np.int64)
    for face, (own_row, own_yarn, *marks) in contents.marks:
        row[face], yarn[face] = own_row, own_yarn
        for place, *values in zip(*(marks[k::4] for k in range(4)), strict=True):
            side = int(fabric.face_start[face]) + place - 1
            if not fabric.face_start[face] <= side < fabric.face_start[face + 1]:
                raise contents.bad(contents.face_line[face], f"side {place} has marks but does not exist")
            for name, value in zip(sides, values, strict=True):
                sides[name][side] = value
    return replace(fabric, row=row, yarn=yarn, **sides)  # type: ignore[arg-type]


def _rows(fabric: StitchMesh) -> IntArray:
    """A row for each course, in knitting order; courses that stand on each other in a circle come last."""
    courses = find_courses(fabric)
    order, rest = knitting_order(courses_below(fabric, courses))
    number = np.empty(len(courses), dtype=np.int64)
    number[[*order, *rest]] = np.arange(len(courses))
    return number[course_of_faces(fabric, courses)]
