# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Traced stitches of AutoKnit, ``.st`` files (github.com/textiles-lab/autoknit). They are read only.

Each line is a stitch, in the order in which a machine makes it: its yarn, its type, its direction, two stitches below,
two stitches above, and a position. Stitches are counted from 0, and -1 is none. The types are s (start), k (knit), i
(increase, two above), d (decrease, two below), t (tuck on the loop below), m (miss) and e (end, none above). The
direction is a, anticlockwise and seen from outside to the right, or c.

A stitch becomes a face. Its loops join it to the stitches below and above, and its yarn joins it to the stitches before
and after it if they have its direction. A corner lies half a step from the stitch towards its neighbours; corners that
are joined become their mean. A turn is a tuck and a miss on one loop: a wrapped and a slipped loop.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from os import fspath

import numpy as np

from stitchmesh.errors import FileError, StitchMeshError
from stitchmesh.io.contents import FilePath, is_coordinate, read_lines
from stitchmesh.io.stitch_formats.smobj import FaceKind, JoinedStitches, connected_twins, stitch_mesh_of
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.connectivity import find_fans, next_sides
from stitchmesh.mesh.stitch import Stitch

COUNTS = {"s": (0, 1), "e": (1, 0), "k": (1, 1), "t": (1, 1), "m": (1, 1), "i": (1, 2), "d": (2, 1)}
"""Numbers of stitches below and above each type."""
RIGHTWARDS, LEFTWARDS = "a", "c"
"""Directions of a stitch, seen from outside with the older stitches below."""
STITCHES = {
    ("s", "a"): Stitch.CAST_ON, ("s", "c"): Stitch.CAST_ON, ("e", "a"): Stitch.KNIT, ("e", "c"): Stitch.KNIT,
    ("k", "a"): Stitch.KNIT, ("k", "c"): Stitch.KNIT, ("t", "a"): Stitch.WRAP, ("t", "c"): Stitch.WRAP,
    ("m", "a"): Stitch.SLIP_BACK, ("m", "c"): Stitch.SLIP_BACK, ("i", "a"): Stitch.KY, ("i", "c"): Stitch.YK,
    ("d", "a"): Stitch.D12K, ("d", "c"): Stitch.D21K,
}  # fmt: skip
"""Stitch of each type and direction. The second loop of an increase is the new loop; the first loop of a decrease is in
front. The end of a wale is a knit whose loop is bound off when yarns are made."""
NONE = -1
_WHOLE = re.compile(r"-1|[0-9]{1,9}")


@dataclass(frozen=True)
class _Traced:
    """A stitch."""

    yarn: int
    type: str
    direction: str
    below: tuple[int, ...]
    """Stitches below, from left to right."""
    above: tuple[int, ...]
    """Stitches above, from left to right."""
    position: tuple[float, float, float]

    @property
    def kind(self) -> FaceKind:
        """Kind of the face; a face has one lower and one upper side where the stitch has no neighbour."""
        return FaceKind(STITCHES[self.type, self.direction], max(1, len(self.below)), max(1, len(self.above)))


def read_traced_stitches(path: FilePath) -> StitchMesh:
    """Read traced stitches as a stitch mesh; positions are taken as centimetres.

    Raises:
        FileError: the file is missing, a folder, empty, binary or malformed, two stitches do not name each other, or
            the stitches form no stitch mesh. The message names the line.
    """
    name = fspath(path)
    lines = [(number, line.split()) for number, line in enumerate(read_lines(path), start=1) if line.strip()]
    stitches = [_stitch(name, number, words) for number, words in lines]
    if not stitches:
        raise FileError(f"{name}: got no stitches; expected one in each line")
    _check_links(name, stitches, [number for number, _ in lines])
    try:
        fabric = stitch_mesh_of(_joined_stitches(stitches))
        return replace(fabric, yarn=np.array([stitch.yarn for stitch in stitches]))
    except (StitchMeshError, ValueError, IndexError) as error:
        raise FileError(f"{name}: {error}") from error


def _stitch(name: str, number: int, words: Sequence[str]) -> _Traced:
    try:
        if len(words) != 10:
            raise ValueError("expected yarn, type, direction, two stitches below, two above, x, y and z")
        if words[1] not in COUNTS or words[2] not in (RIGHTWARDS, LEFTWARDS):
            raise ValueError(f"expected a type of {' '.join(COUNTS)} and a direction of a c")
        if not all(_WHOLE.fullmatch(word) for word in (words[0], *words[3:7])) or words[0] == "-1":
            raise ValueError("expected numbers of a yarn and of stitches, -1 for none")
        links = [int(word) for word in words[3:7]]
        below, above = ([other for other in pair if other != NONE] for pair in (links[:2], links[2:]))
        if (len(below), len(above)) != COUNTS[words[1]]:
            expected = "{} below and {} above".format(*COUNTS[words[1]])
            raise ValueError(f"expected {expected} a stitch of type {words[1]}")
        position = _position(words[7:])
    except ValueError as error:
        raise FileError(f"{name}: line {number}: got {' '.join(words)[:60]!r}; {error}") from error
    order = 1 if words[2] == RIGHTWARDS else -1
    return _Traced(int(words[0]), words[1], words[2], tuple(below[::order]), tuple(above[::order]), position)


def _position(words: Sequence[str]) -> tuple[float, float, float]:
    try:
        x, y, z = (float(word) for word in words)
    except ValueError as error:
        raise ValueError("expected a position of three numbers") from error
    if not all(map(is_coordinate, (x, y, z))):
        raise ValueError("coordinates must be finite")
    return x, y, z


def _check_links(name: str, stitches: Sequence[_Traced], lines: Sequence[int]) -> None:
    """Check that linked stitches name each other, and that each is made after the stitches below it."""
    for index, stitch in enumerate(stitches):
        for other in stitch.below:
            if other >= index or stitches[other].above.count(index) != 1 or stitch.below.count(other) != 1:
                found = f"stitch {index} is above stitch {other}, which is not made before it and below it"
                raise FileError(f"{name}: line {lines[index]}: {found}; links must be mutual")
        for other in stitch.above:
            if not index < other < len(stitches) or stitches[other].below.count(index) != 1:
                found = f"stitch {index} is below stitch {other}, which is not made after it and above it"
                raise FileError(f"{name}: line {lines[index]}: {found}; links must be mutual")


def _joined_stitches(stitches: Sequence[_Traced]) -> JoinedStitches:
    """Return the faces and joins of stitches."""
    joined = JoinedStitches()
    right = _right_neighbours(stitches)
    steps = _steps(stitches, right)
    for index, stitch in enumerate(stitches):
        joined.kinds.append(stitch.kind)
        first = len(joined.vertices)
        joined.vertices += [(x, y, z) for x, y, z in _corners(stitch, *steps[index]).tolist()]
        joined.faces.append(list(range(first, len(joined.vertices))))
        for slot, other in enumerate(stitch.above):
            # Upper sides run from right to left, behind the lower sides and the right wale side.
            top = stitch.kind.n_bottom + stitch.kind.n_top - slot
            _join(joined, (index, top), (other, stitches[other].below.index(index)))
    for left, other in right.items():
        kind = stitches[other].kind
        _join(joined, (left, stitches[left].kind.n_bottom), (other, kind.n_bottom + kind.n_top + 1))
    _open_pinches(joined, stitches)
    return joined


def _open_pinches(joined: JoinedStitches, stitches: Sequence[_Traced]) -> None:
    """Remove joins along the yarn until no side on a border begins and ends in one vertex.

    Where a tube divides, the yarn of one branch crosses the gap between the branches, and a join along it would pinch
    the gap together. At a pinched vertex, the longest join is removed.
    """
    start = np.concatenate([[0], np.cumsum([len(face) for face in joined.faces])])
    following = next_sides(start)
    while True:
        twin = connected_twins(joined, start)
        vertex = find_fans(np.where(twin == BORDER, BORDER, following[twin]))
        pinched = np.flatnonzero((twin == BORDER) & (vertex == vertex[following]))
        joins = [] if not len(pinched) else _joins_at(joined, stitches, vertex, start, int(vertex[pinched[0]]))
        if not joins:
            return
        _, left, right = max(joins)
        del joined.connections[left], joined.connections[right]


def _joins_at(
    joined: JoinedStitches, stitches: Sequence[_Traced], vertex: IntArray, start: IntArray, at: int
) -> list[tuple[float, tuple[int, int], tuple[int, int]]]:
    """Return the joins along the yarn that have an end at a vertex: length, right side and left side."""
    found = []
    for index, stitch in enumerate(stitches):
        side = stitch.kind.n_bottom
        if at in vertex[start[index] + side : start[index] + side + 2] and (index, side) in joined.connections:
            other = joined.connections[index, side]
            gap = np.subtract(stitches[other[0]].position, stitch.position)
            found.append((float(np.linalg.norm(gap)), (index, side), other))
    return found


def _join(joined: JoinedStitches, first: tuple[int, int], second: tuple[int, int]) -> None:
    joined.connections[first], joined.connections[second] = second, first


def _right_neighbours(stitches: Sequence[_Traced]) -> dict[int, int]:
    """Return the stitch to the right of each stitch that has one: the next stitch of its yarn, or the one before."""
    last: dict[int, int] = {}
    pairs: list[tuple[int, int]] = []
    for index, stitch in enumerate(stitches):
        before = last.get(stitch.yarn)
        if before is not None and _are_beside(stitches[before], stitch):
            pairs.append((before, index) if stitch.direction == RIGHTWARDS else (index, before))
        last[stitch.yarn] = index
    return dict(pairs)


def _are_beside(before: _Traced, after: _Traced) -> bool:
    """Return whether two successive stitches of a yarn lie side by side; at a row end the yarn goes elsewhere."""
    ends = before.type == "e" != after.type or after.type == "s" != before.type
    return before.direction == after.direction and not ends


def _steps(stitches: Sequence[_Traced], right: dict[int, int]) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """Return the position of each stitch, and the steps to its neighbours on the right and above."""
    place = np.array([stitch.position for stitch in stitches])
    left = {other: index for index, other in right.items()}
    found = []
    for index, stitch in enumerate(stitches):
        beside = [left.get(index), index, right.get(index)]
        across = _mean_step([place[k] for k in beside if k is not None])
        column = [place[list(stitch.below)].mean(axis=0)] if stitch.below else []
        column += [place[index]]
        column += [place[list(stitch.above)].mean(axis=0)] if stitch.above else []
        found.append((place[index], across, _mean_step(column)))
    return found


def _mean_step(points: Sequence[FloatArray]) -> FloatArray:
    """Return the mean step from point to point; zero for a single point."""
    steps = [after - before for before, after in pairwise(points)]
    return np.mean(steps, axis=0) if steps else np.zeros(3)


def _corners(stitch: _Traced, place: FloatArray, across: FloatArray, up: FloatArray) -> FloatArray:
    """Return the corners of a face from the lower left, shape (corners, 3)."""
    low = np.linspace(-0.5, 0.5, stitch.kind.n_bottom + 1)
    high = np.linspace(0.5, -0.5, stitch.kind.n_top + 1)
    shares = [(x, -0.5) for x in low] + [(x, 0.5) for x in high]
    return np.array([place + x * across + y * up for x, y in shares])
