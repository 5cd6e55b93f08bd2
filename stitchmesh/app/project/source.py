# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The file that a project starts from: its bytes as they were imported, and what they hold."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.any_file import holds_mesh, read_any
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.garments import GarmentMesh, MeshReading, read_garment
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.labeling import PartialLabeling, read_labeling, start_labeling
from stitchmesh.labeling.labeling_file import holds_labeling
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.layers import Layer
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.mesh.upright import Direction
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
    objects: tuple[str, ...] = ()
    """Names of objects of the file that are the garment; none for all that can be garments."""
    layer: Layer = "outer"
    """Layer of a garment with a thickness."""

    @property
    def reading(self) -> MeshReading:
        """How the mesh is read."""
        return MeshReading(unit=self.unit, up=self.up, objects=self.objects, layer=self.layer)


def source_of(name: str, content: bytes, unit: str = DEFAULT_UNIT) -> Source:
    """Return an imported file; its name may be given with folders, as on Windows too."""
    return Source(Path(name.replace("\\", "/")).name, content, unit)


@dataclass(frozen=True, eq=False)
class Start:
    """What a project starts with: a labeling, on which nothing may be labeled yet, or stitches."""

    labeling: PartialLabeling | None
    """The labeling; None if the file holds stitches."""
    fabric: StitchMesh | None
    """The stitches; None if the file holds a mesh that is not divided."""
    garment: GarmentMesh | None = None
    """The mesh as it was read, with what was found out about its file; None for labels and stitches."""

    @property
    def mesh(self) -> Mesh | None:
        """The polygon mesh; None if the file holds stitches."""
        return None if self.labeling is None else self.labeling.mesh


def read_source(source: Source) -> Start:
    """Read an imported file: a polygon mesh, a labeled or partly labeled mesh, or stitches.

    Raises:
        StitchMeshError: the file cannot be read, or it holds yarns.
    """
    with tempfile.TemporaryDirectory(prefix="stitchmesh-") as folder:
        path = Path(folder) / source.name
        write_bytes(path, source.content)
        try:
            return _start(path, source)
        except FileError as error:  # The message names the file of the user and not the temporary folder.
            raise FileError(str(error).replace(f"{folder}/", "")) from error


def _start(path: Path, source: Source) -> Start:
    if holds_labeling(path):
        return Start(read_labeling(path), None)
    if holds_mesh(path):
        garment = read_garment(path, source.reading, repaired=False)
        return Start(start_labeling(garment.mesh), None, garment)
    found = read_any(path, unit=source.unit)
    if not isinstance(found, StitchMesh):
        kind = "yarns" if isinstance(found, YarnSet) else "faces that are no stitches"
        expected = "expected a mesh or stitches; look at yarns on the page View"
        raise ParameterError(f"{source.name}: holds {kind}; {expected}")
    return _start_of_stitches(found, source.name)


def _start_of_stitches(fabric: StitchMesh, name: str) -> Start:
    panels = fabric.stitch == Stitch.PANEL
    if panels.all():
        return Start(PartialLabeling.of_rows(fabric), None)
    if panels.any():
        face = np.flatnonzero(panels)[0]
        raise ParameterError(f"{name}: face {face} is a panel among stitches; divide the labeled mesh anew")
    return Start(None, fabric)
