# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Compare rows that are found on triangles with the modelled rows of the same garments.

Each line is one garment of ``assets/meshes``: the width of a stitch, and rows and stitches by ``label`` and
``tessellate`` of the modelled mesh, by ``auto_stitches`` of the same mesh in triangles, and the differences in percent.
"""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np

import stitchmesh as sm
from benchmarks.measures.surfaces.any_surface import width_of
from benchmarks.places import MESHES
from benchmarks.surface_shapes import triangulated  # needs pyvista
from benchmarks.table import Rows
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import StitchMesh


def size(fabric: StitchMesh) -> tuple[int, int]:
    """Return the numbers of rows and of stitches of a fabric."""
    return len(np.unique(fabric.row)), fabric.face_count


def compared(path: Path, width: float) -> tuple[object, ...]:
    """Return the row of the table of one garment."""
    mesh = sm.read_mesh(path)
    rows, stitches = size(sm.tessellate(sm.label(mesh), stitch_width=width))
    found_rows, found_stitches = size(sm.auto_stitches(triangulated(mesh), stitch_width=width))
    more_rows, more_stitches = 100 * (found_rows / rows - 1), 100 * (found_stitches / stitches - 1)
    counts = rows, found_rows, f"{more_rows:+.1f}", stitches, found_stitches, f"{more_stitches:+.1f}"
    return path.name, f"{width:.2f}", *counts


def rows_found_again(names: tuple[str, ...] = (), /) -> Rows:
    """Yield the table.

    Args:
        names: names of garments, such as hat; all of them without any
    """
    logging.disable(logging.WARNING)
    yield "garment", "width", "rows", "found", "%", "stitches", "found", "%"
    for path in sorted(MESHES.glob("*.obj")):
        if names and path.stem not in names:
            continue
        try:
            yield compared(path, width_of(path))
        except StitchMeshError as error:
            yield path.name, f"{type(error).__name__}: {error}"
