# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The lines of an ``.smobj`` file, read and checked; the module ``smobj`` describes them and makes the stitch mesh."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from os import fspath

from stitchmesh.errors import FileError, first_few
from stitchmesh.faces.face_type import STITCHES_OF_NAMES
from stitchmesh.io.contents import FilePath, is_coordinate, read_lines
from stitchmesh.mesh.stitch import Stitch

COMMENT_WORD = "#stitchmesh"
"""First word of the comments with data for which the format has no place."""
IGNORED_ELEMENTS = frozenset("N U c h vn vt vt2 tex tex2 usemtl mtllib".split())
"""First words of lines that do not concern a stitch mesh."""

_LABEL = re.compile(r"([+-])?([lyx])([0-9]+|X)?")
_FRAME = re.compile(r"(?P<below>(-l )*)(?P<right>[+-]?y) (?P<above>(\+l )*)(?P<left>[+-]?y) ")
_CONNECTION = re.compile(r"([0-9]{1,18})/(-?)([0-9]{1,18})")
_LARGEST_NUMBER = 2**31 - 1


@dataclass(frozen=True)
class FaceKind:
    """A kind of face: an ``L`` line."""

    stitch: Stitch
    n_bottom: int
    """Number of lower sides."""
    n_top: int
    """Number of upper sides."""


@dataclass
class SmobjContents:
    """The content of the lines that have been read so far. All numbers are counted from 0, except line numbers."""

    path: str
    """The file, for error messages."""
    kinds: list[FaceKind | str] = field(default_factory=list)
    """Kinds of faces; an unknown kind is its name, which is an error only if a face has this kind."""
    kind_line: list[int] = field(default_factory=list)
    """Line number of each kind."""
    vertices: list[tuple[float, float, float]] = field(default_factory=list)
    """Positions [cm], images of vertices included."""
    image_of: dict[int, tuple[int, int, int]] = field(default_factory=dict)
    """For each vertex that is a lattice image: the vertex in the cell, and the two lattice steps to the image."""
    periods: list[list[float]] | None = None
    """Lattice vectors [cm], shape (2, 3); None if the mesh is not periodic."""
    counts: tuple[int, int] | None = None
    """Numbers of faces and connections that a comment states."""
    faces: list[list[int]] = field(default_factory=list)
    """Vertices of each face."""
    face_line: list[int] = field(default_factory=list)
    """Line number of each face."""
    face_kind: list[int] = field(default_factory=list)
    """Kind of each face, as an index of ``kinds``."""
    connections: dict[tuple[int, int], tuple[int, int]] = field(default_factory=dict)
    """For each connected side, as face and place in the face: the other side of the same edge."""
    marks: list[tuple[int, list[int]]] = field(default_factory=list)
    """Face and numbers of each comment about a face."""

    def kinds_of_faces(self) -> list[FaceKind]:
        """Return the kind of each face; the file must have been read completely."""
        return [kind for kind in (self.kinds[index] for index in self.face_kind) if isinstance(kind, FaceKind)]

    def error(self, line: int, what: str) -> FileError:
        """Return the error of a line."""
        return FileError(f"{self.path}: line {line}: {what}")


def read_contents(path: FilePath) -> SmobjContents:
    """Read a file, and check each line and the consistency of all lines.

    Raises:
        FileError: the file is missing, a folder, empty, binary or malformed, the kind of a face is not a known stitch,
            or the labels of a face are not loops in, yarn, loops out, yarn. The message names the line.
    """
    contents = SmobjContents(fspath(path))
    for number, line in enumerate(read_lines(path), start=1):
        fields = line.partition("#")[0].split()
        if line.startswith(COMMENT_WORD):
            _read_comment(contents, number, line.split()[1:])
        elif fields:
            _read_line(contents, number, fields)
    _check_complete(contents)
    return contents


def _read_comment(contents: SmobjContents, number: int, fields: list[str]) -> None:
    """Read a comment that StitchMesh wrote."""
    try:
        if fields[0] == "lattice" and len(fields) == 7:
            contents.periods = [[float(x) for x in fields[1:4]], [float(x) for x in fields[4:]]]
        elif fields[0] == "counts" and len(fields) == 3:
            contents.counts = int(fields[1]), int(fields[2])
        elif fields[0] == "image" and len(fields) == 4:
            vertex, a, b = (_small_number(text) for text in fields[1:])
            contents.image_of[len(contents.vertices) - 1] = (vertex - 1, a, b)
        elif fields[0] == "face" and len(fields) >= 3 and len(fields) % 4 == 3:
            contents.marks.append((len(contents.faces) - 1, [_small_number(text) for text in fields[1:]]))
        else:
            raise ValueError
    except (ValueError, IndexError) as error:
        found = " ".join(fields)[:40]
        what = f"got {COMMENT_WORD} {found!r}; expected counts, lattice, image or face, and numbers"
        raise contents.error(number, what) from error


def _read_line(contents: SmobjContents, number: int, fields: list[str]) -> None:
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
    elif word not in IGNORED_ELEMENTS:
        what = f"unknown element {word[:20]!r}; expected an .smobj file of L, v, f, T and e lines"
        raise contents.error(number, what)


def _small_number(text: str) -> int:
    """Return a whole number of a comment, such as a row or a lattice step.

    Raises:
        ValueError: it is no whole number, or too large to count anything.
    """
    number = int(text)
    if abs(number) > _LARGEST_NUMBER:
        raise ValueError(f"{text[:20]} is too large")
    return number


def _read_kind(contents: SmobjContents, number: int, fields: list[str]) -> None:
    """Read an ``L`` line."""
    name, labels = fields[1] if len(fields) > 1 else "", fields[2:]
    matches = [_LABEL.fullmatch(label) for label in labels]
    if len(labels) < 3 or not all(matches):
        found = " ".join(fields)[:60]
        raise contents.error(number, f"got {found!r}; expected L, a name and at least three labels such as -l1 or +y1")
    contents.kind_line.append(number)
    stitch = STITCHES_OF_NAMES.get(name)
    if stitch is None:
        contents.kinds.append(name)
        return
    shape = _FRAME.fullmatch(" ".join((match[1] or "") + match[2] for match in matches if match) + " ")
    if shape is None or shape["right"] == shape["left"] != "y":
        found = " ".join(labels)[:60]
        expected = "loops in (-l), yarn (y), loops out (+l), yarn, counter-clockwise from the lower left"
        raise contents.error(number, f"{name}: got sides {found}; expected {expected}")
    contents.kinds.append(FaceKind(stitch, shape["below"].count("l"), shape["above"].count("l")))


def _position(contents: SmobjContents, number: int, fields: list[str]) -> tuple[float, float, float]:
    try:
        x, y, z = (float(text) for text in fields[1:])
    except ValueError as error:
        found = " ".join(fields)[:40]
        raise contents.error(number, f"got {found!r}; expected 'v x y z' with three numbers") from error
    if not all(map(is_coordinate, (x, y, z))):
        raise contents.error(number, f"got {' '.join(fields)[:40]!r}; coordinates must be finite")
    return x, y, z


def _corners(contents: SmobjContents, number: int, fields: list[str]) -> list[int]:
    try:
        corners = [int(text.partition("/")[0]) for text in fields[1:]]
    except ValueError as error:
        raise contents.error(number, f"got {' '.join(fields)[:40]!r}; expected 'f' and vertex numbers") from error
    count = len(contents.vertices)
    if len(corners) < 3:
        raise contents.error(number, f"got a face of {len(corners)} corners; expected at least 3")
    for vertex in corners:
        if not 1 <= vertex <= count:
            raise contents.error(number, f"vertex {vertex} does not exist; {count} vertices come before this line")
    return [vertex - 1 for vertex in corners]


def _close_face(contents: SmobjContents, number: int) -> None:
    """Check that the last face has a kind."""
    if len(contents.face_kind) < len(contents.faces):
        line = contents.face_line[-1]
        raise contents.error(number, f"the face of line {line} has no T line; every face needs its kind")


def _read_type(contents: SmobjContents, number: int, fields: list[str]) -> None:
    """Read a ``T`` line, the kind of the last face."""
    try:
        kind = int(fields[1])
    except (IndexError, ValueError) as error:
        raise contents.error(number, f"got {' '.join(fields)[:40]!r}; expected 'T' and a number") from error
    if not 1 <= kind <= len(contents.kinds):
        raise contents.error(number, f"kind {kind} does not exist; {len(contents.kinds)} L lines come before this line")
    if len(contents.face_kind) != len(contents.faces) - 1:
        raise contents.error(number, "a T line without a face of its own; expected one after each f line")
    contents.face_kind.append(kind - 1)


def _read_connection(contents: SmobjContents, number: int, fields: list[str]) -> None:
    """Read an ``e`` line, two sides that are the same edge."""
    ends = [_CONNECTION.fullmatch(text) for text in fields[1:]]
    if len(ends) != 2 or ends[0] is None or ends[1] is None:
        raise contents.error(number, f"got {' '.join(fields)[:40]!r}; expected 'e face/side face/-side'")
    first, second = ((int(end[1]) - 1, int(end[3]) - 1) for end in ends if end)
    for face, side in (first, second):
        if not 0 <= face < len(contents.faces):
            raise contents.error(number, f"face {face + 1} does not exist; the file has {len(contents.faces)} so far")
        if not 0 <= side < len(contents.faces[face]):
            sides = len(contents.faces[face])
            raise contents.error(number, f"side {side + 1} of face {face + 1} does not exist; it has {sides} sides")
        if (face, side) in contents.connections:
            raise contents.error(number, f"side {side + 1} of face {face + 1} is joined twice; an edge has two sides")
    if bool(ends[0][2]) == bool(ends[1][2]):
        what = "joins two sides of the same direction; on an oriented surface exactly one of them is negative"
        raise contents.error(number, what)
    contents.connections[first], contents.connections[second] = second, first


def _check_complete(contents: SmobjContents) -> None:
    """Check the consistency of all lines."""
    if not contents.faces:
        raise FileError(f"{contents.path}: got no faces; expected an .smobj file of L, v, f, T and e lines")
    _close_face(contents, contents.face_line[-1])
    found = len(contents.faces), len(contents.connections) // 2
    if contents.counts is not None and contents.counts != found:
        what = f"got {found[0]} faces and {found[1]} connections of {contents.counts[0]} and {contents.counts[1]}"
        raise FileError(f"{contents.path}: {what}; the file was cut short")
    names = [contents.kinds[kind] for kind in contents.face_kind]
    unknown = sorted({name for name in names if isinstance(name, str)})
    if unknown:
        line = contents.kind_line[contents.kinds.index(unknown[0])]
        what = f"no known stitch has the face name {first_few(unknown, 8)}; rename the kind in its L line"
        raise contents.error(line, what)
    for face, kind in enumerate(contents.kinds_of_faces()):
        sides = kind.n_bottom + kind.n_top + 2
        if sides != len(contents.faces[face]):
            what = f"got {len(contents.faces[face])} corners; its kind has {sides} sides"
            raise contents.error(contents.face_line[face], what)
