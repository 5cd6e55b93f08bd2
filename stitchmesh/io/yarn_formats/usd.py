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

from os import fspath
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.io.contents import FilePath
from stitchmesh.io.float32 import to_float32
from stitchmesh.io.usd_stage import export_stage, new_stage
from stitchmesh.io.yarn_formats.gltf import ROUGHNESS
from stitchmesh.io.yarn_formats.usd_curves import CONTACT_RADIUS, LABELS
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.palette import STOCK, colours_of, linear_colour
from stitchmesh.yarn import YarnSet

if TYPE_CHECKING:
    from pxr import Usd

PERIOD = "/yarns/tiles/period"
"""Path of the prim above the curves of one period, the prototype of the instances."""


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
    from pxr import Sdf, UsdGeom

    stage = new_stage()
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/yarns").GetPrim())
    define_yarns(path, stage, "/yarns" if places is None else PERIOD, yarns)
    if places is not None:
        _define_instances(stage, to_float32(path, "the places", places))
    export_stage(path, stage)
    opened = Sdf.Layer.Find(fspath(path))
    if opened:  # USD caches open layers. Without a reload, readers in this process would still see the old content.
        opened.Reload(force=True)


def define_yarns(path: FilePath, stage: Usd.Stage, above: str, yarns: YarnSet) -> list[tuple[Usd.Prim, IntArray]]:
    """Define a prim with the closed yarns and one with the open yarns; a prim without yarns is left out.

    Args:
        path: the file, for messages.
        stage: the stage.
        above: path of the prim above them.
        yarns: the yarns.

    Returns:
        Each prim with the numbers of its yarns.

    Raises:
        FileError: a number is too large for float32.
    """
    from pxr import UsdShade

    wool = _define_wool(stage, "/yarns/wool")
    widths = to_float32(path, "the widths", 2.0 * yarns.drawn_radius)
    radii = to_float32(path, "the radii", yarns.radius)
    points = to_float32(path, "the coordinates", yarns.points)
    defined = []
    for name, closed in (("closed", True), ("open", False)):
        chosen = np.flatnonzero(yarns.closed == closed)
        if len(chosen):
            prim = _define_curves(stage, f"{above}/{name}", yarns, chosen, points, widths[chosen], radii[chosen])
            UsdShade.MaterialBindingAPI.Apply(prim).Bind(wool)
            defined.append((prim, chosen))
    return defined


def _define_curves(
    stage: Usd.Stage,
    path: str,
    yarns: YarnSet,
    chosen: IntArray,
    points: NDArray[np.float32],
    widths: NDArray[np.float32],
    radii: NDArray[np.float32],
) -> Usd.Prim:
    """Define a prim with some yarns, which are all closed or all open, and return the prim.

    Args:
        stage: the stage.
        path: path of the prim.
        yarns: all yarns.
        chosen: the yarns of the prim, shape (n,).
        points: control points of all yarns [cm], shape (P, 3).
        widths: apparent diameters of the yarns of the prim [cm], shape (n,).
        radii: radii of the yarns of the prim at contacts [cm], shape (n,).
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
    radius.Set(Vt.FloatArray.FromNumpy(radii))
    colours = linear_colour(colours_of(yarns.colour[chosen], yarns.palette) / 255).astype(np.float32)
    curves.CreateDisplayColorPrimvar(UsdGeom.Tokens.uniform).Set(Vt.Vec3fArray.FromNumpy(colours))
    return curves.GetPrim()


def _define_wool(stage: Usd.Stage, path: str) -> Any:
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
