# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checkpoint files (``.smc``): a header and arrays with a checksum. The previous checkpoint is kept beside the newest.

A file consists of the text ``StitchMesh checkpoint`` and a newline; the version as uint32; the length of the header as
uint64; the header, JSON in UTF-8, whose entry ``arrays`` lists the name, type and shape of each array; the arrays in
the order of that list, each in C order; and the SHA-256 checksum of all preceding bytes. Numbers are little-endian and
keep all their bits.

``NAME.smc`` is the newest checkpoint and ``NAME.previous.smc`` the checkpoint before it. At every moment at least one
of the two files is undamaged: the newest file first receives the previous file's name as a second name (a hard link),
and then a complete new file replaces the first name.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import os
import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from os import fspath
from pathlib import Path
from typing import Any, TypedDict, TypeVar

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.atomic import atomic_path
from stitchmesh.io.checked import check_value, parse_json
from stitchmesh.io.contents import FilePath, read_bytes
from stitchmesh.io.outputs import check_output, note_output
from stitchmesh.io.path_kind import is_file

T = TypeVar("T")

MAGIC = b"StitchMesh checkpoint\n"
VERSION = 1
LENGTHS = struct.Struct("<IQ")
CHECKSUM_BYTES = 32
NUMBER_TYPE = re.compile(r"[<|]([iu][1248]|f[248]|b1)")
"""NumPy's names of the types of numbers that arrays may have."""


class _Header(TypedDict):
    """The header of a file."""

    content: dict[str, Any]
    arrays: list[tuple[str, str, list[int]]]


@dataclass(frozen=True, eq=False)
class CheckpointFile:
    """The content of a checkpoint file."""

    header: Mapping[str, Any]
    """Values that JSON can hold, by name."""
    arrays: Mapping[str, NDArray[Any]]
    """Arrays of numbers, by name."""


def previous_path(path: FilePath) -> Path:
    """Return the path of the previous checkpoint that is kept beside a checkpoint."""
    path = Path(path)
    return path.parent / f"{path.stem}.previous{path.suffix}"


def write_checkpoint(path: FilePath, content: CheckpointFile) -> None:
    """Write a checkpoint; an existing undamaged checkpoint at the path becomes the previous one.

    Raises:
        FileError: the file cannot be written; the existing checkpoint is then still there, under its own name or under
            the name of the previous one.
    """
    target = Path(path)
    with atomic_path(target) as temporary:
        _write(temporary, content)
        if is_undamaged(target):  # A damaged file must not replace an undamaged previous checkpoint.
            _keep_as_previous(target, temporary.with_name("second"))


def was_written(path: FilePath) -> bool:
    """Return whether there is a checkpoint at a path, or a previous checkpoint beside it."""
    return is_file(path) or is_file(previous_path(path))


def read_checkpoint(path: FilePath) -> CheckpointFile:
    """Read a checkpoint.

    Raises:
        FileError: the file is missing, is not a checkpoint, is of another version, is damaged or was cut short; the
            message names the previous checkpoint if that one is undamaged.
    """
    try:
        return _read(path)
    except FileError as error:
        previous = previous_path(path)
        if not is_undamaged(previous):
            raise
        raise FileError(f"{error}; the previous checkpoint is undamaged, use {previous}") from error


def checked_header(path: FilePath, content: CheckpointFile, kind: type[T]) -> T:
    """Return the header of a checkpoint as a value of a type.

    Args:
        path: the file, for the message.
        content: the content that ``read_checkpoint`` returned.
        kind: a dataclass or a ``TypedDict``.

    Raises:
        FileError: the header is not of the type.
    """
    try:
        return check_value(dict(content.header), kind)
    except ParameterError as error:
        raise FileError(f"{fspath(path)}: is a checkpoint of something else, or it was altered ({error})") from error


def is_undamaged(path: FilePath) -> bool:
    """Return whether a file exists and is an undamaged checkpoint."""
    try:
        _verified_content(path)
    except FileError:
        return False
    return True


def _write(path: Path, content: CheckpointFile) -> None:
    arrays = [np.asarray(values, values.dtype.newbyteorder("<")) for values in content.arrays.values()]
    table = [[name, a.dtype.str, list(a.shape)] for name, a in zip(content.arrays, arrays, strict=True)]
    header = json.dumps({"content": content.header, "arrays": table}, allow_nan=False).encode("utf-8")
    checksum = hashlib.sha256()
    with path.open("wb") as file:
        start = MAGIC + LENGTHS.pack(VERSION, len(header)) + header
        for part in itertools.chain([start], (values.tobytes() for values in arrays)):
            checksum.update(part)
            file.write(part)
        file.write(checksum.digest())


def _read(path: FilePath) -> CheckpointFile:
    content = _verified_content(path)
    version, header_bytes = LENGTHS.unpack_from(content, len(MAGIC))
    if version != VERSION:
        found = f"is a checkpoint of version {version}; expected version {VERSION}"
        raise FileError(f"{fspath(path)}: {found}; resume with the StitchMesh that wrote it")
    start = len(MAGIC) + LENGTHS.size
    try:
        text = bytes(content[start : start + header_bytes]).decode("utf-8")
        header = check_value(parse_json(text), _Header)
        return CheckpointFile(header["content"], _arrays(content[start + header_bytes :], header["arrays"]))
    except (ParameterError, UnicodeDecodeError) as error:
        raise FileError(f"{fspath(path)}: the header of the checkpoint is damaged ({error}); write it again") from error


def _verified_content(path: FilePath) -> memoryview:
    """Return the bytes of a checkpoint before the checksum, after a comparison with the checksum."""
    name, content = fspath(path), memoryview(read_bytes(path))
    if content[: len(MAGIC)] != MAGIC:
        raise FileError(f"{name}: is not a checkpoint of a relaxation; expected a .smc file that stitchmesh wrote")
    if len(content) < len(MAGIC) + LENGTHS.size + CHECKSUM_BYTES:
        raise FileError(f"{name}: the checkpoint was cut short after {len(content)} bytes")
    if hashlib.sha256(content[:-CHECKSUM_BYTES]).digest() != content[-CHECKSUM_BYTES:]:
        raise FileError(f"{name}: the checkpoint is damaged or was cut short, its checksum is wrong")
    return content[:-CHECKSUM_BYTES]


def _arrays(content: memoryview, table: list[tuple[str, str, list[int]]]) -> dict[str, NDArray[Any]]:
    """Return the arrays of a checkpoint, given the table of their names, types and shapes.

    Raises:
        ParameterError: a type is no type of numbers, or the arrays are not as long as the content.
    """
    arrays, offset = {}, 0
    for name, kind, shape in table:
        if not NUMBER_TYPE.fullmatch(kind) or len(shape) > 8 or min(shape, default=0) < 0:
            found = f"type {kind[:20]!r} and shape {shape[:8]}"
            raise ParameterError(f"array {name[:40]!r} is of {found}; expected numbers")
        count = math.prod(shape)
        if count * np.dtype(kind).itemsize > len(content) - offset:
            raise ParameterError(f"array {name[:40]!r} of shape {shape[:8]} is longer than the file")
        # The array is copied, because the bytes in the file are not aligned.
        arrays[name] = np.frombuffer(content, kind, count, offset).reshape(shape).copy()
        offset += arrays[name].nbytes
    if offset != len(content):
        raise ParameterError(f"{len(content) - offset} bytes are left after the last array")
    return arrays


def _keep_as_previous(target: Path, second: Path) -> None:
    """Give a checkpoint the name of the previous one.

    The file keeps its own name too if the file system supports hard links; otherwise it is renamed.

    Args:
        target: the checkpoint.
        second: a free name beside the new checkpoint, in the folder that is removed after the write.
    """
    previous = previous_path(target)
    check_output(previous)
    note_output(previous, target)
    try:
        os.link(target, second)
    except OSError:
        os.replace(target, previous)
        return
    os.replace(second, previous)  # This does nothing if both names belong to the same file.
