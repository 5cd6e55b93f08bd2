# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scene files: what is written is read again, every key is checked, and bad input is one line."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.errors import StitchMeshError
from stitchmesh.mixed.cloth.panels import Panel, PanelPosition
from stitchmesh.mixed.cloth.seams import PanelBorder, PanelSeam
from stitchmesh.mixed.scene import matched_cloth
from stitchmesh.mixed.scene.motion_section import AttachmentSection, BodySection, Keyframe
from stitchmesh.mixed.scene.region_section import BoxSection, RegionSection
from stitchmesh.mixed.scene.scene import (
    ClothSection,
    ContactSection,
    OutputSection,
    Scene,
    SceneSolverSection,
    YarnsSection,
    example_scene,
    knit_chart,
    read_scene,
    weave_matrix,
    write_scene,
)
from stitchmesh.mixed.scene.scene_fabric import prepare
from stitchmesh.periodic.weave.library import read_weave

BASE = """
[cloth]
rectangle = [4, 4]
edge_length = 1
[yarns]
weave = "plain"
ends = 4
picks = 4
"""


def scene_of(tmp_path: Path, text: str) -> Scene:
    path = tmp_path / "scene.toml"
    path.write_text(text)
    return read_scene(path)


def two_panels() -> ClothSection:
    square = ((0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0))
    right = Panel(name="right", outline=square, position=PanelPosition(origin=(3.0, 0.0, 0.0)))
    first, second = PanelBorder(panel="left", start=1, end=2), PanelBorder(panel="right", start=3, end=0)
    seam = PanelSeam(first=first, second=second, angle=10.0)
    return ClothSection(panels=(Panel(name="left", outline=square), right), seams=(seam,), edge_length=1.0)


def test_a_scene_is_read_as_it_was_written(tmp_path):
    scene = Scene(
        cloth=two_panels(),
        yarns=YarnsSection(weave=("10", "01"), ends=4.0, picks=3.0, material="gong-2"),
        region=RegionSection(boxes=(BoxSection(low=(1.0, 1.0), high=(2.0, 2.0), panel="right"),), rings=2),
        mode="dynamic",
        duration=0.5,
        attachments=(
            AttachmentSection(
                boxes=(BoxSection(low=(-1.0, 2.9, -1.0), high=(9.0, 9.0, 1.0)),),
                keyframes=(Keyframe(time=0.0), Keyframe(time=1.0, displacement=(0.0, 1.0, 0.0))),
                release=0.4,
            ),
        ),
        bodies=(BodySection(shape="box", size=(1.0, 2.0, 3.0), friction=0.1),),
        contact=ContactSection(self_collision=True, thickness=0.2, friction=0.3),
        solver=SceneSolverSection(precision="float32"),
        output=OutputSection(yarns=("usda", "h5"), colour="alpha", view=(30.0, 10.0)),
    )
    write_scene(tmp_path / "scene.toml", scene)
    assert read_scene(tmp_path / "scene.toml") == scene


def test_paths_are_relative_to_the_file(tmp_path):
    (tmp_path / "inner").mkdir()
    text = BASE.replace("rectangle = [4, 4]", 'file = "../panels.toml"') + '[[bodies]]\nfile = "body.obj"\n'
    scene = scene_of(tmp_path / "inner", text)
    assert Path(scene.cloth.file) == tmp_path / "panels.toml"
    assert Path(scene.bodies[0].file) == tmp_path / "inner" / "body.obj"
    write_scene(tmp_path / "moved.toml", scene)
    again = read_scene(tmp_path / "moved.toml")
    assert Path(again.bodies[0].file).resolve() == (tmp_path / "inner" / "body.obj").resolve()


def test_the_example_is_a_scene(tmp_path):
    prepared = prepare(scene_of(tmp_path, example_scene()))
    assert len(prepared.region.nodes) > 0
    assert [len(held.vertices) > 0 and len(held.nodes) > 0 for held in prepared.held] == [True]


WRONG = {
    "unknown key": (BASE + "[regions]\n", "did you mean 'region'"),
    "no cloth": ("[cloth]\n[yarns]\nweave = 'plain'\n", "expected exactly one of rectangle, panels and file"),
    "two fabrics": (BASE + "knit = ['k']\n", "got both of weave and knit"),
    "unknown weave": (BASE.replace('"plain"', '"plane"'), "did you mean plain"),
    "weave of layers": (BASE.replace('"plain"', '"double-plain-stitched"'), "has 2 layers"),
    "uneven rows": (BASE.replace('"plain"', '["10", "0"]'), "expected equal ones"),
    "unknown yarn": (BASE + 'material = "gong-9"\n', "did you mean 'gong-"),
    "unknown cloth": (BASE.replace("[yarns]", 'material = "denin"\n[yarns]'), "did you mean 'denim'"),
    "region outside": (BASE + "[[region.boxes]]\nlow = [8, 8, 8]\nhigh = [9, 9, 9]\n", "holds no triangle"),
    "box with two numbers": (BASE + "[[region.boxes]]\nlow = [8, 8]\nhigh = [9, 9]\n", "expected 3 in space"),
    "face outside": (BASE + "[region]\nfaces = [999]\n", "expected 0 to"),
    "attached to nothing": (BASE + "[[attachments]]\nboxes = [{ low = [8, 8, 8], high = [9, 9, 9] }]", "holds nothing"),
    "empty attachment": (BASE + "[[attachments]]\n", "expected boxes, faces or vertices"),
    "times that fall": (
        BASE + "[[attachments]]\nvertices = [0]\nkeyframes = [{ time = 1 }, { time = 0 }]\n", "times that increase"
    ),
    "body without size": (BASE + '[[bodies]]\nshape = "ball"\n', "expected 1 positive numbers"),
    "missing body": (BASE + '[[bodies]]\nfile = "nowhere.obj"\n', "nowhere.obj"),
    "friction of resting layers": (BASE + "[contact]\nfriction = 0.3\n", "in a static scene, whose layers"),
    "crossed panel": (
        BASE.replace("rectangle = [4, 4]", "panels = [{ name = 'a', outline = [[0,0],[2,2],[2,0],[0,2]] }]"), "cross"
    ),
    "frames without end": ('mode = "dynamic"\nduration = 1e300\n' + BASE, "got 1e+300 s with 3e+301 frames; expected"),
    "digits without end": (BASE + "[solver]\nmost_iterations = 1" + 400 * "0" + "\n", "at most 1e+300"),
    "tiny triangles": (BASE.replace("edge_length = 1", "edge_length = 1e-320"), "at least 0.0001 cm"),
    "no TOML": ("duration = \n", "is no TOML"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_bad_input_is_one_line(tmp_path, name):
    text, expected = WRONG[name]
    with pytest.raises(StitchMeshError) as caught:
        prepare(scene_of(tmp_path, text))
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


def test_seams_of_different_counts_and_missing_texture_coordinates_are_one_line(tmp_path):
    square = "outline = [[0, 0], [2, 0], [2, 2], [0, 2]]"
    panels = "".join(f'[[cloth.panels]]\nname = "{name}"\n{square}\nside_edges = [2, {n}, 2, {n}]\n' for name, n in
                     (("a", 2), ("b", 3)))  # fmt: skip
    seam = (
        '[[cloth.seams]]\nfirst = { panel = "a", start = 1, end = 2 }\nsecond = { panel = "b", start = 3, end = 0 }\n'
    )
    (tmp_path / "plain.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    yarns = '[yarns]\nweave = "plain"\n'
    for text, expected in (
        (panels + seam + yarns, "same number"),
        ('[cloth]\nfile = "plain.obj"\n' + yarns, "texture coordinates"),
    ):
        with pytest.raises(StitchMeshError, match=expected) as caught:
            prepare(scene_of(tmp_path, text))
        assert "\n" not in str(caught.value)


def test_an_attachment_to_covered_vertices_alone_is_refused(tmp_path):
    text = BASE + '[region]\nyarns = "all"\n[[attachments]]\nboxes = [{ low = [-1, 3.99, -1], high = [9, 9, 1] }]\n'
    with pytest.raises(StitchMeshError, match="none of its yarn nodes"):
        prepare(scene_of(tmp_path, text))


def test_weaves_of_the_library_and_of_files(tmp_path):
    assert np.array_equal(weave_matrix("twill-4x1") == 1, read_weave("twill-4x1").over)
    assert weave_matrix("satin-3x2").tolist() == [list(row) for row in read_weave("satin-3x2").matrix]
    (tmp_path / "mine.weave").write_text("wefts colour: 0 1 2\n110\n011\n101\n")
    text = BASE.replace('weave = "plain"', 'weave = "mine.weave"')
    prepared = prepare(scene_of(tmp_path, text))
    assert prepared.scene.yarns.weave == str(tmp_path / "mine.weave")
    assert weave_matrix(prepared.scene.yarns.weave).tolist() == [[1, 1, 0], [0, 1, 1], [1, 0, 1]]


def test_a_cloth_is_matched_once_and_kept(tmp_path, monkeypatch):
    """The plain weave of straight yarns is matched exactly; the file is used again for the same yarns alone."""
    stages: list[str] = []
    scene = scene_of(tmp_path, BASE.replace("[yarns]", 'material = "matched"\n[yarns]'))
    monkeypatch.setattr(matched_cloth, "_known", {})

    def prepared(given):
        stages.clear()
        return prepare(given, folder=tmp_path / "out", progress=lambda stage, *_: stages.append(stage)).fabric

    fabric = prepared(scene)
    assert set(stages) == {"match"}
    stiffness = 4.0 * fabric.yarn_materials.weft.stretch_stiffness
    assert fabric.cloth_material.stretch_course == pytest.approx(stiffness, rel=0.2)  # of the linear law up to 20 %
    matched_cloth._known.clear()
    again = prepared(scene)
    assert not stages
    assert again.cloth_material == fabric.cloth_material
    other = prepared(replace(scene, yarns=replace(scene.yarns, radius=0.04)))
    assert set(stages) == {"match"}
    assert other.cloth_material.stretch_course < fabric.cloth_material.stretch_course
    finer = prepared(replace(scene, yarns=replace(scene.yarns, density=2.0)))
    assert finer.cloth_material.stretch_course == pytest.approx(fabric.cloth_material.stretch_course, rel=1e-6)


def test_knits_by_name_and_chart():
    assert knit_chart(("KP", "kp")).tolist() == [[1, 0], [1, 0]]
    assert np.ptp(knit_chart("rib1x1"), axis=0).tolist() == [0, 0]  # wales of one kind, next to one another
    assert knit_chart("rib1x1")[0].sum() == 1
    with pytest.raises(StitchMeshError, match="expected knit and purl stitches alone"):
        knit_chart("rope-cable")


BALL = """
[cloth]
rectangle = [4, 4]
edge_length = 0.5
[yarns]
weave = "plain"
ends = 4
picks = 4
[[bodies]]
shape = "ball"
size = [1]
centre = [2, 2, 0.3]
[contact]
thickness = 0.2
"""


def test_a_cloth_that_starts_in_a_body_is_moved_out_where_the_scene_says_so(tmp_path: Path) -> None:
    distances = []
    for end in ("", "start_outside = true\n"):
        path = tmp_path / "scene.toml"
        path.write_text(BALL + end)
        prepared = prepare(read_scene(path))
        distances.append(np.linalg.norm(prepared.vertices - [2.0, 2.0, 0.3], axis=1).min() - 1.0)
    assert distances[0] < -0.5
    assert distances[1] > 0.0  # the ball of triangles lies within the ball of radius 1
