# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Binary glTF (``.glb``): yarns as one mesh of tubes of triangles, in metres and y up as the format prescribes.

The colours of the vertices are those of the yarns if the yarns have several colours, and otherwise those of the rows;
they are linear, not sRGB, and multiply a rough white material. Sets with more segments get tubes with fewer sides and
sections, so that viewers can load the file.
"""

from __future__ import annotations

from os import fspath

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath
from stitchmesh.io.float32 import to_float32
from stitchmesh.mesh.tube_mesh import tubes_around
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.colours import yarn_colours
from stitchmesh.yarn.polyline import polylines_of_segments

METRES = 0.01
"""Metres in a centimetre."""
DETAIL = ((20_000, 12, 4), (60_000, 8, 2), (160_000, 6, 1))
"""Largest number of segments, sides of a tube, sections of a segment; a file has at most about a million vertices."""
COARSEST = (4, 1)
"""Sides of a tube and sections of a segment for larger sets."""
ROUGHNESS = 0.9
"""Roughness of the material, from 0 (mirror) to 1 (matt)."""
TUBES = "yarns"
"""Name of the mesh of tubes; ``read_mesh`` recognises a file of yarns by this name."""


def write_glb(path: FilePath, yarns: YarnSet) -> None:
    """Write yarns as tubes with the radius of the yarns.

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
    visual.vertex_attributes["color"] = _linear_colours(colours[curves.control_point])[tubes.ring]
    mesh = trimesh.Trimesh(
        vertices=to_float32(path, "the coordinates", METRES * tubes.vertices),
        faces=tubes.triangles,
        vertex_normals=tubes.normals,
        visual=visual,
        process=False,
    )
    scene = trimesh.Scene()
    scene.add_geometry(mesh, node_name=TUBES, geom_name=TUBES)
    write_bytes(path, export_glb(scene, include_normals=True))


def tubes_error(path: FilePath) -> FileError:
    """Return the error of an attempt to read yarns, or a polygon mesh, from a file of tubes."""
    found = "a glTF file of yarns holds tubes and not the curves of the yarns"
    return FileError(f"{fspath(path)}: {found}; read the .h5 file of the yarns")


def _linear_colours(colours: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the linear opaque colours of sRGB colours, both from 0 to 255, shapes (n, 4) and (n, 3)."""
    value = colours / 255
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)  # IEC 61966-2-1
    opaque = np.concatenate([linear, np.ones((len(colours), 1))], axis=1)
    return np.round(255 * opaque).astype(np.uint8)
