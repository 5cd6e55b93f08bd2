# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mesh of a garment from a file that may say little about it.

Its unit and its direction upwards may be other ones than those of the program. glTF fixes both; of other files the
shape of the mesh tells which direction is up, or the caller says it.
"""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.io.contents import FilePath
from stitchmesh.io.meshes import read_mesh, read_repaired_mesh, stated_unit
from stitchmesh.io.units import DEFAULT_UNIT, size_doubt
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.repair import RepairAction
from stitchmesh.mesh.upright import Direction, Y, Z, turned_upright, up_of_openings

LYING = "z was taken as up, because the openings of the mesh face along it; --up y leaves it as it lies in the file"
"""What is said of a mesh that was found to lie in its file."""
UNSURE = "y was taken as up, but the openings of the mesh face along z; if it lies in its file, --up z turns it"
"""What is said of a mesh whose openings do not tell."""


@dataclass(frozen=True, kw_only=True)
class MeshReading:
    """How the mesh of a garment is read from a file."""

    unit: str = DEFAULT_UNIT
    """Unit of a mesh file that states no unit."""
    up: Direction | None = None
    """Direction in the coordinates of the file that points up; if it is None, glTF states y, and the shape of another
    mesh tells whether it is y or z (``up_of_openings``)."""


@dataclass(frozen=True, eq=False)
class GarmentMesh:
    """The mesh of a garment, and what was found out about its file."""

    mesh: Mesh
    """The mesh in centimetres, with y up."""
    up: Direction
    """Direction in the coordinates of the file that points up."""
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
    up, said = (reading.up, "") if reading.up is not None else found_up(path, mesh)
    notes = filter(None, [doubt_of_unit(path, mesh, reading.unit), said])
    return GarmentMesh(turned_upright(mesh, up), up, repairs, tuple(notes))


def found_up(path: FilePath, mesh: Mesh) -> tuple[Direction, str]:
    """Return the direction that points up in a file, and a sentence about it unless it is clearly the usual one.

    Args:
        path: the file.
        mesh: its mesh, in the coordinates of the file.
    """
    if stated_unit(path):
        return Y, ""
    up = up_of_openings(mesh)
    return (Y, UNSURE) if up is None else (up, LYING if up == Z else "")


def read_body(path: FilePath, *, unit: str, up: Direction) -> Mesh:
    """Read the mesh of a body, which stands as its garment does in its file, unless its own format fixes what is up.

    Args:
        path: a file, as for ``read_mesh``.
        unit: unit of a file that states no unit.
        up: direction in the coordinates of the garment's file that points up.

    Raises:
        ParameterError, FileError, MeshError: as for ``read_mesh``.
    """
    return turned_upright(read_mesh(path, unit=unit), Y if stated_unit(path) else up)


def doubt_of_unit(path: FilePath, mesh: Mesh, unit: str) -> str:
    """Return a sentence about a mesh whose size cannot be that of a garment (``size_doubt``); no text if it can.

    Args:
        path: its file.
        mesh: the mesh [cm].
        unit: the unit in which the file was read if its format fixes none.
    """
    stated = stated_unit(path)
    return size_doubt(mesh.vertices, stated or unit, stated=stated is not None)
