# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenes that choose their region from a run with triangles alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.automatic_region import place_yarns, run_triangles
from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.placement.chosen_region import NodeBudget
from stitchmesh.mixed.scene.cloth_section import ClothSection
from stitchmesh.mixed.scene.motion_section import AttachmentSection, Keyframe
from stitchmesh.mixed.scene.region_section import BoxSection, RegionSection
from stitchmesh.mixed.scene.scene import OutputSection, Scene, SolverSection
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, prepare
from stitchmesh.mixed.scene.yarns_section import YarnsSection

CPU = device_named("cpu")


def held(low: tuple[float, float], high: tuple[float, float], move: tuple[float, float, float]) -> AttachmentSection:
    box = BoxSection(low=(*low, -1.0), high=(*high, 1.0))
    return AttachmentSection(boxes=(box,), keyframes=(Keyframe(time=0.0), Keyframe(time=1.0, displacement=move)))


PUSHED = Scene(
    cloth=ClothSection(rectangle=(4.0, 4.0), edge_length=0.5),
    yarns=YarnsSection(weave="plain", ends=4.0, picks=4.0),
    region=RegionSection(yarns="automatic", nodes=120),
    gravity=(0.0, 0.0, 0.0),
    attachments=(held((-1.0, -1.0), (5.0, 0.1), (0.0, 0.0, 0.0)), held((2.9, 2.9), (5.0, 5.0), (0.0, -0.2, 0.0))),
    solver=SolverSection(device="cpu", force_tolerance=1.0),
    output=OutputSection(picture=False),
)
"""A patch that is held along its lower side, and pressed down at its upper right corner."""


def placed(scene: Scene) -> PreparedScene:
    prepared = prepare(scene)
    error = run_triangles(prepared, wp.float64, CPU).error
    return place_yarns(prepared, error, NodeBudget(nodes=int(scene.region.nodes or 0)))


def test_the_region_keeps_to_its_nodes_and_lies_where_the_cloth_is_pressed() -> None:
    prepared = placed(PUSHED)
    assert 0 < len(prepared.region.nodes) <= 120
    full = prepared.region.triangle_alpha == 1.0
    assert prepared.fabric.cloth.rest.mean(axis=1)[full, 0].mean() > 2.0
    again = placed(PUSHED)
    assert np.array_equal(prepared.region.triangle_kind, again.region.triangle_kind)


def test_boxes_bound_the_region() -> None:
    box = BoxSection(low=(-1.0, -1.0, -1.0), high=(2.0, 5.0, 1.0))
    prepared = placed(replace(PUSHED, region=RegionSection(yarns="automatic", nodes=120, boxes=(box,))))
    full = prepared.region.triangle_alpha == 1.0
    assert (prepared.fabric.cloth.rest.mean(axis=1)[full, 0] < 2.0).all()


def test_a_run_places_its_yarns_first() -> None:
    run = drape(PUSHED)
    mixed = run.report["mixed"]
    assert 0 < mixed["yarn_nodes_full"] + mixed["yarn_nodes_hybrid"] <= 120


def test_too_few_nodes_are_refused() -> None:
    with pytest.raises(ParameterError, match="2 nodes hold no triangle"):
        placed(replace(PUSHED, region=RegionSection(yarns="automatic", nodes=2)))


@pytest.mark.parametrize(("yarns", "nodes"), [("automatic", None), ("automatic", 0), ("chosen", -1)])
def test_automatic_regions_need_a_number_of_nodes(yarns: str, nodes: int | None) -> None:
    with pytest.raises(ParameterError, match=r"region"):
        RegionSection(yarns=yarns, nodes=nodes)
