# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The faces of a fabric that a selection names."""

from __future__ import annotations

import re
from os import fspath

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError, ParameterError, check_kind
from stitchmesh.hand_knitting.words import stitch_named
from stitchmesh.io.contents import FilePath, read_lines
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.selection.borders import Border, band_distance, named_borders
from stitchmesh.selection.parse import parse_selection
from stitchmesh.selection.parts import Parts
from stitchmesh.selection.selection import (
    AtBorder,
    Both,
    Either,
    Everything,
    Faces,
    FacesOfFile,
    GarmentPart,
    LastRows,
    OfYarn,
    Rectangle,
    RectangleBetween,
    Ring,
    RowRange,
    Selection,
    Spans,
    Stitches,
    Wale,
    WalePanel,
    Without,
)
from stitchmesh.selection.wales import panel_faces, rectangle_between, rectangle_faces, ring_rows, wale_faces

Mask = NDArray[np.bool_]

NUMBER = re.compile(r"[0-9]{1,18}")
"""The number of a face in a file."""


def select(fabric: StitchMesh, selection: str | Selection) -> IntArray:
    """Return the faces of a fabric that a selection names.

    Args:
        fabric: a stitch mesh; for borders and parts of a garment, the y axis points up and the wearer looks along +z.
        selection: a text such as ``hem 6`` or ``front and rows 20-40``, or a ``Selection``.

    Returns:
        Numbers of the faces, ascending, shape (n,), with n at least 1.

    Raises:
        ParameterError: the text is not a selection; a face, a row, a border or a part that it names does not exist; or
            no face belongs to the selection.
        FileError: a file of face numbers cannot be read, or holds something else.
    """
    check_kind("select", fabric, StitchMesh)
    chosen = parse_selection(selection) if isinstance(selection, str) else selection
    faces = np.flatnonzero(_mask(Parts(fabric), chosen))
    if not len(faces):
        raise ParameterError(f"selection {str(chosen)!r}: is empty; no face of the {fabric.face_count} belongs to it")
    return faces


def _mask(parts: Parts, selection: Selection) -> Mask:
    """Return whether each face belongs to a selection, shape (F,)."""
    match selection:
        case Either(one, other):
            return _mask(parts, one) | _mask(parts, other)
        case Both(one, other):
            return _mask(parts, one) & _mask(parts, other)
        case Without(part):
            return ~_mask(parts, part)
        case Everything():
            return np.ones(parts.fabric.face_count, dtype=bool)
        case AtBorder():
            return _band(parts, selection)
        case GarmentPart():
            return _place(parts, selection)
        case RowRange(spans):
            return _rows(parts, spans)
        case LastRows(count):
            return parts.row_index >= len(parts.row_numbers) - count
        case OfYarn(spans):
            return in_spans(parts.fabric.yarn, spans)
        case Stitches(name):
            return _stitches(parts.fabric, name)
        case Ring():
            return np.isin(parts.row_index, ring_rows(parts, selection))
    return _listed(parts, selection)


def _listed(parts: Parts, selection: Selection) -> Mask:
    """Return the mask of a selection that lists its faces."""
    fabric = parts.fabric
    match selection:
        case Faces(spans):
            _check_faces(fabric, str(selection), max(span.first if span.last is None else span.last for span in spans))
            return in_spans(np.arange(fabric.face_count), spans)
        case FacesOfFile(path):
            faces = read_faces(path)
            _check_faces(fabric, path, int(faces.max(initial=0)))
        case Wale():
            faces = wale_faces(fabric, selection)
        case Rectangle():
            faces = rectangle_faces(fabric, selection)
        case RectangleBetween():
            faces = rectangle_between(fabric, selection)
        case WalePanel():
            faces = panel_faces(parts, selection)
        case _:
            raise ParameterError(f"selection: got {type(selection).__name__}; expected a text or a selection")
    mask = np.zeros(fabric.face_count, dtype=bool)
    mask[faces] = True
    return mask


def in_spans(numbers: IntArray, spans: Spans) -> Mask:
    """Return whether each number belongs to one of some spans, shape as ``numbers``."""
    chosen = np.zeros(numbers.shape, dtype=bool)
    for span in spans:
        inside = (numbers >= span.first) & ((numbers <= span.last) if span.last is not None else True)
        chosen |= inside & ((numbers - span.first) % span.step < span.height)
    return chosen


def _rows(parts: Parts, spans: Spans) -> Mask:
    chosen = in_spans(parts.row_numbers, spans)
    if not chosen.any():
        last = parts.row_numbers[-1]
        raise ParameterError(f"{RowRange(spans)}: the fabric has no such row; its rows are 0 to {last}")
    return chosen[parts.row_index]


def borders_named(borders: list[Border], band: AtBorder) -> list[Border]:
    """Return the borders that a selection of bands names.

    Raises:
        ParameterError: the fabric has no such border.
    """
    if band.name == "border":
        found = [border for border in borders if border.number == band.number]
    else:
        found = named_borders(borders, band.name, band.hand)
    if not found:
        known = ", ".join(dict.fromkeys(border.name for border in borders)) or "none"
        raise ParameterError(f"{band}: the fabric has no such border; its borders are {known}")
    return found


def _band(parts: Parts, band: AtBorder) -> Mask:
    found = borders_named(parts.borders, band)
    ends = [span.last for span in band.spans]
    farthest = None if None in ends else max(end for end in ends if end is not None)
    distance = band_distance(parts.fabric, np.concatenate([border.sides for border in found]), farthest)
    return in_spans(distance, band.spans) & (distance > 0)


def _place(parts: Parts, place: GarmentPart) -> Mask:
    match place.name:
        case "front":
            return parts.in_front
        case "back":
            return ~parts.in_front
        case "left":
            return parts.on_left
        case "right":
            return ~parts.on_left
    sleeves = np.isin(parts.row_index, parts.sleeve_rows(place.hand))
    if place.name == "sleeves" and not sleeves.any():
        raise ParameterError(f"{place}: the fabric has none; a sleeve is a tube of rows from a cuff to the body")
    return sleeves if place.name == "sleeves" else ~sleeves


def _stitches(fabric: StitchMesh, name: str) -> Mask:
    match name:
        case "increases":
            return fabric.n_top > fabric.n_bottom
        case "decreases":
            return fabric.n_top < fabric.n_bottom
        case "cables" | "twists":
            marked = fabric.side_face[np.flatnonzero(fabric.cable_shift if name == "cables" else fabric.twist)]
            return np.isin(np.arange(fabric.face_count), marked)
        case "cast-on":
            return fabric.stitch == Stitch.CAST_ON
        case "draw-through":
            return fabric.stitch == Stitch.DRAW_THROUGH
    return fabric.stitch == stitch_named(name)


def _check_faces(fabric: StitchMesh, what: str, largest: int) -> None:
    if largest >= fabric.face_count:
        raise ParameterError(f"{what}: face {largest} does not exist; the mesh has faces 0 to {fabric.face_count - 1}")


def read_faces(path: FilePath) -> IntArray:
    """Read the numbers of faces from a text file.

    Raises:
        FileError: the file cannot be read, or holds something other than whole numbers.
    """
    words: list[str] = []
    for number, line in enumerate(read_lines(path), start=1):
        found = re.split(r"[\s,]+", line.partition("#")[0].strip())
        bad = [word for word in found if word and not NUMBER.fullmatch(word)]
        if bad:
            raise FileError(f"{fspath(path)} line {number}: got {bad[0][:20]!r}; expected numbers of faces")
        words += [word for word in found if word]
    return np.array(words, dtype=np.int64)
