# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Universal Scene Description (USD): yarns as ``BasisCurves``, with the control points of their cubic B-splines.

    /yarns          Xform, the default prim; the stage is y up with 0.01 metres to the unit
    /yarns/closed   BasisCurves, wrap periodic
    /yarns/open     BasisCurves, wrap nonperiodic; a prim without curves is left out

For tiles of periodic yarns, the curves of one period are below the prim /yarns/tiles/period, and the PointInstancer
/yarns/tiles, whose only prototype is this prim, draws them once for each tile. The first instance has no displacement.

``widths`` are apparent diameters: one number if all are equal, and otherwise one for each curve. The primvars ``yarn``
(the number of the yarn in the set), ``colour`` (its colour number), ``displayColor`` (its colour in linear light) and
``contactRadius`` belong to curves, and ``row``, ``face`` and ``part`` to control points. All curves are bound to the
material /yarns/wool, a rough ``UsdPreviewSurface`` whose colour is ``displayColor``. Coordinates are rounded to
float32. Curves of other programs can be read if they are cubic B-splines; their
transforms, their unit and an up axis z are taken into account.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import fspath
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError, first_few
from stitchmesh.io.atomic import atomic_path
from stitchmesh.io.contents import FilePath, read_bytes
from stitchmesh.io.float32 import to_float32
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.palette import STOCK, colours_of, linear_colour, srgb_colour
from stitchmesh.yarn import YarnSet

if TYPE_CHECKING:
    from pxr import Usd

METRES_PER_UNIT = 0.01
"""Unit of the coordinates in files that are written [m]."""
LABELS = ("row", "face", "part")
"""Fields of a yarn set that are kept for each control point."""
Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rotation of points with z up, as rows, to points with y up."""
CONTACT_RADIUS = "contactRadius"
"""Name of the primvar with the contact radius of each curve [cm]."""
ROUGHNESS = 0.9
"""Roughness of the material, from 0 (mirror) to 1 (matt)."""
PERIOD = "/yarns/tiles/period"
"""Path of the prim above the curves of one period, the prototype of the instances."""


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


def write_usd(path: FilePath, yarns: YarnSet, places: FloatArray | None = None) -> None:
    """Write yarns as text (``.usda``) or in binary (``.usdc``, ``.usd``).

    Args:
        path: the file.
        yarns: a set without a lattice.
        places: displacements of the instances of the yarns [cm], shape (n, 3). If it is None, the yarns are written
            without instances.

    Raises:
        FileError: a coordinate is too large for float32, or the file cannot be written.
    """
    from pxr import Sdf, Tf, Usd, UsdGeom, UsdShade

    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, METRES_PER_UNIT)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/yarns").GetPrim())
    wool = define_wool(stage, "/yarns/wool")
    widths = to_float32(path, "the widths", 2.0 * yarns.drawn_radius)
    points = to_float32(path, "the coordinates", yarns.points)
    above = "/yarns" if places is None else PERIOD
    for name, closed in (("closed", True), ("open", False)):
        chosen = np.flatnonzero(yarns.closed == closed)
        if len(chosen):
            curves = define_curves(stage, f"{above}/{name}", yarns, chosen, points, widths[chosen])
            UsdShade.MaterialBindingAPI.Apply(curves).Bind(wool)
    if places is not None:
        _define_instances(stage, to_float32(path, "the places", places))
    with atomic_path(path) as temporary:
        try:
            stage.GetRootLayer().Export(str(temporary))
        except Tf.ErrorException as error:
            raise FileError(f"{fspath(path)}: cannot be written ({_reason(error)})") from error
    opened = Sdf.Layer.Find(fspath(path))
    if opened:  # USD caches open layers. Without a reload, readers in this process would still see the old content.
        opened.Reload(force=True)


def read_usd(path: FilePath) -> list[UsdCurve]:
    """Read the curves of a stage, in the order of their yarn numbers, or of the stage if yarn numbers are missing.

    Raises:
        FileError: the file cannot be read, is malformed, has no curves, or has curves that are not cubic B-splines.
    """
    from pxr import Tf, Usd, UsdGeom

    name = fspath(path)
    read_bytes(path)
    try:
        stage = Usd.Stage.Open(name)
        prims = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.BasisCurves)]
        curves = [curve for prim in prims for curve in _curves_of(name, prim)]
    except Tf.ErrorException as error:
        raise FileError(f"{name}: is not a valid USD file ({_reason(error)}); write it again") from error
    if not curves:
        raise FileError(f"{name}: has no curves; expected prims of type BasisCurves")
    if any(curve.yarn is None for curve in curves):
        return curves
    return sorted(curves, key=lambda curve: curve.yarn or 0)


def define_curves(
    stage: Usd.Stage,
    path: str,
    yarns: YarnSet,
    chosen: IntArray,
    points: NDArray[np.float32],
    widths: NDArray[np.float32],
) -> Usd.Prim:
    """Define a prim with some yarns, which are all closed or all open, and return the prim.

    Args:
        stage: the stage.
        path: path of the prim.
        yarns: all yarns.
        chosen: the yarns of the prim, shape (n,).
        points: control points of all yarns [cm], shape (P, 3).
        widths: apparent diameters of the yarns of the prim [cm], shape (n,).
    """
    from pxr import Sdf, UsdGeom, Vt

    curves = UsdGeom.BasisCurves.Define(stage, path)
    of_chosen = np.isin(yarns.point_yarn, chosen)
    curves.CreateTypeAttr(UsdGeom.Tokens.cubic)
    curves.CreateBasisAttr(UsdGeom.Tokens.bspline)
    curves.CreateWrapAttr(UsdGeom.Tokens.periodic if yarns.closed[chosen[0]] else UsdGeom.Tokens.nonperiodic)
    curves.CreateCurveVertexCountsAttr(Vt.IntArray.FromNumpy(_int32(np.diff(yarns.start)[chosen])))
    curves.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points[of_chosen]))
    alike = bool((widths == widths[0]).all())
    curves.CreateWidthsAttr(Vt.FloatArray.FromNumpy(widths[:1] if alike else widths))
    curves.SetWidthsInterpolation(UsdGeom.Tokens.constant if alike else UsdGeom.Tokens.uniform)
    extent = _extent(points[of_chosen], yarns.drawn_radius[yarns.point_yarn[of_chosen]])
    curves.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(extent))
    primvars = UsdGeom.PrimvarsAPI(curves)
    labels = {name: (getattr(yarns, name)[of_chosen], UsdGeom.Tokens.vertex) for name in LABELS}
    own = {"yarn": (chosen, UsdGeom.Tokens.uniform), "colour": (yarns.colour[chosen], UsdGeom.Tokens.uniform)}
    for name, (values, interpolation) in {**own, **labels}.items():
        primvar = primvars.CreatePrimvar(name, Sdf.ValueTypeNames.IntArray, interpolation)
        primvar.Set(Vt.IntArray.FromNumpy(_int32(values)))
    radius = primvars.CreatePrimvar(CONTACT_RADIUS, Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.uniform)
    radius.Set(Vt.FloatArray.FromNumpy(yarns.radius[chosen].astype(np.float32)))
    colours = linear_colour(colours_of(yarns.colour[chosen], yarns.palette) / 255).astype(np.float32)
    curves.CreateDisplayColorPrimvar(UsdGeom.Tokens.uniform).Set(Vt.Vec3fArray.FromNumpy(colours))
    return curves.GetPrim()


def define_wool(stage: Usd.Stage, path: str) -> Any:
    """Define and return a rough material whose colour is the primvar ``displayColor`` of the curves."""
    from pxr import Gf, Sdf, UsdShade

    material = UsdShade.Material.Define(stage, path)
    colour = UsdShade.Shader.Define(stage, f"{path}/colour")
    colour.CreateIdAttr("UsdPrimvarReader_float3")
    colour.CreateInput("varname", Sdf.ValueTypeNames.String).Set("displayColor")
    colour.CreateInput("fallback", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(*linear_colour(STOCK[0] / 255).tolist()))
    surface = UsdShade.Shader.Define(stage, f"{path}/surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(ROUGHNESS)
    surface.CreateInput("metallic", Sdf.ValueTypeNames.Float).Set(0.0)
    result = colour.CreateOutput("result", Sdf.ValueTypeNames.Float3)
    surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(result)
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    return material


def _define_instances(stage: Usd.Stage, places: NDArray[np.float32]) -> None:
    """Define instances of the curves below the prim ``PERIOD``, with the given displacements [cm], shape (n, 3)."""
    from pxr import Usd, UsdGeom, Vt

    UsdGeom.Xform.Define(stage, PERIOD)
    instancer = UsdGeom.PointInstancer.Define(stage, PERIOD.rpartition("/")[0])
    instancer.CreatePrototypesRel().SetTargets([PERIOD])
    instancer.CreateProtoIndicesAttr(Vt.IntArray(len(places), 0))
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(places))
    time = Usd.TimeCode.Default()
    instancer.CreateExtentAttr(instancer.ComputeExtentAtTime(time, time))


def _extent(points: NDArray[np.float32], radius: FloatArray) -> NDArray[np.float32]:
    """Return the bounding box of the tubes, rounded outward, shape (2, 3).

    The box encloses the control points, because a B-spline lies in the convex hull of its control points.
    """
    low = (points - radius[:, None]).min(axis=0).astype(np.float32)
    high = (points + radius[:, None]).max(axis=0).astype(np.float32)
    return np.stack([np.nextafter(low, np.float32(-np.inf)), np.nextafter(high, np.float32(np.inf))])


def _int32(values: IntArray) -> NDArray[np.int32]:
    return values.astype(np.int32)


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
    turn, shift, scale = _to_centimetres(prim.GetStage(), curves.ComputeLocalToWorldTransform(time))
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
        for index, own in enumerate(np.split(points @ turn + shift, cuts))
    ]


def _is_closed(where: str, attributes: list[Usd.Attribute]) -> bool:
    """Return whether curves are closed, given their attributes type, basis and wrap."""
    kind, basis, wrap = (attribute.Get() for attribute in attributes)
    if (kind, basis) != ("cubic", "bspline") or wrap not in ("periodic", "nonperiodic"):
        found = f"{wrap} {kind} {basis}"
        raise FileError(f"{where}: got {found} curves; expected cubic bspline, periodic or nonperiodic; convert them")
    return bool(wrap == "periodic")


def _to_centimetres(stage: Usd.Stage, world: Any) -> tuple[FloatArray, FloatArray, float]:
    """Return the transform of the points of a prim, as rows, to centimetres with y up.

    Returns:
        Matrix, shape (3, 3), translation [cm], shape (3,), and the mean factor of lengths.
    """
    from pxr import UsdGeom

    matrix = np.array(world, dtype=np.float64) * (UsdGeom.GetStageMetersPerUnit(stage) / METRES_PER_UNIT)
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z:
        matrix[:, :3] = matrix[:, :3] @ Z_UP
    return matrix[:3, :3], matrix[3, :3], float(np.cbrt(abs(np.linalg.det(matrix[:3, :3]))))


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
    """Return a primvar of numbers of a shape; a constant one is repeated. None if the prim has no such primvar."""
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


def _reason(error: Any) -> str:
    """Return the first of USD's error messages in one line."""
    return " ".join(str(error.args[0].commentary).split())[:160]
