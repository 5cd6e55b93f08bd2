# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Curves of USD stages, read in a process of their own (``stitchmesh.io.guarded_child``)."""

from __future__ import annotations

from dataclasses import dataclass
from os import fspath
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError, first_few
from stitchmesh.io.checkpoint_file import CheckpointFile, checked_header
from stitchmesh.io.contents import FilePath, check_points
from stitchmesh.io.guarded_child import answer_of_child, answer_parent
from stitchmesh.io.usd_stage import LIBRARIES, read_stage, to_centimetres
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.palette import srgb_colour

if TYPE_CHECKING:
    from pxr import Usd

LABELS = ("row", "face", "part")
"""Fields of a yarn set that are kept for each control point."""
CONTACT_RADIUS = "contactRadius"
"""Name of the primvar with the contact radius of each curve [cm]."""


@dataclass(frozen=True)
class UsdCurve:
    """One curve of a stage, in world coordinates."""

    points: FloatArray
    """B-spline control points [cm], y up, shape (n, 3)."""
    closed: bool
    """Whether the curve is closed."""
    radius: float | None
    """Contact radius of the curve [cm]: half its width if the file states no other, and None without a width."""
    drawn_radius: float | None
    """Half the width of the curve [cm]; None if the file states no width."""
    yarn: int | None
    """Number of the yarn; None if the file states none."""
    colour: int | None
    """Number of the colour; None if the file states none."""
    display_colour: NDArray[np.uint8] | None
    """Colour (sRGB), shape (3,); None if the file states none."""
    labels: dict[str, IntArray]
    """Values of the fields of ``LABELS`` that the file states, shape (n,) each."""


class _CurveHeader(TypedDict):
    """The numbers of a curve that are no arrays."""

    closed: bool
    radius: float | None
    drawn_radius: float | None
    yarn: int | None
    colour: int | None


class _Header(TypedDict):
    """The header that the child hands over with the arrays of the curves."""

    error: str
    """Error message; empty if the stage was read."""
    curves: list[_CurveHeader]


def read_usd(path: FilePath) -> list[UsdCurve]:
    """Read the curves of a stage, in the order of their yarn numbers, or of the stage if yarn numbers are missing.

    Raises:
        FileError: the file cannot be read, is malformed, has no curves, or has curves that are not cubic B-splines, or
            the process that reads it ends.
    """
    content = answer_of_child(__name__, path, in_place=True)
    header = checked_header(path, content, _Header)
    return [_unpacked(content, number, own) for number, own in enumerate(header["curves"])]


def curves_of_stage(path: FilePath) -> list[UsdCurve]:
    """Read the curves of a stage in this process; the child of ``read_usd`` does so.

    Raises:
        FileError: the file is malformed, names files outside of its folder, has no curves, or has curves that are not
            cubic B-splines.
    """
    from pxr import UsdGeom

    def read(name: str, stage: Usd.Stage) -> list[UsdCurve]:
        prims = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.BasisCurves)]
        return [curve for prim in prims for curve in _curves_of(name, prim)]

    curves = read_stage(path, read)
    if not curves:
        raise FileError(f"{fspath(path)}: has no curves; expected prims of type BasisCurves")
    if any(curve.yarn is None for curve in curves):
        return curves
    return sorted(curves, key=lambda curve: curve.yarn or 0)


def packed_curves(stage: str) -> CheckpointFile:
    """Read the curves of a stage for the parent of this process."""
    curves = curves_of_stage(stage)
    arrays = {f"{number} {name}": values for number, curve in enumerate(curves) for name, values in _arrays(curve)}
    heads = [{name: getattr(curve, name) for name in _CurveHeader.__annotations__} for curve in curves]
    return CheckpointFile({"curves": heads}, arrays)


def _arrays(curve: UsdCurve) -> list[tuple[str, NDArray[Any]]]:
    shown = [] if curve.display_colour is None else [("display_colour", curve.display_colour)]
    return [("points", curve.points), *shown, *curve.labels.items()]


def _unpacked(content: CheckpointFile, number: int, head: _CurveHeader) -> UsdCurve:
    """Return a curve from the data that the child has handed over."""
    own = {label: content.arrays.get(f"{number} {label}") for label in ("points", "display_colour", *LABELS)}
    labels = {label: values for label in LABELS if (values := own[label]) is not None}
    points = content.arrays[f"{number} points"]
    return UsdCurve(points=points, display_colour=own["display_colour"], labels=labels, **head)


def _curves_of(name: str, prim: Usd.Prim) -> list[UsdCurve]:
    """Return the curves of one prim."""
    from pxr import Usd, UsdGeom

    where = f"{name}: {prim.GetPath()}"
    curves = UsdGeom.BasisCurves(prim)
    time = Usd.TimeCode.EarliestTime()
    closed = _is_closed(where, [curves.GetTypeAttr(), curves.GetBasisAttr(), curves.GetWrapAttr()])
    points = _array(curves.GetPointsAttr(), np.float64).reshape(-1, 3)
    counts = _array(curves.GetCurveVertexCountsAttr(), np.int64)
    if (counts < 0).any() or counts.sum() != len(points):
        found = f"curves of {first_few(counts)} points, {counts.sum()} in total"
        raise FileError(f"{where}: got {found}; expected {len(points)} points in total; write it again")
    turn, shift, scale = to_centimetres(prim.GetStage(), curves.ComputeLocalToWorldTransform(time))
    placed = points @ turn + shift
    check_points(f"{where}: point", placed)
    cuts = np.cumsum(counts)[:-1]
    labels = {label: _primvar(prim, label, len(points)) for label in LABELS}
    split = {label: np.split(values, cuts) for label, values in labels.items() if values is not None}
    drawn = _radii(where, curves, len(counts))
    contact = _float_primvar(prim, CONTACT_RADIUS, (len(counts),))
    radius = drawn if contact is None else contact
    display = _float_primvar(prim, "displayColor", (len(counts), 3))
    shown = None if display is None else np.round(255 * np.clip(srgb_colour(display), 0.0, 1.0)).astype(np.uint8)
    yarn, colour = _primvar(prim, "yarn", len(counts)), _primvar(prim, "colour", len(counts))
    return [
        UsdCurve(
            points=own,
            closed=closed,
            radius=None if radius is None else float(radius[index] * scale),
            drawn_radius=None if drawn is None else float(drawn[index] * scale),
            yarn=None if yarn is None else int(yarn[index]),
            colour=None if colour is None else int(colour[index]),
            display_colour=None if shown is None else shown[index],
            labels={label: values[index] for label, values in split.items()},
        )
        for index, own in enumerate(np.split(placed, cuts))
    ]


def _is_closed(where: str, attributes: list[Usd.Attribute]) -> bool:
    """Return whether curves are closed, given their attributes type, basis and wrap."""
    kind, basis, wrap = (attribute.Get() for attribute in attributes)
    if (kind, basis) != ("cubic", "bspline") or wrap not in ("periodic", "nonperiodic"):
        found = f"{wrap} {kind} {basis}"
        raise FileError(f"{where}: got {found} curves; expected cubic bspline, periodic or nonperiodic; convert them")
    return bool(wrap == "periodic")


def _radii(where: str, curves: Any, count: int) -> FloatArray | None:
    """Return half the width of each curve in the unit of the prim, shape (count,), or None without widths."""
    widths = _array(curves.GetWidthsAttr(), np.float64)
    if len(widths) == 0:
        return None
    if len(widths) not in (1, count):
        raise FileError(f"{where}: got {len(widths)} widths of {count} curves; expected one, or one for each curve")
    return np.broadcast_to(widths / 2, count)


def _primvar(prim: Usd.Prim, name: str, count: int) -> IntArray | None:
    """Return a primvar that holds ``count`` integers; None if the prim has no such primvar."""
    from pxr import Usd, UsdGeom

    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar(name)
    values = np.array(primvar.ComputeFlattened(Usd.TimeCode.EarliestTime()) if primvar else [])
    return values.astype(np.int64) if values.shape == (count,) and values.dtype.kind == "i" else None


def _float_primvar(prim: Usd.Prim, name: str, shape: tuple[int, ...]) -> FloatArray | None:
    """Return a primvar of numbers of a shape, repeated if it is constant; None if the prim has no such primvar."""
    from pxr import Usd, UsdGeom

    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar(name)
    values = np.array(primvar.ComputeFlattened(Usd.TimeCode.EarliestTime()) if primvar else [])
    if values.dtype.kind != "f" or values.shape not in (shape, (1, *shape[1:])):
        return None
    return np.broadcast_to(values.astype(np.float64), shape)


def _array(attribute: Usd.Attribute, kind: Any) -> NDArray:
    from pxr import Usd

    values = attribute.Get(Usd.TimeCode.EarliestTime())
    return np.array([] if values is None else values, dtype=kind)


if __name__ == "__main__":
    answer_parent(lambda name, _: packed_curves(name), *LIBRARIES)
