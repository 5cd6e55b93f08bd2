# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Garments of the examples on a body, with larger triangles and fewer yarns: outside of it, and in one piece."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.mixed.assembly import contact_points
from stitchmesh.mixed.contact.body_distance import BodyContact
from stitchmesh.mixed.drape import Draped, drape
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.scene.region_section import BoxSection
from stitchmesh.mixed.scene.scene import read_scene
from tests.gallery import ROOT
from tests.nightly import at_night

EXAMPLES = ROOT / "examples" / "mixed"
REGIONS = {
    "shirt": (((15, 20), (25, 36)), ((-25, 20), (-15, 36))),
    "dress": (((14, 55), (24, 68)), ((-24, 55), (-14, 68))),
}
"""Corners of boxes in the front and in the back, at both sides of a side seam [cm]."""


@pytest.fixture(scope="module", params=at_night("shirt", "dress"))
def worn(request) -> Draped:
    """A garment at rest on the body, with yarns on both sides of a seam."""
    scene = read_scene(EXAMPLES / f"{request.param}.toml")
    sides = zip(("front", "back"), REGIONS[request.param], strict=True)
    boxes = tuple(BoxSection(panel=panel, low=low, high=high) for panel, (low, high) in sides)
    contact = replace(scene.contact, pressure=5e4)  # large triangles bridge the body; their few points carry more
    coarse = replace(
        scene,
        cloth=replace(scene.cloth, edge_length=6.0),
        contact=contact,
        yarns=replace(scene.yarns, density=0.5),
        region=replace(scene.region, boxes=boxes),
        solver=replace(scene.solver, device="cpu", force_tolerance=300.0, friction_updates=0),
    )
    return drape(coarse)


def test_a_garment_comes_to_rest_outside_the_body(worn):
    """All contact points, on triangles and at yarn nodes, keep a distance."""
    assert worn.report["mixed"]["converged"]
    prepared, end, cpu = worn.prepared, worn.end, device_named("cpu")
    points, _links = contact_points(prepared.fabric, prepared.region, prepared.loads(0.0).thickness)
    contact = BodyContact(points, prepared.bodies[0].body, scalar=wp.float64, device=cpu)
    state = MixedVector.from_numpy(end.vertices, end.nodes, end.sliding, wp.float64, cpu)
    assert contact.distances(state).min() > 0.0


def test_yarns_go_on_over_the_seam(worn):
    """No segment of a simulated yarn, nor of the rod at the seam, is twice as long as at rest and 1 cm longer."""
    yarns, region = worn.prepared.fabric.yarns, worn.prepared.region
    panels = set(yarns.panel[region.nodes[region.node_alpha[region.nodes] == 1.0]].tolist())
    assert len(panels) >= 2
    places, along = worn.shown.nodes, yarns.rest_sliding[yarns.yarn_node, yarns.yarn_coordinate]
    first = np.setdiff1d(np.arange(len(yarns.yarn_node) - 1), yarns.yarn_start[1:-1] - 1)
    ends = np.stack([yarns.yarn_node[first], yarns.yarn_node[first + 1]], axis=1)
    simulated = (region.node_number[ends] >= 0).all(axis=1)
    length = np.linalg.norm(places[ends[:, 1]] - places[ends[:, 0]], axis=1)[simulated]
    at_rest = (along[first + 1] - along[first])[simulated]
    assert (length < 2.0 * at_rest + 1.0).all()
