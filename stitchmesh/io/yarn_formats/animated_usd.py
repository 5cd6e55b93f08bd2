# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""USD files of a cloth that moves: yarns as ``BasisCurves`` and a surface as ``Mesh``, with time samples.

    /yarns          Xform, the default prim; the stage is y up with 0.01 metres to the unit
    /yarns/closed   BasisCurves as in ``usd``, with samples of the points; left out without closed yarns
    /yarns/open     the same of open yarns
    /yarns/cloth    Mesh of triangles with samples of the points; left out without triangles

Where the triangles change from one frame to the next, the mesh has samples of its topology too. The primvars of the
mesh, such as ``alpha``, belong to its vertices. Time codes are frames: the stage states how many of them make a second.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from os import fspath
from typing import Any

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath
from stitchmesh.io.float32 import to_float32
from stitchmesh.io.usd_stage import growing_stage
from stitchmesh.io.yarn_formats.usd import define_yarns
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.yarn import YarnSet

MOST_UNSAVED = 2**26
"""Size of the positions of which the stage keeps time samples in memory [bytes]."""


@dataclass(frozen=True, eq=False)
class UsdFrame:
    """What an animation shows at a time."""

    time: float
    """Time [s]."""
    yarns: YarnSet
    """The yarns; the number of yarns and the numbers of their points are the same in all frames."""
    surface: FloatArray
    """Vertices of the surface [cm], shape (W, 3)."""
    triangles: IntArray
    """Vertices of the triangles of the surface, shape (T, 3)."""
    values: Mapping[str, FloatArray]
    """Numbers at the vertices of the surface by name, shape (W,) each."""


def write_animated_usd(path: FilePath, frames: Iterable[UsdFrame], *, frames_per_second: float) -> int:
    """Write an animation as text (``.usda``) or in binary (``.usdc``); return the number of frames.

    Args:
        path: the file.
        frames: at least one, in the order of their times; they are read and written one by one.
        frames_per_second: number of time codes for each second.

    Raises:
        FileError: there is no frame, a coordinate is too large for float32, or the file cannot be written.
    """
    count = 0
    with growing_stage(path) as stage:
        animation = _Animation(path, stage, frames_per_second)
        for frame in frames:
            animation.add(frame)
            count += 1
        if not count:
            raise FileError(f"{fspath(path)}: got no frame; expected at least one")
    return count


class _Animation:
    """A stage to which frames are added, one after the other."""

    def __init__(self, path: FilePath, stage: Any, frames_per_second: float) -> None:
        from pxr import UsdGeom

        self.path, self.stage, self.frames_per_second = path, stage, frames_per_second
        stage.SetTimeCodesPerSecond(frames_per_second)
        stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/yarns").GetPrim())
        self.curves: list[tuple[Any, Any]] | None = None
        self.surface = _Surface(path, stage)
        self.unsaved = 0

    def add(self, frame: UsdFrame) -> None:
        """Add a frame; values that fill ``MOST_UNSAVED`` go to the file."""
        code = frame.time * self.frames_per_second
        if self.curves is None:
            self.curves = _define_curves(self.path, self.stage, frame)
            self.stage.SetStartTimeCode(code)
        for target, own in self.curves:
            points = to_float32(self.path, "the coordinates", frame.yarns.points[own])
            _set_points(target, points, frame.yarns, code)
        self.surface.add(frame, code)
        self.stage.SetEndTimeCode(code)
        self.unsaved += frame.yarns.points.nbytes + frame.surface.nbytes
        if self.unsaved > MOST_UNSAVED:
            self.stage.Save()
            self.unsaved = 0


def _define_curves(path: FilePath, stage: Any, frame: UsdFrame) -> list[tuple[Any, Any]]:
    """Define the curves of closed and of open yarns; return the schema of each, and the numbers of its points."""
    from pxr import UsdGeom

    yarns, defined = frame.yarns, []
    for prim, chosen in define_yarns(path, stage, "/yarns", yarns):
        curves = UsdGeom.BasisCurves(prim)
        curves.GetPointsAttr().Clear()
        defined.append((curves, np.isin(yarns.point_yarn, chosen)))
    return defined


class _Surface:
    """The mesh, which is defined with the first frame that has triangles."""

    def __init__(self, path: FilePath, stage: Any) -> None:
        self.path, self.stage = path, stage
        self.mesh: Any = None
        self.triangles: IntArray = np.zeros((0, 3), dtype=np.int64)
        self.since = 0.0

    def add(self, frame: UsdFrame, code: float) -> None:
        """Add the surface of a frame."""
        if self.mesh is None and not len(frame.triangles):
            return
        if self.mesh is None:
            self._define(frame.triangles, code)
        elif not np.array_equal(frame.triangles, self.triangles):
            self._change(frame.triangles, code)
        places = to_float32(self.path, "the coordinates", frame.surface)
        _set_points(self.mesh, places, frame.yarns, code)
        _set_values(self.path, self.mesh, frame.values, code)

    def _define(self, triangles: IntArray, code: float) -> None:
        from pxr import UsdGeom

        self.mesh = mesh = UsdGeom.Mesh.Define(self.stage, "/yarns/cloth")
        counts, corners = _faces(triangles)
        mesh.CreateFaceVertexCountsAttr(counts)
        mesh.CreateFaceVertexIndicesAttr(corners)
        mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        mesh.CreateDoubleSidedAttr(True)
        mesh.CreatePointsAttr()
        mesh.CreateExtentAttr()
        self.triangles, self.since = triangles, code

    def _change(self, triangles: IntArray, code: float) -> None:
        """Continue with new triangles; the triangles before get a sample at the time of their first frame."""
        for each, when in ((self.triangles, self.since), (triangles, code)):
            counts, corners = _faces(each)
            self.mesh.GetFaceVertexCountsAttr().Set(counts, when)
            self.mesh.GetFaceVertexIndicesAttr().Set(corners, when)
        self.triangles, self.since = triangles, code


def _faces(triangles: IntArray) -> tuple[Any, Any]:
    """Numbers of corners, and the corners."""
    from pxr import Vt

    return Vt.IntArray(len(triangles), 3), Vt.IntArray.FromNumpy(triangles.ravel().astype(np.int32))


def _set_points(target: Any, places: Any, yarns: YarnSet, code: float) -> None:
    """Set the points and the bounding box of curves or of the mesh at a time."""
    from pxr import Vt

    target.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(places), code)
    target.GetExtentAttr().Set(Vt.Vec3fArray.FromNumpy(_extent(places, yarns)), code)


def _set_values(path: FilePath, mesh: Any, values: Mapping[str, FloatArray], code: float) -> None:
    from pxr import Sdf, UsdGeom, Vt

    primvars = UsdGeom.PrimvarsAPI(mesh.GetPrim())
    for name, numbers in values.items():
        primvar = primvars.CreatePrimvar(name, Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.vertex)
        primvar.Set(Vt.FloatArray.FromNumpy(to_float32(path, f"the values {name!r}", numbers)), code)


def _extent(points: Any, yarns: YarnSet) -> Any:
    """Bounding box of points, with room for the yarns around them."""
    room = float(yarns.drawn_radius.max())
    if not len(points):
        return np.zeros((2, 3), dtype=np.float32)
    return np.stack([points.min(axis=0) - room, points.max(axis=0) + room]).astype(np.float32)
