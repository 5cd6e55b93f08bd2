# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Binary glTF (``.glb``): yarns as tubes of triangles, in metres and y up as the format prescribes.

The yarns of one colour are one mesh with one rough material of this colour. Tubes have the apparent radius of the
yarns. Sets with more segments get tubes with fewer sides and sections, so that viewers can load the file.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from os import fspath

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath
from stitchmesh.io.float32 import to_float32
from stitchmesh.mesh.palette import colours_of, linear_colour
from stitchmesh.mesh.tube_mesh import TubeMesh, tubes_around
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.polyline import polylines_of_segments

DETAIL = ((20_000, 12, 4), (60_000, 8, 2), (160_000, 6, 1), (math.inf, 4, 1))
"""Largest number of segments, sides of a tube, sections of a segment; a file has at most about a million vertices,
unless it has very many segments."""
ROUGHNESS = 0.9
"""Roughness of wool in glTF and USD, from 0 (mirror) to 1 (matt)."""
TUBES = "yarns"
"""First word of the names of meshes of tubes; ``read_mesh`` recognises a file of yarns by this word."""


def write_glb(path: FilePath, yarns: YarnSet) -> None:
    """Write yarns as tubes with the apparent radius of the yarns.

    Args:
        path: a ``.glb`` file.
        yarns: a set without a lattice.

    Raises:
        FileError: a coordinate is too large for float32, or the file cannot be written.
    """
    import trimesh
    from trimesh.exchange.gltf import export_glb
    from trimesh.visual.material import PBRMaterial

    scene = trimesh.Scene()
    for number, tubes in tubes_of_colours(yarns):
        colour = linear_colour(colours_of([number], yarns.palette)[0] / 255)
        material = PBRMaterial(
            name=f"wool {number}", baseColorFactor=[*colour, 1.0], metallicFactor=0.0, roughnessFactor=ROUGHNESS
        )
        mesh = trimesh.Trimesh(
            vertices=to_float32(path, "the coordinates", 0.01 * tubes.vertices),  # Metres in a centimetre.
            faces=tubes.triangles,
            vertex_normals=tubes.normals,
            visual=trimesh.visual.TextureVisuals(material=material),
            process=False,
        )
        name = f"{TUBES} {number}"
        scene.add_geometry(mesh, node_name=name, geom_name=name)
    write_bytes(path, export_glb(scene, include_normals=True))


def tubes_of_colours(yarns: YarnSet) -> Iterator[tuple[int, TubeMesh]]:
    """Yield each colour number with tubes of the apparent radius around its yarns [cm].

    Args:
        yarns: a set without a lattice.
    """
    count = len(yarns.segment_points)
    sides, samples = next((sides, samples) for most, sides, samples in DETAIL if count <= most)
    for number in np.unique(yarns.colour).tolist():
        curves = polylines_of_segments(yarns, np.flatnonzero((yarns.colour == number)[yarns.segment_yarn]), samples)
        yield number, tubes_around(curves.points, curves.closed, yarns.drawn_radius[curves.yarn], sides=sides)


def holds_tubes(names: Iterable[str]) -> bool:
    """Return whether meshes with these names are the tubes of yarns."""
    return any(name.split(" ")[0] == TUBES for name in names)


def tubes_error(path: FilePath) -> FileError:
    """Return the error of an attempt to read yarns, or a polygon mesh, from a file of tubes."""
    found = "a glTF file of yarns holds tubes and not the curves of the yarns"
    return FileError(f"{fspath(path)}: {found}; read the .h5 file of the yarns")
