# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rest lengths of yarns: the generated lengths times factors, or a given length of each loop.

The rest length l of a segment becomes

    l * a * factor * factor of its stitch type * factor of its row * factor of its yarn * factors of its part

If a loop length is given (Yuksel et al. 2012, section 6.3), a = loop length / rest length of the yarn in the stitch,
so that every plain stitch has the loop length before the factors are applied; without a loop length, a = 1. Plain
stitches are the knit and purl stitches inside the fabric that are not part of a cable. All other yarn that stitches
made (increases, decreases, cables, row ends with their turns, cast-on and bind-off) takes the median of a over the
plain stitches, so that its length relative to plain stitches does not change. Floats behind stitches of other yarns
take the median too: a float is no part of the loop that it starts from, and that loop has the loop length without the
float. Yarn that no stitch made keeps its rest length.

A segment extends approximately from its second to its third control point, and belongs to the stitch and to the row of
its second control point. The yarn of a plain stitch consists of its own foot and legs and of the head through which
they are drawn. Together these are as long as one loop.

The parts whose yarn length varies most have names (Leaf et al. 2018, section 6.1). A slip stitch has a *float*, the
yarn of its own row that passes the stitch, and a *held* loop, which comes from a row below. The row of a segment
distinguishes the two. A tuck has a held loop as well, but its own yarn is a loop and not a float. Yarn that is carried
along a row behind stitches of other yarns is also a float; it belongs to the stitch that it comes from. The *warp* of a
weave advances along the second period of the lattice, the *weft* along the first. Rest lengths can also come from marks
on a yarn, each of which states the length of yarn up to the next mark.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, check_kind, check_positive
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.stitch import CODES, VOCABULARY, Stitch
from stitchmesh.yarn.yarn_set import FLOATING, UNKNOWN_FACE, YarnSet

PARTS = ("floats", "held", "warp", "weft")
"""Names of the parts; each is a field of ``RestLengths`` and a name on the command line."""
FORMS = "CODE=FACTOR, row:N=FACTOR, yarn:N=FACTOR, or floats, held, warp or weft=FACTOR"
"""The forms in which a user may write a factor."""
SLIPS = tuple(stitch for stitch, making in VOCABULARY.items() if making.made == "s")
"""Stitches whose own yarn passes the loop without being drawn through it."""
HOLDING = tuple(stitch for stitch, making in VOCABULARY.items() if "s" in making.made)
"""Stitches with a held loop: slips, tucks, and stitches that are knit into a loop which stays on the needle."""


@dataclass(frozen=True, kw_only=True)
class RestLengths:
    """How rest lengths are changed; with the default values they do not change.

    Raises:
        ParameterError: a factor or the loop length is not a positive number, or a stitch code is unknown.
    """

    factor: float = 1.0
    """Factor of all yarn."""
    loop_length: float | None = None
    """Rest length of the yarn in every plain stitch before the factors are applied [cm]; None keeps the lengths."""
    stitches: Mapping[str, float] = field(default_factory=dict)
    """Factor of the stitches with each code (``stitch.CODES``)."""
    rows: Mapping[int, float] = field(default_factory=dict)
    """Factor of each knitting row."""
    yarns: Mapping[int, float] = field(default_factory=dict)
    """Factor of each yarn."""
    floats: float = 1.0
    """Factor of the yarn that passes slipped loops, or that is carried behind stitches of other yarns."""
    held: float = 1.0
    """Factor of the loops held by slips and tucks, for the part of the loop inside the slip or tuck."""
    warp: float = 1.0
    """Factor of the warp yarns of a weave."""
    weft: float = 1.0
    """Factor of the weft yarns of a weave."""

    def __post_init__(self) -> None:
        check_positive("rest length factor", self.factor)
        if self.loop_length is not None:
            check_positive("loop length", self.loop_length)
        for prefix, factors in (("", self.stitches), ("", self.parts), ("row:", self.rows), ("yarn:", self.yarns)):
            for key, factor in factors.items():
                check_positive(f"rest length {prefix}{key}", factor)
        unknown = [code for code in self.stitches if code not in CODES]
        if unknown:
            known = ", ".join((*CODES, *PARTS))
            raise ParameterError(f"rest length {unknown[0]}: unknown stitch; expected one of {known}")

    @property
    def parts(self) -> dict[str, float]:
        """Factors of the parts whose factor is not 1, by name."""
        return {name: getattr(self, name) for name in PARTS if getattr(self, name) != 1.0}

    @property
    def need_fabric(self) -> bool:
        """Whether the change requires the fabric from which the yarns were made."""
        return self.loop_length is not None or bool(self.stitches) or bool({"floats", "held"} & set(self.parts))


def parse_rest_lengths(
    words: Iterable[str], *, factor: float = RestLengths.factor, loop_length: float | None = RestLengths.loop_length
) -> RestLengths:
    """Parse factors as a user writes them: ``k=1.1``, ``row:3=0.9``, ``yarn:12=1.2``, ``held=0.6``.

    Args:
        words: factors of stitches, rows, yarns and parts; each of these may be named once.
        factor: factor of all yarn.
        loop_length: rest length of the yarn in every plain stitch [cm].

    Raises:
        ParameterError: a word does not have one of these forms, two words name the same thing, or as for
            ``RestLengths``.
    """
    parsed: dict[str, dict[Any, float]] = {"stitch": {}, "row": {}, "yarn": {}, "part": {}}
    for word in words:
        kind, key, value = _parse_factor(word)
        if key in parsed[kind]:
            raise ParameterError(f"rest length: got {word!r} after another factor for the same; expected one")
        parsed[kind][key] = value
    stitches, rows, yarns, parts = parsed.values()
    return RestLengths(factor=factor, loop_length=loop_length, stitches=stitches, rows=rows, yarns=yarns, **parts)


def apply_rest_lengths(yarns: YarnSet, change: RestLengths, *, fabric: StitchMesh | None = None) -> YarnSet:
    """Return the same yarns with changed rest lengths.

    Args:
        yarns: the yarns; the factors scale their rest lengths.
        change: the factors and the loop length.
        fabric: the fabric from which the yarns were made; required for a loop length and for factors of stitches,
            floats and held loops.

    Raises:
        ParameterError: a named stitch type, row, yarn or part does not exist, the fabric is missing or is not the
            fabric of the yarns, the yarns do not store which stitches made them, or a loop length is given and the
            fabric has no plain stitch.
    """
    check_kind("apply_rest_lengths", yarns, YarnSet)
    check_kind("apply_rest_lengths, change", change, RestLengths)
    scale = np.full(len(yarns.rest_length), change.factor)
    if change.loop_length is not None:
        scale *= _loop_length_scale(yarns, _own_fabric(yarns, fabric, "loop length"), change.loop_length)
    for code, factor in change.stitches.items():
        scale[_segments_of_stitch(yarns, _own_fabric(yarns, fabric, f"rest length {code}"), code)] *= factor
    for row, factor in change.rows.items():
        scale[_segments_of_row(yarns, row)] *= factor
    for yarn, factor in change.yarns.items():
        scale[_segments_of_yarn(yarns, yarn)] *= factor
    for name, factor in change.parts.items():
        scale[_segments_of_part(yarns, fabric, name)] *= factor
    return dataclasses.replace(yarns, rest_length=yarns.rest_length * scale)


def segment_faces(yarns: YarnSet) -> IntArray:
    """Return the stitch face of each segment, ``UNKNOWN_FACE`` if no stitch made it, shape (S,)."""
    return yarns.face[yarns.segment_points[:, 1]]


def carried_segments(yarns: YarnSet) -> NDArray[np.bool_]:
    """Return whether each segment lies in a float behind stitches of other yarns, shape (S,)."""
    carried: NDArray[np.bool_] = yarns.part[yarns.segment_points[:, 1]] == FLOATING
    return carried


def stitch_lengths(yarns: YarnSet, fabric: StitchMesh) -> FloatArray:
    """Return the rest length of the yarn in each stitch face [cm], shape (F,); for a plain stitch, the loop length.

    Floats behind stitches of other yarns are not counted: they are no part of the loop that they start from.
    """
    face = segment_faces(yarns)
    known = (face != UNKNOWN_FACE) & ~carried_segments(yarns)
    total: FloatArray = np.bincount(face[known], yarns.rest_length[known], fabric.face_count).astype(np.float64)
    return total


def _parse_factor(word: str) -> tuple[str, str | int, float]:
    """Split a word into its kind ("stitch", "part", "row" or "yarn"), its code, name or number, and its factor."""
    name, equals, text = word.partition("=")
    kind, colon, number = name.strip().partition(":")
    try:
        value = float(text)
        if not equals:
            raise ValueError
        if not colon:
            return "part" if kind in PARTS else "stitch", kind, value
        if kind not in ("row", "yarn"):
            raise ValueError
        return kind, int(number), value
    except ValueError as error:
        raise ParameterError(f"rest length: got {word!r}; expected {FORMS}") from error


def _own_fabric(yarns: YarnSet, fabric: StitchMesh | None, what: str) -> StitchMesh:
    """Return the fabric if the yarns can refer to it; ``what`` names the request in an error message."""
    if fabric is None:
        raise ParameterError(f"{what}: got no fabric; give the stitch mesh that the yarns were made from")
    _check_stitches_known(yarns, what)
    if yarns.face.max() >= fabric.face_count:
        raise ParameterError(
            f"{what}: yarns refer to stitch face {yarns.face.max()} and the fabric has {fabric.face_count}; "
            "give the stitch mesh that the yarns were made from"
        )
    return fabric


def _check_stitches_known(yarns: YarnSet, what: str) -> None:
    if (yarns.face == UNKNOWN_FACE).all():
        raise ParameterError(
            f"{what}: the yarns do not store which stitch made them, as in files of curves; use factors of all yarn "
            "or of yarns"
        )


def _loop_length_scale(yarns: YarnSet, fabric: StitchMesh, loop_length: float) -> FloatArray:
    """Return the scale a of each segment for a loop length (module docstring), shape (S,)."""
    given = stitch_lengths(yarns, fabric)
    plain = plain_stitches(fabric) & (given > 0.0)
    if not plain.any():
        raise ParameterError("loop length: the fabric has no plain stitch away from its borders; use a factor instead")
    median = np.median(loop_length / given[plain])
    of_face = np.full(fabric.face_count, median)
    of_face[plain] = loop_length / given[plain]
    face = segment_faces(yarns)
    return np.where(face == UNKNOWN_FACE, 1.0, np.where(carried_segments(yarns), median, of_face[face]))


def plain_stitches(fabric: StitchMesh) -> NDArray[np.bool_]:
    """Return whether each face is a plain stitch, shape (F,).

    A plain stitch is a knit or purl stitch that is not on a border or in a cable and whose neighbours have the same
    wale direction.
    """
    special = (fabric.twin == BORDER) | fabric.mismatched | (fabric.cable_shift != 0)
    special_sides = np.bincount(fabric.side_face[special], minlength=fabric.face_count)
    return np.isin(fabric.stitch, [Stitch.KNIT, Stitch.PURL]) & (special_sides == 0)


def _segments_of_stitch(yarns: YarnSet, fabric: StitchMesh, code: str) -> NDArray[np.bool_]:
    """Return whether a stitch of the given code made each segment, shape (S,)."""
    found = fabric.stitch == CODES[code]
    if not found.any():
        codes = [known for known, stitch in CODES.items() if (fabric.stitch == stitch).any()]
        raise ParameterError(f"rest length {code}: the fabric has no such stitch; it has {', '.join(codes) or 'none'}")
    face = segment_faces(yarns)
    return (face != UNKNOWN_FACE) & found[face]


def _segments_of_row(yarns: YarnSet, row: int) -> NDArray[np.bool_]:
    """Return whether a stitch of the given row made each segment, shape (S,)."""
    _check_stitches_known(yarns, f"rest length row:{row}")
    rows = np.where(segment_faces(yarns) == UNKNOWN_FACE, -1, yarns.row[yarns.segment_points[:, 1]])
    found = (rows == row) & (rows >= 0)
    if not found.any():
        raise ParameterError(f"rest length row:{row}: no yarn is in that row; expected 0 to {rows.max()}")
    return found


def _segments_of_yarn(yarns: YarnSet, yarn: int) -> NDArray[np.bool_]:
    """Return whether each segment belongs to the given yarn, shape (S,)."""
    if not 0 <= yarn < yarns.yarn_count:
        raise ParameterError(f"rest length yarn:{yarn}: there is no such yarn; expected 0 to {yarns.yarn_count - 1}")
    return yarns.segment_yarn == yarn


def _segments_of_part(yarns: YarnSet, fabric: StitchMesh | None, name: str) -> NDArray[np.bool_]:
    """Return whether each segment belongs to the given part (``PARTS``), shape (S,)."""
    if name in ("warp", "weft"):
        return _segments_of_weave(yarns, name)
    fabric = _own_fabric(yarns, fabric, f"rest length {name}")
    face = segment_faces(yarns)
    own = yarns.row[yarns.segment_points[:, 1]] == fabric.row[face]
    holds = np.isin(fabric.stitch[face], SLIPS if name == "floats" else HOLDING) & (face != UNKNOWN_FACE)
    found: NDArray[np.bool_] = holds & (own if name == "floats" else ~own)
    if name == "floats":
        found = found | carried_segments(yarns)
    if not found.any():
        no_floats = "no slip stitch and no stitches of another yarn that yarn could pass"
        missing = no_floats if name == "floats" else "no slip or tuck that holds a loop"
        raise ParameterError(f"rest length {name}: the fabric has {missing}; leave the factor out")
    return found


def _segments_of_weave(yarns: YarnSet, name: str) -> NDArray[np.bool_]:
    """Return whether each segment is part of a warp (or weft) yarn, shape (S,)."""
    step = yarns.lattice_step
    if step is None or (yarns.face != UNKNOWN_FACE).any() or not step.any(axis=0).all():
        raise ParameterError(f"rest length {name}: the yarns are not woven; use it for a weave, or yarn:N")
    found: NDArray[np.bool_] = (step[:, 0 if name == "weft" else 1] != 0)[yarns.segment_yarn]
    return found


def marked_stretches(marks: Mapping[float, float], lengths: FloatArray) -> FloatArray:
    """Return the factor of each segment's length that gives the parts between marks their stated lengths.

    A segment belongs to the part in which its middle lies. Segments before the first mark, and segments in a part whose
    stated length is zero, keep their length. The last mark reaches to the end of the yarn.

    Args:
        marks: place of each mark, in segments from the start of the yarn, and the length up to the next one [cm].
        lengths: present length of each segment [cm], shape (S,).
    """
    factor = np.ones(len(lengths))
    middles = np.arange(len(lengths)) + 0.5
    for start, end in pairwise([*sorted(marks), float(len(lengths))]):
        part = (middles >= start) & (middles < end)
        if marks[start] > 0.0 and part.any():
            factor[part] = marks[start] / lengths[part].sum()
    return factor
