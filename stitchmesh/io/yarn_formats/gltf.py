# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Binary glTF (``.glb``): yarns as tubes of triangles, in metres and y up as the format prescribes.

The yarns of one colour have one rough material of this colour. Tubes have the apparent radius of the yarns. Sets with
more segments get tubes with fewer sides and sections, so that viewers can load the file. A mesh has at most 65,535
vertices, so that 16 bits number them.

The coarse level of detail is for web pages. Its tubes have two sections in three segments. Its coordinates are 16-bit
numbers and its normals 8-bit numbers (the extension KHR_mesh_quantization, which browsers and Blender read, and
VTK does not). The node of a mesh holds its scale and its place. A step is the 65,534th part of the box around the mesh:
0.001 cm in a box of 60 cm.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath
from stitchmesh.io.float32 import to_float32
from stitchmesh.io.mesh_formats.gltf_file import CHUNK, HEAD, NUMBERS, TRIANGLES, TUBES
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.palette import colours_of, linear_colour
from stitchmesh.mesh.tube_mesh import TubeMesh, tubes_around
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.polyline import polylines_of_segments

Detail = Literal["fine", "coarse"]
DETAILS: tuple[Detail, ...] = ("fine", "coarse")
"""Levels of detail."""
DETAIL = ((20_000, 12, 4), (60_000, 8, 2), (160_000, 6, 1), (math.inf, 4, 1))
"""Largest number of segments, sides of a tube, sections of a segment of the fine level; a file has at most about a
million vertices, unless it has very many segments."""
COARSE_SIDES, COARSE_SAMPLES, COARSE_STRIDE = 5, 2, 3
"""Sides of a tube of the coarse level, samples of a segment, and samples from one of its sections to the next. With a
section for every second segment, the legs of a stitch would no longer be told apart."""
ROUGHNESS = 0.9
"""Roughness of wool in glTF and USD, from 0 (mirror) to 1 (matt)."""
STEPS, MOST_VERTICES = 32_767, 65_535
"""Steps from the middle of a box to its border, and the largest number of vertices that 16 bits number."""
QUANTISATION = "KHR_mesh_quantization"
KINDS = {np.dtype(name): kind for kind, name in NUMBERS.items()}
"""Kinds of numbers, by NumPy's types."""
VERTICES, CORNERS = 34_962, 34_963
"""Targets of the bytes of vertices, and of the bytes of corners of triangles."""


def write_glb(path: FilePath, yarns: YarnSet, detail: Detail = "fine") -> None:
    """Write yarns as tubes with the apparent radius of the yarns.

    Args:
        path: a ``.glb`` file.
        yarns: a set without a lattice.
        detail: level of detail, ``fine`` or ``coarse``.

    Raises:
        FileError: a coordinate is too large for float32, or the file cannot be written.
    """
    file = _Glb(is_quantised=detail == "coarse")
    for number, tubes in tubes_of_colours(yarns, detail):
        places = to_float32(path, "the coordinates", 0.01 * tubes.vertices)  # Metres in a centimetre.
        material = file.add("materials", {
            "name": f"wool {number}", "pbrMetallicRoughness": {
                "baseColorFactor": [*linear_colour(colours_of([number], yarns.palette)[0] / 255).tolist(), 1.0],
                "metallicFactor": 0.0, "roughnessFactor": ROUGHNESS,
            },
        })  # fmt: skip
        for part, (vertices, normals, triangles) in enumerate(_parts(tubes, places)):
            file.add_mesh(f"{TUBES} {number}" + (f" part {part + 1}" if part else ""), material, vertices, normals,
                          triangles)  # fmt: skip
    write_bytes(path, file.content())


def tubes_of_colours(yarns: YarnSet, detail: Detail = "fine") -> Iterator[tuple[int, TubeMesh]]:
    """Yield each colour number with tubes of the apparent radius around its yarns [cm].

    Args:
        yarns: a set without a lattice.
        detail: level of detail.
    """
    count = len(yarns.segment_points)
    sides, samples = next((sides, samples) for most, sides, samples in DETAIL if count <= most)
    stride = 1
    if detail == "coarse":
        sides, samples, stride = min(sides, COARSE_SIDES), COARSE_SAMPLES, COARSE_STRIDE
    for number in np.unique(yarns.colour).tolist():
        curves = polylines_of_segments(yarns, np.flatnonzero((yarns.colour == number)[yarns.segment_yarn]), samples)
        points = [_thinned(own, stride, closed) for own, closed in zip(curves.points, curves.closed, strict=True)]
        yield number, tubes_around(points, curves.closed, yarns.drawn_radius[curves.yarn], sides=sides)


def _thinned(points: FloatArray, stride: int, closed: bool) -> FloatArray:
    """Return every ``stride``-th point of a curve and the last point of an open one, as many as a tube needs."""
    if stride == 1 or len(points) < 3 * stride:
        return points
    if closed:
        return points[::stride]
    return np.concatenate([points[:-1:stride], points[-1:]])


def _parts(tubes: TubeMesh, places: NDArray[np.float32]) -> Iterator[tuple[NDArray[np.float32], FloatArray, IntArray]]:
    """Yield vertices, which have these places [m], normals and triangles of parts that 16 bits can number."""
    farthest = tubes.triangles.max(axis=1)
    order = np.argsort(farthest, kind="stable")
    triangles, farthest = tubes.triangles[order], farthest[order]
    first = 0
    while first < len(triangles):
        # Triangles join neighbouring rings, so that few vertices lie before the first one of a part.
        last = int(np.searchsorted(farthest, farthest[first] + MOST_VERTICES))
        used = np.unique(triangles[first:last])
        while len(used) > MOST_VERTICES:
            last -= max((last - first) // 16, 1)
            used = np.unique(triangles[first:last])
        yield places[used], tubes.normals[used], np.searchsorted(used, triangles[first:last])
        first = last


class _Glb:
    """A glTF file under way: the entries of its head, and its bytes."""

    def __init__(self, *, is_quantised: bool) -> None:
        self._is_quantised = is_quantised
        self._entries: dict[str, list[dict[str, Any]]] = {}
        self._bytes = bytearray()

    def add(self, kind: str, entry: dict[str, Any]) -> int:
        """Add an entry to a list of the head, and return its number."""
        entries = self._entries.setdefault(kind, [])
        entries.append(entry)
        return len(entries) - 1

    def add_mesh(
        self, name: str, material: int, vertices: NDArray[np.float32], normals: FloatArray, triangles: IntArray
    ) -> None:
        """Add a mesh and the node that places it.

        Args:
            name: name of both.
            material: number of its material.
            vertices: positions [m], shape (V, 3).
            normals: unit normals, shape (V, 3).
            triangles: corners, shape (T, 3).
        """
        node: dict[str, Any] = {"name": name}
        if self._is_quantised:
            low, high = vertices.min(axis=0), vertices.max(axis=0)
            middle = 0.5 * (low + high)
            step = max(float((high - middle).max()), 1e-12) / STEPS  # One scale for all axes keeps normals upright.
            node |= {"scale": [step] * 3, "translation": middle.tolist()}
            places: NDArray[Any] = np.rint((vertices - middle) / step).astype("<i2")
            directions: NDArray[Any] = np.rint(127.0 * normals).astype("i1")
        else:
            places, directions = vertices, normals.astype("<f4")
        bounds = {"min": places.min(axis=0).tolist(), "max": places.max(axis=0).tolist()}
        attributes = {
            "POSITION": self._of_vertices(places, **bounds),
            "NORMAL": self._of_vertices(directions, **({"normalized": True} if self._is_quantised else {})),
        }
        corners = triangles.astype("<u2")
        indices = self.add("accessors", {
            "bufferView": self._view(corners.tobytes(), CORNERS), "componentType": KINDS[corners.dtype],
            "count": corners.size, "type": "SCALAR",
        })  # fmt: skip
        primitive = {"attributes": attributes, "indices": indices, "material": material, "mode": TRIANGLES}
        mesh = self.add("meshes", {"name": name, "primitives": [primitive]})
        self.add("nodes", node | {"mesh": mesh})

    def _of_vertices(self, numbers: NDArray[Any], **stated: Any) -> int:
        """Add numbers of vertices, shape (V, 3), whose rows are filled up to whole words of four bytes."""
        rows = np.zeros((len(numbers), -(-3 * numbers.itemsize // 4) * 4 // numbers.itemsize), dtype=numbers.dtype)
        rows[:, :3] = numbers
        view = self._view(rows.tobytes(), VERTICES, byteStride=rows.strides[0])
        own = {"bufferView": view, "componentType": KINDS[numbers.dtype], "count": len(numbers), "type": "VEC3"}
        return self.add("accessors", own | stated)

    def _view(self, content: bytes, target: int, **stated: Any) -> int:
        """Add bytes, which begin at a whole word."""
        start = len(self._bytes)
        self._bytes += content + bytes(-len(content) % 4)
        own = {"buffer": 0, "byteOffset": start, "byteLength": len(content), "target": target}
        return self.add("bufferViews", own | stated)

    def content(self) -> bytes:
        """Return the bytes of the file."""
        from stitchmesh import __version__

        nodes, used = self._entries.get("nodes", []), ("extensionsUsed", "extensionsRequired")
        head = {
            "asset": {"version": "2.0", "generator": f"StitchMesh {__version__}"}, "scene": 0,
            "scenes": [{"nodes": list(range(len(nodes)))}], "buffers": [{"byteLength": len(self._bytes)}],
            **self._entries, **({key: [QUANTISATION] for key in used} if self._is_quantised else {}),
        }  # fmt: skip
        text = json.dumps(head, separators=(",", ":")).encode()
        chunks = [(b"JSON", text + b" " * (-len(text) % 4)), (b"BIN\0", bytes(self._bytes))]
        content = b"".join(CHUNK.pack(len(own), kind) + own for kind, own in chunks)
        return HEAD.pack(b"glTF", 2, HEAD.size + len(content)) + content
