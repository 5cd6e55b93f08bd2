# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conversion from and to the meshes of the libraries trimesh, meshio and pyvista.

Lengths are in centimetres, unless another unit is given. A library is imported only for a value of its own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias, cast

import numpy as np

from stitchmesh.errors import FileError, MeshError, ParameterError, described
from stitchmesh.io.mesh_formats.by_meshio import cells_of_faces, faces_of_cells
from stitchmesh.io.mesh_formats.cells import strip_triangles, used_points
from stitchmesh.io.mesh_formats.welding import weld
from stitchmesh.io.units import DEFAULT_UNIT, centimetres
from stitchmesh.io.yarn_formats.gltf import tubes_of_colours
from stitchmesh.io.yarn_formats.vtp import poly_data_of_yarns
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.mesh.face_triangles import face_triangles
from stitchmesh.mesh.palette import colours_of
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.tiling import tile_yarns

if TYPE_CHECKING:
    import meshio
    import pyvista
    import trimesh

MeshLike: TypeAlias = "Mesh | trimesh.Trimesh | meshio.Mesh | pyvista.PolyData"
"""What can stand for a polygon mesh."""


def as_mesh(given: MeshLike, *, unit: str = DEFAULT_UNIT, place: str = "as_mesh") -> Mesh:
    """Return a mesh of another library as a mesh; a mesh stays as it is.

    Points at exactly equal positions become one vertex, and points without a face are left out.

    Args:
        given: a ``Mesh``, or a ``trimesh.Trimesh``, ``meshio.Mesh`` or ``pyvista.PolyData`` with faces.
        unit: unit of its coordinates: mm, cm, dm, m or inch.
        place: name of the operation, for messages.

    Raises:
        ParameterError: the value is none of these, or the unit is unknown.
        MeshError: the polygons do not form an oriented manifold surface.
    """
    if isinstance(given, Mesh):
        return given
    name = f"{type(given).__module__.split('.')[0]}.{type(given).__name__}"
    if name not in FACES:
        expected = f"expected a Mesh (sm.read_mesh(path)), or a {', '.join(FACES)}"
        raise ParameterError(f"{place}: got {described(given)}; {expected}")
    points, faces = FACES[name](given)
    if not faces:
        raise MeshError(f"{place}: the {name} has no faces; expected triangles, quads or polygons")
    welded = weld(np.asarray(points, dtype=np.float64).reshape(-1, 3), faces)
    vertices, faces = used_points(f"{place}: the {name}", *welded)
    return Mesh.from_polygons(vertices * centimetres(unit), faces)


def _of_trimesh(given: Any) -> tuple[FloatArray, list[list[int]]]:
    return given.vertices, np.asarray(given.faces).tolist()


def _of_meshio(given: Any) -> tuple[FloatArray, list[list[int]]]:
    points = np.asarray(given.points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise MeshError(f"meshio.Mesh: got points of shape {points.shape}; expected (P, 3)")
    try:
        faces, _ = faces_of_cells("meshio.Mesh", given.cells)
    except FileError as error:
        raise MeshError(str(error)) from error
    return np.pad(points, ((0, 0), (0, 3 - points.shape[1]))), faces


def _of_poly_data(given: Any) -> tuple[FloatArray, list[list[int]]]:
    strips = [strip_triangles(strip).tolist() for strip in _lists(given.strips)]
    return given.points, [face.tolist() for face in _lists(given.faces)] + [face for strip in strips for face in strip]


def _lists(cells: Any) -> list[Any]:
    """Return the points of each cell of VTK's array of cells: a number of points, and then the points."""
    cells, found, place = np.asarray(cells), [], 0
    while place < len(cells):
        found.append(cells[place + 1 : place + 1 + cells[place]])
        place += 1 + int(cells[place])
    return found


FACES = {"trimesh.Trimesh": _of_trimesh, "meshio.Mesh": _of_meshio, "pyvista.PolyData": _of_poly_data}
"""Functions that return the points and the faces of a mesh, by the name of its class."""


def to_trimesh(value: Any) -> trimesh.Trimesh:
    """Return triangles in centimetres: the faces of a mesh or of a fabric, divided, or tubes around yarns.

    Args:
        value: a ``Mesh``, a ``StitchMesh``, a ``YarnSet``, or a value with ``yarns``, such as a ``Swatch``. Of yarns on
            a lattice, one period is taken.

    Returns:
        The triangles; triangles of tubes have the colours of the yarns.

    Raises:
        ParameterError: the value is none of these.
    """
    import trimesh

    content = _content("to_trimesh", value)
    if isinstance(content, Mesh):
        triangles = content.face_vertex[face_triangles(content).corners]
        return trimesh.Trimesh(vertices=content.vertices, faces=triangles, process=False)
    parts = [
        trimesh.Trimesh(tubes.vertices, tubes.triangles, vertex_normals=tubes.normals, process=False,
                        vertex_colors=np.tile(colours_of([number], content.palette)[0], (len(tubes.vertices), 1)))
        for number, tubes in tubes_of_colours(content)
    ]  # fmt: skip
    return cast("trimesh.Trimesh", trimesh.util.concatenate(parts))


def to_pyvista(value: Any) -> pyvista.PolyData:
    """Return polygons, or polylines along yarns, in centimetres.

    Args:
        value: as for ``to_trimesh``.

    Returns:
        The faces, of a fabric with ``row`` and ``stitch`` at the cells; or the yarns as in a ``.vtp`` file, with
        ``radius``, ``rgb`` and more at the points.

    Raises:
        ParameterError: as for ``to_trimesh``.
    """
    import pyvista

    content = _content("to_pyvista", value)
    if isinstance(content, YarnSet):
        return poly_data_of_yarns(content, 1.0)
    size = np.diff(content.face_start)
    data = pyvista.PolyData(content.vertices, faces=np.insert(content.face_vertex, content.face_start[:-1], size))
    if isinstance(content, StitchMesh):
        data.cell_data["row"], data.cell_data["stitch"] = content.row, content.stitch
    return data


def to_meshio(value: Any) -> meshio.Mesh:
    """Return polygons, or lines along yarns, in centimetres.

    Args:
        value: as for ``to_trimesh``.

    Returns:
        Blocks of cells in the order of the faces; or lines between points of the yarns, with ``radius`` and ``yarn`` at
        the points.

    Raises:
        ParameterError: as for ``to_trimesh``.
    """
    import meshio

    content = _content("to_meshio", value)
    if isinstance(content, Mesh):
        return meshio.Mesh(content.vertices, cells_of_faces(content.polygons))
    data = poly_data_of_yarns(content, 1.0)
    lines = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in _lists(data.lines)])
    held = {name: np.asarray(data.point_data[name]) for name in ("radius", "yarn")}
    return meshio.Mesh(np.asarray(data.points), [("line", lines)], point_data=held)


def _content(place: str, value: Any) -> Mesh | YarnSet:
    """Return the mesh or the yarns of a value; of yarns on a lattice one period, with ends."""
    content = value if isinstance(value, Mesh | YarnSet) else getattr(value, "yarns", None)
    if isinstance(content, YarnSet):
        return content if content.lattice is None else tile_yarns(content, 1, 1)
    if not isinstance(content, Mesh):
        expected = "expected a Mesh, a StitchMesh, a YarnSet, or a value with yarns such as a Swatch"
        raise ParameterError(f"{place}: got {described(value)}; {expected}")
    return content
