# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Texture maps show the round tubes of yarns from above, and repeat without a seam."""

from __future__ import annotations

import io
import json
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from stitchmesh.errors import FileError, ParameterError, YarnError
from stitchmesh.lattice import Lattice
from stitchmesh.mesh.palette import STOCK
from stitchmesh.periodic.textures.files import DESCRIPTIONS, images, texture_archive, write_textures
from stitchmesh.periodic.textures.textures import PixelSurface, TextureMaps, surface_at, texture_maps
from stitchmesh.periodic.textures.tubes import PixelGrid, tubes_above
from stitchmesh.periodic.textures.visibility import visible_pieces
from stitchmesh.yarn import YarnSet, basis
from tests.io.yarn_sets import ring
from tests.yarnrelax.stockinette import periodic_patch, woven_cell

RADIUS = 0.25
CREAM_AND_DENIM = STOCK / 255


def straight(height: float = 0.5) -> YarnSet:
    """Return one yarn along x in a cell of 1.5 cm by 1 cm."""
    line = np.stack([np.arange(6) * 0.25, np.full(6, height), np.zeros(6)], axis=1)
    bare = YarnSet.from_curves([line], closed=[True], radius=RADIUS, rest_lengths=[np.full(6, 0.25)])
    lattice = Lattice([[1.5, 0.0, 0.0], [0.0, 1.0, 0.0]])
    return replace(bare, lattice=lattice, lattice_step=np.array([[1, 0]]), colour=[1])


def ring_cell(points: NDArray[np.float64], radius: float = 0.2) -> YarnSet:
    """Return a ring in the middle of a square cell of 2 cm."""
    bare = YarnSet.from_curves([points + np.array([1.0, 1.0, 0.0])], closed=[True], radius=radius)
    return replace(bare, lattice=Lattice(2 * np.eye(3)[:2]), lattice_step=np.array([[0, 0]]))


def seen(yarns: YarnSet, width: int, height: int) -> tuple[PixelGrid, PixelSurface]:
    """Return a plan and the surface at its pixels."""
    assert yarns.lattice is not None
    plan = PixelGrid(yarns.lattice, width, height)
    tubes = tubes_above(yarns, plan)
    return plan, surface_at(tubes, plan, visible_pieces(tubes, plan), 0, height)


def places(plan: PixelGrid) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    row, column = np.mgrid[: plan.height, : plan.width]
    return plan.places(column, row)


def assert_alike(first: TextureMaps, second: dict[str, NDArray]) -> None:
    """Check that stored maps are equal, except for one step of a channel where a value is rounded differently."""
    for name, picture in images(first).items():
        difference = np.abs(picture.astype(int) - second[name].astype(int))
        assert difference.max() <= 1, name
        assert (difference > 0).mean() < 0.01, name


def test_a_straight_yarn_gives_a_half_cylinder():
    maps = texture_maps(straight(), width=96, height=64)
    samples = (np.arange(128) + 0.5) / 128 - 0.5
    inside = np.abs(samples) < RADIUS
    top = np.where(inside, RADIUS + np.sqrt(np.maximum(RADIUS**2 - samples**2, 0)), 0).reshape(64, 2)
    count = inside.reshape(64, 2).sum(axis=1)
    expected = top.sum(axis=1) / np.maximum(count, 1)
    # rounding of a square root near its zero
    np.testing.assert_allclose(maps.height, np.tile(expected[:, None], (1, 96)), atol=1e-7)
    assert maps.depth == pytest.approx(2 * RADIUS, rel=1e-12)  # rounding
    assert maps.opacity.mean() == 2 * RADIUS  # the rim lies between samples
    yarn = maps.opacity > 0
    np.testing.assert_allclose(maps.tangent[yarn], np.tile([1.0, 0.0, 0.0], (yarn.sum(), 1)), atol=1e-12)
    np.testing.assert_array_equal(maps.tangent[~yarn], 0.0)


def test_normals_point_upwards_in_the_image_and_outwards():
    maps = texture_maps(straight(), width=12, height=64)
    np.testing.assert_allclose(np.linalg.norm(maps.normal, axis=2), 1.0, rtol=1e-12)
    np.testing.assert_array_equal(maps.normal[0], np.tile([0.0, 0.0, 1.0], (12, 1)))
    # the top row comes first; row 20 lies above the middle of the yarn
    above, below = maps.normal[20, 0], maps.normal[43, 0]
    assert above[1] > 0.5
    np.testing.assert_allclose(below, above * [1, -1, 1], atol=1e-12)
    # the samples of a row lie a quarter of a pixel above and below its middle
    assert above[1] == pytest.approx((31.5 - 20) / 64 / RADIUS, abs=0.01)


def test_a_crest_has_the_colour_of_the_yarn_and_a_hole_the_mean_colour():
    maps = texture_maps(straight(), width=24, height=64)
    np.testing.assert_allclose(maps.colour[31:33], np.tile(CREAM_AND_DENIM[1], (2, 24, 1)), atol=1e-9)
    woven = texture_maps(woven_cell(), width=64)
    yarn = woven.opacity == 1.0
    deep, high = woven.height[yarn].argmin(), woven.height[yarn].argmax()
    np.testing.assert_allclose(woven.colour[yarn][high], CREAM_AND_DENIM[0], atol=1e-9)
    assert (woven.colour[yarn][deep] < 0.9 * CREAM_AND_DENIM[0]).all()  # a yarn above takes light
    hole = woven.colour[woven.opacity == 0.0]
    assert (hole == hole[0]).all()
    assert (woven.colour[yarn].min(axis=0) < hole[0]).all()
    assert (hole[0] < CREAM_AND_DENIM[0]).all()


def test_a_ring_gives_a_torus():
    _, surface = seen(ring_cell(ring([0, 0, 0.3], 0.6)), 100, 100)
    x, y = places(PixelGrid(Lattice(2 * np.eye(3)[:2]), 100, 100))
    around = np.hypot(x - 1, y - 1)
    # a B-spline of 40 control points on a circle lies inside it by a factor (2 + cos 9 degrees) / 3
    across = around - 0.6 * (2 + np.cos(2 * np.pi / 40)) / 3
    inside = np.abs(across) < 0.2 - 1e-4
    assert surface.covered[inside].all()
    assert not surface.covered[np.abs(across) > 0.2 + 1e-4].any()
    top = np.sqrt(np.maximum(0.04 - across**2, 0))
    expected = np.stack([across / around * (x - 1), across / around * (y - 1), top])
    # between knots the spline deviates from the circle by 1e-6; the normal changes fast near the edge of the tube
    np.testing.assert_allclose(surface.normal[inside], expected[:, inside].T / 0.2, atol=5e-3)
    np.testing.assert_allclose(surface.height[inside], 0.3 + top[inside], atol=1e-3)
    middle = np.abs(across) < 0.15
    np.testing.assert_allclose(surface.height[middle], 0.3 + top[middle], atol=1e-5)


def test_the_surface_is_the_maximum_over_all_balls():
    rng = np.random.default_rng(1)
    cell = periodic_patch(1, 1)
    cell = replace(cell, points=cell.points + rng.normal(scale=0.02, size=cell.points.shape))
    plan, surface = seen(cell, 40, 30)
    parameter = np.arange(0, 1, 1 / 80)
    corners = (cell.points[cell.segment_points] + cell.point_shift) @ plan.axes.T
    balls = np.einsum("kj,sjd->skd", basis(parameter), corners).reshape(-1, 3)
    x, y = places(plan)
    top = np.full(x.shape, -np.inf)
    for a in range(-2, 3):
        for b in range(-2, 3):
            shift = a * plan.periods[0] + b * plan.periods[1]
            for ball in balls:
                under = cell.radius[0] ** 2 - (x - ball[0] - shift[0]) ** 2 - (y - ball[1] - shift[1]) ** 2
                top = np.maximum(top, np.where(under > 0, ball[2] + np.sqrt(np.maximum(under, 0)), -np.inf))
    np.testing.assert_array_equal(surface.covered, top > -np.inf)
    inside = surface.covered & (surface.normal[:, :, 2] > 0.2)
    assert inside.mean() > 0.5
    # balls at distances of 0.01 radii leave hollows of 1e-5 radii on a crest, more on a steep side; between two yarns,
    # straight pieces with an error of up to 1e-3 radii decide which yarn is uppermost
    gap = surface.height[inside] - top[inside]
    assert np.abs(gap).max() < 1e-3 * cell.radius[0]
    assert (gap > -1e-9).mean() > 0.99


def test_the_image_in_which_a_yarn_is_stored_does_not_matter():
    cell = periodic_patch(2, 1)
    shift = cell.lattice.shift(np.array([[3, -2], [0, 5]]))[cell.point_yarn]
    away = replace(cell, points=cell.points + shift)
    assert_alike(texture_maps(away, width=64, height=96), images(texture_maps(cell, width=64, height=96)))


def test_tiles_repeat_the_same_period():
    cell = replace(woven_cell(), colour=[0, 0, 1, 2])
    one, six = texture_maps(cell, width=32), texture_maps(cell, width=96, tiles=(3, 2))
    repeated = {name: np.tile(p, (2, 3, *[1] * (p.ndim - 2))) for name, p in images(one).items()}
    assert_alike(six, repeated)
    np.testing.assert_allclose(six.lattice.periods, cell.lattice.periods * [[3], [2]])


def test_a_sheared_cell_shows_the_same_fabric():
    """If v is replaced by v + 2 u and w = h, column i of row j moves to column i + 2 j + 1."""
    cell = periodic_patch(1, 1)
    u, v = cell.lattice.periods
    sheared = replace(cell, lattice=Lattice([u, v + 2 * u]))
    (_, first), (_, second) = seen(cell, 60, 60), seen(sheared, 60, 60)
    row, column = np.mgrid[:60, :60]
    same = row, (column + 2 * row + 1) % 60
    np.testing.assert_array_equal(second.covered, first.covered[same])
    np.testing.assert_allclose(second.height, first.height[same], atol=1e-9)  # rounding near rims
    # other straight pieces: two Newton steps leave 4e-5 near edges; half a step of eight bits is 4e-3
    np.testing.assert_allclose(second.normal, first.normal[same], atol=1e-3)


def test_a_turned_fabric_has_the_same_maps():
    cell = periodic_patch(1, 1)
    turn = np.array([[0.0, 1.0, 0.0], [-0.6, 0.0, 0.8], [0.8, 0.0, 0.6]])
    turned = replace(cell, points=cell.points @ turn, lattice=Lattice(cell.lattice.periods @ turn))
    assert_alike(texture_maps(turned, width=48), images(texture_maps(cell, width=48)))


def test_files_hold_the_maps_and_their_descriptions(tmp_path):
    maps = texture_maps(woven_cell(), width=32)
    write_textures(tmp_path / "new" / "folder", maps)
    folder = tmp_path / "new" / "folder"
    assert sorted(path.name for path in folder.iterdir()) == sorted(
        [f"{name}.png" for name in DESCRIPTIONS] + ["textures.json"]
    )
    for name, picture in images(maps).items():
        np.testing.assert_array_equal(np.array(Image.open(folder / f"{name}.png")), picture)
    assert images(maps)["height"].max() > 65000
    content = json.loads((folder / "textures.json").read_text())
    assert content["pixels"] == [32, 32]
    assert content["size_cm"] == [0.75, 0.75]
    assert content["height_cm"] == maps.depth
    assert sorted(content["maps"]) == sorted(DESCRIPTIONS)
    with zipfile.ZipFile(io.BytesIO(texture_archive(maps))) as archive:
        assert archive.testzip() is None
        files = {name: archive.read(name) for name in archive.namelist()}
    assert files == {path.name: path.read_bytes() for path in folder.iterdir()}


def test_impossible_maps_are_refused(tmp_path):
    for size in (0, 8193, 1.5):
        with pytest.raises(ParameterError, match="expected a whole number from 1 to 8192"):
            texture_maps(straight(), width=size)
        with pytest.raises(ParameterError, match="got a height of"):
            texture_maps(straight(), width=8, height=size)
    with pytest.raises(ParameterError, match="got 0 rows"):
        texture_maps(straight(), width=8, tiles=(1, 0))
    with pytest.raises(YarnError, match="do not repeat; expected a cell on a lattice"):
        texture_maps(YarnSet.from_curves([ring([0, 0, 0])], closed=[True], radius=0.1), width=8)
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(FileError, match="choose another folder"):
        write_textures(tmp_path / "file", texture_maps(straight(), width=4))
