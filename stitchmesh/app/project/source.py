# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The file that a project starts from: its bytes as they were imported, and what they hold."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stitchmesh.errors import FileError, MeshError, ParameterError
from stitchmesh.io.any_file import read_any
from stitchmesh.io.garments import found_up
from stitchmesh.io.meshes import FORMATS as MESH_FORMATS
from stitchmesh.io.meshes import read_repaired_mesh
from stitchmesh.io.temporary_file import temporary_file
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.labeling import PartialLabeling, read_labeling, start_labeling
from stitchmesh.labeling.faults import triangles_message
from stitchmesh.labeling.labeling_file import holds_labeling
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.repair import RepairAction, Repaired, repair_mesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.mesh.upright import Direction, Y, turned_upright
from stitchmesh.yarn import YarnSet


@dataclass(frozen=True, eq=False)
class Source:
    """The imported file of a project, which is kept without a change."""

    name: str
    """Name of the file, without folders."""
    content: bytes
    """The bytes of the file."""
    unit: str = DEFAULT_UNIT
    """Unit of the coordinates in the file."""
    up: Direction | None = None
    """Direction in the coordinates of the file that points up; None if it is to be found."""


def source_of(name: str, content: bytes, unit: str = DEFAULT_UNIT, up: Direction | None = None) -> Source:
    """Return an imported file; its name may be given with folders, as on Windows too."""
    return Source(Path(name.replace("\\", "/")).name, content, unit, up)


@dataclass(frozen=True, eq=False)
class Start:
    """What a project starts with: a labeling, on which nothing may be labeled yet, or stitches."""

    labeling: PartialLabeling | None
    """The labeling; None if the file holds stitches."""
    fabric: StitchMesh | None
    """The stitches; None if the file holds a mesh that is not divided."""
    surface: Mesh | None = None
    """The repaired mesh, on which rows are found; None if the file holds stitches."""
    repairs: tuple[RepairAction, ...] = ()
    """What was changed in it."""
    up: Direction = Y
    """Direction in the coordinates of the file that points up."""

    @property
    def mesh(self) -> Mesh | None:
        """The polygon mesh; None if the file holds stitches."""
        return None if self.labeling is None else self.labeling.mesh


def read_source(source: Source) -> Start:
    """Read an imported file: a polygon mesh, a labeled or partly labeled mesh, or stitches.

    A polygon mesh is repaired for the search for rows, as ``stitchmesh knit --auto`` does. Quads that form a surface
    are labeled as they are in the file.

    Raises:
        StitchMeshError: the file cannot be read, or it holds yarns.
    """
    with temporary_file(source.name, source.content) as path:
        return _start(path, source)


def _start(path: Path, source: Source) -> Start:
    if holds_labeling(path):
        return _start_of_mesh(read_labeling(path))
    try:
        found = read_any(path, unit=source.unit)
    except (FileError, MeshError):
        if path.suffix.lower() not in MESH_FORMATS:
            raise
        repaired = read_repaired_mesh(path, unit=source.unit)
        up = _up(path, repaired.mesh, source)
        return replace(_start_of_repaired(replace(repaired, mesh=turned_upright(repaired.mesh, up))), up=up)
    if not isinstance(found, Mesh):
        kind = "yarns" if isinstance(found, YarnSet) else "faces that are no stitches"
        expected = "expected a mesh or stitches; look at yarns on the page View"
        raise ParameterError(f"{source.name}: holds {kind}; {expected}")
    if isinstance(found, StitchMesh):
        return _start_of_stitches(found, source.name)
    up = _up(path, found, source)
    mesh = turned_upright(found, up)
    start = _start_of_repaired(_repaired(mesh)) if triangles_message(mesh) else _start_of_mesh(start_labeling(mesh))
    return replace(start, up=up)


def _up(path: Path, mesh: Mesh, source: Source) -> Direction:
    return found_up(path, mesh)[0] if source.up is None else source.up


def _start_of_repaired(repaired: Repaired) -> Start:
    return Start(start_labeling(repaired.mesh), None, repaired.mesh, repaired.actions)


def _start_of_mesh(labeling: PartialLabeling) -> Start:
    repaired = _repaired(labeling.mesh)
    return Start(labeling, None, repaired.mesh if repaired.actions else labeling.mesh, repaired.actions)


def _repaired(mesh: Mesh) -> Repaired:
    return repair_mesh(mesh.vertices, [face.tolist() for face in np.split(mesh.face_vertex, mesh.face_start[1:-1])])


def _start_of_stitches(fabric: StitchMesh, name: str) -> Start:
    panels = fabric.stitch == Stitch.PANEL
    if panels.all():
        return _start_of_mesh(PartialLabeling.of_rows(fabric))
    if panels.any():
        face = np.flatnonzero(panels)[0]
        raise ParameterError(f"{name}: face {face} is a panel among stitches; divide the labeled mesh anew")
    return Start(None, fabric)
