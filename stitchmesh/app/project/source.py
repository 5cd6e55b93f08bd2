# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The file from which a project starts: its imported bytes, and their content."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from stitchmesh.errors import FileError, MeshError, ParameterError
from stitchmesh.io.any_file import holds_mesh, read_any
from stitchmesh.io.atomic import temporary_file
from stitchmesh.io.garments import GarmentMesh, read_garment
from stitchmesh.io.mesh_reading import MeshReading
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.labeling import PartialLabeling, read_labeling, start_labeling
from stitchmesh.labeling.faults import triangles_message
from stitchmesh.labeling.labeling_file import holds_labeling
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.repair import RepairAction, Repaired, repair_mesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarn import YarnSet


@dataclass(frozen=True, eq=False)
class Source:
    """The imported file of a project, kept without a change."""

    name: str
    """Name of the file, without folders."""
    content: bytes
    """The bytes of the file."""
    reading: MeshReading = field(default_factory=MeshReading)
    """How a mesh in the file is read."""


def source_of(name: str, content: bytes, unit: str = DEFAULT_UNIT) -> Source:
    """Return an imported file; its name may include folders, also in the form of Windows."""
    return Source(Path(name.replace("\\", "/")).name, content, MeshReading(unit=unit))


@dataclass(frozen=True, eq=False)
class Start:
    """The start of a project: a labeling, possibly without any row yet, or stitches."""

    labeling: PartialLabeling | None
    """The labeling; None if the file holds stitches."""
    fabric: StitchMesh | None
    """The stitches; None if the file holds a mesh that is not divided."""
    garment: GarmentMesh | None = None
    """The mesh as it was read, with the facts about its file; None for labels and stitches."""
    surface: Mesh | None = None
    """The repaired mesh for the search for rows; None if the file holds stitches."""
    repairs: tuple[RepairAction, ...] = ()
    """The changes that the repair has made to the mesh."""

    @property
    def mesh(self) -> Mesh | None:
        """The polygon mesh; None if the file holds stitches."""
        return None if self.labeling is None else self.labeling.mesh


NO_START = Start(None, None)
"""The start of an empty project."""


def read_source(source: Source) -> Start:
    """Read an imported file: a polygon mesh, a labeled or partly labeled mesh, or stitches.

    A polygon mesh is repaired for the search for rows, as ``stitchmesh knit --auto`` does. If the quads of the file
    form a surface, they are labeled unchanged.

    Raises:
        StitchMeshError: the file cannot be read, or it holds yarns.
    """
    with temporary_file(source.name, source.content) as path:
        return _start(path, source)


def _start(path: Path, source: Source) -> Start:
    if holds_labeling(path):
        return _start_of_mesh(read_labeling(path))
    if holds_mesh(path):
        return _start_of_garment(path, source.reading)
    found = read_any(path, unit=source.reading.unit)
    if not isinstance(found, StitchMesh):
        kind = "yarns" if isinstance(found, YarnSet) else "faces that are no stitches"
        expected = "expected a mesh or stitches; look at yarns on the page View"
        raise ParameterError(f"{source.name}: holds {kind}; {expected}")
    return _start_of_stitches(found, source.name)


def _start_of_garment(path: Path, reading: MeshReading) -> Start:
    try:
        garment = read_garment(path, reading, repaired=False)
    except (FileError, MeshError):  # The polygons form no surface, or the file cannot be read at all.
        garment = read_garment(path, reading, repaired=True)
        start = _start_of_repaired(Repaired(garment.mesh, garment.repairs or ()))
    else:
        mesh = garment.mesh
        start = _start_of_repaired(_repaired(mesh)) if triangles_message(mesh) else _start_of_mesh(start_labeling(mesh))
    return replace(start, garment=garment)


def _start_of_repaired(repaired: Repaired) -> Start:
    return Start(start_labeling(repaired.mesh), None, surface=repaired.mesh, repairs=repaired.actions)


def _start_of_mesh(labeling: PartialLabeling) -> Start:
    repaired = _repaired(labeling.mesh)
    surface = repaired.mesh if repaired.actions else labeling.mesh
    return Start(labeling, None, surface=surface, repairs=repaired.actions)


def _repaired(mesh: Mesh) -> Repaired:
    return repair_mesh(mesh.vertices, mesh.polygons)


def _start_of_stitches(fabric: StitchMesh, name: str) -> Start:
    panels = fabric.stitch == Stitch.PANEL
    if panels.all():
        return _start_of_mesh(PartialLabeling.of_rows(fabric))
    if panels.any():
        face = np.flatnonzero(panels)[0]
        raise ParameterError(f"{name}: face {face} is a panel among stitches; divide the labeled mesh anew")
    return Start(None, fabric)
