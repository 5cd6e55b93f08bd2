# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""HDF5 files that hold one frozen dataclass of arrays (a stitch mesh or a set of yarns) without loss.

The root group has the attributes ``format``, ``version`` and ``unit`` and one dataset for each field of the dataclass.
Optional fields that are None are left out, and a lattice is stored as its periods.
"""

from __future__ import annotations

import dataclasses
import io
import math
from collections.abc import Iterable
from os import fspath
from typing import TYPE_CHECKING, Any, TypeVar, get_args, get_type_hints

import numpy as np

from stitchmesh.errors import FileError, StitchMeshError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath, check_expansion, read_bytes
from stitchmesh.io.own_stitches import format_own_drawings, parse_own_drawings
from stitchmesh.lattice import Lattice
from stitchmesh.yarn.yarn_presets import Yarn, format_yarn, parse_yarn

if TYPE_CHECKING:
    import h5py

Data = TypeVar("Data")

SIGNATURE = b"\x89HDF\r\n\x1a\n"
VERSION = 1
DRAWINGS = "own_stitches"
"""Field with the drawings of the user's own stitches; its dataset, if there is one, holds their JSON text as bytes."""
MADE_OF = "made_of"
"""Field with the yarn of a set of yarns; its dataset, if there is one, holds the JSON text of the yarn as bytes."""
FREE_CHUNKS, SMALLEST_CHUNK = 1000, 1024
"""Number of chunks that each file may have, and least mean size of further chunks [bytes]; h5py chooses 8 kB and
more."""
HEAP, HEAP_HEAD = b"GCOL\x01\0\0\0", 16
"""First bytes of a heap of texts, and the size of its head and of the heads of its objects."""


def write_dataclass(path: FilePath, data: object, format_name: str) -> None:
    """Write every field of a frozen dataclass of arrays.

    Args:
        path: the file; missing folders are made.
        data: instance of the dataclass.
        format_name: value of the attribute ``format``.

    Raises:
        FileError: the file cannot be written.
    """
    import h5py

    content = io.BytesIO()  # On a full disk HDF5 itself writes a damaged file and ends the process.
    with h5py.File(content, "w") as file:
        file.attrs["format"] = format_name
        file.attrs["version"] = VERSION
        file.attrs["unit"] = "cm"
        for field in _stored_fields(data):
            value = getattr(data, field.name)
            if value is not None:
                file.create_dataset(field.name, data=value.periods if isinstance(value, Lattice) else value)
        if getattr(data, DRAWINGS, ()):
            file.create_dataset(DRAWINGS, data=np.frombuffer(format_own_drawings(getattr(data, DRAWINGS)), np.uint8))
        if isinstance(yarn := getattr(data, MADE_OF, None), Yarn):
            file.create_dataset(MADE_OF, data=np.frombuffer(format_yarn(yarn).encode(), np.uint8))
    write_bytes(path, content.getbuffer())


def read_dataclass(path: FilePath, kind: type[Data], format_name: str) -> Data:
    """Read every field of a frozen dataclass of arrays.

    Args:
        path: the file.
        kind: the dataclass.
        format_name: value that the attribute ``format`` must have.

    Raises:
        FileError: the file cannot be read, is not of that format, was written by a newer version, lacks a field, or
            its fields contradict each other.
    """
    import h5py

    name = fspath(path)
    content = read_bytes(path)
    if content[: len(SIGNATURE)] != SIGNATURE:
        raise FileError(f"{name}: is not an HDF5 file; expected one that StitchMesh wrote ({format_name})")
    _check_heaps(name, content)
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            _check_format(name, file, format_name)
            datasets = {field.name: _dataset(name, file, field.name) for field in _stored_fields(kind)}
            drawings, made_of = (_dataset(name, file, label) for label in (DRAWINGS, MADE_OF))
            _check_sizes(name, len(content), [*datasets.values(), drawings, made_of])
            fields = {field.name: _value(name, datasets[field.name], field, kind) for field in _stored_fields(kind)}
            if drawings is not None:
                fields[DRAWINGS] = parse_own_drawings(name, np.asarray(drawings[()], dtype=np.uint8).tobytes())
            if made_of is not None:
                fields[MADE_OF] = parse_yarn(np.asarray(made_of[()], dtype=np.uint8).tobytes())
    except FileError:
        raise
    except Exception as error:  # h5py raises exceptions of many types for damaged files.
        raise FileError(f"{name}: the HDF5 file is damaged or cut short; write it again") from error
    try:
        return kind(**fields)
    except (StitchMeshError, ValueError, IndexError, TypeError) as error:
        raise FileError(f"{name}: {error}") from error


def stored_format(path: FilePath) -> str:
    """Return the attribute ``format`` of an HDF5 file, or an empty text if the file has no such attribute.

    Raises:
        FileError: the file cannot be opened as HDF5.
    """
    import h5py

    content = read_bytes(path)
    _check_heaps(fspath(path), content)
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            return str(file.attrs.get("format", ""))
    except Exception as error:  # h5py raises exceptions of many types for damaged files.
        raise FileError(f"{fspath(path)}: is not an HDF5 file, or it is damaged; write it again") from error


def _check_heaps(name: str, content: bytes) -> None:
    """Check the lengths in the heaps of texts: the HDF5 library reads for ever where one leads back to its place.

    A heap begins with the letters ``GCOL``, its version, three zeros, and its size in eight bytes. Each object in it
    has a head of 16 bytes: the first two are its number, and the last eight are its size. The size of the object of
    number 0, the free space, contains its head. The contents of the other objects are filled up to eight bytes. They
    must be texts. Heaps can also hold lists of the parts of virtual datasets, which begin with a version that is no
    letter; at a damaged list the library ends the process.
    """
    heap = content.find(HEAP)
    while heap >= 0:
        end, place = heap + _length_at(content, heap + 8), heap + HEAP_HEAD
        if end > len(content):
            raise FileError(f"{name}: the HDF5 file is damaged or cut short (a heap ends beyond it); write it again")
        while place + HEAP_HEAD <= end:
            size = _length_at(content, place + 8)
            is_free = content[place : place + 2] == b"\0\0"
            step = size if is_free else HEAP_HEAD + -(-size // 8) * 8
            if not HEAP_HEAD <= step <= end - place:
                found = f"an object of {size} bytes in a heap"
                raise FileError(f"{name}: the HDF5 file is damaged ({found}); write it again")
            if not is_free and size and content[place + HEAP_HEAD] < ord(" "):
                raise FileError(f"{name}: holds virtual datasets or other data than texts in a heap; write it again")
            place += step
        heap = content.find(HEAP, heap + len(HEAP))


def _length_at(content: bytes, place: int) -> int:
    return int.from_bytes(content[place : place + 8], "little")


def _check_format(name: str, file: h5py.File, format_name: str) -> None:
    found = str(file.attrs.get("format", ""))
    if found != format_name:
        holds = repr(found) if found else "something else"
        raise FileError(f"{name}: holds {holds}; expected {format_name!r}")
    version = file.attrs.get("version", 0)
    if not isinstance(version, int | np.integer) or not 1 <= version <= VERSION:
        raise FileError(f"{name}: has version {version}; this StitchMesh reads version {VERSION}, use a newer one")


def _stored_fields(data: object) -> list[dataclasses.Field[Any]]:
    """Return the fields of a dataclass that files hold; a field with ``stored`` False in its metadata is left out."""
    return [field for field in dataclasses.fields(data) if field.metadata.get("stored", True)]  # type: ignore[arg-type]


def _dataset(name: str, file: h5py.File, label: str) -> h5py.Dataset | None:
    """Return a dataset whose numbers lie in the file itself; None if the file has none of this name.

    Links, virtual datasets and external storage could name any file of the machine.
    """
    import h5py

    link = file.get(label, getlink=True)
    if link is None:
        return None
    dataset = file.get(label) if isinstance(link, h5py.HardLink) else None
    if isinstance(dataset, h5py.Group):
        raise FileError(f"{name}: {label!r} is a group; expected a dataset")
    if not isinstance(dataset, h5py.Dataset) or dataset.external or dataset.is_virtual or dataset.shape is None:
        raise FileError(f"{name}: {label!r} is a link, empty or stored elsewhere; expected numbers in the file itself")
    return dataset


def _check_sizes(name: str, size: int, datasets: Iterable[h5py.Dataset | None]) -> None:
    """Check that the datasets need neither much more memory than the file has bytes (``size``), nor very many chunks.

    The library takes about 4 kB for each chunk that it reads, also for a chunk that the file does not hold.
    """
    stated, chunks = 0, 0
    for dataset in (dataset for dataset in datasets if dataset is not None):
        sizes = dataset.chunks or dataset.shape
        stated += dataset.dtype.itemsize * (math.prod(dataset.shape) + math.prod(sizes))
        chunks += math.prod(-(-length // part) for length, part in zip(dataset.shape, sizes, strict=True) if length)
    try:
        check_expansion(stated, size)
    except ValueError as error:
        raise FileError(f"{name}: {error}; it was altered") from error
    if chunks > FREE_CHUNKS + stated // SMALLEST_CHUNK:
        raise FileError(f"{name}: divides {stated} bytes of numbers into {chunks} chunks; write it with larger chunks")


def _value(name: str, dataset: h5py.Dataset | None, field: dataclasses.Field[Any], owner: type) -> Any:
    """Return the value of one field: its dataset, or the default of the dataclass if there is no dataset."""
    if dataset is None:
        if field.default_factory is not dataclasses.MISSING:
            return field.default_factory()
        if field.default is dataclasses.MISSING:
            raise FileError(f"{name}: dataset {field.name!r} is missing; write the file again")
        return field.default
    expected = np.dtype(_number_type(get_type_hints(owner)[field.name]))
    if not np.can_cast(dataset.dtype, expected, "safe"):
        raise FileError(f"{name}: dataset {field.name!r} holds {dataset.dtype}; expected {expected}")
    return Lattice(dataset[()]) if field.name == "lattice" else dataset[()]


def _number_type(hint: object) -> type[np.generic]:
    """Return the NumPy number type in the annotation of a field; it is float64 for the periods of a lattice."""
    if isinstance(hint, type) and issubclass(hint, np.generic):
        return hint
    inner = [_number_type(part) for part in get_args(hint)]
    specific = [part for part in inner if part is not np.float64] or inner
    return specific[0] if specific else np.float64
