# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Compare rows that are found on triangles with the modelled rows of the same garments.

    python benchmarks/rows_found_again.py

Each line is one garment of ``assets/meshes``: the width of a stitch, and rows and stitches by ``label`` and
``tessellate`` of the modelled mesh, by ``auto_stitches`` of the same mesh in triangles, and the differences in percent.
"""

from __future__ import annotations

import argparse
import logging
from pathlib import Path

import numpy as np
from any_surface import GARMENTS, width_of
from surface_shapes import triangulated  # needs pyvista

import stitchmesh as sm
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import StitchMesh


def size(fabric: StitchMesh) -> tuple[int, int]:
    """Return the numbers of rows and of stitches of a fabric."""
    return len(np.unique(fabric.row)), fabric.face_count


def compared(path: Path, width: float) -> str:
    """Return the line of the table of one garment."""
    mesh = sm.read_mesh(path)
    rows, stitches = size(sm.tessellate(sm.label(mesh), stitch_width=width))
    found_rows, found_stitches = size(sm.auto_stitches(triangulated(mesh), stitch_width=width))
    more_rows, more_stitches = 100 * (found_rows / rows - 1), 100 * (found_stitches / stitches - 1)
    counts = f"{rows:6d} {found_rows:6d} {more_rows:+6.1f} {stitches:9d} {found_stitches:9d} {more_stitches:+6.1f}"
    return f"{path.name:14s} {width:5.2f} {counts}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="names of garments, such as hat; all of them without any")
    names = parser.parse_args().names
    logging.disable(logging.WARNING)
    print(f"{'garment':14s} width   rows  found      %  stitches     found      %")
    for path in sorted(GARMENTS.glob("*.obj")):
        if names and path.stem not in names:
            continue
        try:
            print(compared(path, width_of(path)), flush=True)
        except StitchMeshError as error:
            print(f"{path.name:14s} {type(error).__name__}: {error}", flush=True)


if __name__ == "__main__":
    main()
