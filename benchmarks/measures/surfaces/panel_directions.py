# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sewing patterns in many directions of knitting: how their seams are made, and whether the loops hold.

Run: python benchmarks/run.py panel-directions [ANGLE ...]
"""

from __future__ import annotations

import logging
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.table import Rows
from stitchmesh.errors import StitchMeshError
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.run import QUIET
from stitchmesh.shaping.panels.panel_mesh import PanelMesh
from stitchmesh.shaping.panels.shape_panels import ShapedPanels, knit_panels
from stitchmesh.yarngen import generate_yarns, make_room
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from tests.shaping.panels.sewing_patterns import bag, skirt, t_shirt

PATTERNS = {bag: 1.0, skirt: 2.0, t_shirt: 1.5}
"""Patterns with the width of their stitches [cm]."""
ANGLES = (0, 30, 45, 90, 135, 180, 270)
"""Directions of all panels in the texture [degrees]; 90 is upwards."""


def knitted(panels: PanelMesh, angle: float, width: float) -> ShapedPanels:
    """Knit all panels in one direction."""
    direction = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    directions = dict.fromkeys(range(panels.panel_count), direction)
    return knit_panels(panels, stitch_width=width, directions=directions, progress=False)


def state(shaped: ShapedPanels) -> str:
    """Return whether the loops hold each other, or what refuses them."""
    try:
        fabric = make_room(relax_mesh(shaped.fabric, surface=shaped.surface, run=QUIET).fabric)
        check_loops(fabric, generate_yarns(fabric))
    except StitchMeshError as error:
        return str(error)
    return "held"


def panel_directions(angles: tuple[float, ...] = ANGLES, /) -> Rows:
    """Yield a row for each pattern and direction, and the number of those that hold."""
    logging.disable(logging.WARNING)
    states = []
    yield "pattern", "degrees", "seams", "state"
    for pattern, width in PATTERNS.items():
        with tempfile.TemporaryDirectory() as folder:
            panels = pattern().read(Path(folder))
        for angle in angles:
            shaped = knitted(panels, angle, width)
            kinds = [seam.kind for seam in shaped.seams]
            counts = ", ".join(f"{kinds.count(kind)} {kind}" for kind in ("grafted", "joined", "sewn"))
            states.append(state(shaped))
            yield pattern.__name__, f"{angle:g}", counts, states[-1]
    yield f"{states.count('held')} of {len(states)} held"
