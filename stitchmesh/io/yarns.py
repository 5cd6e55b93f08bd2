# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Reading and writing of yarns; the suffix of the file decides the format.

In the program yarns are cubic B-splines. HDF5 keeps every field of a yarn set without loss. USD keeps all fields
except rest lengths and natural curvatures, with coordinates rounded to float32. The other formats keep only the curves,
VTP also the colours and both radii, and glTF the colours and tubes of the apparent radius. A BCC file usually holds
Catmull-Rom curves, which pass through the same knots as the B-splines but differ from them between the knots; the
largest distance between the two curves is logged. BCC and OBJ files state no radius: the radius is then estimated, and
a warning is logged.

HDF5 and ``.pyp`` keep the lattice of periodic yarns. The other formats hold a finite piece of periodic yarns, by
default one period: the yarns of the piece are open and end at the borders of the piece (``stitchmesh.yarn.tiling``).
USD stores one period and draws the other periods as instances.
"""

from __future__ import annotations

import dataclasses
import logging
from collections.abc import Callable
from dataclasses import dataclass
from os import fspath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError, ParameterError, YarnError, check_kind, check_positive
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.io.hdf5 import read_dataclass, write_dataclass
from stitchmesh.io.mesh_formats.gltf_file import tubes_error
from stitchmesh.io.path_kind import refuse_folder
from stitchmesh.io.units import DEFAULT_UNIT, centimetres, check_unit_left_out
from stitchmesh.io.yarn_formats import bcc
from stitchmesh.io.yarn_formats.gltf import DETAILS, Detail, write_glb
from stitchmesh.io.yarn_formats.midpoint_curve import knots_of_polyline, polyline_of_knots
from stitchmesh.io.yarn_formats.obj import read_obj_polylines, write_obj_polylines
from stitchmesh.io.yarn_formats.pyp import check_pyp, read_pyp, write_pyp
from stitchmesh.io.yarn_formats.splines import bspline_to_catmull_rom, catmull_rom_to_bspline, polyline_to_bspline
from stitchmesh.io.yarn_formats.usd import write_usd
from stitchmesh.io.yarn_formats.usd_curves import LABELS, UsdCurve, read_usd
from stitchmesh.io.yarn_formats.vtp import POINTS_PER_SEGMENT, read_vtp, write_vtp
from stitchmesh.io.yarn_formats.yarn_chunks import YarnChunks, read_yarn_chunks, write_yarn_chunks
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.palette import empty_palette, filled_palette
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.radius_estimate import estimate_radius
from stitchmesh.yarn.rest_length import marked_stretches
from stitchmesh.yarn.tiling import instances, tile_yarns

HDF5_FORMAT = "stitchmesh yarns"
"""Attribute ``format`` of HDF5 files of yarns."""
BCC_CURVES = {"catmull-rom": bcc.CATMULL_ROM, "bspline": bcc.BSPLINE}
"""Kinds of curve that can be written to a BCC file; the first is the kind that most programs read."""
LARGEST_COLOUR = 65_535
"""Largest number of a colour in files that state numbers and colours."""

Tiles = tuple[int, int] | None
"""Numbers of periods to write along the courses and along the wales, or None."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class _Writing:
    """How yarns are written; a format uses what it can hold."""

    scale: float
    """Number of centimetres in the file's unit."""
    curve: str
    """Kind of curve in a BCC file."""
    tiles: Tiles
    """Periods of periodic yarns that are written."""
    detail: Detail
    """Level of detail of tubes."""


@dataclass(frozen=True)
class YarnFormat:
    """The functions of one format of yarns."""

    read: Callable[[FilePath, float, float | None], YarnSet]
    """Function of the path, the number of centimetres in the file's unit, and the given radius [cm] or None."""
    write: Callable[[FilePath, YarnSet, _Writing], None]
    """Function of the path, the yarns, and how they are written."""
    has_unit: bool = False
    """Whether the format fixes or states its unit, so that the caller gives none."""


def read_yarns(path: FilePath, *, unit: str = DEFAULT_UNIT, radius: float | None = None) -> YarnSet:
    """Read yarns.

    Args:
        path: an ``.h5``, ``.pyp``, ``.bcc``, ``.yarns``, ``.usda``, ``.usdc``, ``.usd``, ``.vtp`` or ``.obj`` file.
        unit: unit of the coordinates in the file: mm, cm, dm, m or inch. HDF5, USD and ``.pyp`` files state or
            prescribe their unit; leave the unit out for them.
        radius: radius of all yarns [cm]. If it is None, the radius in the file is used. If the file states no radius,
            the radius is estimated as half the typical distance of touching yarns
            (``stitchmesh.yarn.radius_estimate``), and a warning is logged.

    Raises:
        ParameterError: the unit is unknown, the radius is not positive, or no radius is given or stated and it cannot
            be estimated.
        FileError: the file cannot be read, is malformed, or its suffix is unknown.
    """
    scale = centimetres(unit)
    if radius is not None:
        check_positive("radius", radius, "cm")
    yarn_format = FORMATS[suffix_of(path, FORMATS)]
    if yarn_format.has_unit:
        check_unit_left_out(path, scale)
    try:
        return yarn_format.read(path, scale, radius)
    except YarnError as error:
        raise FileError(f"{fspath(path)}: {error}") from error


def write_yarns(
    path: FilePath, yarns: YarnSet, *, unit: str = DEFAULT_UNIT, curve: str = "catmull-rom", tiles: Tiles = None,
    detail: Detail = "fine",
) -> None:  # fmt: skip
    """Write yarns.

    Args:
        path: an ``.h5``, ``.pyp``, ``.bcc``, ``.yarns``, ``.usda``, ``.usdc``, ``.usd``, ``.vtp``, ``.glb`` or ``.obj``
            file; missing folders are made.
        yarns: the yarns.
        unit: unit of the coordinates in the file: mm, cm, dm, m or inch. HDF5 and USD files are always in centimetres,
            glTF and ``.pyp`` files in metres; leave the unit out for them.
        curve: kind of curve in a BCC file: ``catmull-rom``, which agrees with the yarns at the knots only, or
            ``bspline``, which is exact but which fewer programs read.
        tiles: numbers of periods of periodic yarns to write along the courses and along the wales, as a finite piece.
            If it is None, HDF5 and ``.pyp`` files keep the lattice, and the other formats hold one period.
        detail: level of detail of tubes in a glTF file: ``fine``, or ``coarse`` for a small file.

    Raises:
        ParameterError: the unit, the kind of curve or the level of detail is unknown, a unit, a coarse level or tiles
            are given for a format that cannot have them, or the tiles are not two whole numbers from 1.
        YarnError: tiles are given for yarns that are not periodic.
        FileError: the suffix is unknown, the format cannot hold these yarns, or the file cannot be written.
    """
    scale = centimetres(unit)
    if curve not in BCC_CURVES:
        raise ParameterError(f"curve: got {curve!r}; expected one of {', '.join(BCC_CURVES)}")
    if detail not in DETAILS:
        raise ParameterError(f"detail: got {detail!r}; expected one of {', '.join(DETAILS)}")
    suffix = suffix_of(path, FORMATS)
    if detail != DETAILS[0] and suffix != ".glb":
        raise ParameterError(f"detail: {fspath(path)} holds curves and no tubes; leave the detail out, or write .glb")
    yarn_format = FORMATS[suffix]
    check_kind("write_yarns", yarns, YarnSet)
    if yarn_format.has_unit:
        check_unit_left_out(path, scale)
    yarn_format.write(path, yarns, _Writing(scale, curve, tiles, detail))


def check_writable(path: FilePath, yarns: YarnSet) -> None:
    """Check that ``write_yarns`` can write yarns to a path, before a long computation.

    Args:
        path: the file to write later.
        yarns: yarns with the same lattice, radii and natural curvatures as those to write.

    Raises:
        FileError: the path is a folder, its suffix is unknown, or its format cannot hold these yarns.
    """
    if suffix_of(path, FORMATS) == ".pyp":
        check_pyp(path, yarns)
    refuse_folder(path)


def _read_hdf5(path: FilePath, _: float, radius: float | None) -> YarnSet:
    yarns = read_dataclass(path, YarnSet, HDF5_FORMAT)
    return yarns if radius is None else _with_radius(yarns, radius)


def _write_hdf5(path: FilePath, yarns: YarnSet, how: _Writing) -> None:
    write_dataclass(path, yarns if how.tiles is None else tile_yarns(yarns, *how.tiles), HDF5_FORMAT)


def _read_pyp(path: FilePath, _: float, radius: float | None) -> YarnSet:
    yarns = read_pyp(path)
    return yarns if radius is None else _with_radius(yarns, radius)


def _write_pyp(path: FilePath, yarns: YarnSet, how: _Writing) -> None:
    if how.tiles is not None:
        raise ParameterError(f"tiles: {fspath(path)} is of a format that holds one period; leave the tiles out")
    write_pyp(path, yarns)


def _read_bcc(path: FilePath, scale: float, radius: float | None) -> YarnSet:
    content = bcc.read_bcc(path)
    curves = [points * scale for points in content.curves]
    if content.kind == bcc.POLYLINE:
        curves = [polyline_to_bspline(points, closed) for points, closed in zip(curves, content.closed, strict=True)]
    elif content.kind == bcc.CATMULL_ROM:
        pairs = [catmull_rom_to_bspline(points, closed) for points, closed in zip(curves, content.closed, strict=True)]
        curves = [control for control, _ in pairs]
        _log_conversion(path, max(error for _, error in pairs))
    return _yarns_of_curves(curves, content.closed, radius)


def _write_bcc(path: FilePath, yarns: YarnSet, how: _Writing) -> None:
    yarns = _finite(path, yarns, how.tiles)
    closed = yarns.closed.tolist()
    curves = np.split(yarns.points, yarns.start[1:-1])
    if how.curve == "catmull-rom":
        pairs = [bspline_to_catmull_rom(control, flag) for control, flag in zip(curves, closed, strict=True)]
        curves = [points for points, _ in pairs]
        _log_conversion(path, max(error for _, error in pairs))
    bcc.write_bcc(path, bcc.BccCurves(BCC_CURVES[how.curve], [points / how.scale for points in curves], closed))


def _read_obj(path: FilePath, scale: float, radius: float | None) -> YarnSet:
    polylines, closed = read_obj_polylines(path)
    curves = [polyline_to_bspline(points * scale, flag) for points, flag in zip(polylines, closed, strict=True)]
    return _yarns_of_curves(curves, closed, radius)


def _write_obj(path: FilePath, yarns: YarnSet, how: _Writing) -> None:
    yarns = _finite(path, yarns, how.tiles)
    samples = [points / how.scale for points in yarns.sampled(POINTS_PER_SEGMENT)]
    write_obj_polylines(path, samples, yarns.closed.tolist())


def _read_usd(path: FilePath, _: float, radius: float | None) -> YarnSet:
    return yarns_of_usd(read_usd(path), radius)


def yarns_of_usd(curves: list[UsdCurve], radius: float | None = None) -> YarnSet:
    """Return the yarns of the curves of a stage; a radius [cm], if given, holds for all of them.

    Raises:
        YarnError: the curves are no yarns.
    """
    own = _array_of_all([curve.radius for curve in curves])
    closed = [curve.closed for curve in curves]
    yarns = _yarns_of_curves([curve.points for curve in curves], closed, own if radius is None else radius)
    shared = [name for name in LABELS if all(name in curve.labels for curve in curves)]
    labels: dict[str, Any] = {name: np.concatenate([curve.labels[name] for curve in curves]) for name in shared}
    labels |= _colours(
        _array_of_all([curve.colour for curve in curves]), _array_of_all([curve.display_colour for curve in curves])
    )
    drawn = _array_of_all([curve.drawn_radius for curve in curves])
    if radius is None and drawn is not None:
        labels["drawn_radius"] = drawn
    return dataclasses.replace(yarns, **labels)


def _write_usd(path: FilePath, yarns: YarnSet, how: _Writing) -> None:
    places = None if how.tiles is None else instances(_lattice(path, yarns), *how.tiles)
    write_usd(path, _finite(path, yarns, None if how.tiles is None else (1, 1)), places)


def _read_vtp(path: FilePath, scale: float, radius: float | None) -> YarnSet:
    content = read_vtp(path)
    pairs = zip(content.curves, content.closed, strict=True)
    curves = [polyline_to_bspline(points * scale, flag) for points, flag in pairs]
    own = None if content.radius is None else content.radius * scale
    yarns = _yarns_of_curves(curves, content.closed, own if radius is None else radius)
    changes = _colours(content.colour, content.rgb)
    if radius is None and content.drawn_radius is not None:
        changes["drawn_radius"] = content.drawn_radius * scale
    return dataclasses.replace(yarns, **changes)


def _write_vtp(path: FilePath, yarns: YarnSet, how: _Writing) -> None:
    write_vtp(path, _finite(path, yarns, how.tiles), how.scale)


def _read_yarns(path: FilePath, scale: float, radius: float | None) -> YarnSet:
    content = read_yarn_chunks(path)
    closed = [len(curve) > 3 and bool((curve[0] == curve[-1]).all()) for curve in content.curves]
    knots = [knots_of_polyline(curve * scale, flag) for curve, flag in zip(content.curves, closed, strict=True)]
    curves = [polyline_to_bspline(points, flag) for points, flag in zip(knots, closed, strict=True)]
    own = content.radius * scale if (content.radius > 0.0).all() else None
    yarns = _yarns_of_curves(curves, closed, own if radius is None else radius)
    rest = np.concatenate(
        [
            lengths * marked_stretches({point: length * scale for point, length in marks.items()}, lengths)
            for marks, lengths in zip(content.lengths, np.split(yarns.lengths, yarns.segment_start[1:-1]), strict=True)
        ]
    )
    return dataclasses.replace(yarns, rest_length=rest, **_colours(None, content.rgba[:, :3]))


def _write_yarns(path: FilePath, yarns: YarnSet, how: _Writing) -> None:
    yarns = _finite(path, yarns, how.tiles)
    curves = [
        polyline_of_knots(points, flag) / how.scale
        for points, flag in zip(yarns.sampled(1), yarns.closed.tolist(), strict=True)
    ]
    shown = filled_palette(yarns.palette, int(yarns.colour.max()) + 1)[yarns.colour]
    rgba = np.concatenate([shown, np.full((yarns.yarn_count, 1), 255)], axis=1).astype(np.uint8)
    rest = np.split(yarns.rest_length / how.scale, yarns.segment_start[1:-1])
    marks = [dict(enumerate(lengths.tolist())) for lengths in rest]
    write_yarn_chunks(path, YarnChunks(curves, yarns.radius / how.scale, rgba, marks))


def _read_glb(path: FilePath, _: float, __: float | None) -> YarnSet:
    raise tubes_error(path)


def _write_glb(path: FilePath, yarns: YarnSet, how: _Writing) -> None:
    write_glb(path, _finite(path, yarns, how.tiles), how.detail)


FORMATS: dict[str, YarnFormat] = {
    ".h5": YarnFormat(_read_hdf5, _write_hdf5, has_unit=True),
    ".pyp": YarnFormat(_read_pyp, _write_pyp, has_unit=True),
    ".bcc": YarnFormat(_read_bcc, _write_bcc),
    **dict.fromkeys((".usda", ".usdc", ".usd"), YarnFormat(_read_usd, _write_usd, has_unit=True)),
    ".vtp": YarnFormat(_read_vtp, _write_vtp),
    ".yarns": YarnFormat(_read_yarns, _write_yarns),
    ".glb": YarnFormat(_read_glb, _write_glb, has_unit=True),
    ".obj": YarnFormat(_read_obj, _write_obj),
}
"""Formats of yarns, by suffix."""


def _yarns_of_curves(curves: list[FloatArray], closed: list[bool], radius: float | FloatArray | None) -> YarnSet:
    """Return yarns with the given control points; the radius is estimated if it is None."""
    yarns = YarnSet.from_curves(curves, closed=closed, radius=1.0 if radius is None else radius)
    if radius is not None:
        return yarns
    estimate = estimate_radius(yarns)
    logger.warning("yarn radius: %.4g cm, estimated from the distances between yarns; --yarn-radius sets it", estimate)
    return _with_radius(yarns, estimate)


def _array_of_all(values: list[Any]) -> NDArray | None:
    """Return the values as an array; None if one of them is None."""
    return None if any(value is None for value in values) else np.array(values)


def _colours(number: IntArray | None, shown: NDArray[np.uint8] | None) -> dict[str, Any]:
    """Return the fields ``colour`` and ``palette`` of yarns.

    Args:
        number: colour number of each yarn, shape (Y,); if None, equal colours have one number.
        shown: colour of each yarn (sRGB), shape (Y, 3); None if the file states none.

    Raises:
        YarnError: a number is negative, or larger than a palette may be.
    """
    if number is not None and not 0 <= number.min() <= number.max() <= LARGEST_COLOUR:
        found = f"got colours {number.min()} to {number.max()}"
        raise YarnError(f"{found}; expected numbers from 0 to {LARGEST_COLOUR}")
    if shown is None:
        return {} if number is None else {"colour": number}
    if number is None:
        palette, number = np.unique(shown, axis=0, return_inverse=True)
        return {"colour": number.ravel(), "palette": palette}
    palette = filled_palette(empty_palette(), int(number.max()) + 1)
    if (palette[number] == shown).all():
        return {"colour": number}
    palette[number] = shown
    return {"colour": number, "palette": palette}


def _with_radius(yarns: YarnSet, radius: float) -> YarnSet:
    return yarns.with_radius(radius)


def _log_conversion(path: FilePath, error: float) -> None:
    message = "%s: the Catmull-Rom curves differ from the B-splines by up to %.3g cm between the knots"
    logger.debug(message, fspath(path), error)


def _finite(path: FilePath, yarns: YarnSet, tiles: Tiles) -> YarnSet:
    """Return yarns for a format without a lattice: the yarns themselves, or a finite piece of periodic yarns."""
    if tiles is not None:
        return tile_yarns(yarns, *tiles)
    if yarns.lattice is None:
        return yarns
    logger.info("%s: holds one period of the periodic yarns, as yarns with ends; .h5 keeps the lattice", fspath(path))
    return tile_yarns(yarns, 1, 1)


def _lattice(path: FilePath, yarns: YarnSet) -> Lattice:
    if yarns.lattice is None:
        raise YarnError(f"{fspath(path)}: got tiles of yarns that do not repeat; expected a cell on a lattice")
    return yarns.lattice
