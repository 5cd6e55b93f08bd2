# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How much yarn goes where: rest lengths as generated, times factors, or a length for each loop.

The rest length l of a segment becomes

    l * a * factor * factor of its stitch's type * factor of its row * factor of its yarn * factors of its part

Where a loop length is asked for (Yuksel et al. 2012, section 6.3), a = loop length / yarn in the stitch, so that every
plain stitch holds that length before the factors; else a = 1. Plain stitches are the knits and purls inside the fabric
that cross no others. All other yarn that stitches made, in increases and decreases, in cables, in row ends with their
turns, in cast-on and bind-off, takes the median of the plain stitches' a, and so keeps its share. Yarn that no stitch
made keeps the length it has.

A segment runs from about its second control point to about its third, and belongs to the stitch and to the row of
the second. The yarn in a plain stitch is its own foot and legs and the head that they are drawn through: one loop.

Parts have names where the yarn they need varies most (Leaf et al. 2018, section 6.1). A slip stitch has a *float*, the
yarn of its own row that passes by, and a *held* loop, drawn up from a row below; they are told apart by their rows. A
tuck holds a loop too, but its own yarn is a loop and no float. Yarn that is carried along a row behind stitches of
other yarns is a float too, and yarn of the stitch that it comes from. Of a weave the *warp* goes on along the second
period of its lattice, the *weft* along the first.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.stitch import CODES, VOCABULARY, Stitch
from stitchmesh.yarn.yarn_set import FLOATING, UNKNOWN_FACE, YarnSet

PARTS = ("floats", "held", "warp", "weft")
"""Names of parts; each is a field of ``RestLengths`` and a word of the user."""
FORMS = "CODE=FACTOR, row:N=FACTOR, yarn:N=FACTOR, or floats, held, warp or weft=FACTOR"
"""How a user writes a factor."""
SLIPS = tuple(stitch for stitch, making in VOCABULARY.items() if making.made == "s")
"""Stitches whose yarn only passes by."""
HOLDING = tuple(stitch for stitch, making in VOCABULARY.items() if "s" in making.made)
"""Stitches that hold a loop: slips, tucks and those that knit into a loop and keep it."""


@dataclass(frozen=True, kw_only=True)
class RestLengths:
    """What a user asks of the rest lengths; all stay as they are unless told otherwise.

    Raises:
        ParameterError: a factor or the loop length is not a positive number, or a stitch code is unknown.
    """

    factor: float = 1.0
    """Factor of all yarn."""
    loop_length: float | None = None
    """Yarn in every plain stitch before the factors [cm]."""
    stitches: Mapping[str, float] = field(default_factory=dict)
    """Factor of the stitches of each code (``stitch.CODES``)."""
    rows: Mapping[int, float] = field(default_factory=dict)
    """Factor of each knitting row."""
    yarns: Mapping[int, float] = field(default_factory=dict)
    """Factor of each yarn."""
    floats: float = 1.0
    """Factor of the yarn that passes by slipped loops, or behind stitches of other yarns."""
    held: float = 1.0
    """Factor of the loops that slips and tucks hold, where these hold them."""
    warp: float = 1.0
    """Factor of the warps of a weave."""
    weft: float = 1.0
    """Factor of the wefts of a weave."""

    def __post_init__(self) -> None:
        _check_positive("rest length factor", self.factor)
        if self.loop_length is not None:
            _check_positive("loop length", self.loop_length)
        for prefix, factors in (("", self.stitches), ("", self.parts), ("row:", self.rows), ("yarn:", self.yarns)):
            for key, factor in factors.items():
                _check_positive(f"rest length {prefix}{key}", factor)
        unknown = [code for code in self.stitches if code not in CODES]
        if unknown:
            known = ", ".join((*CODES, *PARTS))
            raise ParameterError(f"rest length {unknown[0]}: unknown stitch; expected one of {known}")

    @property
    def parts(self) -> dict[str, float]:
        """Factors of parts, of those that change."""
        return {name: getattr(self, name) for name in PARTS if getattr(self, name) != 1.0}

    @property
    def need_fabric(self) -> bool:
        """Whether they can only be applied where the fabric is known."""
        return self.loop_length is not None or bool(self.stitches) or bool({"floats", "held"} & set(self.parts))


def parse_rest_lengths(
    words: Iterable[str], *, factor: float = RestLengths.factor, loop_length: float | None = RestLengths.loop_length
) -> RestLengths:
    """Rest lengths from factors as a user writes them: ``k=1.1``, ``row:3=0.9``, ``yarn:12=1.2``, ``held=0.6``.

    Args:
        words: factors of stitches, rows, yarns and parts, each named once.
        factor: factor of all yarn.
        loop_length: yarn in every plain stitch [cm].

    Raises:
        ParameterError: a word has another form or names what another one names; or as for ``RestLengths``.
    """
    parsed: dict[str, dict[Any, float]] = {"stitch": {}, "row": {}, "yarn": {}, "part": {}}
    for word in words:
        kind, key, value = _parsed(word)
        if key in parsed[kind]:
            raise ParameterError(f"rest length: got {word!r} after another factor for the same; expected one")
        parsed[kind][key] = value
    stitches, rows, yarns, parts = parsed.values()
    return RestLengths(factor=factor, loop_length=loop_length, stitches=stitches, rows=rows, yarns=yarns, **parts)


def apply_rest_lengths(yarns: YarnSet, wanted: RestLengths, *, fabric: StitchMesh | None = None) -> YarnSet:
    """The same yarns with other rest lengths.

    Args:
        yarns: the yarns; their rest lengths are what the factors scale.
        wanted: what to change.
        fabric: the fabric that the yarns were made from; a loop length and factors of stitches, floats and held loops
            need it.

    Raises:
        ParameterError: a stitch type, row, yarn or part is not there, the fabric is missing or not the yarns' own, no
            yarn knows its stitch, or the fabric has no plain stitch to set a loop length by.
    """
    scale = np.full(len(yarns.rest_length), wanted.factor)
    if wanted.loop_length is not None:
        scale *= _loop_length_scale(yarns, _own_fabric(yarns, fabric, "loop length"), wanted.loop_length)
    for code, factor in wanted.stitches.items():
        scale[_of_stitch(yarns, _own_fabric(yarns, fabric, f"rest length {code}"), code)] *= factor
    for row, factor in wanted.rows.items():
        scale[_of_row(yarns, row)] *= factor
    for yarn, factor in wanted.yarns.items():
        scale[_of_yarn(yarns, yarn)] *= factor
    for name, factor in wanted.parts.items():
        scale[_of_part(yarns, fabric, name)] *= factor
    return dataclasses.replace(yarns, rest_length=yarns.rest_length * scale)


def segment_faces(yarns: YarnSet) -> IntArray:
    """Stitch face of each segment, ``UNKNOWN_FACE`` where none, shape (S,)."""
    return yarns.face[yarns.segment_points[:, 1]]


def stitch_lengths(yarns: YarnSet, fabric: StitchMesh) -> FloatArray:
    """Rest length of the yarn in each stitch face [cm], shape (F,); in a plain stitch it is the loop length."""
    face = segment_faces(yarns)
    known = face != UNKNOWN_FACE
    total: FloatArray = np.bincount(face[known], yarns.rest_length[known], fabric.face_count).astype(np.float64)
    return total


def _parsed(word: str) -> tuple[str, str | int, float]:
    """Kind, stitch code or number, and factor of a word."""
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


def _check_positive(name: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise ParameterError(f"{name}: got {value}; expected a positive number")


def _own_fabric(yarns: YarnSet, fabric: StitchMesh | None, what: str) -> StitchMesh:
    """The fabric that the yarns refer to."""
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
            f"{what}: no yarn knows which stitch made it, as in files of curves; use factors of all yarn or of yarns"
        )


def _loop_length_scale(yarns: YarnSet, fabric: StitchMesh, loop_length: float) -> FloatArray:
    """What each segment's rest length is multiplied by for plain stitches of that loop length, shape (S,)."""
    given = stitch_lengths(yarns, fabric)
    plain = plain_stitches(fabric) & (given > 0.0)
    if not plain.any():
        raise ParameterError("loop length: the fabric has no plain stitch off its borders to set it by; use a factor")
    of_face = np.full(fabric.face_count, np.median(loop_length / given[plain]))
    of_face[plain] = loop_length / given[plain]
    face = segment_faces(yarns)
    return np.where(face == UNKNOWN_FACE, 1.0, of_face[face])


def plain_stitches(fabric: StitchMesh) -> NDArray[np.bool_]:
    """Whether each face is plain: knit or purl, between stitches of its wale direction, in no cable, shape (F,)."""
    odd = (fabric.twin == BORDER) | fabric.mismatched | (fabric.cable_shift != 0)
    odd_sides = np.bincount(fabric.side_face[odd], minlength=fabric.face_count)
    return np.isin(fabric.stitch, [Stitch.KNIT, Stitch.PURL]) & (odd_sides == 0)


def _of_stitch(yarns: YarnSet, fabric: StitchMesh, code: str) -> NDArray[np.bool_]:
    found = fabric.stitch == CODES[code]
    if not found.any():
        there = [known for known, stitch in CODES.items() if (fabric.stitch == stitch).any()]
        raise ParameterError(f"rest length {code}: the fabric has no such stitch; it has {', '.join(there) or 'none'}")
    face = segment_faces(yarns)
    return (face != UNKNOWN_FACE) & found[face]


def _of_row(yarns: YarnSet, row: int) -> NDArray[np.bool_]:
    _check_stitches_known(yarns, f"rest length row:{row}")
    rows = np.where(segment_faces(yarns) == UNKNOWN_FACE, -1, yarns.row[yarns.segment_points[:, 1]])
    found = (rows == row) & (rows >= 0)
    if not found.any():
        raise ParameterError(f"rest length row:{row}: no yarn is in that row; expected 0 to {rows.max()}")
    return found


def _of_yarn(yarns: YarnSet, yarn: int) -> NDArray[np.bool_]:
    if not 0 <= yarn < yarns.yarn_count:
        raise ParameterError(f"rest length yarn:{yarn}: there is no such yarn; expected 0 to {yarns.yarn_count - 1}")
    return yarns.segment_yarn == yarn


def _of_part(yarns: YarnSet, fabric: StitchMesh | None, name: str) -> NDArray[np.bool_]:
    if name in ("warp", "weft"):
        return _of_weave(yarns, name)
    fabric = _own_fabric(yarns, fabric, f"rest length {name}")
    face = segment_faces(yarns)
    own = yarns.row[yarns.segment_points[:, 1]] == fabric.row[face]
    holds = np.isin(fabric.stitch[face], SLIPS if name == "floats" else HOLDING) & (face != UNKNOWN_FACE)
    found: NDArray[np.bool_] = holds & (own if name == "floats" else ~own)
    if name == "floats":
        found = found | (yarns.part[yarns.segment_points[:, 1]] == FLOATING)
    if not found.any():
        passing = "no slip stitch for yarn to pass by, nor stitches of another yarn"
        missing = passing if name == "floats" else "no slip or tuck that holds a loop"
        raise ParameterError(f"rest length {name}: the fabric has {missing}; leave the factor out")
    return found


def _of_weave(yarns: YarnSet, name: str) -> NDArray[np.bool_]:
    """Segments of the warps or of the wefts."""
    step = yarns.lattice_step
    if step is None or (yarns.face != UNKNOWN_FACE).any() or not step.any(axis=0).all():
        raise ParameterError(f"rest length {name}: the yarns are not woven; use it for a weave, or yarn:N")
    found: NDArray[np.bool_] = (step[:, 0 if name == "weft" else 1] != 0)[yarns.segment_yarn]
    return found
