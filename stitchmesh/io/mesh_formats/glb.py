# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""glTF meshes (``.glb``, ``.gltf``): triangles, in metres as the format prescribes.

A file has a head in JSON and buffers of bytes: behind the head, in the head as text, or in files beside it. The head
lists nodes, each with a transform, inner nodes and at most one mesh; meshes, whose primitives name accessors for
positions and corners; and accessors, which say where in a buffer their numbers lie. One mesh may be placed by many
nodes. The numbers of all placed meshes are therefore counted before they are made.

A mesh is read in the pose of the file: its morph targets move the points by the weights of the node or of the mesh, and
the joints of a skin carry them. The transform of a node with a skin is not used (glTF 2.0 specification, 3.7.3).

Programs that write glTF repeat a vertex for each of its normals and texture coordinates. When a file is read, points
with exactly equal coordinates therefore become one vertex.
"""

from __future__ import annotations

import base64
import struct
from collections.abc import Iterable
from dataclasses import dataclass
from os import fspath
from pathlib import Path
from typing import TypeVar
from urllib.parse import unquote

import msgspec
import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.checked import check_value, parse_json
from stitchmesh.io.contents import FilePath, check_expansion, check_points, read_bytes, say_left_out
from stitchmesh.io.float32 import to_float32
from stitchmesh.io.mesh_formats.by_meshio import weld
from stitchmesh.io.mesh_formats.cells import strip_triangles
from stitchmesh.io.yarn_formats.gltf import holds_tubes, tubes_error
from stitchmesh.mesh import FloatArray, IntArray

T = TypeVar("T")

HEAD = struct.Struct("<4sII")
"""Head of a file: the letters, the version and the length."""
CHUNK = struct.Struct("<I4s")
"""Head of a chunk: its length and its kind."""
NUMBERS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""NumPy's names of the types of numbers."""
COLUMNS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}
"""Numbers of an element, for the kinds of accessors of corners, positions, joints with their weights, and matrices."""
SURFACES = TRIANGLES, STRIP, FAN = 4, 5, 6
"""Modes of primitives that are surfaces."""
BYTES = 24, 300
"""Memory that is counted for a point and for a triangle, of which lists are made [bytes]."""
SKIN_BYTES = 128
"""Memory that is counted for the matrix of a point with a skin, and for the matrix of a joint [bytes]."""
DEEPEST = 256
"""Largest number of nodes within each other; skeletons of characters have tens of them."""
COMPRESSIONS = {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"}
"""Extensions that store positions in another form."""
LOOKS = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_", "EXT_lights_", "KHR_xmp",
         "KHR_animation_pointer", "KHR_mesh_quantization")  # fmt: skip
"""Beginnings of the names of extensions that leave positions as they are, or that this reader obeys."""
DATA = "data:application/octet-stream;base64,"
"""Beginning of the address of a buffer that the head holds."""
COPIES = "EXT_mesh_gpu_instancing"
"""Extension by which one node places many copies of its mesh."""


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
    """Numbers that replace numbers of the accessor, or zeros."""

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
    extensions: dict[str, object] = {}


class _Buffer(_Stated):
    uri: str | None = None


class _Primitive(_Stated):
    attributes: dict[str, int]
    indices: int | None = None
    mode: int = TRIANGLES
    targets: list[dict[str, int]] = []
    extensions: dict[str, object] = {}


class _Mesh(_Stated):
    primitives: list[_Primitive]
    name: str = ""
    weights: list[float] = []


class _Skin(_Stated):
    joints: list[int]
    inverse_bind_matrices: int | None = None


class _Node(_Stated):
    name: str = ""
    mesh: int | None = None
    skin: int | None = None
    weights: list[float] | None = None
    children: list[int] = []
    extensions: dict[str, object] = {}
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
    skins: list[_Skin] = []
    accessors: list[_Accessor] = []
    buffer_views: list[_View] = []
    buffers: list[_Buffer] = []
    extensions_required: list[str] = []


@dataclass(frozen=True, eq=False)
class _File:
    """The head of a file with its buffers."""

    head: _Head
    buffers: list[bytes | None]
    """Bytes of each buffer; None for a buffer without bytes, which stands for the numbers of a compression."""
    size: int
    """Size of the file and of the files beside it [bytes]."""


def read_glb_polygons(path: FilePath) -> tuple[FloatArray, list[list[int]]]:
    """Read the triangles of all meshes of a scene in their pose.

    Points and lines are left out; a warning says how many.

    Args:
        path: a ``.glb`` file, or a ``.gltf`` file, whose buffers may lie in its folder or in folders within it.

    Returns:
        Vertices [m] in the coordinates of the scene, shape (V, 3), and the vertices of each triangle, counted from 0.

    Raises:
        FileError: the file cannot be read, is malformed, has no triangles, states very many more of them than it holds,
            needs an extension that is not read, or holds tubes that ``write_yarns`` wrote.
    """
    name, content = fspath(path), read_bytes(path)
    try:
        head, binary = _head(path, content)
        if holds_tubes(mesh.name for mesh in head.meshes):
            raise tubes_error(path)
        _check_extensions(name, (one for one in head.extensions_required if not one.startswith(LOOKS)))
        buffers = [_bytes_of(path, one, None if number else binary) for number, one in enumerate(head.buffers)]
        size = len(content) + sum(len(one) for one in buffers if one is not None and one is not binary)
        points, triangles = _placed_triangles(name, _File(head, buffers, size))
    except (ParameterError, ValueError) as error:
        raise FileError(f"{name}: is not a valid glTF file ({error}); write it again") from error
    if len(triangles) == 0:
        raise FileError(f"{name}: has no triangles; expected a polygon mesh")
    check_points(f"{name}: point", points)
    return weld(points, triangles.tolist())


def glb_face_names(path: FilePath) -> list[tuple[str, ...]]:
    """Return the names of the node and of the mesh of each triangle that ``read_glb_polygons`` has read.

    Raises:
        FileError: the file cannot be read.
    """
    head, _ = _head(path, read_bytes(path))
    found: list[tuple[str, ...]] = []
    for primitive, number in _placed_primitives(head, _world(head)):
        if primitive.mode in SURFACES:
            accessor = primitive.attributes["POSITION"] if primitive.indices is None else primitive.indices
            corners = head.accessors[accessor].count
            triangles = corners // 3 if primitive.mode == TRIANGLES else max(0, corners - 2)
            names = head.nodes[number].name, _item(head.meshes, head.nodes[number].mesh, "mesh").name
            found += [tuple(filter(None, names))] * triangles
    return found


def _head(path: FilePath, content: bytes) -> tuple[_Head, bytes | None]:
    """Return the head of a file, and the buffer behind it; a ``.gltf`` file is a head alone."""
    json, binary = (content, None) if Path(path).suffix.lower() == ".gltf" else _chunks(content)
    return check_value(parse_json(json.decode("utf-8")), _Head), binary


def _check_extensions(name: str, needed: Iterable[str]) -> None:
    """Refuse a file that needs an extension, by the name of the extension.

    Raises:
        FileError: the file needs an extension.
    """
    for one in needed:
        found = f"its meshes are compressed by {one}" if one in COMPRESSIONS else f"it needs the extension {one[:60]}"
        raise FileError(f"{name}: {found}, which is not read; export it without")


def _bytes_of(path: FilePath, buffer: _Buffer, binary: bytes | None) -> bytes | None:
    """Return the bytes of a buffer, which lie behind the head, in a text in the head, or in another file.

    Raises:
        FileError: the other file cannot be read.
    """
    if buffer.uri is None:
        return binary
    if buffer.uri.startswith("data:"):
        kind, _, text = buffer.uri.partition(",")
        if not kind.endswith(";base64"):
            raise ValueError(f"a buffer is {kind[:40]!r}, expected base64")
        return base64.b64decode(text, validate=True)
    other = Path(unquote(buffer.uri))
    if ":" in buffer.uri or other.is_absolute() or ".." in other.parts:
        raise ValueError(f"a buffer lies in {buffer.uri[:60]!r}, expected a file in its folder")
    return read_bytes(Path(path).parent / other)


def write_glb_polygons(path: FilePath, vertices: FloatArray, faces: list[list[int]]) -> None:
    """Write triangles.

    Args:
        path: a ``.glb`` file, or a ``.gltf`` file, which holds its buffer as text.
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
    content = export_glb(scene, include_normals=False)
    write_bytes(path, _in_text(content) if Path(path).suffix.lower() == ".gltf" else content)


def _in_text(content: bytes) -> bytes:
    """Return a binary file as text, with its buffer in base 64."""
    text, buffer = _chunks(content)
    head = msgspec.json.decode(text)
    head["buffers"] = [{"byteLength": len(buffer), "uri": DATA + base64.b64encode(buffer).decode("ascii")}]
    return msgspec.json.encode(head)


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


def _placed_triangles(name: str, file: _File) -> tuple[FloatArray, IntArray]:
    """Return the points and the triangles of the surfaces of all nodes."""
    head, world = file.head, _world(file.head)
    everything = _placed_primitives(head, world)
    placed = [(primitive, number) for primitive, number in everything if primitive.mode in SURFACES]
    if len(everything) > len(placed):
        say_left_out(name, {"points or lines": len(everything) - len(placed)}, "primitives")
    _check_extensions(name, (COPIES for _, number in placed if COPIES in head.nodes[number].extensions))
    _check_extensions(name, (one for primitive, _ in placed for one in _compressions(file, primitive)))
    check_expansion(sum(_stated_bytes(head, primitive, head.nodes[number]) for primitive, number in placed), file.size)
    points, triangles, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], 0
    for primitive, number in placed:
        own = _positions(file, primitive, head.nodes[number])
        corners = _corners(file, primitive, len(own))
        if len(corners) and corners.max() >= len(own):
            raise ValueError(f"a triangle names point {corners.max()} of {len(own)}")
        carry = _carrying(file, primitive, head.nodes[number], world, number)
        with np.errstate(all="ignore"):  # Numbers that overflow are not finite, which is checked.
            points.append(np.einsum("nij,nj->ni", carry[:, :, :3], own) + carry[:, :, 3])
            mirrored = len(carry) and np.linalg.det(carry[:, :, :3].mean(axis=0)) < 0.0
        triangles.append(count + (corners[:, ::-1] if mirrored else corners))
        count += len(own)
    return np.concatenate(points), np.concatenate(triangles)


def _placed_primitives(head: _Head, nodes: Iterable[int]) -> list[tuple[_Primitive, int]]:
    """Return the primitives of some nodes, each with the number of its node."""
    return [
        (primitive, number)
        for number in nodes
        if head.nodes[number].mesh is not None
        for primitive in _item(head.meshes, head.nodes[number].mesh, "mesh").primitives
    ]


def _compressions(file: _File, primitive: _Primitive) -> set[str]:
    """Names of the extensions without which the numbers of a primitive cannot be read."""
    found = set()
    for number in (primitive.attributes.get("POSITION", -1), primitive.indices):
        accessor = None if number is None else _item(file.head.accessors, number, "accessor")
        if accessor is None:
            continue
        if accessor.buffer_view is None:
            found |= COMPRESSIONS & set(primitive.extensions) if accessor.sparse is None else set()
            continue
        view = _item(file.head.buffer_views, accessor.buffer_view, "part of the buffer")
        if _item(file.buffers, view.buffer, "buffer") is None:
            found |= COMPRESSIONS & set(view.extensions)
    return found


def _world(head: _Head) -> dict[int, FloatArray]:
    """Return the transform of each node of the scene into the coordinates of the scene, shape (4, 4)."""
    if head.scenes:
        roots = _item(head.scenes, head.scene, "scene").nodes
    else:
        inner = {child for node in head.nodes for child in node.children}
        roots = [number for number in range(len(head.nodes)) if number not in inner]
    left, found = [(number, np.eye(4), 1) for number in reversed(roots)], {}
    while left:
        number, outer, depth = left.pop()
        node = _item(head.nodes, number, "node")
        if number in found:
            raise ValueError(f"node {number} lies in itself, or in two nodes")
        if depth > DEEPEST:
            raise ValueError(f"node {number} lies in {depth - 1} others; expected less than {DEEPEST}, join them")
        with np.errstate(all="ignore"):  # Numbers that overflow are not finite, which is checked.
            found[number] = outer @ _transform(node)
        left += [(child, found[number], depth + 1) for child in reversed(node.children)]
    return found


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


def _stated_bytes(head: _Head, primitive: _Primitive, node: _Node) -> int:
    """Return the memory that the points and the triangles of a primitive need at a node [bytes]."""
    accessors = [primitive.attributes.get("POSITION", -1), primitive.indices]
    counts = [_item(head.accessors, number, "accessor").count for number in accessors if number is not None]
    if min(counts) < 0:
        raise ValueError(f"an accessor has {min(counts)} elements")
    triangles = counts[-1] // 3 if primitive.mode == TRIANGLES else counts[-1]
    joints = 0 if node.skin is None else len(_item(head.skins, node.skin, "skin").joints)
    carried = SKIN_BYTES * (joints + counts[0] * (1 + len(primitive.attributes))) if node.skin is not None else 0
    return BYTES[0] * counts[0] * (1 + len(primitive.targets)) + BYTES[1] * triangles + carried


def _positions(file: _File, primitive: _Primitive, node: _Node) -> FloatArray:
    """Return the points of a primitive, moved by its morph targets, shape (n, 3)."""
    points = _numbers(file, primitive.attributes.get("POSITION", -1), "VEC3")
    weights = _item(file.head.meshes, node.mesh, "mesh").weights if node.weights is None else node.weights
    for weight, target in zip(weights, primitive.targets, strict=False):
        if weight != 0.0 and "POSITION" in target:
            shift = _numbers(file, target["POSITION"], "VEC3")
            if len(shift) != len(points):
                raise ValueError(f"a morph target moves {len(shift)} of {len(points)} points")
            with np.errstate(all="ignore"):  # Numbers that overflow are not finite, which is checked.
                points = points + weight * shift
    return points


def _carrying(
    file: _File, primitive: _Primitive, node: _Node, world: dict[int, FloatArray], number: int
) -> FloatArray:
    """Return the matrices that carry the points of a primitive into the scene: one, or one for each point of a skin.

    Returns:
        The upper three rows of the matrices, shape (1, 3, 4) or (n, 3, 4).
    """
    if node.skin is None:
        return world[number][None, :3]
    skin = _item(file.head.skins, node.skin, "skin")
    if not skin.joints or not set(skin.joints) <= set(world):
        raise ValueError(f"skin {node.skin} has no joints, or joints that are not in the scene")
    joints = np.array([world[joint] for joint in skin.joints])
    if skin.inverse_bind_matrices is not None:
        bind = _numbers(file, skin.inverse_bind_matrices, "MAT4").reshape(-1, 4, 4).transpose(0, 2, 1)
        if len(bind) < len(joints):
            raise ValueError(f"skin {node.skin} has {len(bind)} matrices for {len(joints)} joints")
        with np.errstate(all="ignore"):  # Numbers that overflow are not finite, which is checked.
            joints = joints @ bind[: len(joints)]
    count = _item(file.head.accessors, primitive.attributes.get("POSITION", -1), "accessor").count
    carry, total = np.zeros((count, 3, 4)), np.zeros(count)
    sets = [key.removeprefix("JOINTS_") for key in primitive.attributes if key.startswith("JOINTS_")]
    for one in sets:
        weights = _numbers(file, primitive.attributes.get(f"WEIGHTS_{one}", -1), "VEC4")
        own = _accessed(file, _item(file.head.accessors, primitive.attributes[f"JOINTS_{one}"], "accessor"), "VEC4")
        fits = own.dtype.kind == "u" and own.shape == weights.shape and len(own) == count
        if not fits or own.max(initial=0) >= len(joints):
            raise ValueError(f"the joints and weights {one[:10]} do not fit the {count} points of a skin")
        with np.errstate(all="ignore"):  # Numbers that overflow are not finite, which is checked.
            for joint, weight in zip(own.T, weights.T, strict=True):
                carry += weight[:, None, None] * joints[joint, :3]
            total += weights.sum(axis=1)
    if not (total > 0.0).all():
        raise ValueError(f"point {int(np.argmin(total))} of a skin has no weight")
    weighed: FloatArray = carry / total[:, None, None]
    return weighed


def _numbers(file: _File, number: int, kind: str) -> FloatArray:
    """Return the numbers of an accessor of a kind; whole numbers may stand for numbers from -1 to 1."""
    accessor = _item(file.head.accessors, number, "accessor")
    values = _accessed(file, accessor, kind)
    numbers: FloatArray = values.astype(np.float64)
    if accessor.normalized and values.dtype.kind in "iu":
        return np.maximum(numbers / np.iinfo(values.dtype).max, -1.0)
    return numbers


def _corners(file: _File, primitive: _Primitive, count: int) -> IntArray:
    """Return the points of each triangle of a primitive of a number of points, shape (n, 3)."""
    if primitive.indices is None:
        corners = np.arange(count)
    else:
        values = _accessed(file, _item(file.head.accessors, primitive.indices, "accessor"), "SCALAR")
        if values.dtype.kind != "u":
            raise ValueError(f"the corners of triangles are numbers of type {values.dtype}")
        corners = values[:, 0].astype(np.int64)
    if primitive.mode == TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if primitive.mode == STRIP:
        return strip_triangles(corners)
    last = np.arange(max(0, len(corners) - 2))
    return corners[np.stack([last + 1, last + 2, np.zeros_like(last)], axis=1)]


def _accessed(file: _File, accessor: _Accessor, kind: str) -> NDArray:
    """Return the numbers of an accessor of a kind, shape (elements, columns)."""
    if accessor.type != kind or accessor.component_type not in NUMBERS:
        raise ValueError(f"an accessor is of {accessor.type[:20]!r} and {accessor.component_type}, expected {kind}")
    kind_of_numbers, columns = np.dtype(NUMBERS[accessor.component_type]), COLUMNS[kind]
    place = accessor.buffer_view, accessor.byte_offset
    if accessor.buffer_view is not None:
        values = _viewed(file, *place, accessor.count, kind_of_numbers, columns)
    elif accessor.sparse is not None:
        values = np.zeros((accessor.count, columns), kind_of_numbers)
    else:
        raise ValueError("an accessor has no bytes in the buffer")
    if accessor.sparse is None:
        return values
    changed, found = accessor.sparse.indices, accessor.sparse.values
    integers = np.dtype(NUMBERS.get(changed.component_type, "<f4"))
    number = _viewed(file, changed.buffer_view, changed.byte_offset, accessor.sparse.count, integers, 1)[:, 0]
    if integers.kind != "u" or (len(number) and number.max() >= accessor.count):
        raise ValueError("a sparse accessor changes elements that it does not have")
    values = values.copy()
    values[number] = _viewed(
        file, found.buffer_view, found.byte_offset, accessor.sparse.count, kind_of_numbers, columns
    )
    return values


def _viewed(file: _File, view: int | None, offset: int, count: int, kind: np.dtype, columns: int) -> NDArray:
    """Return elements of a part of a buffer, shape (count, columns)."""
    part = _item(file.head.buffer_views, view, "part of the buffer")
    buffer = _item(file.buffers, part.buffer, "buffer")
    if buffer is None:
        raise ValueError(f"buffer {part.buffer} has no bytes")
    size = kind.itemsize * columns
    step = part.byte_stride or size
    start = part.byte_offset + offset
    end = start + step * (count - 1) + size if count else start
    within = min(len(buffer), part.byte_offset + part.byte_length)
    if min(part.byte_offset, part.byte_length, offset, count) < 0 or step < size or end > within:
        raise ValueError(f"an accessor of {count} elements ends beyond its bytes")
    return np.ndarray((count, columns), kind, buffer, start, (step, kind.itemsize))


def _item(items: list[T], number: int | None, what: str) -> T:
    if number is None or not 0 <= number < len(items):
        raise ValueError(f"it names {what} {number} of {len(items)}")
    return items[number]
