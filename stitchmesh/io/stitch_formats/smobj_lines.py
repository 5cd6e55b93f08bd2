# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What an ``.smobj`` file says, line by line, before it becomes a stitch mesh (``smobj``)."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from os import fspath

from stitchmesh.errors import FileError, first_few
from stitchmesh.io.contents import FilePath, read_lines
from stitchmesh.mesh.stitch import VOCABULARY, Stitch

OWN = "#stitchmesh"
"""First word of the comments that carry what the format has no place for."""
PASSED_OVER = frozenset("N U c h vn vt vt2 tex tex2 usemtl mtllib".split())
"""Lines that say nothing about a stitch mesh."""

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
class Kind:
    """A line of the library."""

    stitch: Stitch
    n_bottom: int
    n_top: int


@dataclass
class Contents:
    """What a file holds, as far as it has been read."""

    path: str
    kinds: list[Kind | str] = field(default_factory=list)
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

    def kinds_of_faces(self) -> list[Kind]:
        """The kind of each face, once all of them are known."""
        return [kind for kind in (self.kinds[index] for index in self.face_kind) if isinstance(kind, Kind)]

    def bad(self, line: int, what: str) -> FileError:
        """What is wrong with a line."""
        return FileError(f"{self.path}: line {line}: {what}")


def read_contents(path: FilePath) -> Contents:
    """All that a file says, each line checked, and what can only be told from all of them.

    Raises:
        FileError: the file is missing, a folder, empty, binary or malformed, or a face is no stitch of ours or its
            labels do not form our frame. The message names the line.
    """
    contents = Contents(fspath(path))
    for number, line in enumerate(read_lines(path), start=1):
        fields = line.partition("#")[0].split()
        if line.startswith(OWN):
            _read_own(contents, number, line.split()[1:])
        elif fields:
            _read_line(contents, number, fields)
    _check_whole(contents)
    return contents


def _read_own(contents: Contents, number: int, fields: list[str]) -> None:
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


def _read_line(contents: Contents, number: int, fields: list[str]) -> None:
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


def _read_kind(contents: Contents, number: int, fields: list[str]) -> None:
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
    contents.kinds.append(Kind(stitch, shape["below"].count("l"), shape["above"].count("l")))


def _position(contents: Contents, number: int, fields: list[str]) -> tuple[float, float, float]:
    try:
        x, y, z = (float(text) for text in fields[1:])
    except ValueError as error:
        found = " ".join(fields)[:40]
        raise contents.bad(number, f"got {found!r}; expected 'v x y z' with three numbers") from error
    if not all(map(math.isfinite, (x, y, z))):
        raise contents.bad(number, f"got {' '.join(fields)[:40]!r}; coordinates must be finite")
    return x, y, z


def _corners(contents: Contents, number: int, fields: list[str]) -> list[int]:
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


def _close_face(contents: Contents, number: int) -> None:
    if len(contents.face_kind) < len(contents.faces):
        line = contents.face_line[-1]
        raise contents.bad(number, f"the face of line {line} has no T line; every face needs its kind")


def _read_type(contents: Contents, number: int, fields: list[str]) -> None:
    try:
        kind = int(fields[1])
    except (IndexError, ValueError) as error:
        raise contents.bad(number, f"got {' '.join(fields)[:40]!r}; expected 'T' and a number") from error
    if not 1 <= kind <= len(contents.kinds):
        raise contents.bad(number, f"kind {kind} does not exist; {len(contents.kinds)} L lines come before this line")
    if len(contents.face_kind) != len(contents.faces) - 1:
        raise contents.bad(number, "a T line without a face of its own; expected one after each f line")
    contents.face_kind.append(kind - 1)


def _read_connection(contents: Contents, number: int, fields: list[str]) -> None:
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


def _check_whole(contents: Contents) -> None:
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
    for face, kind in enumerate(contents.kinds_of_faces()):
        sides = kind.n_bottom + kind.n_top + 2
        if sides != len(contents.faces[face]):
            what = f"got {len(contents.faces[face])} corners; its kind has {sides} sides"
            raise contents.bad(contents.face_line[face], what)
