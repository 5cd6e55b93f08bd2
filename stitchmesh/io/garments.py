# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The mesh of a garment from a file that may say little about it.

The file may hold other objects too, such as a body. A garment with a thickness has two layers, and one of them is
knitted. Its unit and its direction upwards may differ from those of the program. glTF fixes both. For other files the
shape of the mesh shows which direction is up, or the caller says it.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import fspath
from typing import get_args

from stitchmesh.errors import MeshError
from stitchmesh.io.contents import FilePath
from stitchmesh.io.examples import mesh_file
from stitchmesh.io.mesh_objects import about_objects, faces_alone, scene_objects
from stitchmesh.io.mesh_reading import MeshReading
from stitchmesh.io.meshes import read_mesh, read_polygons, read_strict_polygons, stated_unit
from stitchmesh.io.units import size_doubt
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.layers import Layer, ParallelLayers, layer_of, parallel_layers
from stitchmesh.mesh.repair import RepairAction, repair_mesh
from stitchmesh.mesh.upright import Direction, Y, Z, turned_upright, up_of_openings

LYING = "z was taken as up, because the openings of the mesh face along it; --up y leaves it as it lies in the file"
"""Note on a mesh that lies in its file."""
UNSURE = "y was taken as up, but the openings of the mesh face along z; if it lies in its file, --up z turns it"
"""Note on a mesh whose openings do not show which direction is up."""


@dataclass(frozen=True, eq=False)
class GarmentMesh:
    """The mesh of a garment, and facts about its file."""

    mesh: Mesh
    """The mesh in centimetres, with y up."""
    up: Direction
    """Direction in the coordinates of the file that points up."""
    repairs: tuple[RepairAction, ...] | None
    """What a repair has changed; None if the mesh was not repaired."""
    notes: tuple[str, ...]
    """Sentences about each choice that the file leaves open, and about how to choose otherwise."""
    objects: tuple[str, ...]
    """Names of all objects of the file (``SceneObjects``)."""
    has_layers: bool
    """Whether the mesh is one layer of a garment with a thickness."""


def read_garment(path: FilePath, reading: MeshReading, *, repaired: bool) -> GarmentMesh:
    """Read the mesh of a garment.

    Args:
        path: a file, as for ``read_mesh``.
        reading: how it is read.
        repaired: whether a valid mesh is made of polygons that need not form a surface.

    Raises:
        ParameterError: as for ``read_mesh``, or nothing in the file has the name of a chosen object.
        FileError, MeshError: as for ``read_mesh`` or ``read_repaired_mesh``.
    """
    path = mesh_file(path)
    polygons = read_polygons(path, unit=reading.unit) if repaired else read_strict_polygons(path, unit=reading.unit)
    scene = scene_objects(path, *polygons)
    kept = scene.chosen(reading.objects) if reading.objects else scene.garments()
    chosen = polygons if kept.all() else faces_alone(*polygons, kept)
    try:
        found = repair_mesh(*chosen) if repaired else None
        mesh = Mesh.from_polygons(*chosen) if found is None else found.mesh
    except MeshError as error:
        raise MeshError(f"{fspath(path)}: {error}") from error
    layers = parallel_layers(mesh)
    if layers is not None:
        mesh = layer_of(mesh, layers, reading.layer)
    up, about_up = (reading.up, "") if reading.up is not None else found_up(path, mesh)
    mesh = turned_upright(mesh, up)
    notes = [
        "" if reading.objects else about_objects(scene, kept),
        "" if layers is None else _about_layers(layers, reading.layer),
        about_up, doubt_of_unit(path, mesh, reading.unit),
    ]  # fmt: skip
    return GarmentMesh(
        mesh, up, None if found is None else found.actions, tuple(filter(None, notes)),
        scene.objects, layers is not None,
    )  # fmt: skip


def _about_layers(layers: ParallelLayers, layer: Layer) -> str:
    """Return a sentence about the two layers of a garment, and about the layer that is taken."""
    others = " or ".join(other for other in get_args(Layer) if other != layer)
    return (
        f"the mesh has two layers {layers.thickness:.2g} cm apart, of which the {layer} one is knitted; "
        f"--layer {others} takes another one"
    )


def found_up(path: FilePath, mesh: Mesh) -> tuple[Direction, str]:
    """Return the direction that points up in a file, and a sentence about it unless it is clearly y.

    Args:
        path: the file.
        mesh: its mesh, in the coordinates of the file.
    """
    if stated_unit(path):
        return Y, ""
    up = up_of_openings(mesh)
    return (Y, UNSURE) if up is None else (up, LYING if up == Z else "")


def read_body(path: FilePath, *, unit: str, up: Direction) -> Mesh:
    """Read the mesh of a body. Its upward direction is that of the garment's file, unless its own format fixes it.

    Args:
        path: a file, as for ``read_mesh``.
        unit: unit of a file that states no unit.
        up: direction in the coordinates of the garment's file that points up.

    Raises:
        ParameterError, FileError, MeshError: as for ``read_mesh``.
    """
    return turned_upright(read_mesh(path, unit=unit), Y if stated_unit(path) else up)


def doubt_of_unit(path: FilePath, mesh: Mesh, unit: str) -> str:
    """Return a sentence about a mesh that cannot have the size of a garment (``size_doubt``); no text if it can.

    Args:
        path: its file.
        mesh: the mesh [cm].
        unit: the unit in which the file was read if its format fixes none.
    """
    stated = stated_unit(path)
    return size_doubt(mesh.vertices, stated or unit, stated=stated is not None)
