# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of runs of mixed yarns and triangles: one camera for all panels, colours by alpha and tension."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from stitchmesh.mixed.drape import Draped, drape
from stitchmesh.mixed.scene.motion_section import AttachmentSection, BodySection, Keyframe
from stitchmesh.mixed.scene.region_section import BoxSection, RegionSection
from stitchmesh.mixed.scene.scene import ClothSection, Scene, SceneSolverSection, YarnsSection
from stitchmesh.mixed.scene.simple_bodies import ball
from stitchmesh.render.camera import camera_around
from stitchmesh.render.draped.picture import (
    ALPHA_SCALE,
    bodies_at_end,
    colours_of_runs,
    render_draped,
)
from stitchmesh.render.options import PictureOptions
from stitchmesh.render.stage import add_body, look, picture, shade_hollows

SCENE = Scene(
    cloth=ClothSection(rectangle=(3.0, 3.0), edge_length=0.6),
    yarns=YarnsSection(weave="plain", ends=5.0, picks=5.0),
    region=RegionSection(boxes=(BoxSection(low=(1.0, 1.0, -1.0), high=(2.0, 2.0, 1.0)),)),
    attachments=(AttachmentSection(boxes=(BoxSection(low=(-1.0, 2.8, -1.0), high=(9.0, 9.0, 1.0)),)),),
    solver=SceneSolverSection(device="cpu"),
)


@pytest.fixture(scope="module")
def runs() -> list[tuple[str, Draped]]:
    forms = [replace(SCENE, region=replace(SCENE.region, yarns=kind)) for kind in ("none", "chosen")]
    return [(name, drape(form)) for name, form in zip(("triangles", "mixed"), forms, strict=True)]


def test_colours_by_alpha_are_those_of_triangles_and_of_yarns_and_tension_has_one_scale(runs):
    """Tension of yarns is known where they are simulated and where they follow the triangles."""
    draped = [run for _name, run in runs]
    curves = [run.yarns for run in draped]
    triangles, mixed = colours_of_runs(draped, curves, "alpha")
    ends = ALPHA_SCALE.of(np.array([0.0, 1.0]))
    assert (triangles.points == ends[0]).all()
    assert (mixed.points == ends[0]).all(axis=1).any()
    assert (mixed.points == ends[1]).all(axis=1).any()
    triangles, mixed = colours_of_runs(draped, curves, "tension")
    assert triangles.scale.high == mixed.scale.high > 0.0


def test_bodies_are_drawn_where_they_end():
    moves = (Keyframe(time=0.0), Keyframe(time=1.0, displacement=(0.0, -1.0, 0.0)))
    ball = BodySection(shape="ball", size=(0.5,), centre=(1.5, -3.0, 0.0), keyframes=moves)
    run = drape(replace(SCENE, region=RegionSection(yarns="none"), bodies=(ball,)))
    (mesh,) = bodies_at_end(run)
    assert mesh.vertices.mean(axis=0) == pytest.approx([1.5, -4.0, 0.0], abs=1e-9)


@pytest.mark.usefixtures("display")
def test_runs_are_drawn_side_by_side(tmp_path, runs):
    render_draped(runs, tmp_path / "both.png", colour="alpha", size=(160, 120))
    image = np.asarray(Image.open(tmp_path / "both.png").convert("RGB")).astype(int)
    assert image.shape == (120, 320, 3)
    red = image[..., 0] - image[..., 2] > 60
    assert red[:, 160:].sum() > 100 > red[:, :160].sum()  # yarns are simulated on the right only


@pytest.mark.usefixtures("display")
def test_a_ball_far_from_the_camera_has_no_hollows(tmp_path):
    """Ambient occlusion changes no pixel of a convex body, however short its reach is beside the distance."""
    body, towards, up = ball(30.0, (0.0, 0.0, 0.0)), np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    camera = camera_around(body.vertices, towards, up, 1.0)
    pictures = []
    for occlusion in (False, True):
        options = PictureOptions(size=(160, 160), occlusion=occlusion)
        with picture(tmp_path / "ball.png", options) as plotter:
            add_body(plotter, body)
            look(plotter, camera)
            shade_hollows(plotter, 0.4, options)
        pictures.append(np.asarray(Image.open(tmp_path / "ball.png").convert("RGB")).astype(int))
    inside = pictures[0][40:120, 40:120], pictures[1][40:120, 40:120]
    assert np.abs(inside[1] - inside[0]).max() <= 3  # the pass blends colours once more: a level and its roundings
