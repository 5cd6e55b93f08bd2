# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Find rows of panels on the surfaces of ``any_surface.py``, and divide them into stitches.

Each line is one surface: panels, rows of panels, stitches, stitches of ``auto_stitches``, whether both have the same
borders and handles, and with ``--loops`` whether loops hold after mesh relaxation on the surface.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tyro.conf import Positional

import stitchmesh as sm
from benchmarks.measures.surfaces.any_surface import MOST_CHECKED, Scene, loops_of, scenes
from benchmarks.table import Rows
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.run import QUIET
from stitchmesh.shaping.options import PANEL_SIZE
from stitchmesh.shaping.report import topology


def loops_on(fabric: StitchMesh, surface: Mesh) -> str:
    """Return ``held`` if each loop holds after mesh relaxation on a surface, or what is wrong."""
    even = sm.relax_mesh(fabric, surface=surface, run=QUIET)
    try:
        yarns = sm.generate_yarns(even)
    except StitchMeshError as error:
        return str(error)[:80]
    return loops_of(even, yarns)


def measure(scene: Scene, options: Options) -> tuple[object, ...]:
    """Label and divide one surface, and return its row of the table."""
    name, width, make = scene
    mesh = make()
    panels = sm.auto_labels(mesh, stitch_width=width, panel_size=options.panel_size, progress=False)
    # Turns of short rows would be borders that panels do not have.
    direct = sm.auto_stitches(mesh, stitch_width=width, short_rows=False)
    fabric = sm.tessellate(panels, stitch_width=width)
    same = topology(panels) == topology(fabric) == topology(direct)
    checked = options.loops and fabric.face_count < MOST_CHECKED
    counts = panels.face_count, panels.row.max() + 1, fabric.face_count, direct.face_count
    return name, *counts, "yes" if same else "no", loops_on(fabric, mesh) if checked else ""


@dataclass(frozen=True)
class Options:
    """What is measured."""

    files: Positional[tuple[Path, ...]] = ()
    unit: str = "cm"
    width: float = 0.8
    panel_size: int = PANEL_SIZE
    loops: bool = False
    """check the loops of the generated yarns"""


def found_panels(options: Options) -> Rows:
    """Yield the table."""
    logging.disable(logging.WARNING)
    np.seterr(all="ignore")
    yield "surface", "panels", "rows", "stitches", "direct", "same", "loops"
    for scene in scenes(options):
        try:
            yield measure(scene, options)
        except StitchMeshError as error:
            yield scene[0], f"{type(error).__name__}: {error}"
