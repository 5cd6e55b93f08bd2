# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How far wefts slide down along the warps of an open weave that hangs by its upper border.

A square of 15 x 15 yarns of ``gong-1`` hangs for 0.4 s, or comes to its equilibrium. The figure is the largest change
of a coordinate of the warps, by which a weft has moved along them, in cm.
"""

from __future__ import annotations

import numpy as np

from benchmarks.table import Rows
from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.mixed.layout.crossing_yarns import WARP
from stitchmesh.mixed.scene.motion_section import AttachmentSection
from stitchmesh.mixed.scene.region_section import BoxSection, RegionSection
from stitchmesh.mixed.scene.scene import ClothSection, Scene, SceneSolverSection, YarnsSection
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, prepare
from stitchmesh.mixed.simulation import Simulation, begin_simulation

YARNS = 15
"""Warps, and wefts."""
SECONDS = 0.4


def hanging(density: float, mode: str) -> PreparedScene:
    """Return the square with a number of yarns for each cm; its upper weft is held."""
    side, far = YARNS / density, 2.0 * YARNS
    top = BoxSection(low=(-1.0, side - 0.9 / density, -1.0), high=(far, far, 1.0))
    return prepare(
        Scene(
            mode="dynamic" if mode == "motion" else "static",
            duration=SECONDS,
            disturbance=0.0,
            cloth=ClothSection(rectangle=(side, side), edge_length=side / 5.0),
            yarns=YarnsSection(weave="plain", ends=density, picks=density, material="gong-1"),
            region=RegionSection(yarns="all"),
            attachments=(AttachmentSection(boxes=(top,)),),
            solver=SceneSolverSection(precision="float64", device="cpu", force_tolerance=0.1, most_iterations=2000),
        )
    )


def slid(density: float, mode: str) -> float:
    """Return the largest distance by which a weft moves along a warp [cm]."""
    prepared = hanging(density, mode)
    with alone():
        simulation: Simulation = begin_simulation(prepared, scalar_named("float64"), device_named("cpu"))
        while not simulation.done:
            simulation.step()
    yarns = prepared.fabric.yarns
    along_warp = yarns.yarn_family[yarns.node_yarn] == WARP
    change = np.abs(simulation.positions[2] - prepared.sliding)
    return float(change[along_warp[prepared.region.nodes]].max())


def mixed_sliding() -> Rows:
    """Yield the table."""
    yield "yarns /cm", "after 0.4 s [cm]", "at equilibrium [cm]"
    for density in (2.0, 3.0, 4.0, 5.0):
        yield f"{density:g}", f"{slid(density, 'motion'):.2g}", f"{slid(density, 'equilibrium'):.2g}"
