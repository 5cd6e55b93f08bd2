# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A small piece of stockinette with yarns at rest, and systems of it, for the tests of B-spline yarns."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.labeling import label
from stitchmesh.mesh import BORDER
from stitchmesh.mixed.assembly import MixedFabric
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.from_stitches import cloth_from_stitches
from stitchmesh.mixed.enrichment.region import Region, region_around
from stitchmesh.mixed.layout.spline_yarns import SplineYarns, lay_splines
from stitchmesh.mixed.splines.spline_pieces import SplineMaterial
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.quality import quality_named
from stitchmesh.tessellate import tessellate
from stitchmesh.yarn.rest_length import RestLengths, apply_rest_lengths
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.constraints.pins import Pins
from tests.gallery import grid
from tests.mixed.cloth_scene import ClothScene, cloth_scene
from tests.mixed.patch import enriched_everywhere

CPU = device_named("cpu")
WIDTH, HEIGHT, RADIUS, LOOP = 0.41, 0.316, 0.05, 1.668
"""A stitch of a free swatch with this yarn [cm]."""
YARN = SplineMaterial.named(radius=RADIUS)
SHEET = ClothMaterial.isotropic("sheet", 1500.0, 0.5, 20.0, YARN.density * LOOP / (WIDTH * HEIGHT))
"""A cloth that weighs what its yarn does."""
TIGHT = replace(
    quality_named("draft"), precision="float64", tolerance=1e-6, largest_change=1e-6,
    contact_samples=YARN.contact_samples,
)  # fmt: skip


@functools.cache
def jersey(columns: int = 6, rows: int = 6) -> tuple[Cloth, SplineYarns, np.ndarray]:
    """A cloth, its yarns at rest with the stitches along the border pinned, and the pinned control points."""
    mesh = label(grid(columns, rows, width=WIDTH, height=HEIGHT))
    fabric = tessellate(mesh, stitch_width=WIDTH, stitch_height=HEIGHT)
    drawn = generate_yarns(fabric, quality="draft", yarn_radius=RADIUS)
    drawn = replace(drawn, rest_length=drawn.lengths)  # Its border is that of a swatch, without the tension of edges.
    drawn = apply_rest_lengths(drawn, RestLengths(loop_length=LOOP), fabric=fabric)
    border = np.unique(fabric.side_face[fabric.twin == BORDER])
    pinned = np.flatnonzero(np.isin(drawn.face, border) | (drawn.face < 0))
    rest = relax_yarns(
        drawn, material=YARN.yarn, quality=TIGHT, terms=[Pins(pinned)], device="cpu"
    )
    assert rest.report["converged"]
    cloth = cloth_from_stitches(fabric, stitch_width=WIDTH, course_height=HEIGHT)
    return cloth, lay_splines(cloth, fabric, rest.yarns), pinned


def region_of(name: str) -> Region:
    """Regions of the piece of six by six stitches."""
    cloth, yarns, _pinned = jersey()
    layout: Any = (cloth.triangles, len(cloth.vertices), yarns.triangle, yarns.barycentric)
    if name == "everywhere":
        return enriched_everywhere(*layout)
    middle = np.abs(cloth.vertices[cloth.triangles].mean(axis=1) - cloth.vertices.mean(axis=0))
    chosen = {
        "none": [],
        "middle": np.flatnonzero((middle < [WIDTH, HEIGHT, 1.0]).all(axis=1)),
        "all": np.arange(len(cloth.triangles)),
    }
    return region_around(*layout, chosen[name])


def built(name: str, *, nodes: Sequence[int] = (), vertices: Sequence[int] = (), scalar: Any = wp.float64,
          gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> ClothScene:  # fmt: skip
    """The system of a region, without weight by default."""
    cloth, yarns, _pinned = jersey()
    fabric = MixedFabric(cloth=cloth, yarns=yarns, cloth_material=SHEET, yarn_materials=YARN)
    return cloth_scene(fabric, region_of(name), nodes=nodes, vertices=vertices, gravity=gravity, scalar=scalar)
