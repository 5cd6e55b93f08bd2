# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Binary glTF: yarns as one mesh of triangle tubes, in metres and y up as the format demands, in colour.

That is the colour of the yarn where there are several, else of the row. Colours stand at the vertices, as light and not
as sRGB, over a rough white material. Tubes have fewer sides and sections the more segments there are, so that a file
stays within what a viewer loads.
"""

from __future__ import annotations

from os import fspath

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath
from stitchmesh.io.float32 import rounded
from stitchmesh.mesh.tube_mesh import tubes_around
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.colours import yarn_colours
from stitchmesh.yarn.polyline import polylines_of_segments

METRES = 0.01
"""In a centimetre."""
DETAIL = ((20_000, 12, 4), (60_000, 8, 2), (160_000, 6, 1))
"""Sides of a tube and sections of a segment for sets of up to so many segments: about a million vertices at most."""
COARSEST = (4, 1)
ROUGHNESS = 0.9
TUBES = "yarns"
"""Name of the mesh of tubes, by which a file of yarns is known."""


def write_glb(path: FilePath, yarns: YarnSet) -> None:
    """Write yarns as tubes of their radius.

    Args:
        path: a ``.glb`` file.
        yarns: a set without a lattice.

    Raises:
        FileError: a coordinate is too large for float32, or the file cannot be written.
    """
    import trimesh
    from trimesh.exchange.gltf import export_glb
    from trimesh.visual.material import PBRMaterial

    count = len(yarns.segment_points)
    sides, samples = next(((sides, samples) for most, sides, samples in DETAIL if count <= most), COARSEST)
    curves = polylines_of_segments(yarns, np.arange(count), samples)
    tubes = tubes_around(curves.points, curves.closed, yarns.radius[curves.yarn], sides=sides)
    visual = trimesh.visual.TextureVisuals(
        material=PBRMaterial(name="wool", metallicFactor=0.0, roughnessFactor=ROUGHNESS)
    )
    colours = yarn_colours(yarns.row, yarns.colour[yarns.point_yarn])
    visual.vertex_attributes["color"] = _light(colours[curves.control_point])[tubes.ring]
    mesh = trimesh.Trimesh(
        vertices=rounded(path, "the coordinates", METRES * tubes.vertices),
        faces=tubes.triangles,
        vertex_normals=tubes.normals,
        visual=visual,
        process=False,
    )
    scene = trimesh.Scene()
    scene.add_geometry(mesh, node_name=TUBES, geom_name=TUBES)
    write_bytes(path, export_glb(scene, include_normals=True))


def holds_tubes(path: FilePath) -> FileError:
    """The error of a file that is read for curves."""
    return FileError(f"{fspath(path)}: a glTF file holds tubes, not the curves of yarns; read the .h5 they came from")


def _light(colours: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Opaque linear colour of sRGB colours, shape (n, 3) to (n, 4)."""
    value = colours / 255
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)  # IEC 61966-2-1
    opaque = np.concatenate([linear, np.ones((len(colours), 1))], axis=1)
    return np.round(255 * opaque).astype(np.uint8)
