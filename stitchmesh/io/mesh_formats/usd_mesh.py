# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Meshes of a USD stage, read in a process of its own (``stitchmesh.io.guarded_child``).

A frame is a time sample of the points or of a transform above them. Meshes that a skeleton or blend shapes move
(``UsdSkel``) are read where these put them. The faces must be the same at all samples. Several meshes are joined as
they lie at their first samples. Faces of left-handed or mirrored meshes are reversed.
"""

from __future__ import annotations

from collections import Counter
from os import fspath
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import FileError
from stitchmesh.io.checkpoint_file import CheckpointFile
from stitchmesh.io.contents import FilePath, check_one_mesh, check_points, say_left_out
from stitchmesh.io.float32 import to_float32
from stitchmesh.io.guarded_child import answer_of_child, answer_parent
from stitchmesh.io.usd_stage import LIBRARIES, export_stage, new_stage, read_stage, to_centimetres
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.vertex_motion import MovingMesh

if TYPE_CHECKING:
    from pxr import Usd, UsdGeom


def read_usd_mesh(path: FilePath) -> tuple[list[list[int]], FloatArray, FloatArray]:
    """Read the only mesh of a stage.

    Returns:
        The vertices of each face, the times of the samples [s], shape (K,), and the positions [cm], shape (K, V, 3).

    Raises:
        FileError: the file cannot be read, is malformed, or holds no mesh, several meshes, or faces that change.
    """
    packed = answer_of_child(__name__, path, in_place=True)
    check_one_mesh(path, [names[0] for names, _ in packed.header["names"]])
    return samples_of(packed)


def read_usd_polygons(path: FilePath) -> tuple[FloatArray, list[list[int]]]:
    """Read the polygons of all meshes of a stage at their first samples.

    Returns:
        Vertices [cm], shape (V, 3), and the vertices of each face, counted from 0.

    Raises:
        FileError: the file cannot be read, is malformed, or holds no mesh.
    """
    packed = answer_of_child(__name__, path, in_place=True)
    say_left_out(path, packed.header["left out"], "prims")
    faces, _, positions = samples_of(packed)
    if not len(faces):
        raise FileError(f"{fspath(path)}: has no faces; expected prims of type Mesh, or of type BasisCurves for yarns")
    return positions[0], faces


def usd_face_names(path: FilePath) -> list[tuple[str, ...]]:
    """Return the name of the mesh of each face of ``read_usd_polygons``, and the names of the prims around it.

    Raises:
        FileError: the file cannot be read or is malformed.
    """
    named = answer_of_child(__name__, path, in_place=True).header["names"]
    return [tuple(names) for names, count in named for _ in range(count)]


def holds_curves(path: FilePath) -> bool:
    """Return whether a stage has curves.

    Raises:
        FileError: the file cannot be read or is malformed.
    """
    return bool(answer_of_child(__name__, path, in_place=True).arrays["curves"][0])


def samples_of(packed: CheckpointFile) -> tuple[list[list[int]], FloatArray, FloatArray]:
    """Return what ``read_usd_mesh`` returns, from what ``packed_mesh`` returns."""
    arrays = packed.arrays
    faces = np.split(arrays["corners"], np.cumsum(arrays["counts"])[:-1]) if len(arrays["counts"]) else []
    return [face.tolist() for face in faces], arrays["times"], arrays["points"]


def write_usd_polygons(path: FilePath, vertices: FloatArray, faces: list[list[int]]) -> None:
    """Write polygons as a mesh that does not move; coordinates are rounded to float32.

    Args:
        path: a ``.usda``, ``.usdc`` or ``.usd`` file.
        vertices: positions [cm], shape (V, 3).
        faces: vertices of each face, counted from 0.

    Raises:
        FileError: a coordinate is too large for float32, or the file cannot be written.
    """
    from pxr import Vt

    stage, mesh = _new_mesh("/mesh", [len(face) for face in faces], [vertex for face in faces for vertex in face])
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(to_float32(path, "the coordinates", vertices)))
    export_stage(path, stage)


def _new_mesh(place: str, counts: ArrayLike, corners: ArrayLike) -> tuple[Usd.Stage, UsdGeom.Mesh]:
    """Return a stage in centimetres with a mesh without points."""
    from pxr import UsdGeom, Vt

    stage = new_stage()
    mesh = UsdGeom.Mesh.Define(stage, place)
    stage.SetDefaultPrim(mesh.GetPrim())
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.asarray(counts, dtype=np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.asarray(corners, dtype=np.int32)))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    return stage, mesh


def write_usd_mesh(path: FilePath, moving: MovingMesh, *, frames_per_second: float) -> None:
    """Write a mesh with a time sample for each of its times; coordinates are rounded to float32.

    Raises:
        FileError: a coordinate is too large for float32, or the file cannot be written.
    """
    from pxr import Vt

    stage, mesh = _new_mesh("/body", np.diff(moving.mesh.face_start), moving.mesh.face_vertex)
    stage.SetTimeCodesPerSecond(frames_per_second)
    codes = [float(time) * frames_per_second for time in moving.motion.times]
    for code, places in zip(codes, moving.motion.vertices, strict=True):
        points = to_float32(path, "the coordinates", places)
        mesh.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy(points), code)
    stage.SetStartTimeCode(codes[0])
    stage.SetEndTimeCode(codes[-1])
    export_stage(path, stage)


def packed_mesh(stage: str) -> CheckpointFile:
    """Read the meshes of a stage for the parent of this process."""
    return read_stage(stage, _meshes_of)


def _meshes_of(name: str, stage: Usd.Stage) -> CheckpointFile:
    """Return the only mesh with all its samples, or all meshes at their first samples, and counts of other prims."""
    from pxr import Usd, UsdGeom

    _put_skins(stage)
    prims = list(stage.Traverse(Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)))
    meshes = [UsdGeom.Mesh(prim) for prim in prims if prim.IsA(UsdGeom.Mesh)]
    curves = sum(prim.IsA(UsdGeom.BasisCurves) for prim in prims)
    drawn = (prim for prim in prims if prim.IsA(UsdGeom.Gprim) and not prim.IsA(UsdGeom.Mesh))
    others = Counter(str(prim.GetTypeName()) for prim in drawn)
    made = [(mesh, _sample_codes(mesh)) for mesh in meshes]
    if len(made) > 1:
        made = [(mesh, codes[:1]) for mesh, codes in made]
    counts, corners, points = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)], []
    times, first, names = np.zeros(1), 0, []
    for mesh, codes in made:
        size, vertex = _faces(name, mesh, codes)
        positions = np.array([_places(name, mesh, code) for code in codes])
        counts.append(size)
        names.append((_names(mesh), len(size)))
        corners.append(first + (reversed_faces(size, vertex) if _is_turned(mesh, codes[0]) else vertex))
        points.append(positions)
        first += positions.shape[1]
        times = np.array(codes) / stage.GetTimeCodesPerSecond() if len(made) == 1 else times
    arrays = {
        "curves": np.array([curves]), "counts": np.concatenate(counts),
        "corners": np.concatenate(corners), "times": times,
        "points": np.concatenate([np.zeros((len(times), 0, 3)), *points], axis=1),
    }  # fmt: skip
    return CheckpointFile({"left out": dict(others), "names": names}, arrays)


def _put_skins(stage: Usd.Stage) -> None:
    """Replace the points of meshes with skeletons or blend shapes by the places to which these bring them.

    The file stays as it is, because the new points are values of the session.
    """
    from pxr import UsdSkel

    roots = [UsdSkel.Root(prim) for prim in stage.Traverse() if prim.IsA(UsdSkel.Root)]
    if not roots:
        return
    session, rate = stage.GetSessionLayer(), stage.GetTimeCodesPerSecond()
    session.timeCodesPerSecond = rate  # A layer without a rate of its own has 24.
    stage.SetEditTarget(session)
    for root in roots:
        UsdSkel.BakeSkinning(root)


def _names(mesh: UsdGeom.Mesh) -> list[str]:
    """The names of a mesh and of the prims around it, from the inside outwards."""
    names = str(mesh.GetPath()).strip("/").split("/")
    return names[::-1]


def _is_turned(mesh: Any, code: float) -> bool:
    """Whether the corners of the faces are clockwise, seen from outside: left-handed or mirrored, and not both."""
    from pxr import UsdGeom

    turn = np.array(mesh.ComputeLocalToWorldTransform(code), dtype=np.float64)[:3, :3]
    return bool((mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded) != (np.linalg.det(turn) < 0.0))


def reversed_faces(size: IntArray, corners: IntArray) -> IntArray:
    """Return the corners of faces in the other direction; their first corners stay first.

    Args:
        size: number of corners of each face.
        corners: the corners of all faces.
    """
    if (size < 1).any() or size.sum() != len(corners):
        return corners  # The faces are damaged; the check of the mesh reports it.
    first = np.repeat(np.cumsum(size) - size, size)
    place = np.arange(len(corners)) - first
    return corners[first + (np.repeat(size, size) - place) % np.repeat(size, size)]


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
