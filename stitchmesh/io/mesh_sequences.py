# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Meshes that move: a folder with one mesh file for each frame, or a file with an animation.

The files of a folder end in a number, such as ``walk.0001.obj``. Their numbers follow one another without a gap. USD
and Alembic have time samples, and glTF has animations of nodes, joints and morph targets.

Programs that write meshes for renderers repeat a vertex for each of its texture coordinates and normals. Vertices that
lie together in all frames are therefore joined, unless the surface would not be a manifold then.
"""

from __future__ import annotations

import logging
import re
from os import fspath
from pathlib import Path

import numpy as np

from stitchmesh.errors import FileError, MeshError, ParameterError, check_positive
from stitchmesh.io.contents import FilePath, check_path
from stitchmesh.io.mesh_formats.alembic_mesh import read_moving_alembic
from stitchmesh.io.mesh_formats.glb_motion import read_moving_glb
from stitchmesh.io.mesh_formats.usd_mesh import read_usd_mesh, write_usd_mesh
from stitchmesh.io.mesh_formats.welding import weld_frames
from stitchmesh.io.meshes import FORMATS, read_mesh
from stitchmesh.io.path_kind import entries_of, is_folder
from stitchmesh.io.units import DEFAULT_UNIT, centimetres, check_unit_left_out
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.mesh.upright import Direction, Y, turned_upright, upright_turn
from stitchmesh.mesh.vertex_motion import FRAMES_PER_SECOND, MovingMesh, VertexMotion

logger = logging.getLogger(__name__)

USD, GLTF, ALEMBIC = (".usd", ".usda", ".usdc"), (".glb", ".gltf"), ".abc"
"""Suffixes of files with an animation."""


def read_moving_mesh(
    path: FilePath, *, unit: str = DEFAULT_UNIT, up: Direction = Y, frames_per_second: float = FRAMES_PER_SECOND
) -> MovingMesh:
    """Read a mesh that moves.

    Args:
        path: a folder with one mesh file for each frame, in any format of ``read_mesh``; a ``.usd``, ``.usda`` or
            ``.usdc`` file with one mesh, which may have a skeleton or blend shapes; a ``.glb`` or ``.gltf`` file with
            one mesh and an animation; or an ``.abc`` file with one mesh (``pip install stitchmesh[alembic]``).
        unit: unit of the coordinates in the files of a folder and in Alembic. USD and glTF state their unit; leave the
            unit out for them.
        up: direction in the coordinates of these files that points up, and becomes y. USD and glTF state it.
        frames_per_second: frames of a folder or of a glTF animation for each second; USD and Alembic state the times
            of their samples.

    Raises:
        ParameterError: the unit is unknown or is given for a file that states it, the direction is zero or not finite,
            or the number of frames is not positive.
        FileError: a file is missing, cannot be read or is malformed, has no animation, no mesh or several, a frame is
            missing, or its faces differ from those of the first one; the message names the frame.
        MeshError: the polygons do not form an oriented manifold surface.
    """
    check_path(path)
    check_positive("frames per second", frames_per_second)
    if is_folder(path):
        return _of_folder(Path(path), unit, up, frames_per_second)
    suffix, scale = Path(path).suffix.lower(), centimetres(unit)
    if suffix == ALEMBIC:
        faces, times, positions = read_moving_alembic(path)
        return moving_mesh_of_samples(path, faces, times, scale * positions @ upright_turn(up).T)
    if suffix not in (*USD, *GLTF):
        known = " ".join((*USD, *GLTF, ALEMBIC))
        expected = f"expected a folder with a mesh for each frame, or a file {known}"
        raise FileError(f"{fspath(path)}: is no mesh that moves; {expected}")
    check_unit_left_out(path, scale)
    if suffix in USD:
        return moving_mesh_of_samples(path, *read_usd_mesh(path))
    faces, times, positions = read_moving_glb(path, frames_per_second)
    return moving_mesh_of_samples(path, faces, times, centimetres("m") * positions)


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
        moving = MovingMesh.of_frames(frames, np.arange(len(frames)) / frames_per_second)
    except ParameterError as error:
        raise FileError(f"{folder}: {error}") from error
    return moving_mesh_of_samples(folder, moving.mesh.polygons, moving.motion.times, moving.motion.vertices)


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


def moving_mesh_of_samples(
    path: FilePath, faces: list[list[int]], times: FloatArray, positions: FloatArray
) -> MovingMesh:
    """Return a mesh that moves, with vertices that lie together in all frames joined.

    Args:
        path: the file, for messages.
        faces: the vertices of each face.
        times: times of the samples [s], shape (K,).
        positions: positions of the vertices [cm], shape (K, V, 3).

    Raises:
        FileError: the times do not increase.
        MeshError: the polygons do not form an oriented manifold surface.
    """
    given = positions, faces
    is_complete = all(0 <= vertex < positions.shape[1] for face in faces for vertex in face)
    joined = weld_frames(*given) if is_complete else given  # The check of the mesh names the vertex that is missing.
    try:
        if joined[0].shape != positions.shape:
            try:
                return _moving(times, *joined)
            except MeshError as error:
                logger.warning("%s: its vertices at equal places stay apart, because joined: %s", path, error)
        return _moving(times, *given)
    except MeshError as error:
        raise MeshError(f"{fspath(path)}: {error}") from error
    except ParameterError as error:
        raise FileError(f"{fspath(path)}: {error}") from error


def _moving(times: FloatArray, positions: FloatArray, faces: list[list[int]]) -> MovingMesh:
    return MovingMesh(Mesh.from_polygons(positions[0], faces), VertexMotion(times, positions))
