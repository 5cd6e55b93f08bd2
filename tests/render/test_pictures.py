# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures are written with the requested size and with content, and no other files are left."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from stitchmesh import io
from stitchmesh.errors import FileError, ParameterError, StitchMeshError
from stitchmesh.io.any_file import read_any
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.render import (
    PictureOptions,
    any_picture,
    render,
    render_faces,
    render_mesh,
    render_rows,
    render_stitches,
    render_stretch,
    render_yarns,
    stage,
)
from stitchmesh.render.surface import wale_arrowheads
from stitchmesh.yarn import YarnSet
from tests.gallery import tube

SIZE = (320, 200)
SMALL = PictureOptions(size=SIZE)


def fabric(*, labeled_only: bool = False) -> StitchMesh:
    mesh = tube(12, 5)
    stitch = np.full(60, Stitch.PANEL) if labeled_only else np.resize([Stitch.KNIT, Stitch.PURL], 60)
    edges = len(mesh.edge_side)
    return StitchMesh(
        mesh.vertices, mesh.face_start, mesh.face_vertex, mesh.twin, n_bottom=np.ones(60), n_top=np.ones(60),
        stitch=stitch, row=np.arange(60) // 12, stretch=np.linspace(0.9, 1.1, edges),
    )  # fmt: skip


def rings() -> YarnSet:
    angle = 2 * np.pi * np.arange(30) / 30
    curves = [np.stack([3 * np.cos(angle), np.full(30, 0.4 * k), 2 * np.sin(angle)], axis=1) for k in range(9)]
    return YarnSet.from_curves(curves, closed=[True] * 9, radius=0.15)


def pixels(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def is_drawn(path: Path) -> bool:
    """Whether the picture has the requested size and a sufficient part of it shows objects in many colours."""
    image = pixels(path)
    paper = image[0, 0]
    inked = (np.abs(image - paper) > 60).any(axis=2).mean()
    return image.shape == (SIZE[1], SIZE[0], 3) and inked > 0.05 and len(np.unique(image.reshape(-1, 3), axis=0)) > 200


@pytest.mark.parametrize(
    ("render", "content"),
    [
        (render_yarns, rings()), (render_mesh, tube(12, 5)), (render_rows, fabric(labeled_only=True)),
        (render_stitches, fabric()), (render_stretch, fabric()), (render_faces, fabric()),
    ],
)  # fmt: skip
def test_every_picture_is_drawn(display, tmp_path, render, content):
    render(content, tmp_path / "deep" / "a.png", SMALL)
    assert is_drawn(tmp_path / "deep" / "a.png")
    assert [path.name for path in (tmp_path / "deep").iterdir()] == ["a.png"]


def test_the_same_fabric_gives_the_same_picture(display, tmp_path):
    for name in ("a.png", "b.png"):
        render_stitches(fabric(), tmp_path / name, SMALL)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_a_failed_picture_does_not_replace_the_old_one(display, tmp_path, monkeypatch):
    (tmp_path / "a.png").write_bytes(b"the old picture")

    def fail(*arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(stage, "write_caption", fail)
    with pytest.raises(KeyboardInterrupt):
        render_mesh(tube(12, 5), tmp_path / "a.png", SMALL)
    assert (tmp_path / "a.png").read_bytes() == b"the old picture"
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]


def test_a_single_short_yarn_is_drawn(display, tmp_path):
    straight = np.outer(np.arange(6.0), [1.0, 0, 0])
    yarns = YarnSet.from_curves([straight], closed=[False], radius=0.3)
    render(yarns, tmp_path / "a.png", size=SIZE, colour="navy")
    assert is_drawn(tmp_path / "a.png")


def test_the_content_of_a_file_determines_its_picture(tmp_path, monkeypatch):
    drawn: list[str] = []
    for name in ("render_mesh", "render_yarns"):
        monkeypatch.setattr(any_picture, name, lambda *a, name=name, **k: drawn.append(name))
    pictures = {what: lambda *a, what=what, **k: drawn.append(what) for what in ("row", "stitch", "strain", "yarn")}
    monkeypatch.setattr(any_picture, "FABRIC_PICTURES", pictures)
    io.write_mesh(tmp_path / "m.obj", tube(12, 5))
    for name in ("y.h5", "y.bcc", "y.obj"):
        io.write_yarns(tmp_path / name, rings())
    io.write_stitches(tmp_path / "s.h5", fabric())
    io.write_stitches(tmp_path / "l.h5", fabric(labeled_only=True))
    for name in ("m.obj", "y.h5", "y.bcc", "y.obj", "s.h5", "l.h5"):
        render(read_any(tmp_path / name), tmp_path / "a.png")
    render(read_any(tmp_path / "s.h5"), tmp_path / "a.png", colour="strain")
    assert drawn == ["render_mesh", "render_yarns", "render_yarns", "render_yarns", "stitch", "row", "strain"]


def test_messages_name_invalid_requests(tmp_path):
    with pytest.raises(ParameterError, match="stretch: the stitch mesh has none; relax the mesh first"):
        render_stretch(replace(fabric(), stretch=None), tmp_path / "a.png")
    io.write_stitches(tmp_path / "s.h5", fabric())
    io.write_mesh(tmp_path / "m.obj", tube(12, 5))
    with pytest.raises(ParameterError, match=r"colour: got 'stitches'.*did you mean 'stitch'"):
        render(read_any(tmp_path / "s.h5"), tmp_path / "a.png", colour="stitches")
    with pytest.raises(ParameterError, match="colour: got 'strain' for a polygon mesh, which has no strains"):
        render(read_any(tmp_path / "m.obj"), tmp_path / "a.png", colour="strain")
    with pytest.raises(FileError, match=r"unknown format '.jpg'; expected one of .png"):
        render_mesh(tube(12, 5), tmp_path / "a.jpg")
    with pytest.raises(StitchMeshError, match="no such file"):
        render(read_any(tmp_path / "none.h5"), tmp_path / "a.png")


def test_arrowheads_point_along_the_wales():
    tip, left, right = np.moveaxis(wale_arrowheads(fabric()), 1, 0)
    along = tip - (left + right) / 2
    np.testing.assert_allclose(
        along / np.linalg.norm(along, axis=1, keepdims=True), np.tile([0, 1, 0], (60, 1)), atol=1e-12
    )
