# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Face meshes in ``.smobj`` files (github.com/textiles-lab/smobj): every record of the format is read and written.

Beside the lines that the module ``smobj`` describes, a file may hold the following ones, with all numbers from 1:

- ``N line``: the line of the knitting program that made the last face, 0 if it is unknown.
- ``e face/side face/side`` without a minus sign: a join whose sides run in the same direction.
- ``h face/side needle``, ``o``, ``I`` and ``ci`` (orders of instructions), ``xfer`` and ``t face variant``: hints for a
  machine. Instructions of no face are numbered with face 0 or with faces beyond the last one.
- ``U name length``: a unit of yarn length. The first one is named 1 and has the length 1.
- ``c face/side/crossing factor unit factor unit ...``: a checkpoint on a yarn, and the length to the next one.
- ``vt``, ``vn``, ``tex`` and the like: texture.

Comments are not kept, except for those with data of a stitch mesh (``OwnComment``). Faces may share vertices or not;
only ``e`` lines join faces.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from os import fspath

import numpy as np

from stitchmesh.errors import FileError, MeshError
from stitchmesh.faces.face_mesh import Checkpoint, FaceMesh, Record
from stitchmesh.faces.face_type import FaceType, is_foreign
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, is_coordinate, read_lines

HINTS = ("h", "o", "t", "I", "ci", "xfer")
"""First words of hints for a machine."""
TEXTURE = ("vt", "vt2", "vn", "tex", "tex2", "usemtl", "mtllib")
"""First words of records of texture."""
COMMENT_WORD = "#stitchmesh"
"""First word of the comments with data of a stitch mesh for which the format has no place."""
UNKNOWN_SOURCE = -1
"""Source line of a face without an ``N`` line."""
_PLACE = re.compile(r"([0-9]{1,9})/(-?)([0-9]{1,9})")
_CHECKPOINT = re.compile(r"([0-9]{1,9})/([0-9]{1,9})/([0-9]{1,9})")


@dataclass(frozen=True)
class OwnComment:
    """A comment with data of a stitch mesh, and where it stands."""

    line: int
    """Line number, counted from 1."""
    vertex: int
    """The last vertex before the comment, counted from 0."""
    face: int
    """The last face before the comment, counted from 0."""
    words: tuple[str, ...]
    """The words after the first one."""


@dataclass(frozen=True, eq=False)
class SurfaceRecords:
    """The faces and joins of a file, and where they stand in it."""

    mesh: FaceMesh
    """The faces, without hints, checkpoints and texture."""
    comments: Sequence[OwnComment]
    """The comments about a stitch mesh."""
    type_line: Sequence[int]
    """Line number of each type of face, counted from 1."""
    join_line: Sequence[int]
    """Line number of each join, counted from 1."""


@dataclass
class _Reading:
    """What has been read so far; numbers are counted from 0."""

    path: str
    surface_only: bool
    """Whether records that do not describe faces and their joins are left out unread."""
    line: int = 0
    """Number of the line that is read, counted from 1."""
    comments: list[OwnComment] = field(default_factory=list)
    type_line: list[int] = field(default_factory=list)
    join_line: list[int] = field(default_factory=list)
    types: list[FaceType] = field(default_factory=list)
    vertices: list[list[float]] = field(default_factory=list)
    face_vertex: list[int] = field(default_factory=list)
    corner_texture: list[str] = field(default_factory=list)
    face_start: list[int] = field(default_factory=lambda: [0])
    face_type: list[int] = field(default_factory=list)
    source_line: list[int] = field(default_factory=list)
    joins: list[tuple[int, int]] = field(default_factory=list)
    joined: set[int] = field(default_factory=set)
    reverses: list[bool] = field(default_factory=list)
    hints: list[Record] = field(default_factory=list)
    units: list[tuple[str, float]] = field(default_factory=list)
    checkpoints: list[Checkpoint] = field(default_factory=list)
    texture: list[Record] = field(default_factory=list)

    @property
    def face_count(self) -> int:
        """Number of faces so far."""
        return len(self.face_start) - 1

    def side(self, face: str, side: str) -> tuple[int, int]:
        """Return a face and one of its sides, both counted from 0.

        Raises:
            ValueError: there is no such side.
        """
        f, s = int(face) - 1, int(side) - 1
        if not 0 <= f < self.face_count:
            raise ValueError(f"face {face} does not exist; {self.face_count} faces come before this line")
        count = self.face_start[f + 1] - self.face_start[f]
        if not 0 <= s < count:
            raise ValueError(f"side {side} of face {face} does not exist; it has {count} sides")
        return f, s


def read_face_mesh(path: FilePath) -> FaceMesh:
    """Read a mesh of faces of any type.

    Raises:
        FileError: the file is missing, a folder, empty, binary or malformed. The message names the line.
    """
    return _face_mesh(_records(path, surface_only=False))


def read_surface(path: FilePath) -> SurfaceRecords:
    """Read the faces and joins of a file, and its comments about a stitch mesh; other records are left out unread.

    Raises:
        FileError: as for ``read_face_mesh``.
    """
    reading = _records(path, surface_only=True)
    return SurfaceRecords(_face_mesh(reading), reading.comments, reading.type_line, reading.join_line)


def _records(path: FilePath, *, surface_only: bool) -> _Reading:
    reading = _Reading(fspath(path), surface_only)
    for number, line in enumerate(read_lines(path), start=1):
        words = line.partition("#")[0].split()
        reading.line = number
        if line.startswith(COMMENT_WORD):
            place = number, len(reading.vertices) - 1, reading.face_count - 1
            reading.comments.append(OwnComment(*place, tuple(line.split()[1:])))
        elif words:
            try:
                _read_record(reading, words)
            except ValueError as error:
                found = " ".join(words)[:60]
                raise FileError(f"{reading.path}: line {number}: got {found!r}; {error}") from error
    return reading


def holds_foreign_faces(path: FilePath) -> bool:
    """Return whether a face of a file is no stitch; a malformed record is no face.

    Raises:
        FileError: the file is missing, a folder, empty or binary.
    """
    lines = [line.partition("#")[0].split() for line in read_lines(path)]
    types = [FaceType(words[1], tuple(words[2:])) for words in lines if words[:1] == ["L"] and len(words) > 4]
    used = {words[1] for words in lines if words[:1] == ["T"] and len(words) == 2}
    return any(str(number) in used and is_foreign(kind) for number, kind in enumerate(types, start=1))


def _face_mesh(reading: _Reading) -> FaceMesh:
    if not reading.face_count:
        raise FileError(f"{reading.path}: got no faces; expected an .smobj file of L, v, f, T and e lines")
    if len(reading.face_type) < reading.face_count:
        raise FileError(f"{reading.path}: face {reading.face_count} has no T line; every face needs its type")
    has_texture = any(reading.corner_texture)
    try:
        return FaceMesh(
            types=tuple(reading.types), vertices=np.array(reading.vertices), face_start=np.array(reading.face_start),
            face_vertex=np.array(reading.face_vertex), face_type=np.array(reading.face_type),
            source_line=np.array(reading.source_line), joins=np.array(reading.joins, dtype=np.int64),
            reverses=np.array(reading.reverses, dtype=np.bool_), hints=tuple(reading.hints),
            units=tuple(reading.units), checkpoints=tuple(reading.checkpoints), texture=tuple(reading.texture),
            corner_texture=tuple(reading.corner_texture) if has_texture else (),
        )  # fmt: skip
    except MeshError as error:
        raise FileError(f"{reading.path}: {error} (counted from 0)") from error


def _read_record(reading: _Reading, words: Sequence[str]) -> None:
    """Read the words of a line.

    Raises:
        ValueError: the words are no record of the format; the message says what was expected.
    """
    known = words[0] in HINTS or words[0] in TEXTURE or words[0] in _READERS
    if known and reading.surface_only and words[0] not in ("L", "v", "f", "T", "e"):
        return
    if words[0] in HINTS:
        reading.hints.append(_hint(reading, words))
    elif words[0] in TEXTURE:
        reading.texture.append(tuple(words))
    elif known:
        _READERS[words[0]](reading, words[1:])
    else:
        raise ValueError("expected a record of an .smobj file: L, v, f, T, N, e, h, o, t, I, U or c")


def _read_type(reading: _Reading, words: Sequence[str]) -> None:
    if len(words) < 4:
        raise ValueError("expected L, a name and at least three labels such as -l1 or +y1")
    reading.types.append(FaceType(words[0], tuple(words[1:])))
    reading.type_line.append(reading.line)


def _read_vertex(reading: _Reading, words: Sequence[str]) -> None:
    if len(words) != 3:
        raise ValueError("expected 'v x y z' with three numbers")
    place = _numbers(words, "expected 'v x y z' with three numbers")
    if not all(map(is_coordinate, place)):
        raise ValueError("coordinates must be finite")
    reading.vertices.append(place)


def _read_face(reading: _Reading, words: Sequence[str]) -> None:
    if len(reading.face_type) < reading.face_count:
        raise ValueError("the face before has no T line; every face needs its type")
    if len(words) < 3:
        raise ValueError("expected at least 3 corners")
    count = len(reading.vertices)
    for word in words:
        vertex, slash, texture = word.partition("/")
        number = _whole(vertex, "expected 'f' and vertex numbers")
        number = number - 1 if number > 0 else count + number
        if not 0 <= number < count:
            raise ValueError(f"vertex {vertex} does not exist; {count} vertices come before this line")
        reading.face_vertex.append(number)
        reading.corner_texture.append(slash + texture)
    reading.face_start.append(len(reading.face_vertex))


def _read_face_type(reading: _Reading, words: Sequence[str]) -> None:
    number = _whole(words[0], "expected 'T' and a number") if len(words) == 1 else 0
    if not 1 <= number <= len(reading.types):
        raise ValueError(f"expected a number of the {len(reading.types)} L lines before this line")
    if len(reading.face_type) != reading.face_count - 1:
        raise ValueError("expected one T line after each f line")
    kind, corners = reading.types[number - 1], reading.face_start[-1] - reading.face_start[-2]
    if len(kind.labels) != corners:
        raise ValueError(f"the face has {corners} corners and its type {kind.name} has {len(kind.labels)} sides")
    reading.face_type.append(number - 1)
    reading.source_line.append(UNKNOWN_SOURCE)


def _read_source(reading: _Reading, words: Sequence[str]) -> None:
    number = _whole(words[0], "expected 'N' and a line") if len(words) == 1 else -1
    if number < 0 or len(reading.source_line) != reading.face_count or not reading.face_count:
        raise ValueError("expected 'N' and a line number from 0, after the T line of a face")
    reading.source_line[-1] = number


def _read_join(reading: _Reading, words: Sequence[str]) -> None:
    places = [_PLACE.fullmatch(word) for word in words]
    if len(places) != 2 or places[0] is None or places[1] is None:
        raise ValueError("expected 'e face/side face/-side'")
    ends = [reading.side(place[1], place[3]) for place in places if place]
    first, second = (reading.face_start[face] + side for face, side in ends)
    for end, (face, side) in zip((first, second), ends, strict=True):
        if end in reading.joined:
            raise ValueError(f"side {side + 1} of face {face + 1} is joined twice; an edge has two sides")
        reading.joined.add(end)
    reading.joins.append((first, second))
    reading.join_line.append(reading.line)
    reading.reverses.append(bool(places[0][2]) != bool(places[1][2]))


def _hint(reading: _Reading, words: Sequence[str]) -> Record:
    """Return a hint. The face of ``h`` and ``t`` exists; other hints may name face 0 or faces beyond the last one."""
    if words[0] == "xfer":
        return tuple(words)
    face, _, side = words[1].partition("/") if len(words) > 1 else ("", "", "")
    number = _whole(face, f"expected {words[0]!r} and a face")
    if side:
        _whole(side, "expected a face, or a face and a number such as 3/1")
    if words[0] == "h":
        reading.side(face, side or "0")
    elif words[0] == "t" and not 1 <= number <= reading.face_count:
        raise ValueError(f"face {face} does not exist; {reading.face_count} faces come before this line")
    return tuple(words)


def _read_unit(reading: _Reading, words: Sequence[str]) -> None:
    if len(words) != 2:
        raise ValueError("expected 'U name length'")
    length = _numbers(words[1:], "expected 'U name length'")[0]
    if not 0 <= length or not is_coordinate(length):
        raise ValueError("expected a length from 0")
    if not reading.units and (words[0], length) != ("1", 1.0):
        raise ValueError("expected 'U 1 1' first: the first unit is named 1 and has the length 1")
    reading.units.append((words[0], length))


def _read_checkpoint(reading: _Reading, words: Sequence[str]) -> None:
    place = _CHECKPOINT.fullmatch(words[0]) if words else None
    if place is None or place[3] == "0" or len(words) % 2 == 0:
        raise ValueError("expected 'c face/side/crossing' and pairs of a factor and a unit")
    face, side = reading.side(place[1], place[2])
    factors = _numbers(words[1::2], "expected pairs of a factor and the number of a unit")
    units = [_whole(word, "expected the number of a unit") for word in words[2::2]]
    if not all(0 <= factor and is_coordinate(factor) for factor in factors):
        raise ValueError("expected factors from 0")
    if not all(1 <= unit <= len(reading.units) for unit in units):
        raise ValueError(f"expected numbers of the {len(reading.units)} U lines before this line")
    lengths = tuple((factor, unit - 1) for factor, unit in zip(factors, units, strict=True))
    reading.checkpoints.append(Checkpoint(face, side, int(place[3]) - 1, lengths))


_READERS: dict[str, Callable[[_Reading, Sequence[str]], None]] = {
    "L": _read_type, "v": _read_vertex, "f": _read_face, "T": _read_face_type, "N": _read_source, "e": _read_join,
    "U": _read_unit, "c": _read_checkpoint,
}  # fmt: skip
"""Function that reads the words after the first one, by first word."""


def _numbers(words: Sequence[str], expected: str) -> list[float]:
    try:
        return [float(word) for word in words]
    except ValueError as error:
        raise ValueError(expected) from error


def _whole(word: str, expected: str) -> int:
    if not re.fullmatch(r"-?[0-9]{1,9}", word):
        raise ValueError(expected)
    return int(word)


def write_face_mesh(path: FilePath, mesh: FaceMesh) -> None:
    """Write a mesh of faces; ``read_face_mesh`` reads the same mesh from the file.

    Raises:
        FileError: the file cannot be written.
    """
    lines = [f"L {kind}" for kind in mesh.types]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    lines += [" ".join(record) for record in mesh.texture]
    for face in range(mesh.face_count):
        lines += _face_lines(mesh, face)
    for (first, second), reverses in zip(mesh.joins.tolist(), mesh.reverses.tolist(), strict=True):
        (face, side), (other, across) = mesh.side_at(first), mesh.side_at(second)
        lines.append(f"e {face + 1}/{side + 1} {other + 1}/{'-' if reverses else ''}{across + 1}")
    lines += [" ".join(record) for record in mesh.hints]
    lines += [f"U {name} {length!r}" for name, length in mesh.units]
    lines += [_checkpoint_line(checkpoint) for checkpoint in mesh.checkpoints]
    write_text(path, "\n".join(lines) + "\n")


def _face_lines(mesh: FaceMesh, face: int) -> list[str]:
    corners = range(int(mesh.face_start[face]), int(mesh.face_start[face + 1]))
    texture = mesh.corner_texture or [""] * len(mesh.face_vertex)
    lines = ["f " + " ".join(f"{mesh.face_vertex[corner] + 1}{texture[corner]}" for corner in corners)]
    lines.append(f"T {mesh.face_type[face] + 1}")
    return lines if mesh.source_line[face] < 0 else [*lines, f"N {mesh.source_line[face]}"]


def _checkpoint_line(checkpoint: Checkpoint) -> str:
    place = f"{checkpoint.face + 1}/{checkpoint.side + 1}/{checkpoint.crossing + 1}"
    return " ".join(["c", place, *(f"{factor!r} {unit + 1}" for factor, unit in checkpoint.lengths)])
