# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mesh of a garment from a file that may say little about it: its unit may be another one."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.io.contents import FilePath
from stitchmesh.io.meshes import read_mesh, read_repaired_mesh, stated_unit
from stitchmesh.io.units import DEFAULT_UNIT, size_doubt
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.repair import RepairAction


@dataclass(frozen=True, kw_only=True)
class MeshReading:
    """How the mesh of a garment is read from a file."""

    unit: str = DEFAULT_UNIT
    """Unit of a mesh file that states no unit."""


@dataclass(frozen=True, eq=False)
class GarmentMesh:
    """The mesh of a garment, and what was found out about its file."""

    mesh: Mesh
    """The mesh."""
    repairs: tuple[RepairAction, ...] | None
    """What a repair has changed; None if the mesh was not repaired."""
    notes: tuple[str, ...]
    """Sentences about what was taken where the file does not say it, and how to take something else."""


def read_garment(path: FilePath, reading: MeshReading, *, repaired: bool) -> GarmentMesh:
    """Read the mesh of a garment.

    Args:
        path: a file, as for ``read_mesh``.
        reading: how it is read.
        repaired: whether the polygons need not form a surface, and a valid mesh is made of them.

    Raises:
        ParameterError, FileError, MeshError: as for ``read_mesh`` or ``read_repaired_mesh``.
    """
    if repaired:
        found = read_repaired_mesh(path, unit=reading.unit)
        mesh, repairs = found.mesh, found.actions
    else:
        mesh, repairs = read_mesh(path, unit=reading.unit), None
    doubt = doubt_of_unit(path, mesh, reading.unit)
    return GarmentMesh(mesh, repairs, (doubt,) if doubt else ())


def doubt_of_unit(path: FilePath, mesh: Mesh, unit: str) -> str:
    """Return a sentence about a mesh whose size cannot be that of a garment (``size_doubt``); no text if it can.

    Args:
        path: its file.
        mesh: the mesh [cm].
        unit: the unit in which the file was read if its format fixes none.
    """
    stated = stated_unit(path)
    return size_doubt(mesh.vertices, stated or unit, stated=stated is not None)
