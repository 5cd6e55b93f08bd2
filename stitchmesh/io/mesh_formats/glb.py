# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""glTF meshes (``.glb``, ``.gltf``): triangles, in metres as the format prescribes.

The head of a file (``gltf_file``) lists nodes, each with a transform, inner nodes and at most one mesh, and meshes,
whose primitives name accessors for positions and corners. One mesh may be placed by many nodes. The numbers of all
placed meshes are therefore counted before they are made.

A mesh is read in the pose of the file: its morph targets move the points by the weights of the node or of the mesh, and
the joints of a skin carry them. The transform of a node with a skin is not used (glTF 2.0 specification, 3.7.3).

Programs that write glTF repeat a vertex for each of its normals and texture coordinates. When a file is read, points
with exactly equal coordinates therefore become one vertex.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable
from os import fspath
from pathlib import Path

import msgspec
import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath, check_expansion, check_points, read_bytes, say_left_out
from stitchmesh.io.float32 import to_float32
from stitchmesh.io.mesh_formats.cells import strip_triangles
from stitchmesh.io.mesh_formats.gltf_file import (
    COMPRESSIONS,
    TRIANGLES,
    GltfFile,
    GltfHead,
    Node,
    Primitive,
    accessed,
    check_extensions,
    chunks_of,
    item_of,
    numbers_of,
    read_gltf,
    read_head,
    refusing_damage,
)
from stitchmesh.io.mesh_formats.welding import weld
from stitchmesh.mesh import FloatArray, IntArray

STRIP, FAN = 5, 6
SURFACES = TRIANGLES, STRIP, FAN
"""Modes of primitives that are surfaces."""
BYTES = 24, 300
"""Memory that is counted for a point and for a triangle, of which lists are made [bytes]."""
SKIN_BYTES = 128
"""Memory that is counted for the matrix of a point with a skin, and for the matrix of a joint [bytes]."""
DEEPEST = 256
"""Largest number of nodes within each other; skeletons of characters have tens of them."""
DATA = "data:application/octet-stream;base64,"
"""Beginning of the address of a buffer that the head holds."""
COPIES = "EXT_mesh_gpu_instancing"
"""Extension by which one node places many copies of its mesh."""


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
    name = fspath(path)
    with refusing_damage(path):
        file = read_gltf(path)
        placed = placed_surfaces(name, file)
        points, triangles = posed_points(file, placed), placed_triangles(file, placed)
    if len(triangles) == 0:
        raise FileError(f"{name}: has no triangles; expected a polygon mesh")
    check_points(f"{name}: point", points)
    return weld(points, triangles.tolist())


def glb_face_names(path: FilePath) -> list[tuple[str, ...]]:
    """Return the names of the node and of the mesh of each triangle that ``read_glb_polygons`` has read.

    Raises:
        FileError: the file cannot be read.
    """
    head, _ = read_head(path, read_bytes(path))
    found: list[tuple[str, ...]] = []
    for primitive, number in _placed_primitives(head, _world(head)):
        if primitive.mode in SURFACES:
            accessor = primitive.attributes["POSITION"] if primitive.indices is None else primitive.indices
            corners = head.accessors[accessor].count
            triangles = corners // 3 if primitive.mode == TRIANGLES else max(0, corners - 2)
            names = head.nodes[number].name, item_of(head.meshes, head.nodes[number].mesh, "mesh").name
            found += [tuple(filter(None, names))] * triangles
    return found


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
    text, buffer = chunks_of(content)
    head = msgspec.json.decode(text)
    head["buffers"] = [{"byteLength": len(buffer), "uri": DATA + base64.b64encode(buffer).decode("ascii")}]
    return msgspec.json.encode(head)


Placed = tuple[Primitive, int]
"""A primitive, and the number of a node that places it."""


def placed_surfaces(name: str, file: GltfFile) -> list[Placed]:
    """Return the surfaces of all nodes, and check what they need.

    Raises:
        FileError: they need an extension that is not read.
        ValueError: they state very many more numbers than the file holds, or are malformed.
    """
    head = file.head
    everything = _placed_primitives(head, _world(head))
    placed = [(primitive, number) for primitive, number in everything if primitive.mode in SURFACES]
    if len(everything) > len(placed):
        say_left_out(name, {"points or lines": len(everything) - len(placed)}, "primitives")
    check_extensions(name, (COPIES for _, number in placed if COPIES in head.nodes[number].extensions))
    check_extensions(name, (one for primitive, _ in placed for one in _compressions(file, primitive)))
    check_expansion(sum(_stated_bytes(head, primitive, head.nodes[number]) for primitive, number in placed), file.size)
    return placed


def posed_points(file: GltfFile, placed: list[Placed]) -> FloatArray:
    """Return the points of surfaces in the pose of the nodes [m], shape (n, 3).

    Raises:
        ValueError: the file is malformed.
    """
    world, points = _world(file.head), [np.zeros((0, 3))]
    for primitive, number in placed:
        own = _positions(file, primitive, file.head.nodes[number])
        carry = _carrying(file, primitive, world, number)
        with np.errstate(all="ignore"):  # Numbers that overflow are not finite, which is checked.
            points.append(np.einsum("nij,nj->ni", carry[:, :, :3], own) + carry[:, :, 3])
    return np.concatenate(points)


def placed_triangles(file: GltfFile, placed: list[Placed]) -> IntArray:
    """Return the points of the triangles of surfaces, shape (n, 3); they are turned over where a node mirrors them.

    Raises:
        ValueError: the file is malformed.
    """
    world, triangles, first = _world(file.head), [np.zeros((0, 3), dtype=np.int64)], 0
    for primitive, number in placed:
        count = item_of(file.head.accessors, primitive.attributes.get("POSITION", -1), "accessor").count
        corners = _corners(file, primitive, count)
        if len(corners) and corners.max() >= count:
            raise ValueError(f"a triangle names point {corners.max()} of {count}")
        carry = _carrying(file, primitive, world, number)
        with np.errstate(all="ignore"):  # Numbers that overflow are not finite, which is checked.
            mirrored = len(carry) and np.linalg.det(carry[:, :, :3].mean(axis=0)) < 0.0
        triangles.append(first + (corners[:, ::-1] if mirrored else corners))
        first += count
    return np.concatenate(triangles)


def _placed_primitives(head: GltfHead, nodes: Iterable[int]) -> list[tuple[Primitive, int]]:
    """Return the primitives of some nodes, each with the number of its node."""
    return [
        (primitive, number)
        for number in nodes
        if head.nodes[number].mesh is not None
        for primitive in item_of(head.meshes, head.nodes[number].mesh, "mesh").primitives
    ]


def _compressions(file: GltfFile, primitive: Primitive) -> set[str]:
    """Names of the extensions without which the numbers of a primitive cannot be read."""
    found = set()
    for number in (primitive.attributes.get("POSITION", -1), primitive.indices):
        accessor = None if number is None else item_of(file.head.accessors, number, "accessor")
        if accessor is None:
            continue
        if accessor.buffer_view is None:
            found |= COMPRESSIONS & set(primitive.extensions) if accessor.sparse is None else set()
            continue
        view = item_of(file.head.buffer_views, accessor.buffer_view, "part of the buffer")
        if item_of(file.buffers, view.buffer, "buffer") is None:
            found |= COMPRESSIONS & set(view.extensions)
    return found


def _world(head: GltfHead) -> dict[int, FloatArray]:
    """Return the transform of each node of the scene into the coordinates of the scene, shape (4, 4)."""
    if head.scenes:
        roots = item_of(head.scenes, head.scene, "scene").nodes
    else:
        inner = {child for node in head.nodes for child in node.children}
        roots = [number for number in range(len(head.nodes)) if number not in inner]
    left, found = [(number, np.eye(4), 1) for number in reversed(roots)], {}
    while left:
        number, outer, depth = left.pop()
        node = item_of(head.nodes, number, "node")
        if number in found:
            raise ValueError(f"node {number} lies in itself, or in two nodes")
        if depth > DEEPEST:
            raise ValueError(f"node {number} lies in {depth - 1} others; expected less than {DEEPEST}, join them")
        with np.errstate(all="ignore"):  # Numbers that overflow are not finite, which is checked.
            found[number] = outer @ _transform(node)
        left += [(child, found[number], depth + 1) for child in reversed(node.children)]
    return found


def _transform(node: Node) -> FloatArray:
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


def _stated_bytes(head: GltfHead, primitive: Primitive, node: Node) -> int:
    """Return the memory that the points and the triangles of a primitive need at a node [bytes]."""
    accessors = [primitive.attributes.get("POSITION", -1), primitive.indices]
    counts = [item_of(head.accessors, number, "accessor").count for number in accessors if number is not None]
    if min(counts) < 0:
        raise ValueError(f"an accessor has {min(counts)} elements")
    triangles = counts[-1] // 3 if primitive.mode == TRIANGLES else counts[-1]
    joints = 0 if node.skin is None else len(item_of(head.skins, node.skin, "skin").joints)
    carried = SKIN_BYTES * (joints + counts[0] * (1 + len(primitive.attributes))) if node.skin is not None else 0
    return BYTES[0] * counts[0] * (1 + len(primitive.targets)) + BYTES[1] * triangles + carried


def _positions(file: GltfFile, primitive: Primitive, node: Node) -> FloatArray:
    """Return the points of a primitive, moved by its morph targets, shape (n, 3)."""
    points = numbers_of(file, primitive.attributes.get("POSITION", -1), "VEC3")
    weights = item_of(file.head.meshes, node.mesh, "mesh").weights if node.weights is None else node.weights
    for weight, target in zip(weights, primitive.targets, strict=False):
        if weight != 0.0 and "POSITION" in target:
            shift = numbers_of(file, target["POSITION"], "VEC3")
            if len(shift) != len(points):
                raise ValueError(f"a morph target moves {len(shift)} of {len(points)} points")
            with np.errstate(all="ignore"):  # Numbers that overflow are not finite, which is checked.
                points = points + weight * shift
    return points


def _carrying(file: GltfFile, primitive: Primitive, world: dict[int, FloatArray], number: int) -> FloatArray:
    """Return the matrices that carry the points of a primitive into the scene: one, or one for each point of a skin.

    Returns:
        The upper three rows of the matrices, shape (1, 3, 4) or (n, 3, 4).
    """
    node = file.head.nodes[number]
    if node.skin is None:
        return world[number][None, :3]
    skin = item_of(file.head.skins, node.skin, "skin")
    if not skin.joints or not set(skin.joints) <= set(world):
        raise ValueError(f"skin {node.skin} has no joints, or joints that are not in the scene")
    joints = np.array([world[joint] for joint in skin.joints])
    if skin.inverse_bind_matrices is not None:
        bind = numbers_of(file, skin.inverse_bind_matrices, "MAT4").reshape(-1, 4, 4).transpose(0, 2, 1)
        if len(bind) < len(joints):
            raise ValueError(f"skin {node.skin} has {len(bind)} matrices for {len(joints)} joints")
        with np.errstate(all="ignore"):  # Numbers that overflow are not finite, which is checked.
            joints = joints @ bind[: len(joints)]
    count = item_of(file.head.accessors, primitive.attributes.get("POSITION", -1), "accessor").count
    carry, total = np.zeros((count, 3, 4)), np.zeros(count)
    sets = [key.removeprefix("JOINTS_") for key in primitive.attributes if key.startswith("JOINTS_")]
    for one in sets:
        weights = numbers_of(file, primitive.attributes.get(f"WEIGHTS_{one}", -1), "VEC4")
        own = accessed(file, item_of(file.head.accessors, primitive.attributes[f"JOINTS_{one}"], "accessor"), "VEC4")
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


def _corners(file: GltfFile, primitive: Primitive, count: int) -> IntArray:
    """Return the points of each triangle of a primitive of a number of points, shape (n, 3)."""
    if primitive.indices is None:
        corners = np.arange(count)
    else:
        values = accessed(file, item_of(file.head.accessors, primitive.indices, "accessor"), "SCALAR")
        if values.dtype.kind != "u":
            raise ValueError(f"the corners of triangles are numbers of type {values.dtype}")
        corners = values[:, 0].astype(np.int64)
    if primitive.mode == TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if primitive.mode == STRIP:
        return strip_triangles(corners)
    last = np.arange(max(0, len(corners) - 2))
    return corners[np.stack([last + 1, last + 2, np.zeros_like(last)], axis=1)]


