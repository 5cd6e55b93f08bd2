# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A mesh that moves in an Alembic archive, read by the package alembic3d in a process of its own.

A frame is a sample of the points or of a transform above them (``AbcGeom::IPolyMesh``, ``ISubD`` and ``IXform``). An
archive states no unit. Its faces are clockwise, seen from outside, and are therefore reversed.
"""

from __future__ import annotations

from importlib.util import find_spec
from os import fspath
from pathlib import Path
from typing import Any

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.checkpoint_file import CheckpointFile
from stitchmesh.io.contents import FilePath, check_one_mesh, check_points
from stitchmesh.io.guarded_child import answer_of_child, answer_parent
from stitchmesh.io.mesh_formats.usd_mesh import reversed_faces, samples_of
from stitchmesh.mesh import FloatArray, IntArray

LIBRARY = "alembic3d"


def read_moving_alembic(path: FilePath) -> tuple[list[list[int]], FloatArray, FloatArray]:
    """Read the only mesh of an archive.

    Returns:
        The vertices of each face, the times of the samples [s], shape (K,), and the positions in the unit of the file,
        shape (K, V, 3).

    Raises:
        FileError: the package is not installed, or the file cannot be read, is malformed, or holds no mesh, several
            meshes, or faces that change.
    """
    if find_spec(LIBRARY) is None:
        remedy = "install it by `pip install stitchmesh[alembic]`, or export the animation as USD"
        raise FileError(f"{fspath(path)}: Alembic is read by the package {LIBRARY}, which is not installed; {remedy}")
    packed = answer_of_child(__name__, path)
    check_one_mesh(path, packed.header["names"])
    return samples_of(packed)


def packed_archive(name: str, file: Path) -> CheckpointFile:
    """Read the meshes of an archive for the parent of this process.

    Raises:
        FileError: the file is malformed, or its faces change.
    """
    from alembic3d.Abc import IArchive

    try:
        found = _meshes_below(IArchive(str(file)).getTop(), [])
        if len(found) != 1:
            return CheckpointFile({"names": [path for path, _, _ in found]}, {})
        path, mesh, transforms = found[0]
        return _samples(name, path, mesh, transforms)
    except RuntimeError as error:  # All errors of the library.
        reason = " ".join(str(error).split())[:100]
        raise FileError(f"{name}: is not a valid Alembic file ({reason}); write it again") from error


def _meshes_below(outer: Any, above: list[Any]) -> list[tuple[str, Any, list[Any]]]:
    """Return the path and the schema of each mesh, and the schemas of the transforms above it from the inside."""
    from alembic3d.AbcGeom import IPolyMesh, ISubD, IXform

    found = []
    for inner in outer.children:
        header, name, transforms = inner.getHeader(), inner.getName(), above
        kind = next((kind for kind in (IPolyMesh, ISubD) if kind.matches(header)), None)
        if kind is not None:
            found.append((inner.getFullName(), kind(outer, name).getSchema(), above))
        elif IXform.matches(header):
            transforms = [IXform(outer, name).getSchema(), *above]
        found += _meshes_below(inner, transforms)
    return found


def _samples(name: str, path: str, mesh: Any, transforms: list[Any]) -> CheckpointFile:
    """Return the mesh at all of its samples and of those of the transforms above it."""
    times = np.unique([time for schema in (mesh, *transforms) for time in _times(schema)] or [0.0])
    sizes, corners = _faces(mesh, float(times[0]))
    points = []
    for number, time in enumerate(times.tolist()):
        if any(not np.array_equal(*pair) for pair in zip(_faces(mesh, time), (sizes, corners), strict=True)):
            found = "got faces that differ from those of the first frame; expected the same"
            raise FileError(f"{name}: frame {number}: {found}; export every frame of one mesh")
        points.append(_places(mesh, transforms, time))
        check_points(f"{name}: frame {number}, vertex", points[-1])
    if len({len(places) for places in points}) > 1:
        raise FileError(f"{name}: the number of its vertices changes; export every frame of one mesh")
    arrays = {
        "counts": sizes, "times": times, "points": np.array(points),
        "corners": corners if _is_mirrored(transforms, float(times[0])) else reversed_faces(sizes, corners),
    }  # fmt: skip
    return CheckpointFile({"names": [path]}, arrays)


def _times(schema: Any) -> list[float]:
    """Times of the samples of a schema that changes [s]."""
    if schema.isConstant():
        return []
    sampling = schema.getTimeSampling()
    return [sampling.getSampleTime(number) for number in range(schema.getNumSamples())]


def _at(schema: Any, time: float) -> Any:
    from alembic3d.Abc import ISampleSelector

    return schema.getValue(ISampleSelector(time))


def _faces(mesh: Any, time: float) -> tuple[IntArray, IntArray]:
    """Numbers of corners, and corners."""
    sample = _at(mesh, time)
    return np.array(sample.getFaceCounts(), dtype=np.int64), np.array(sample.getFaceIndices(), dtype=np.int64)


def _places(mesh: Any, transforms: list[Any], time: float) -> FloatArray:
    """Positions at a time, shape (V, 3)."""
    points = np.array(_at(mesh, time).getPositions(), dtype=np.float64).reshape(-1, 3)
    matrix = _world(transforms, time)
    placed: FloatArray = points @ matrix[:3, :3] + matrix[3, :3]
    return placed


def _is_mirrored(transforms: list[Any], time: float) -> bool:
    return bool(np.linalg.det(_world(transforms, time)[:3, :3]) < 0.0)


def _world(transforms: list[Any], time: float) -> FloatArray:
    """Transform of points, as rows, into the coordinates of the archive, shape (4, 4)."""
    matrix: FloatArray = np.eye(4)
    for schema in transforms:
        sample = _at(schema, time)
        own = sample.getMatrix()
        matrix = matrix @ np.array([[own[row][column] for column in range(4)] for row in range(4)])
        if not sample.getInheritsXforms():
            break
    return matrix


if __name__ == "__main__":
    answer_parent(packed_archive, "alembic3d.Abc", "alembic3d.AbcGeom")
