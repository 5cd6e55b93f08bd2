# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns from and to files, by suffix.

Inside StitchMesh yarns are B-splines. HDF5 keeps everything about them, USD all but rest lengths and natural
curvatures, to float32; the other formats keep the curves, VTP with the colours. A BCC file usually holds Catmull-Rom
curves, which pass through the same knots and differ in between: the largest distance is logged. BCC and OBJ state no
radius: reading estimates one, and a warning says so.

Yarns that repeat stay so in HDF5 and in ``.pyp``. The other formats hold a finite piece of them, one period or as many
tiles as are asked for: its yarns are open and cut where the cell's go on (``tiling``). USD draws tiles as instances.
"""

from __future__ import annotations

import dataclasses
import logging
import math
from collections.abc import Callable
from dataclasses import dataclass
from os import fspath
from pathlib import Path
from typing import Any

import numpy as np

from stitchmesh.errors import FileError, ParameterError, YarnError
from stitchmesh.io.contents import FilePath, suffix_of
from stitchmesh.io.hdf5 import read_noun, write_noun
from stitchmesh.io.units import DEFAULT_UNIT, centimetres, check_unit_left_out
from stitchmesh.io.yarn_formats import bcc
from stitchmesh.io.yarn_formats.gltf import holds_tubes, write_glb
from stitchmesh.io.yarn_formats.obj import read_obj_polylines, write_obj_polylines
from stitchmesh.io.yarn_formats.pyp import check_pyp, read_pyp, write_pyp
from stitchmesh.io.yarn_formats.splines import bspline_to_catmull_rom, catmull_rom_to_bspline, polyline_to_bspline
from stitchmesh.io.yarn_formats.usd import LABELS, read_usd, write_usd
from stitchmesh.io.yarn_formats.vtp import read_vtp, write_vtp
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.radius_estimate import estimate_radius
from stitchmesh.yarn.tiling import instances, tile_yarns

HDF5_FORMAT = "stitchmesh yarns"
BCC_CURVES = {"catmull-rom": bcc.CATMULL_ROM, "bspline": bcc.BSPLINE}
"""Kinds of curve that a BCC file can be written with; the first is the official one."""
POINTS_PER_SEGMENT = 4
"""Of the polylines in OBJ and VTP files."""

Tiles = tuple[int, int] | None
"""How often a cell is repeated along the courses and along the wales, if the caller says."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class YarnFormat:
    """How yarns of one suffix are read and written."""

    read: Callable[[FilePath, float, float | None], YarnSet]
    """From path, centimetres in the file's unit, and radius [cm] if the caller gave one."""
    write: Callable[[FilePath, YarnSet, float, str, Tiles], None]
    """To path, with centimetres in the file's unit, the kind of curve and how many tiles of yarns that repeat."""


def read_yarns(path: FilePath, *, unit: str = DEFAULT_UNIT, radius: float | None = None) -> YarnSet:
    """Read yarns.

    Args:
        path: an ``.h5``, ``.pyp``, ``.bcc``, ``.usda``, ``.usdc``, ``.usd``, ``.vtp`` or ``.obj`` file.
        unit: unit of the file's coordinates: mm, cm, dm, m or inch; HDF5, USD and ``.pyp`` files have their own.
        radius: radius of all yarns [cm]. Where None, the file's own, or for formats that hold none half the distance
            at which the yarns typically touch (``yarn_radius.estimate_radius``), and a warning says so.

    Raises:
        ParameterError: the unit is unknown, the radius is not positive, or there is none and it cannot be estimated.
        FileError: the file cannot be read, is malformed, or its format is unknown.
    """
    scale = centimetres(unit)
    if radius is not None and not (math.isfinite(radius) and radius > 0.0):
        raise ParameterError(f"radius: got {radius}; expected a positive number of cm")
    yarn_format = FORMATS[suffix_of(path, FORMATS)]
    try:
        return yarn_format.read(path, scale, radius)
    except YarnError as error:
        raise FileError(f"{fspath(path)}: {error}") from error


def write_yarns(
    path: FilePath, yarns: YarnSet, *, unit: str = DEFAULT_UNIT, curve: str = "catmull-rom", tiles: Tiles = None
) -> None:
    """Write yarns.

    Args:
        path: an ``.h5``, ``.pyp``, ``.bcc``, ``.usda``, ``.usdc``, ``.usd``, ``.vtp``, ``.glb`` or ``.obj`` file;
            missing folders are made.
        yarns: the yarns.
        unit: unit of the file's coordinates: mm, cm, dm, m or inch; HDF5 and USD files are in centimetres, glTF and
            ``.pyp`` files in metres.
        curve: kind of curve in a BCC file: ``catmull-rom``, which passes through the same knots, or ``bspline``, which
            is exact but not read everywhere.
        tiles: how often yarns that repeat are written along the courses and along the wales, as a finite piece; where
            None, HDF5 and ``.pyp`` files keep the lattice, and the others hold one period.

    Raises:
        ParameterError: the unit or the kind of curve is unknown, or the tiles are not two whole numbers from 1.
        YarnError: tiles are asked for of yarns that do not repeat.
        FileError: the format is unknown, cannot hold these yarns, or the file cannot be written.
    """
    scale = centimetres(unit)
    if curve not in BCC_CURVES:
        raise ParameterError(f"curve: got {curve!r}; expected one of {', '.join(BCC_CURVES)}")
    FORMATS[suffix_of(path, FORMATS)].write(path, yarns, scale, curve, tiles)


def check_writable(path: FilePath, yarns: YarnSet) -> None:
    """Refuse, before hours of work, what ``write_yarns`` would refuse after them.

    Raises:
        FileError: the path is a folder, its format is unknown or cannot hold these yarns.
    """
    if suffix_of(path, FORMATS) == ".pyp":
        check_pyp(path, yarns)
    if Path(path).is_dir():
        raise FileError(f"{fspath(path)}: is a folder; expected the name of a file to write")


def _read_hdf5(path: FilePath, scale: float, radius: float | None) -> YarnSet:
    check_unit_left_out(path, scale)
    yarns = read_noun(path, YarnSet, HDF5_FORMAT)
    return yarns if radius is None else _with_radius(yarns, radius)


def _write_hdf5(path: FilePath, yarns: YarnSet, scale: float, curve: str, tiles: Tiles) -> None:
    del curve  # control points are stored as they are
    check_unit_left_out(path, scale)
    write_noun(path, yarns if tiles is None else tile_yarns(yarns, *tiles), HDF5_FORMAT)


def _read_pyp(path: FilePath, scale: float, radius: float | None) -> YarnSet:
    check_unit_left_out(path, scale)
    yarns = read_pyp(path)
    return yarns if radius is None else _with_radius(yarns, radius)


def _write_pyp(path: FilePath, yarns: YarnSet, scale: float, curve: str, tiles: Tiles) -> None:
    del curve  # vertices are knots
    check_unit_left_out(path, scale)
    if tiles is not None:
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


def _write_bcc(path: FilePath, yarns: YarnSet, scale: float, curve: str, tiles: Tiles) -> None:
    yarns = _finite(path, yarns, tiles)
    closed = yarns.closed.tolist()
    curves = np.split(yarns.points, yarns.start[1:-1])
    if curve == "catmull-rom":
        pairs = [bspline_to_catmull_rom(control, flag) for control, flag in zip(curves, closed, strict=True)]
        curves = [points for points, _ in pairs]
        _log_conversion(path, max(error for _, error in pairs))
    bcc.write_bcc(path, bcc.BccCurves(BCC_CURVES[curve], [points / scale for points in curves], closed))


def _read_obj(path: FilePath, scale: float, radius: float | None) -> YarnSet:
    polylines, closed = read_obj_polylines(path)
    curves = [polyline_to_bspline(points * scale, flag) for points, flag in zip(polylines, closed, strict=True)]
    return _yarns_of_curves(curves, closed, radius)


def _write_obj(path: FilePath, yarns: YarnSet, scale: float, curve: str, tiles: Tiles) -> None:
    del curve  # a polyline is a polyline
    yarns = _finite(path, yarns, tiles)
    samples = [points / scale for points in yarns.sampled(POINTS_PER_SEGMENT)]
    write_obj_polylines(path, samples, yarns.closed.tolist())


def _read_usd(path: FilePath, scale: float, radius: float | None) -> YarnSet:
    check_unit_left_out(path, scale)
    curves = read_usd(path)
    radii = [curve.radius for curve in curves if curve.radius is not None]
    own = np.array(radii) if len(radii) == len(curves) else None
    closed = [curve.closed for curve in curves]
    yarns = _yarns_of_curves([curve.points for curve in curves], closed, own if radius is None else radius)
    shared = [name for name in LABELS if all(name in curve.labels for curve in curves)]
    labels: dict[str, Any] = {name: np.concatenate([curve.labels[name] for curve in curves]) for name in shared}
    if all(curve.colour is not None for curve in curves):
        labels["colour"] = [curve.colour for curve in curves]
    return dataclasses.replace(yarns, **labels)


def _write_usd(path: FilePath, yarns: YarnSet, scale: float, curve: str, tiles: Tiles) -> None:
    del curve  # control points are stored as they are
    check_unit_left_out(path, scale)
    places = None if tiles is None else instances(_lattice(path, yarns), *tiles)
    write_usd(path, _finite(path, yarns, None if tiles is None else (1, 1)), places)


def _read_vtp(path: FilePath, scale: float, radius: float | None) -> YarnSet:
    content = read_vtp(path)
    pairs = zip(content.curves, content.closed, strict=True)
    curves = [polyline_to_bspline(points * scale, flag) for points, flag in pairs]
    own = None if content.radius is None else content.radius * scale
    yarns = _yarns_of_curves(curves, content.closed, own if radius is None else radius)
    return yarns if content.colour is None else dataclasses.replace(yarns, colour=content.colour)


def _write_vtp(path: FilePath, yarns: YarnSet, scale: float, curve: str, tiles: Tiles) -> None:
    del curve  # a polyline is a polyline
    write_vtp(path, _finite(path, yarns, tiles), scale, POINTS_PER_SEGMENT)


def _read_glb(path: FilePath, scale: float, radius: float | None) -> YarnSet:
    del scale, radius
    raise holds_tubes(path)


def _write_glb(path: FilePath, yarns: YarnSet, scale: float, curve: str, tiles: Tiles) -> None:
    del curve  # tubes are triangles
    check_unit_left_out(path, scale)
    write_glb(path, _finite(path, yarns, tiles))


FORMATS: dict[str, YarnFormat] = {
    ".h5": YarnFormat(_read_hdf5, _write_hdf5),
    ".pyp": YarnFormat(_read_pyp, _write_pyp),
    ".bcc": YarnFormat(_read_bcc, _write_bcc),
    ".usda": YarnFormat(_read_usd, _write_usd),
    ".usdc": YarnFormat(_read_usd, _write_usd),
    ".usd": YarnFormat(_read_usd, _write_usd),
    ".vtp": YarnFormat(_read_vtp, _write_vtp),
    ".glb": YarnFormat(_read_glb, _write_glb),
    ".obj": YarnFormat(_read_obj, _write_obj),
}
"""The formats of yarns."""


def _yarns_of_curves(
    curves: list[FloatArray], closed: list[bool], radius: float | FloatArray | None
) -> YarnSet:
    yarns = YarnSet.from_curves(curves, closed=closed, radius=1.0 if radius is None else radius)
    if radius is not None:
        return yarns
    estimate = estimate_radius(yarns)
    logger.warning(
        "yarn radius: %.4g cm, estimated from the distances of yarns; give --yarn-radius to set it", estimate
    )
    return _with_radius(yarns, estimate)


def _with_radius(yarns: YarnSet, radius: float) -> YarnSet:
    return dataclasses.replace(yarns, radius=np.full(yarns.yarn_count, radius))


def _log_conversion(path: FilePath, error: float) -> None:
    logger.info("%s: Catmull-Rom curves and B-splines lie up to %.3g cm apart between knots", fspath(path), error)


def _finite(path: FilePath, yarns: YarnSet, tiles: Tiles) -> YarnSet:
    """Yarns for a format that has no lattice: as they are, or a piece of those that repeat."""
    if tiles is not None:
        return tile_yarns(yarns, *tiles)
    if yarns.lattice is None:
        return yarns
    logger.info("%s: holds one period of yarns that repeat, as yarns with ends; .h5 keeps the periods", fspath(path))
    return tile_yarns(yarns, 1, 1)


def _lattice(path: FilePath, yarns: YarnSet) -> Lattice:
    if yarns.lattice is None:
        raise YarnError(f"{fspath(path)}: tiles of yarns that do not repeat; expected a cell on a lattice")
    return yarns.lattice
