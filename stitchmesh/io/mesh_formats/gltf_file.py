# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The parts of a glTF file (``.glb``, ``.gltf``): its head in JSON, its buffers of bytes, and numbers in them.

The head lists nodes, meshes, skins, animations and accessors, which say where in a buffer their numbers lie. The
buffers lie behind the head, in the head as text, or in files beside it.
"""

from __future__ import annotations

import base64
import struct
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from os import fspath
from pathlib import Path
from typing import TypeVar
from urllib.parse import unquote

import msgspec
import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.checked import check_value, parse_json
from stitchmesh.io.contents import FilePath, read_bytes
from stitchmesh.mesh import FloatArray

T = TypeVar("T")

HEAD = struct.Struct("<4sII")
"""Head of a file: the letters, the version and the length."""
CHUNK = struct.Struct("<I4s")
"""Head of a chunk: its length and its kind."""
NUMBERS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""NumPy's names of the types of numbers."""
TUBES = "yarns"
"""First word of the names of meshes that are the tubes of yarns; ``read_mesh`` recognises a file of yarns by it."""
COLUMNS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}
"""Numbers of an element, for the kinds of accessors of corners, positions, joints with their weights, and matrices."""
TRIANGLES = 4
"""Mode of primitives that are triangles."""
COMPRESSIONS = {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"}
"""Extensions that store positions in another form."""
LOOKS = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_", "EXT_lights_", "KHR_xmp",
         "KHR_animation_pointer", "KHR_mesh_quantization")  # fmt: skip
"""Beginnings of the names of extensions that leave positions as they are, or that the readers obey."""


class Stated(msgspec.Struct, rename="camel", kw_only=True):
    """A value of the head; keys that are not read may hold anything."""


class Indices(Stated):
    """Places of the elements that a sparse accessor changes."""

    buffer_view: int
    component_type: int
    byte_offset: int = 0


class Values(Stated):
    """Numbers of the elements that a sparse accessor changes."""

    buffer_view: int
    byte_offset: int = 0


class Sparse(Stated):
    """Numbers that replace numbers of the accessor, or zeros."""

    count: int
    indices: Indices
    values: Values


class Accessor(Stated):
    """Numbers of one kind, and where they lie."""

    count: int
    component_type: int
    type: str
    buffer_view: int | None = None
    byte_offset: int = 0
    normalized: bool = False
    sparse: Sparse | None = None


class View(Stated):
    """A part of a buffer."""

    buffer: int
    byte_length: int
    byte_offset: int = 0
    byte_stride: int | None = None
    extensions: dict[str, object] = {}


class Buffer(Stated):
    """Bytes behind the head, in a text, or in another file."""

    uri: str | None = None


class Primitive(Stated):
    """Points, triangles and morph targets."""

    attributes: dict[str, int]
    indices: int | None = None
    mode: int = TRIANGLES
    targets: list[dict[str, int]] = []
    extensions: dict[str, object] = {}


class GltfMesh(Stated):
    """Primitives, which may have different materials."""

    primitives: list[Primitive]
    name: str = ""
    weights: list[float] = []


class Skin(Stated):
    """The joints of a skeleton that carry a mesh."""

    joints: list[int]
    inverse_bind_matrices: int | None = None


class Node(Stated):
    """A transform, the nodes within it, and what it places there."""

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


class ChannelTarget(Stated):
    """What a channel of an animation changes; an extension may name something else than a node."""

    path: str
    node: int | None = None


class Channel(Stated):
    """What a sampler changes."""

    sampler: int
    target: ChannelTarget


class Sampler(Stated):
    """Times of keys, and the numbers at them."""

    input: int
    output: int
    interpolation: str = "LINEAR"


class Animation(Stated):
    """Changes of nodes in time."""

    channels: list[Channel]
    samplers: list[Sampler]
    name: str = ""


class GltfScene(Stated):
    """The outer nodes."""

    nodes: list[int] = []


class GltfHead(Stated):
    """All lists of a file, whose items name each other by number."""

    scene: int = 0
    scenes: list[GltfScene] = []
    nodes: list[Node] = []
    meshes: list[GltfMesh] = []
    skins: list[Skin] = []
    animations: list[Animation] = []
    accessors: list[Accessor] = []
    buffer_views: list[View] = []
    buffers: list[Buffer] = []
    extensions_required: list[str] = []


@dataclass(frozen=True, eq=False)
class GltfFile:
    """The head of a file with its buffers."""

    head: GltfHead
    buffers: list[bytes | None]
    """Bytes of each buffer; None for a buffer without bytes, which stands for the numbers of a compression."""
    size: int
    """Size of the file and of the files beside it [bytes]."""


@contextmanager
def refusing_damage(path: FilePath) -> Iterator[None]:
    """Report what the block finds wrong with a file as an error that names the file.

    Raises:
        FileError: the block raises an error about a value.
    """
    try:
        yield
    except (ParameterError, ValueError) as error:
        raise FileError(f"{fspath(path)}: is not a valid glTF file ({error}); write it again") from error


def read_gltf(path: FilePath) -> GltfFile:
    """Read the head and the buffers of a file of meshes.

    Args:
        path: a ``.glb`` file, or a ``.gltf`` file, whose buffers may lie in its folder or in folders within it.

    Raises:
        ParameterError, ValueError: the file is malformed; ``refusing_damage`` reports it.
        FileError: the file cannot be read, needs an extension that is not read, or holds tubes that ``write_yarns``
            wrote.
    """
    content = read_bytes(path)
    head, binary = read_head(path, content)
    if holds_tubes(mesh.name for mesh in head.meshes):
        raise tubes_error(path)
    check_extensions(fspath(path), (one for one in head.extensions_required if not one.startswith(LOOKS)))
    buffers = [_bytes_of(path, one, None if number else binary) for number, one in enumerate(head.buffers)]
    size = len(content) + sum(len(one) for one in buffers if one is not None and one is not binary)
    return GltfFile(head, buffers, size)


def read_head(path: FilePath, content: bytes) -> tuple[GltfHead, bytes | None]:
    """Return the head of a file, and the buffer behind it; a ``.gltf`` file is a head alone."""
    json, binary = (content, None) if Path(path).suffix.lower() == ".gltf" else chunks_of(content)
    return check_value(parse_json(json.decode("utf-8")), GltfHead), binary


def check_extensions(name: str, needed: Iterable[str]) -> None:
    """Refuse a file that needs an extension, by the name of the extension.

    Raises:
        FileError: the file needs an extension.
    """
    for one in needed:
        found = f"its meshes are compressed by {one}" if one in COMPRESSIONS else f"it needs the extension {one[:60]}"
        raise FileError(f"{name}: {found}, which is not read; export it without")


def _bytes_of(path: FilePath, buffer: Buffer, binary: bytes | None) -> bytes | None:
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


def chunks_of(content: bytes) -> tuple[bytes, bytes]:
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


def numbers_of(file: GltfFile, number: int, kind: str) -> FloatArray:
    """Return the numbers of an accessor of a kind; whole numbers may stand for numbers from -1 to 1."""
    accessor = item_of(file.head.accessors, number, "accessor")
    values = accessed(file, accessor, kind)
    numbers: FloatArray = values.astype(np.float64)
    if accessor.normalized and values.dtype.kind in "iu":
        return np.maximum(numbers / np.iinfo(values.dtype).max, -1.0)
    return numbers


def accessed(file: GltfFile, accessor: Accessor, kind: str) -> NDArray:
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


def _viewed(file: GltfFile, view: int | None, offset: int, count: int, kind: np.dtype, columns: int) -> NDArray:
    """Return elements of a part of a buffer, shape (count, columns)."""
    part = item_of(file.head.buffer_views, view, "part of the buffer")
    buffer = item_of(file.buffers, part.buffer, "buffer")
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


def item_of(items: list[T], number: int | None, what: str) -> T:
    """Return an item of a list of the head.

    Raises:
        ValueError: the list has no such item.
    """
    if number is None or not 0 <= number < len(items):
        raise ValueError(f"it names {what} {number} of {len(items)}")
    return items[number]


def holds_tubes(names: Iterable[str]) -> bool:
    """Return whether meshes with these names are the tubes of yarns."""
    return any(name.split(" ")[0] == TUBES for name in names)


def tubes_error(path: FilePath) -> FileError:
    """Return the error of an attempt to read yarns, or a polygon mesh, from a file of tubes."""
    found = "a glTF file of yarns holds tubes and not the curves of the yarns"
    return FileError(f"{fspath(path)}: {found}; read the .h5 file of the yarns")
