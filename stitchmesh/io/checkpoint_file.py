# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checkpoint files (``.smc``): a header and arrays under a checksum, and the file before kept beside the newest.

``StitchMesh checkpoint`` and a newline; uint32 version; uint64 length of the header; the header, JSON in UTF-8, whose
``arrays`` list name, type and shape of the arrays; the arrays in that order, in C order; SHA-256 of all that. Numbers
are little-endian and keep all their bits.

``NAME.smc`` is the newest, ``NAME.previous.smc`` the one before it. At no moment is there no sound one of the two: the
newest gets a second name, the previous one's, before a complete new file takes its first.
"""

from __future__ import annotations

import glob
import hashlib
import itertools
import json
import os
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from os import fspath
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import atomic_path
from stitchmesh.io.contents import FilePath, read_bytes

MAGIC = b"StitchMesh checkpoint\n"
VERSION = 1
LENGTHS = struct.Struct("<IQ")
CHECKSUM_BYTES = 32


@dataclass(frozen=True, eq=False)
class CheckpointFile:
    """What a checkpoint file holds."""

    header: Mapping[str, Any]
    """What JSON can hold."""
    arrays: Mapping[str, NDArray[Any]]
    """Arrays of numbers by name."""


def previous_of(path: FilePath) -> Path:
    """Where the checkpoint before this one is kept."""
    path = Path(path)
    return path.with_name(f"{path.stem}.previous{path.suffix}")


def write_checkpoint(path: FilePath, content: CheckpointFile) -> None:
    """Write a checkpoint; the file that stood there, if it is sound, becomes the previous one.

    What a writer that was killed left beside the target is removed.

    Raises:
        FileError: the file cannot be written; the one that stood there is still one of the two.
    """
    target = Path(path)
    for litter in target.parent.glob(f".{glob.escape(target.stem)}-*{glob.escape(target.suffix)}"):
        litter.unlink(missing_ok=True)
    with atomic_path(target) as temporary:
        _write(temporary, content)
        if is_sound(target):  # a damaged file must not push out a sound one
            _keep_as_previous(target)


def read_checkpoint(path: FilePath) -> CheckpointFile:
    """The content of a checkpoint.

    Raises:
        FileError: the file is missing, no checkpoint, of another version, damaged or cut short; the message names the
            one before it if that one is sound.
    """
    try:
        return _read(path)
    except FileError as error:
        previous = previous_of(path)
        if not is_sound(previous):
            raise
        raise FileError(f"{error}; the one before it is sound, take {previous}") from error


def is_sound(path: FilePath) -> bool:
    """Whether a checkpoint is there and undamaged."""
    try:
        _undamaged(path)
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
    content = _undamaged(path)
    version, header_bytes = LENGTHS.unpack_from(content, len(MAGIC))
    if version != VERSION:
        found = f"a checkpoint of version {version}; expected {VERSION}, resume where it was written"
        raise FileError(f"{fspath(path)}: {found}")
    start = len(MAGIC) + LENGTHS.size
    header = json.loads(bytes(content[start : start + header_bytes]))
    return CheckpointFile(header["content"], _arrays(content[start + header_bytes :], header["arrays"]))


def _undamaged(path: FilePath) -> memoryview:
    """All of a file but its checksum, which is right."""
    name, content = fspath(path), memoryview(read_bytes(path))
    if content[: len(MAGIC)] != MAGIC:
        raise FileError(f"{name}: is not a checkpoint of a relaxation; expected a .smc file that stitchmesh wrote")
    if len(content) < len(MAGIC) + LENGTHS.size + CHECKSUM_BYTES:
        raise FileError(f"{name}: the checkpoint was cut short after {len(content)} bytes")
    if hashlib.sha256(content[:-CHECKSUM_BYTES]).digest() != content[-CHECKSUM_BYTES:]:
        raise FileError(f"{name}: the checkpoint is damaged or was cut short, its checksum is wrong")
    return content[:-CHECKSUM_BYTES]


def _arrays(content: memoryview, table: list[tuple[str, str, list[int]]]) -> dict[str, NDArray[Any]]:
    arrays, offset = {}, 0
    for name, kind, shape in table:
        count = int(np.prod(shape, dtype=np.int64))
        # a copy, for the bytes in the file are not aligned
        arrays[name] = np.frombuffer(content, kind, count, offset).reshape(shape).copy()
        offset += arrays[name].nbytes
    return arrays


def _keep_as_previous(target: Path) -> None:
    """Give a file the name of the previous one; it keeps its own where the file system knows second names."""
    second = target.with_name(f".{target.stem}-second{target.suffix}")
    try:
        os.link(target, second)
    except OSError:
        os.replace(target, previous_of(target))
        return
    os.replace(second, previous_of(target))
    second.unlink(missing_ok=True)  # a rename onto another name of the same file does nothing
