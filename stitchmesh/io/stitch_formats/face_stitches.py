# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stitch mesh of a face mesh: its stitches, without faces that only end loops or lead yarn from row to row.

A stitch mesh needs neither: loops on an upper border are live, and rows are joined at their ends when yarns are made.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Iterable

import numpy as np

from stitchmesh.errors import FileError, StitchMeshError
from stitchmesh.faces.face_mesh import FaceMesh
from stitchmesh.faces.face_type import LEAVING, LOOP, NOTHING, YARN, FaceType, stitch_of
from stitchmesh.io.stitch_formats.smobj import stitch_mesh_of
from stitchmesh.io.stitch_formats.smobj_lines import FaceKind, SmobjContents
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import Stitch

logger = logging.getLogger(__name__)


def stitches_of_faces(mesh: FaceMesh, name: str) -> StitchMesh:
    """Return the stitches of a face mesh, and log which faces are left out.

    Args:
        mesh: the faces.
        name: name of the file, for messages.

    Raises:
        FileError: a face is no stitch and cannot be left out, no face is a stitch, or the stitches form no stitch mesh.
    """
    kinds = [stitch_of(kind) for kind in mesh.types]
    foreign = {k for k, stitch in enumerate(kinds) if stitch is None} & set(mesh.face_type.tolist())
    needed = [mesh.types[k] for k in mesh.face_type.tolist() if k in foreign and not _may_be_left_out(mesh.types[k])]
    if needed or len(foreign) == len(set(mesh.face_type.tolist())):
        found = _counted(needed or [mesh.types[k] for k in mesh.face_type.tolist()])
        raise FileError(f"{name}: {found} are no stitches; `stitchmesh yarns` draws the faces as they are")
    left_out = [mesh.types[k] for k in mesh.face_type.tolist() if k in foreign]
    if left_out:
        logger.info("%s: without %s, which only end loops or lead the yarn on", name, _counted(left_out))
    try:
        return stitch_mesh_of(_contents(mesh, kinds, name))
    except (StitchMeshError, ValueError, IndexError) as error:
        raise FileError(f"{name}: {error}") from error


def _may_be_left_out(kind: FaceType) -> bool:
    """Return whether no loop leaves a face, and either loops or yarn enter it."""
    words = {side.kind for side in kind.sides if side.strands}
    makes = any(side.kind == LOOP and side.direction == LEAVING and side.strands for side in kind.sides)
    return not makes and words <= {LOOP, YARN, NOTHING} and len(words) == 1


def _counted(kinds: Iterable[FaceType]) -> str:
    return ", ".join(f"{count} {name}" for name, count in Counter(kind.name for kind in kinds).most_common(8))


def _contents(mesh: FaceMesh, kinds: list[Stitch | None], name: str) -> SmobjContents:
    """Return the stitches and their joins as the lines of a file."""
    kept = [face for face in range(mesh.face_count) if kinds[mesh.face_type[face]] is not None]
    number = {face: k for k, face in enumerate(kept)}
    contents = SmobjContents(name, vertices=[(x, y, z) for x, y, z in mesh.vertices.tolist()])
    for face in kept:
        kind = mesh.types[mesh.face_type[face]]
        n_bottom = next(k for k, side in enumerate(kind.sides) if side.kind == YARN)
        stitch = kinds[mesh.face_type[face]] or Stitch.PANEL
        contents.kinds.append(FaceKind(stitch, n_bottom, len(kind.sides) - n_bottom - 2))
        contents.face_kind.append(len(contents.face_kind))
        contents.faces.append(np.asarray(mesh.face_vertex[mesh.face_start[face] : mesh.face_start[face + 1]]).tolist())
    for (first, second), reverses in zip(mesh.joins.tolist(), mesh.reverses.tolist(), strict=True):
        (face, side), (other, across) = mesh.side_at(first), mesh.side_at(second)
        if face in number and other in number:
            if not reverses:
                found = f"faces {face + 1} and {other + 1} are joined without reversal"
                raise ValueError(f"{found}; the stitches of a stitch mesh face the same way")
            contents.connections[number[face], side] = number[other], across
            contents.connections[number[other], across] = number[face], side
    return contents
