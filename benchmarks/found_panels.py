# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Find rows of panels on the surfaces of ``any_surface.py``, and divide them into stitches.

    python benchmarks/found_panels.py --loops
    python benchmarks/found_panels.py tights.obj skirt.obj --unit dm --width 1.6 --loops

Each line is one surface: panels, rows of panels, stitches, stitches of ``auto_stitches``, whether both have the same
borders and handles, and with ``--loops`` whether loops hold after mesh relaxation on the surface.
"""

from __future__ import annotations

import argparse
import logging
from pathlib import Path

import numpy as np
from any_surface import MOST_CHECKED, Scene, loops_of, scenes

import stitchmesh as sm
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.shaping.options import PANEL_SIZE
from stitchmesh.shaping.topology import topology


def loops_on(fabric: StitchMesh, surface: Mesh) -> str:
    """Return ``held`` if each loop holds after mesh relaxation on a surface, or what is wrong."""
    even = sm.relax_mesh(fabric, surface=surface, progress=False)
    try:
        yarns = sm.generate_yarns(even)
    except StitchMeshError as error:
        return str(error)[:80]
    return loops_of(even, yarns)


def measure(scene: Scene, options: argparse.Namespace) -> str:
    """Label and divide one surface, and return its line of the table."""
    name, width, make = scene
    mesh = make()
    panels = sm.auto_labels(mesh, stitch_width=width, panel_size=options.panel_size, progress=False)
    # Turns of short rows would be borders that panels do not have.
    direct = sm.auto_stitches(mesh, stitch_width=width, short_rows=False)
    fabric = sm.tessellate(panels, stitch_width=width)
    same = topology(panels) == topology(fabric) == topology(direct)
    checked = options.loops and fabric.face_count < MOST_CHECKED
    return (
        f"{name:24s} {panels.face_count:6d} {panels.row.max() + 1:5d} {fabric.face_count:7d} {direct.face_count:7d} "
        f"{'yes' if same else 'no ':3s} {loops_on(fabric, mesh) if checked else ''}"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--unit", default="cm")
    parser.add_argument("--width", type=float, default=0.8)
    parser.add_argument("--panel-size", type=int, default=PANEL_SIZE)
    parser.add_argument("--loops", action="store_true", help="check the loops of the generated yarns")
    options = parser.parse_args()
    logging.disable(logging.WARNING)
    np.seterr(all="ignore")
    print(f"{'surface':24s} panels  rows   stitch  direct same loops")
    for scene in scenes(options):
        try:
            print(measure(scene, options), flush=True)
        except StitchMeshError as error:
            print(f"{scene[0]:24s} {type(error).__name__}: {error}", flush=True)


if __name__ == "__main__":
    main()
