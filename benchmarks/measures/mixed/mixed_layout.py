# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Time to lay yarns out on the panels of a cloth, and to make their curves.

Each row is one layout with about the wanted number of nodes, on a square, and on the shirt and the dress of the
examples. The time of the layout includes the triangles of the nodes, whose time is also given alone.
"""

from __future__ import annotations

import math
import platform
import resource
import time

import numpy as np

from benchmarks.table import Rows
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.panel_file import read_panels
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.cloth.seams import cloth_from_panels
from stitchmesh.mixed.layout.crossing_yarns import CrossingYarns
from stitchmesh.mixed.layout.curves import yarn_curves
from stitchmesh.mixed.layout.embedding import embed_points
from stitchmesh.mixed.layout.knit import lay_knit
from stitchmesh.mixed.layout.weave import lay_weave

PLAIN = np.array([[1, 0], [0, 1]])
NODES_OF_A_LOOP = 4


def cloths() -> dict[str, Cloth]:
    """The cloths of the rows."""
    square = Panel(name="square", outline=[[0, 0], [100, 0], [100, 100], [0, 100]])
    examples = {name: read_panels(f"examples/mixed/panels/{name}.toml").cloth() for name in ("shirt", "dress")}
    return {"square": cloth_from_panels([square], [], edge_length=2.5), **examples}


def laid(cloth: Cloth, kind: str, nodes: int) -> CrossingYarns:
    """A layout with about as many nodes as wanted."""
    area = float(cloth.rest_area.sum())
    if kind == "weave":
        density = math.sqrt(nodes / area)
        return lay_weave(cloth, PLAIN, ends=density, picks=density)
    course = math.sqrt(area * NODES_OF_A_LOOP / nodes / 1.3)
    return lay_knit(cloth, [[1]], wale_spacing=1.3 * course, course_spacing=course)


def mixed_layout() -> Rows:
    """Yield the table."""
    yield f"{platform.processor() or platform.machine()}, one thread; seconds of the processor"
    yield "cloth", "triangles", "yarns", "nodes", "layout [s]", "triangles of nodes alone [s]", "curves [s]"
    for name, cloth in cloths().items():
        for kind in ("weave", "knit"):
            start = time.process_time()
            yarns = laid(cloth, kind, nodes=1_000_000)
            middle = time.process_time()
            embed_points(cloth, yarns.panel, yarns.position)
            found = time.process_time()
            yarn_curves(cloth, yarns, radius=0.01)
            end = time.process_time()
            seconds = (f"{spent:.2f}" for spent in (middle - start, found - middle, end - found))
            yield name, f"{len(cloth.triangles):,}", kind, f"{yarns.node_count:,}", *seconds
    yield f"largest memory: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.1f} GB"
