# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Binary glTF meshes (``.glb``): triangles, in metres as the format prescribes.

Programs that write glTF repeat a vertex for each of its normals and texture coordinates. When a file is read, points
with exactly equal coordinates therefore become one vertex.
"""

from __future__ import annotations

import io
from os import fspath

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath, check_points, read_bytes
from stitchmesh.io.float32 import to_float32
from stitchmesh.io.mesh_formats.by_meshio import weld
from stitchmesh.io.yarn_formats.gltf import holds_tubes, tubes_error
from stitchmesh.mesh import FloatArray


def read_glb_polygons(path: FilePath) -> tuple[FloatArray, list[list[int]]]:
    """Read the triangles of all meshes of a scene.

    Returns:
        Vertices [m] in the coordinates of the scene, shape (V, 3), and the vertices of each triangle, counted from 0.

    Raises:
        FileError: the file cannot be read, is malformed, has no triangles, or holds tubes that ``write_yarns`` wrote.
    """
    import trimesh

    name, content = fspath(path), read_bytes(path)
    try:
        scene = trimesh.load_scene(io.BytesIO(content), file_type="glb", process=False)
        mesh = scene.to_mesh()
        points, triangles = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces)
    except Exception as error:  # trimesh raises exceptions of many types for malformed files.
        reason = (str(error).splitlines() or [type(error).__name__])[0][:100]
        raise FileError(f"{name}: is not a valid glTF file ({reason}); write it again") from error
    if holds_tubes(scene.geometry):
        raise tubes_error(path)
    if points.ndim != 2 or points.shape[1] != 3 or triangles.ndim != 2:
        raise FileError(f"{name}: got points of shape {points.shape}; expected three coordinates each")
    if len(triangles) == 0:
        raise FileError(f"{name}: has no triangles; expected a polygon mesh")
    check_points(f"{name}: point", points)
    if triangles.min() < 0 or triangles.max() >= len(points):
        raise FileError(f"{name}: a triangle names point {triangles.max()}; the file has {len(points)} points")
    return weld(points, triangles.tolist())


def write_glb_polygons(path: FilePath, vertices: FloatArray, faces: list[list[int]]) -> None:
    """Write triangles.

    Args:
        path: a ``.glb`` file.
        vertices: positions [m], shape (V, 3).
        faces: vertices of each triangle, counted from 0.

    Raises:
        FileError: a coordinate is too large for float32, or the file cannot be written.
    """
    import trimesh
    from trimesh.exchange.gltf import export_glb

    mesh = trimesh.Trimesh(vertices=to_float32(path, "the coordinates", vertices), faces=faces, process=False)
    scene = trimesh.Scene()
    scene.add_geometry(mesh, node_name="mesh", geom_name="mesh")
    write_bytes(path, export_glb(scene, include_normals=False))
