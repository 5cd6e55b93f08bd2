# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""USD files of a cloth that moves: yarns as ``BasisCurves`` and a surface as ``Mesh``, with time samples.

    /yarns          Xform, the default prim; the stage is y up with 0.01 metres to the unit
    /yarns/open     BasisCurves as in ``usd``, with samples of the points
    /yarns/cloth    Mesh of triangles with samples of the points; left out without triangles

The primvars of the mesh, such as ``alpha``, belong to its vertices. Time codes are frames: the stage states how many of
them make a second.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from os import fspath
from typing import Any

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import atomic_path
from stitchmesh.io.contents import FilePath
from stitchmesh.io.float32 import to_float32
from stitchmesh.io.yarn_formats.usd import METRES_PER_UNIT, define_curves, define_wool
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet


@dataclass(frozen=True, eq=False)
class UsdFrame:
    """What an animation shows at a time."""

    time: float
    """Time [s]."""
    yarns: YarnSet
    """The yarns; their numbers and those of their points are the same in all frames. All are open."""
    surface: FloatArray
    """Vertices of the surface [cm], shape (W, 3)."""
    values: Mapping[str, FloatArray]
    """Numbers at the vertices of the surface by name, shape (W,) each."""


def write_animated_usd(
    path: FilePath, frames: Iterable[UsdFrame], triangles: IntArray, *, frames_per_second: float
) -> int:
    """Write an animation as text (``.usda``) or in binary (``.usdc``); return the number of frames.

    Args:
        path: the file.
        frames: at least one, in the order of their times; they are read one by one.
        triangles: vertices of the triangles of the surface, shape (T, 3).
        frames_per_second: number of time codes for each second.

    Raises:
        FileError: there is no frame, a coordinate is too large for float32, or the file cannot be written.
    """
    from pxr import Tf, Usd, UsdGeom, Vt

    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, METRES_PER_UNIT)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    stage.SetTimeCodesPerSecond(frames_per_second)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/yarns").GetPrim())
    targets: list[Any] = []
    code, count = 0.0, 0
    for frame in frames:
        points = [to_float32(path, "the coordinates", frame.yarns.points)]
        points += [to_float32(path, "the coordinates", frame.surface)] if len(triangles) else []
        if not targets:
            targets = _define(path, stage, frame, triangles)
            stage.SetStartTimeCode(frame.time * frames_per_second)
        code, count = frame.time * frames_per_second, count + 1
        for target, places in zip(targets, points, strict=True):
            target.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(places), code)
            target.GetExtentAttr().Set(Vt.Vec3fArray.FromNumpy(_extent(places, frame.yarns)), code)
        if len(targets) > 1:
            _set_values(targets[1], frame.values, code)
    if not count:
        raise FileError(f"{fspath(path)}: got no frame; expected at least one")
    stage.SetEndTimeCode(code)
    with atomic_path(path) as temporary:
        try:
            stage.GetRootLayer().Export(str(temporary))
        except Tf.ErrorException as error:
            raise FileError(f"{fspath(path)}: cannot be written ({error})") from error
    return count


def _define(path: FilePath, stage: Any, frame: UsdFrame, triangles: IntArray) -> list[Any]:
    """Define the curves and the mesh, and return their schemas."""
    from pxr import UsdGeom, UsdShade, Vt

    everything = np.arange(frame.yarns.yarn_count)
    points = to_float32(path, "the coordinates", frame.yarns.points)
    widths = to_float32(path, "the widths", 2.0 * frame.yarns.drawn_radius)
    wool = define_wool(stage, "/yarns/wool")
    curves = define_curves(stage, "/yarns/open", frame.yarns, everything, points, widths)
    UsdShade.MaterialBindingAPI.Apply(curves).Bind(wool)
    UsdGeom.BasisCurves(curves).GetPointsAttr().Clear()
    if not len(triangles):
        return [UsdGeom.BasisCurves(curves)]
    mesh = UsdGeom.Mesh.Define(stage, "/yarns/cloth")
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray(len(triangles), 3))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(triangles.ravel().astype(np.int32)))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(True)
    mesh.CreatePointsAttr()
    mesh.CreateExtentAttr()
    return [UsdGeom.BasisCurves(curves), mesh]


def _set_values(mesh: Any, values: Mapping[str, FloatArray], code: float) -> None:
    from pxr import Sdf, UsdGeom, Vt

    primvars = UsdGeom.PrimvarsAPI(mesh.GetPrim())
    for name, numbers in values.items():
        primvar = primvars.CreatePrimvar(name, Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.vertex)
        primvar.Set(Vt.FloatArray.FromNumpy(numbers.astype(np.float32)), code)


def _extent(points: Any, yarns: YarnSet) -> Any:
    """Bounding box of points, with room for the yarns around them."""
    room = float(yarns.drawn_radius.max())
    return np.stack([points.min(axis=0) - room, points.max(axis=0) + room]).astype(np.float32)
