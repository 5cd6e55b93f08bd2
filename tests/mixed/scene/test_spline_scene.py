# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenes with B-spline yarns: a patch at rest, a border that is pulled, resuming, files, and keys that do not fit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.io.stitches import read_stitches, write_stitches
from stitchmesh.labeling import label
from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.enrichment.region import TRIANGLES
from stitchmesh.mixed.layout.spline_yarns import SplineYarns
from stitchmesh.mixed.output.files import MAPS, read_maps
from stitchmesh.mixed.scene import scene_splines
from stitchmesh.mixed.scene.motion_section import AttachmentSection, Keyframe
from stitchmesh.mixed.scene.region_section import BoxSection, RegionSection
from stitchmesh.mixed.scene.scene import (
    ClothSection,
    OutputSection,
    Scene,
    SceneSolverSection,
    YarnsSection,
    read_scene,
    write_scene,
)
from stitchmesh.mixed.scene.scene_fabric import prepare, with_region
from stitchmesh.mixed.simulation import StaticSimulation
from stitchmesh.tessellate import tessellate
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen import check_loops
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.relaxation_result import Relaxation
from tests.gallery import ROOT, grid
from tests.mixed.splines.jersey import HEIGHT, LOOP, RADIUS, WIDTH

YARNS = YarnsSection(model="splines", knit="stitches", radius=RADIUS, loop_length=LOOP)
MATERIAL = str(ROOT / "examples" / "mixed" / "jersey" / "cloth.toml")


@pytest.fixture(scope="module", autouse=True)
def yarns_relaxed_once() -> Iterator[None]:
    """All scenes lay the same yarns, whose relaxation takes longer than what is tested here."""
    known: dict[bytes, Relaxation] = {}

    def relax_once(yarns: YarnSet, **options: Any) -> Relaxation:
        start = yarns.points.tobytes()
        if start not in known:
            known[start] = relax_yarns(yarns, **options)
        return known[start]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(scene_splines, "relax_yarns", relax_once)
        yield


def patch(tmp_path, columns: int = 5, rows: int = 4, pull: float = 0.0) -> Scene:
    """A patch that is held at its left and right border, with yarns in its middle."""
    mesh = label(grid(columns, rows, width=WIDTH, height=HEIGHT))
    write_stitches(tmp_path / "patch.smobj", tessellate(mesh, stitch_width=WIDTH, stitch_height=HEIGHT))
    right = columns * WIDTH
    middle = np.array([right, rows * HEIGHT]) / 2
    half = np.array([0.7 * WIDTH, 0.7 * HEIGHT])
    low, high = middle - half, middle + half
    keyframes = (Keyframe(time=0.0), Keyframe(time=1.0, displacement=(pull, 0.0, 0.0)))
    return Scene(
        cloth=ClothSection(
            file=str(tmp_path / "patch.smobj"), stitch_width=WIDTH, course_height=HEIGHT, material=MATERIAL
        ),
        yarns=YARNS,
        region=RegionSection(boxes=(BoxSection(low=(*low, -1.0), high=(*high, 1.0)),)),
        attachments=(
            AttachmentSection(boxes=(BoxSection(low=(-1.0, -1.0, -1.0), high=(0.01, 9.0, 1.0)),)),
            AttachmentSection(
                boxes=(BoxSection(low=(right - 0.01, -1.0, -1.0), high=(9.0, 9.0, 1.0)),), keyframes=keyframes
            ),
        ),
        gravity=(0.0, 0.0, 0.0),
        solver=SceneSolverSection(device="cpu", force_tolerance=20.0, most_iterations=200),
        output=OutputSection(picture=False),
    )


@pytest.mark.nightly
def test_a_pulled_patch_keeps_its_loops_and_comes_out_the_same_again(tmp_path):
    scene = patch(tmp_path, columns=7, rows=6, pull=0.03 * 7 * WIDTH)
    run = drape(scene, tmp_path / "out")
    run.write(tmp_path / "out")
    yarns = run.prepared.fabric.yarns
    width = run.shown.vertices[:, 0].max() - run.shown.vertices[:, 0].min()
    assert width == pytest.approx(1.03 * 7 * WIDTH, rel=1e-6)
    assert run.report["mixed"]["converged"] and run.report["mixed"]["newton_iterations"] > 1
    check_loops(read_stitches(tmp_path / "patch.smobj"), run.yarns)  # no loop has lost what it holds
    maps = read_maps(tmp_path / "out" / MAPS)
    assert maps.yarn_tension.max() > 0.0 and len(maps.yarn_tension) == yarns.node_count
    again = drape(scene)
    np.testing.assert_array_equal(again.yarns.points, run.yarns.points)


def test_a_scene_with_splines_is_read_as_it_was_written(tmp_path):
    scene = patch(tmp_path)
    write_scene(tmp_path / "scene.toml", scene)
    assert read_scene(tmp_path / "scene.toml").yarns == scene.yarns
    prepared = prepare(replace(scene, region=RegionSection(yarns="none")))
    assert len(prepared.region.nodes) == 0


def test_keys_that_do_not_fit_are_refused(tmp_path):
    scene = patch(tmp_path)
    for wrong, words in (
        ({"knit": ("k",)}, "knit = 'stitches'"),
        ({"divisions": 2}, "divisions"),
        ({"warp_material": "gong-1"}, "warp_material"),
        ({"model": "crossings"}, "loop_length"),
    ):
        with pytest.raises(ParameterError, match=words):
            replace(YARNS, **wrong)
    with pytest.raises(ParameterError, match="static"):
        replace(scene, mode="dynamic")
    with pytest.raises(ParameterError, match="stitchmesh stretch"):
        prepare(replace(scene, cloth=replace(scene.cloth, material=None)))
    with pytest.raises(ParameterError, match="material: got 'gong-1'"):
        prepare(replace(scene, yarns=replace(YARNS, material="gong-1")))


def test_attachments_that_would_lead_yarns_through_one_another_are_refused(tmp_path):
    scene = patch(tmp_path)
    boxes = tuple(BoxSection(low=(x, -1.0, -1.0), high=(x + 0.4 * WIDTH, 9.0, 1.0)) for x in (3.0 * WIDTH, 3.5 * WIDTH))
    crossing = tuple(
        AttachmentSection(
            boxes=(box,), keyframes=(Keyframe(time=0.0), Keyframe(time=1.0, displacement=(way, 0.0, 0.0)))
        )
        for box, way in zip(boxes, (WIDTH, -WIDTH), strict=True)
    )
    with pytest.raises(SolverError, match=r"too close|load_steps|between control points"):
        drape(replace(scene, attachments=crossing))


def test_a_run_that_is_resumed_has_the_same_bits(tmp_path):
    prepared = prepare(replace(patch(tmp_path, pull=0.04 * WIDTH), load_steps=2))
    whole, later = (StaticSimulation(prepared, wp.float64, device_named("cpu")) for _ in range(2))
    whole.step()
    later.resume(whole.arrays())
    for run in (whole, later):
        run.step()
    for ours, theirs in zip(whole.positions, later.positions, strict=True):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.nightly
def test_loops_keep_their_height_where_a_region_grows_to_the_border(tmp_path):
    prepared = prepare(patch(tmp_path, columns=7, rows=6))
    simulation = StaticSimulation(prepared, wp.float64, device_named("cpu"))
    grown = with_region(prepared, np.flatnonzero(prepared.region.triangle_kind != TRIANGLES)).region
    simulation.change_region(grown)
    vertices, nodes, _sliding = simulation.positions
    yarns = prepared.fabric.yarns
    assert isinstance(yarns, SplineYarns)
    laid = yarns.curves.points[grown.nodes]
    assert len(grown.nodes) > 2 * len(prepared.region.nodes) and yarns.height[grown.nodes].std() > RADIUS
    # the change that makes p = B v + F x moves mainly the vertices
    assert np.sqrt(np.mean((nodes - laid) ** 2)) < 0.5 * RADIUS
    np.testing.assert_allclose(simulation._system.embedding.constraint(vertices, nodes), 0.0, atol=1e-12)  # rounding
