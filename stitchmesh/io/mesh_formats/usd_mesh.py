# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A mesh with time samples of a USD stage, read in a process of its own (``stitchmesh.io.guarded_child``).

A frame is a time sample of the points or of a transform above them. The faces must be the same at all samples.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import atomic_path
from stitchmesh.io.checkpoint_file import CheckpointFile
from stitchmesh.io.contents import FilePath, check_points
from stitchmesh.io.float32 import to_float32
from stitchmesh.io.guarded_child import answer_of_child, answer_parent
from stitchmesh.io.usd_stage import LIBRARIES, METRES_PER_UNIT, read_stage, to_centimetres
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.vertex_motion import MovingMesh

if TYPE_CHECKING:
    from pxr import Usd


def read_usd_mesh(path: FilePath) -> tuple[list[list[int]], FloatArray, FloatArray]:
    """Read the only mesh of a stage.

    Returns:
        The vertices of each face, the times of the samples [s], shape (K,), and the positions [cm], shape (K, V, 3).

    Raises:
        FileError: the file cannot be read, is malformed, or holds no mesh, several meshes, or faces that change.
    """
    return samples_of(answer_of_child(__name__, path, in_place=True))


def samples_of(packed: CheckpointFile) -> tuple[list[list[int]], FloatArray, FloatArray]:
    """Return what ``read_usd_mesh`` returns, from what ``packed_mesh`` returns."""
    arrays = packed.arrays
    faces = np.split(arrays["corners"], np.cumsum(arrays["counts"])[:-1])
    return [face.tolist() for face in faces], arrays["times"], arrays["points"]


def write_usd_mesh(path: FilePath, moving: MovingMesh, *, frames_per_second: float) -> None:
    """Write a mesh with a time sample for each of its times; coordinates are rounded to float32.

    Raises:
        FileError: a coordinate is too large for float32, or the file cannot be written.
    """
    from pxr import Usd, UsdGeom, Vt

    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, METRES_PER_UNIT)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    stage.SetTimeCodesPerSecond(frames_per_second)
    mesh = UsdGeom.Mesh.Define(stage, "/body")
    stage.SetDefaultPrim(mesh.GetPrim())
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.diff(moving.mesh.face_start).astype(np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(moving.mesh.face_vertex.astype(np.int32)))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    codes = [float(time) * frames_per_second for time in moving.motion.times]
    for code, places in zip(codes, moving.motion.vertices, strict=True):
        points = to_float32(path, "the coordinates", places)
        mesh.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy(points), code)
    stage.SetStartTimeCode(codes[0])
    stage.SetEndTimeCode(codes[-1])
    with atomic_path(path) as temporary:
        stage.GetRootLayer().Export(str(temporary))


def packed_mesh(stage: str) -> CheckpointFile:
    """Read the mesh of a stage for the parent of this process."""
    return CheckpointFile({}, read_stage(stage, _mesh_of))


def _mesh_of(name: str, stage: Usd.Stage) -> dict[str, Any]:
    from pxr import UsdGeom

    meshes = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    if len(meshes) != 1:
        found = f"has {len(meshes)} meshes" if meshes else "has no mesh"
        raise FileError(f"{name}: {found}; expected one prim of type Mesh; export the body alone")
    mesh = meshes[0]
    codes = _sample_codes(mesh)
    counts, corners = _faces(name, mesh, codes)
    points = np.array([_places(name, mesh, code) for code in codes])
    times = np.array(codes) / stage.GetTimeCodesPerSecond()
    return {"counts": counts, "corners": corners, "times": times, "points": points}


def _sample_codes(mesh: Any) -> list[float]:
    """Time codes of all samples of the points and of the transforms above them; 0 where nothing moves."""
    from pxr import UsdGeom

    codes = set(mesh.GetPointsAttr().GetTimeSamples())
    prim = mesh.GetPrim()
    while prim and not prim.IsPseudoRoot():
        if prim.IsA(UsdGeom.Xformable):
            codes |= set(UsdGeom.Xformable(prim).GetTimeSamples())
        prim = prim.GetParent()
    return sorted(codes) or [0.0]


def _faces(name: str, mesh: Any, codes: list[float]) -> tuple[IntArray, IntArray]:
    """Numbers of corners and corners, the same at all samples."""
    first = [_integers(attribute, codes[0]) for attribute in _topology(mesh)]
    for number, code in enumerate(codes):
        if any(not np.array_equal(_integers(a, code), f) for a, f in zip(_topology(mesh), first, strict=True)):
            found = "got faces that differ from those of the first frame; expected the same"
            raise FileError(f"{name}: frame {number}: {found}; export every frame of one mesh")
    return first[0], first[1]


def _topology(mesh: Any) -> list[Any]:
    return [mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr()]


def _integers(attribute: Any, code: float) -> IntArray:
    values = attribute.Get(code)
    return np.array([] if values is None else values, dtype=np.int64)


def _places(name: str, mesh: Any, code: float) -> FloatArray:
    """Positions at a sample [cm], shape (V, 3)."""
    values = mesh.GetPointsAttr().Get(code)
    points = np.array([] if values is None else values, dtype=np.float64).reshape(-1, 3)
    turn, shift, _ = to_centimetres(mesh.GetPrim().GetStage(), mesh.ComputeLocalToWorldTransform(code))
    placed: FloatArray = points @ turn + shift
    check_points(f"{name}: time code {code:g}, vertex", placed)
    return placed


if __name__ == "__main__":
    answer_parent(lambda name, _: packed_mesh(name), *LIBRARIES)
