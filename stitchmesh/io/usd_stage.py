# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""USD stages: how a stage is opened and written, its unit, its axes, and its error messages.

A stage may be composed only of regular files in the folder of its own file. These files are found and checked before
the library composes the stage, because the library would wait for ever at a pipe.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from os import fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import atomic_path
from stitchmesh.io.contents import FilePath
from stitchmesh.io.disk_refusal import as_refusal

if TYPE_CHECKING:
    from pxr import Usd

T = TypeVar("T")

LIBRARIES = ("pxr.Usd", "pxr.UsdGeom", "pxr.UsdSkel")
"""Modules that a process loads before it reads a stage."""
METRES_PER_UNIT = 0.01
"""Unit of the coordinates in files that are written [m]."""
Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rotation of points with z up, as rows, to points with y up."""
MOST_LAYERS = 1000
"""Largest number of files that a stage may be composed of."""


def read_stage(path: FilePath, read: Callable[[str, Usd.Stage], T]) -> T:
    """Open a stage in this process, and read from it.

    Args:
        path: the file.
        read: reads from the stage; its first argument is the name of the file.

    Raises:
        FileError: the file is malformed or names files outside of its folder, or ``read`` refuses it.
    """
    from pxr import Tf, Usd

    name = fspath(path)
    try:
        _check_layers(name)
        stage = Usd.Stage.Open(name)
        with np.errstate(all="ignore"):  # Numbers that overflow are not finite, which is checked.
            return read(name, stage)
    except FileError:
        raise
    except Exception as error:  # USD raises exceptions of many types for malformed files.
        reason = reason_of(error) if isinstance(error, Tf.ErrorException) else " ".join(str(error).split())[:100]
        raise FileError(f"{name}: is not a valid USD file ({reason}); write it again") from error


def new_stage() -> Usd.Stage:
    """Return an empty stage in centimetres with y up."""
    from pxr import Usd

    stage = Usd.Stage.CreateInMemory()
    _set_units(stage)
    return stage


def _set_units(stage: Usd.Stage) -> None:
    from pxr import UsdGeom

    UsdGeom.SetStageMetersPerUnit(stage, METRES_PER_UNIT)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)


@contextmanager
def growing_stage(path: FilePath) -> Iterator[Usd.Stage]:
    """Provide an empty stage in centimetres with y up, and write it atomically after the block.

    The stage lies in a binary file from the beginning. ``stage.Save()`` in the block moves all values there, so that
    the memory does not grow with the number of time samples; the values that a text file holds are read from there.

    Raises:
        FileError: the file cannot be written.
    """
    from pxr import Tf, Usd

    with atomic_path(path) as temporary:
        is_text = temporary.suffix.lower() == ".usda"
        try:
            stage = Usd.Stage.CreateNew(str(temporary.with_suffix(".usdc") if is_text else temporary))
            _set_units(stage)
            yield stage
            stage.Save()
            if is_text:
                stage.GetRootLayer().Export(str(temporary))
        except Tf.ErrorException as error:
            raise as_refusal(reason_of(error)) from error


def export_stage(path: FilePath, stage: Usd.Stage) -> None:
    """Write a stage atomically.

    Raises:
        FileError: the file cannot be written.
    """
    from pxr import Tf

    with atomic_path(path) as temporary:
        try:
            stage.GetRootLayer().Export(str(temporary))
        except Tf.ErrorException as error:
            raise as_refusal(reason_of(error)) from error


def to_centimetres(stage: Usd.Stage, world: Any) -> tuple[Any, Any, float]:
    """Return the transform of the points of a prim, as rows, to centimetres with y up.

    Returns:
        Matrix, shape (3, 3), translation [cm], shape (3,), and the mean factor of lengths.
    """
    from pxr import UsdGeom

    matrix = np.array(world, dtype=np.float64) * (UsdGeom.GetStageMetersPerUnit(stage) / METRES_PER_UNIT)
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z:
        matrix[:, :3] = matrix[:, :3] @ Z_UP
    return matrix[:3, :3], matrix[3, :3], float(np.cbrt(abs(np.linalg.det(matrix[:3, :3]))))


def reason_of(error: Any) -> str:
    """Return the first of USD's error messages in one line."""
    try:
        return " ".join(str(error.args[0].commentary).split())[:160]
    except UnicodeDecodeError:  # The message quotes the file.
        return "it holds characters that are not UTF-8"


def _check_layers(name: str) -> None:
    """Refuse a stage that needs anything but regular files in its own folder, before any of them is opened."""
    from pxr import Sdf

    folder, seen, left = Path(name).resolve().parent, set(), [name]
    while left:
        layer = Sdf.Layer.FindOrOpen(left.pop())
        for words in layer.GetCompositionAssetDependencies() if layer else ():
            found = layer.ComputeAbsolutePath(words)
            if not words or found in seen:
                continue
            path = Path(found.partition("[")[0])
            if not path.resolve().is_relative_to(folder) or (path.exists() and not path.is_file()):
                raise FileError(f"{name}: names the file {words[:80]}; expected regular files in its own folder only")
            seen.add(found)
            left.append(found)
        if len(seen) > MOST_LAYERS:
            raise FileError(f"{name}: is composed of more than {MOST_LAYERS} files; expected fewer, flatten it")
