# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A skirt for the body of assets/meshes/bodies, as quads in rows: elliptic rings from the hem to the waist.

Its waist is 1.5 cm too narrow, so that the skirt cuts the body and has to be put round it (docs/how-to/follow.md).
"""

from __future__ import annotations

import numpy as np

import stitchmesh as sm
from benchmarks.options import Output
from benchmarks.table import Rows
from stitchmesh.mesh import Mesh

ROWS, COLUMNS = 12, 20
HEIGHTS = (-38.0, 0.0, 18.0)
"""Heights of hem, hip and waist [cm]."""
HALF_WIDTHS, HALF_DEPTHS = (30.0, 20.0, 14.5), (20.0, 11.5, 9.5)
"""Half of the axes of the ellipses there [cm]."""
MIDDLE = 3.5
"""z of the middle of the ellipses [cm]."""


def skirt() -> Mesh:
    """The skirt."""
    height = np.linspace(HEIGHTS[0], HEIGHTS[-1], ROWS + 1)[:, None]
    angle = np.linspace(0.0, 2.0 * np.pi, COLUMNS, endpoint=False)
    x = np.interp(height, HEIGHTS, HALF_WIDTHS) * np.sin(angle)
    z = np.interp(height, HEIGHTS, HALF_DEPTHS) * np.cos(angle) + MIDDLE
    vertices = np.stack([x, height + 0.0 * angle, z], axis=-1).reshape(-1, 3)
    ring = np.arange(len(vertices)).reshape(ROWS + 1, COLUMNS)
    after = np.roll(ring, -1, axis=1)
    faces = np.stack([ring[:-1], after[:-1], after[1:], ring[1:]], axis=-1).reshape(-1, 4)
    return Mesh.from_polygons(vertices, faces.tolist())


def skirt_around_a_body(*, output: Output) -> Rows:
    """Write the skirt."""
    sm.write_mesh(output, skirt())
    yield f"{output}: {skirt()}"
