# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Binary glTF meshes (``.glb``): triangles, in metres as the format prescribes.

A file has a head in JSON and one buffer of bytes. The head lists nodes, each with a transform, inner nodes and at most
one mesh; meshes, whose primitives name accessors for positions and corners; and accessors, which say where in the
buffer their numbers lie. One mesh may be placed by many nodes. The numbers of all placed meshes are therefore counted
before they are made.

Programs that write glTF repeat a vertex for each of its normals and texture coordinates. When a file is read, points
with exactly equal coordinates therefore become one vertex.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from os import fspath
from typing import TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.checked import check_value, parse_json
from stitchmesh.io.contents import FilePath, check_expansion, check_points, read_bytes
from stitchmesh.io.float32 import to_float32
from stitchmesh.io.mesh_formats.by_meshio import weld
from stitchmesh.io.yarn_formats.gltf import holds_tubes, tubes_error
from stitchmesh.mesh import FloatArray, IntArray

T = TypeVar("T")

HEAD = struct.Struct("<4sII")
"""Head of a file: the letters, the version and the length."""
CHUNK = struct.Struct("<I4s")
"""Head of a chunk: its length and its kind."""
NUMBERS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""NumPy's names of the types of numbers."""
COLUMNS = {"SCALAR": 1, "VEC3": 3}
"""Numbers of an element, for the kinds of accessors that positions and corners have."""
TRIANGLES, STRIP, FAN = 4, 5, 6
"""Modes of primitives that are surfaces."""
BYTES = 24, 300
"""Memory that is counted for a point and for a triangle, of which lists are made [bytes]."""
DEEPEST = 256
"""Largest number of nodes within each other; skeletons of characters have tens of them."""
COMPRESSIONS = {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"}
"""Extensions by which positions lie in the file in another form."""


class _Stated(msgspec.Struct, rename="camel", kw_only=True):
    """A value of the head; keys that are not read may hold anything."""


class _Indices(_Stated):
    buffer_view: int
    component_type: int
    byte_offset: int = 0


class _Values(_Stated):
    buffer_view: int
    byte_offset: int = 0


class _Sparse(_Stated):
    """Numbers that differ from those of the accessor, or from zeros."""

    count: int
    indices: _Indices
    values: _Values


class _Accessor(_Stated):
    count: int
    component_type: int
    type: str
    buffer_view: int | None = None
    byte_offset: int = 0
    normalized: bool = False
    sparse: _Sparse | None = None


class _View(_Stated):
    buffer: int
    byte_length: int
    byte_offset: int = 0
    byte_stride: int | None = None


class _Buffer(_Stated):
    uri: str | None = None


class _Primitive(_Stated):
    attributes: dict[str, int]
    indices: int | None = None
    mode: int = TRIANGLES


class _Mesh(_Stated):
    primitives: list[_Primitive]
    name: str = ""


class _Node(_Stated):
    mesh: int | None = None
    children: list[int] = []
    matrix: list[float] | None = None
    translation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


class _Scene(_Stated):
    nodes: list[int] = []


class _Head(_Stated):
    scene: int = 0
    scenes: list[_Scene] = []
    nodes: list[_Node] = []
    meshes: list[_Mesh] = []
    accessors: list[_Accessor] = []
    buffer_views: list[_View] = []
    buffers: list[_Buffer] = []
    extensions_required: list[str] = []


def read_glb_polygons(path: FilePath) -> tuple[FloatArray, list[list[int]]]:
    """Read the triangles of all meshes of a scene.

    Returns:
        Vertices [m] in the coordinates of the scene, shape (V, 3), and the vertices of each triangle, counted from 0.

    Raises:
        FileError: the file cannot be read, is malformed, has no triangles, states very many more of them than it holds,
            or holds tubes that ``write_yarns`` wrote.
    """
    name, content = fspath(path), read_bytes(path)
    try:
        json, buffer = _chunks(content)
        head = check_value(parse_json(json.decode("utf-8")), _Head)
        if holds_tubes(mesh.name for mesh in head.meshes):
            raise tubes_error(path)
        if packed := COMPRESSIONS.intersection(head.extensions_required):
            raise ValueError(f"its meshes are compressed by {min(packed)}, export it without")
        points, triangles = _placed_triangles(head, buffer, len(content))
    except (ParameterError, ValueError) as error:
        raise FileError(f"{name}: is not a valid glTF file ({error}); write it again") from error
    if len(triangles) == 0:
        raise FileError(f"{name}: has no triangles; expected a polygon mesh")
    check_points(f"{name}: point", points)
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


def _chunks(content: bytes) -> tuple[bytes, bytes]:
    """Return the head in JSON, and the buffer, which a file may lack."""
    chunks: dict[bytes, bytes] = {}
    if len(content) < HEAD.size or not content.startswith(b"glTF"):
        raise ValueError("it does not begin with glTF")
    _, version, _ = HEAD.unpack_from(content)
    if version != 2:
        raise ValueError(f"it is of version {version}, expected version 2")
    place = HEAD.size
    while place + CHUNK.size <= len(content):
        length, kind = CHUNK.unpack_from(content, place)
        place += CHUNK.size
        if length > len(content) - place:
            raise ValueError(f"a chunk of {length} bytes ends beyond it")
        chunks.setdefault(kind, content[place : place + length])
        place += length
    if b"JSON" not in chunks:
        raise ValueError("it has no head")
    return chunks[b"JSON"], chunks.get(b"BIN\0", b"")


def _placed_triangles(head: _Head, buffer: bytes, size: int) -> tuple[FloatArray, IntArray]:
    """Return the points and the triangles of the surfaces of all nodes, for a file of a size [bytes]."""
    placed = [
        (primitive, transform)
        for mesh, transform in _placed_meshes(head)
        for primitive in _item(head.meshes, mesh, "mesh").primitives
        if primitive.mode in (TRIANGLES, STRIP, FAN)
    ]
    check_expansion(sum(_stated_bytes(head, primitive) for primitive, _ in placed), size)
    points, triangles, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], 0
    for primitive, transform in placed:
        own = _positions(head, buffer, primitive)
        corners = _corners(head, buffer, primitive, len(own))
        if len(corners) and corners.max() >= len(own):
            raise ValueError(f"a triangle names point {corners.max()} of {len(own)}")
        with np.errstate(all="ignore"):  # Numbers that overflow are not finite, which is checked.
            points.append(own @ transform[:3, :3].T + transform[:3, 3])
            mirrored = np.linalg.det(transform[:3, :3]) < 0.0
        triangles.append(count + (corners[:, ::-1] if mirrored else corners))
        count += len(own)
    return np.concatenate(points), np.concatenate(triangles)


def _placed_meshes(head: _Head) -> Iterator[tuple[int, FloatArray]]:
    """Yield the mesh and the transform of each node of the scene that has a mesh, shape (4, 4)."""
    if head.scenes:
        roots = _item(head.scenes, head.scene, "scene").nodes
    else:
        inner = {child for node in head.nodes for child in node.children}
        roots = [number for number in range(len(head.nodes)) if number not in inner]
    left, seen = [(number, np.eye(4), 1) for number in reversed(roots)], set()
    while left:
        number, outer, depth = left.pop()
        node = _item(head.nodes, number, "node")
        if number in seen:
            raise ValueError(f"node {number} lies in itself, or in two nodes")
        if depth > DEEPEST:
            raise ValueError(f"node {number} lies in {depth - 1} others; expected less than {DEEPEST}, join them")
        seen.add(number)
        with np.errstate(all="ignore"):  # Numbers that overflow are not finite, which is checked.
            transform = outer @ _transform(node)
        left += [(child, transform, depth + 1) for child in reversed(node.children)]
        if node.mesh is not None:
            yield node.mesh, transform


def _transform(node: _Node) -> FloatArray:
    """Return the transform of a node, shape (4, 4); points are columns."""
    if node.matrix is not None:
        if len(node.matrix) != 16:
            raise ValueError(f"a matrix has {len(node.matrix)} numbers, expected 16")
        return np.array(node.matrix).reshape(4, 4).T
    x, y, z, w = node.rotation
    turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])  # fmt: skip
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = turn * np.array(node.scale), node.translation
    return found


def _stated_bytes(head: _Head, primitive: _Primitive) -> int:
    """Return the memory that the points and the triangles of a primitive need [bytes]."""
    accessors = [primitive.attributes.get("POSITION", -1), primitive.indices]
    counts = [_item(head.accessors, number, "accessor").count for number in accessors if number is not None]
    if min(counts) < 0:
        raise ValueError(f"an accessor has {min(counts)} elements")
    triangles = counts[-1] // 3 if primitive.mode == TRIANGLES else counts[-1]
    return BYTES[0] * counts[0] + BYTES[1] * triangles


def _positions(head: _Head, buffer: bytes, primitive: _Primitive) -> FloatArray:
    """Return the points of a primitive, shape (n, 3)."""
    accessor = _item(head.accessors, primitive.attributes.get("POSITION", -1), "accessor")
    values = _accessed(head, buffer, accessor, "VEC3")
    points: FloatArray = values.astype(np.float64)
    if accessor.normalized and values.dtype.kind in "iu":
        return np.maximum(points / np.iinfo(values.dtype).max, -1.0)
    return points


def _corners(head: _Head, buffer: bytes, primitive: _Primitive, count: int) -> IntArray:
    """Return the points of each triangle of a primitive of a number of points, shape (n, 3)."""
    if primitive.indices is None:
        corners = np.arange(count)
    else:
        values = _accessed(head, buffer, _item(head.accessors, primitive.indices, "accessor"), "SCALAR")
        if values.dtype.kind != "u":
            raise ValueError(f"the corners of triangles are numbers of type {values.dtype}")
        corners = values[:, 0].astype(np.int64)
    if primitive.mode == TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    last = np.arange(max(0, len(corners) - 2))
    if primitive.mode == FAN:
        return corners[np.stack([last + 1, last + 2, np.zeros_like(last)], axis=1)]
    # Every other triangle of a strip is turned over.
    return corners[np.stack([last, last + 1 + last % 2, last + 2 - last % 2], axis=1)]


def _accessed(head: _Head, buffer: bytes, accessor: _Accessor, kind: str) -> NDArray:
    """Return the numbers of an accessor of a kind, shape (elements, columns)."""
    if accessor.type != kind or accessor.component_type not in NUMBERS:
        raise ValueError(f"an accessor is of {accessor.type[:20]!r} and {accessor.component_type}, expected {kind}")
    kind_of_numbers, columns = np.dtype(NUMBERS[accessor.component_type]), COLUMNS[kind]
    place = accessor.buffer_view, accessor.byte_offset
    if accessor.buffer_view is not None:
        values = _viewed(head, buffer, *place, accessor.count, kind_of_numbers, columns)
    elif accessor.sparse is not None:
        values = np.zeros((accessor.count, columns), kind_of_numbers)
    else:
        raise ValueError("an accessor has no bytes in the buffer")
    if accessor.sparse is None:
        return values
    changed, found = accessor.sparse.indices, accessor.sparse.values
    integers = np.dtype(NUMBERS.get(changed.component_type, "<f4"))
    number = _viewed(head, buffer, changed.buffer_view, changed.byte_offset, accessor.sparse.count, integers, 1)[:, 0]
    if integers.kind != "u" or (len(number) and number.max() >= accessor.count):
        raise ValueError("a sparse accessor changes elements that it does not have")
    values = values.copy()
    values[number] = _viewed(
        head, buffer, found.buffer_view, found.byte_offset, accessor.sparse.count, kind_of_numbers, columns
    )
    return values


def _viewed(
    head: _Head, buffer: bytes, view: int | None, offset: int, count: int, kind: np.dtype, columns: int
) -> NDArray:
    """Return elements of a part of the buffer, shape (count, columns)."""
    part = _item(head.buffer_views, view, "part of the buffer")
    if part.buffer != 0 or _item(head.buffers, 0, "buffer").uri is not None:
        raise ValueError("its numbers lie in another file, export them within one")
    size = kind.itemsize * columns
    step = part.byte_stride or size
    start = part.byte_offset + offset
    end = start + step * (count - 1) + size if count else start
    within = min(len(buffer), part.byte_offset + part.byte_length)
    if min(part.byte_offset, part.byte_length, offset, count) < 0 or step < size or end > within:
        raise ValueError(f"an accessor of {count} elements ends beyond its bytes")
    return np.ndarray((count, columns), kind, buffer, start, (step, kind.itemsize))


def _item(items: list[T], number: int | None, what: str) -> T:
    """Return the item of a number."""
    if number is None or not 0 <= number < len(items):
        raise ValueError(f"it names {what} {number} of {len(items)}")
    return items[number]
