# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Meshes that move: a folder with one mesh file for each frame, or a USD file with time samples.

The files of a folder end in a number, such as ``walk.0001.obj``. Their numbers follow one another without a gap.
"""

from __future__ import annotations

import re
from os import fspath
from pathlib import Path

import numpy as np

from stitchmesh.errors import FileError, MeshError, ParameterError, check_positive
from stitchmesh.io.contents import FilePath, check_path
from stitchmesh.io.mesh_formats.usd_mesh import read_usd_mesh, write_usd_mesh
from stitchmesh.io.meshes import FORMATS, read_mesh
from stitchmesh.io.path_kind import entries_of, is_folder
from stitchmesh.io.units import DEFAULT_UNIT, centimetres, check_unit_left_out
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.mesh.upright import Direction, Y, turned_upright
from stitchmesh.mesh.vertex_motion import FRAMES_PER_SECOND, MovingMesh, VertexMotion

USD = (".usd", ".usda", ".usdc")
"""Suffixes of USD files."""


def read_moving_mesh(
    path: FilePath, *, unit: str = DEFAULT_UNIT, up: Direction = Y, frames_per_second: float = FRAMES_PER_SECOND
) -> MovingMesh:
    """Read a mesh that moves.

    Args:
        path: a folder with one mesh file for each frame, or a ``.usd``, ``.usda`` or ``.usdc`` file with one mesh.
        unit: unit of the coordinates in the files of a folder. USD states its unit; leave the unit out for it.
        up: direction in the coordinates of these files that points up, and becomes y. USD states it.
        frames_per_second: frames of a folder for each second; USD states its times itself.

    Raises:
        ParameterError: the unit is unknown or is given for USD, the direction is zero or not finite, or the number of
            frames is not positive.
        FileError: a file is missing, cannot be read or is malformed, a frame is missing, or its faces differ from those
            of the first one; the message names the frame.
        MeshError: the polygons do not form an oriented manifold surface.
    """
    check_path(path)
    check_positive("frames per second", frames_per_second)
    if is_folder(path):
        return _of_folder(Path(path), unit, up, frames_per_second)
    if Path(path).suffix.lower() not in USD:
        expected = f"expected a folder with a mesh for each frame, or a file {' '.join(USD)}"
        raise FileError(f"{fspath(path)}: is no mesh that moves; {expected}")
    check_unit_left_out(path, centimetres(unit))
    return moving_mesh_of_stage(path, *read_usd_mesh(path))


def write_moving_mesh(path: FilePath, moving: MovingMesh, *, frames_per_second: float = FRAMES_PER_SECOND) -> None:
    """Write a mesh that moves as USD with time samples; ``read_moving_mesh`` reads it.

    Raises:
        FileError: the suffix is not of USD, a coordinate is too large for float32, or the file cannot be written.
    """
    check_path(path)
    if Path(path).suffix.lower() not in USD:
        raise FileError(f"{fspath(path)}: unknown format; expected one of {' '.join(USD)}")
    write_usd_mesh(path, moving, frames_per_second=frames_per_second)


def _of_folder(folder: Path, unit: str, up: Direction, frames_per_second: float) -> MovingMesh:
    files = _numbered(folder)
    frames = [turned_upright(read_mesh(files[number], unit=unit), up) for number in files]
    try:
        return MovingMesh.of_frames(frames, np.arange(len(frames)) / frames_per_second)
    except ParameterError as error:
        raise FileError(f"{folder}: {error}") from error


def _numbered(folder: Path) -> dict[int, Path]:
    """The mesh files of a folder by their numbers, in ascending order."""
    files: dict[int, Path] = {}
    for path in entries_of(folder):
        found = re.search(r"(\d+)$", path.stem)
        if path.suffix.lower() not in FORMATS or found is None:
            continue
        number = int(found[1])
        if number in files:
            raise FileError(f"{path}: is a second file of frame {number} beside {files[number].name}; remove one")
        files[number] = path
    if not files:
        raise FileError(f"{folder}: has no mesh whose name ends in a number; expected files such as walk.0001.obj")
    first, last = min(files), max(files)
    missing = next((number for number in range(first, last) if number not in files), None)
    if missing is not None:
        found_text = f"got {len(files)} files from {first} to {last}"
        raise FileError(f"{folder}: frame {missing} is missing: {found_text}; expected every number; export it again")
    return dict(sorted(files.items()))


def moving_mesh_of_stage(
    path: FilePath, faces: list[list[int]], times: FloatArray, positions: FloatArray
) -> MovingMesh:
    """Return the mesh of a stage, from what ``read_usd_mesh`` returns.

    Args:
        path: the file, for messages.
        faces: the vertices of each face.
        times: times of the samples [s], shape (K,).
        positions: positions of the vertices [cm], shape (K, V, 3).

    Raises:
        FileError: the times do not increase.
        MeshError: the polygons do not form an oriented manifold surface.
    """
    try:
        return MovingMesh(Mesh.from_polygons(positions[0], faces), VertexMotion(times, positions))
    except MeshError as error:
        raise MeshError(f"{fspath(path)}: {error}") from error
    except ParameterError as error:
        raise FileError(f"{fspath(path)}: {error}") from error
