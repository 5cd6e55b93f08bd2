# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Libraries of drawn faces, ``.sf`` files of the authors of the ``.smobj`` format. They are read only.

- ``face name``: begins a face.
- ``edge (x,y) label``: a corner, and the label of the side that starts there. The sides run counter-clockwise.
- ``yarn [side:along,z] (x,y,z) ... [side:along,z]``: a strand between two sides, which are counted from 0 here.
- ``derive name labels by operations from name labels``: a face derived from another face, mirrored or with reversed
  yarn.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from os import fspath

import numpy as np

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.faces.face_drawing import FaceDrawing, FaceLibrary, SideCrossing, Strand, derived
from stitchmesh.faces.face_type import FaceType
from stitchmesh.io.contents import FilePath, is_coordinate, read_lines
from stitchmesh.mesh import FloatArray

FLAT = 1e-9
"""Largest area of a polygon without an area, over the square of its size; coordinates have about seven digits."""
_NUMBER = r"\s*([-+0-9.eE]+)\s*"
_EDGE = re.compile(rf"edge\s*\({_NUMBER},{_NUMBER}\)\s*(\S+)")
_CROSSING = rf"\[\s*([0-9]{{1,9}})\s*:{_NUMBER},{_NUMBER}\]"
_YARN = re.compile(rf"yarn\s*{_CROSSING}\s*((?:\([^()]*\)\s*)*){_CROSSING}")
_POINT = re.compile(rf"\({_NUMBER},{_NUMBER},{_NUMBER}\)")
_DERIVE = re.compile(r"derive\s+(.+?)(?:\s+by\s+(.+?))?\s+from\s+(.+)")


@dataclass
class _Face:
    """A face that is being read."""

    name: str
    line: int
    corners: list[list[float]] = field(default_factory=list)
    labels: list[str] = field(default_factory=list)
    strands: list[Strand] = field(default_factory=list)

    def drawing(self) -> FaceDrawing:
        """Return the drawing.

        Raises:
            ValueError: the face has too few sides, or a strand starts or ends at a side that does not exist.
        """
        if len(self.corners) < 3:
            raise ValueError(f"face {self.name} has {len(self.corners)} edges; expected at least 3")
        if abs(_twice_the_area(np.array(self.corners))) <= FLAT * float(np.square(np.ptp(self.corners, axis=0)).sum()):
            raise ValueError(f"the corners of face {self.name} enclose no area")
        used = {crossing.side for strand in self.strands for crossing in (strand.start, strand.end)}
        if used and max(used) >= len(self.corners):
            raise ValueError(f"a yarn of face {self.name} crosses side {max(used)}; sides are counted from 0")
        return FaceDrawing(FaceType(self.name, tuple(self.labels)), np.array(self.corners), tuple(self.strands))


def _twice_the_area(corners: FloatArray) -> float:
    following = np.roll(corners, -1, axis=0)
    return float((corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]).sum())


@dataclass(frozen=True)
class _Derivation:
    """A face that is derived from another one."""

    type: FaceType
    operations: tuple[str, ...]
    source: FaceType


def read_face_library(path: FilePath) -> FaceLibrary:
    """Read a library of drawn faces.

    Raises:
        FileError: the file is missing, a folder, empty, binary or malformed, or a face is derived from an unknown face.
            The message names the line.
    """
    faces: list[_Face] = []
    derivations: list[tuple[int, _Derivation]] = []
    for number, line in enumerate(read_lines(path), start=1):
        text = line.partition("#")[0].strip()
        try:
            if text.startswith("derive"):
                derivations.append((number, _derivation(text)))
            elif text:
                _read_line(faces, number, text)
        except ValueError as error:
            raise FileError(f"{fspath(path)}: line {number}: got {text[:60]!r}; {error}") from error
    if not faces:
        raise FileError(f"{fspath(path)}: got no faces; expected an .sf library of face, edge, yarn and derive lines")
    return FaceLibrary(_with_derived(fspath(path), _drawings(fspath(path), faces), derivations))


def read_face_libraries(paths: Iterable[FilePath]) -> FaceLibrary:
    """Read several libraries as one; a drawing of an earlier library is preferred to one of a later library.

    Raises:
        FileError: as for ``read_face_library``.
    """
    return FaceLibrary(tuple(drawing for path in paths for drawing in read_face_library(path).drawings))


def _read_line(faces: list[_Face], number: int, text: str) -> None:
    words = text.split()
    if words[0] == "face" and len(words) == 2:
        faces.append(_Face(words[1], number))
    elif not faces:
        raise ValueError("expected 'face name' first")
    elif edge := _EDGE.fullmatch(text):
        faces[-1].corners.append([_number(edge[1]), _number(edge[2])])
        faces[-1].labels.append(edge[3])
    elif yarn := _YARN.fullmatch(text):
        faces[-1].strands.append(_strand(yarn))
    else:
        raise ValueError("expected face, edge, yarn or derive with their numbers")


def _strand(yarn: re.Match[str]) -> Strand:
    points = [[_number(text) for text in point] for point in _POINT.findall(yarn[4])]
    if len(points) != yarn[4].count("("):
        raise ValueError("expected points of three numbers")
    start = SideCrossing(int(yarn[1]), _number(yarn[2]), _number(yarn[3]))
    end = SideCrossing(int(yarn[5]), _number(yarn[6]), _number(yarn[7]))
    if not all(0.0 <= crossing.along <= 1.0 for crossing in (start, end)):
        raise ValueError("expected places along sides from 0 to 1")
    return Strand(start, np.reshape(np.array(points, dtype=np.float64), (-1, 3)), end)


def _number(text: str) -> float:
    number = float(text)
    if not is_coordinate(number):
        raise ValueError("expected finite numbers")
    return number


def _derivation(text: str) -> _Derivation:
    match = _DERIVE.fullmatch(text)
    if match is None:
        raise ValueError("expected 'derive name labels by operations from name labels'")
    (name, *labels), (source, *source_labels) = match[1].split(), match[3].split()
    return _Derivation(
        FaceType(name, tuple(labels)), tuple((match[2] or "").split()), FaceType(source, tuple(source_labels))
    )


def _drawings(path: str, faces: list[_Face]) -> list[FaceDrawing]:
    drawings = []
    for face in faces:
        try:
            drawings.append(face.drawing())
        except ValueError as error:
            raise FileError(f"{path}: line {face.line}: {error}") from error
    return drawings


def _with_derived(
    path: str, drawings: list[FaceDrawing], derivations: list[tuple[int, _Derivation]]
) -> tuple[FaceDrawing, ...]:
    """Return the drawings, and all drawings that are derived from them, directly or through others."""
    known = {drawing.type: drawing for drawing in drawings}
    while derivations:
        later = []
        for number, derivation in derivations:
            if derivation.source not in known:
                later.append((number, derivation))
                continue
            try:
                made = derived(known[derivation.source], derivation.type, derivation.operations)
            except ParameterError as error:
                raise FileError(f"{path}: line {number}: {error}") from error
            known[derivation.type] = made
        if len(later) == len(derivations):
            number, derivation = later[0]
            raise FileError(f"{path}: line {number}: no face is {derivation.source}; a face is derived from another")
        derivations = later
    return tuple(known.values())
