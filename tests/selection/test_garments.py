# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The borders and the parts of the project's garments have the names that a knitter would use."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stitchmesh.editing.spiral import make_spiral
from stitchmesh.errors import ParameterError
from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.mesh import StitchMesh
from stitchmesh.selection import borders, select
from stitchmesh.tessellate import tessellate
from tests.gallery import GARMENTS
from tests.nightly import mostly_at_night
from tests.shaking import shaken

WIDTH = {
    "alien": 2.0, "dress": 2.5, "glove": 0.8, "hat": 1.2, "poncho": 3.0, "sheep": 3.0, "sock": 0.9, "swatch": 1.0,
    "sweater": 2.0,
}  # fmt: skip
"""Stitch widths [cm] that give garments of about a thousand stitches."""
BORDERS = {
    "alien": ["hem", "left cuff", "right cuff", "neck"],
    "dress": ["hem", "left armhole", "right armhole", "neck"],
    "glove": ["cuff", "tip", "tip", "tip", "tip", "tip"],
    "hat": ["hem", "tip"],
    "poncho": ["hem", "neck"],
    "sheep": ["border 0", "left armhole", "right armhole", "left armhole", "right armhole", "neck"],
    "sock": ["cuff", "tip"],
    "swatch": ["border 0"],
    "sweater": ["hem", "left cuff", "right cuff", "neck"],
    "tea_cozy": ["hem", "right armhole", "left armhole", "tip"],
}


@cache
def garment(name: str, width: float | None = None) -> StitchMesh:
    path = next(path for path in GARMENTS if path.stem == name)
    return tessellate(label(read_mesh(path, unit="cm")), stitch_width=width or WIDTH.get(name, 1.2))


def test_every_garment_is_tested():
    assert {path.stem for path in GARMENTS} == set(BORDERS)


@pytest.mark.parametrize("name", BORDERS)
def test_borders_are_named_by_where_they_lie(name):
    assert [border.name for border in borders(garment(name))] == BORDERS[name]


@pytest.mark.parametrize("name", ["glove", "sheep", "tea_cozy"])
def test_the_names_do_not_depend_on_the_width_of_the_stitches(name):
    assert [border.name for border in borders(garment(name, 2 * WIDTH.get(name, 1.2)))] == BORDERS[name]


@pytest.mark.decides
@pytest.mark.parametrize("name", mostly_at_night(BORDERS, by_day=("glove", "sheep", "sweater")))
def test_names_and_parts_do_not_depend_on_rounding(name):
    fabric = garment(name)
    for seed in range(3):
        other = replace(fabric, vertices=shaken(fabric.vertices, seed))
        assert [border.name for border in borders(other)] == BORDERS[name]
        for part in ("front", "left", "front panel 4"):
            np.testing.assert_array_equal(select(other, part), select(fabric, part))


@pytest.mark.parametrize("name", ["alien", "dress", "glove", "sweater"])
def test_front_and_back_and_left_and_right_share_out_all_faces(name):
    """A face is in front or at the back, and on the left or on the right, unless one of the two parts is empty."""
    fabric, everything = garment(name), set(range(garment(name).face_count))
    for one, other in (("front", "back"), ("left", "right"), ("sleeves", "body")):
        try:
            parts = set(select(fabric, one).tolist()), set(select(fabric, other).tolist())
        except ParameterError:
            continue
        assert parts[0] | parts[1] == everything and not parts[0] & parts[1]


@pytest.mark.parametrize("name", ["dress", "poncho", "tea_cozy"])
def test_the_front_of_a_garment_is_where_the_wearer_looks(name):
    """On the body of an upright garment, the faces in front have larger z than the middle of their row."""
    fabric = garment(name)
    body = select(fabric, "body")
    front = np.intersect1d(select(fabric, "front"), body)
    back = np.setdiff1d(body, front)
    z = fabric.corner_position[fabric.face_start[:-1], 2]
    assert z[front].mean() > 0.0 > z[back].mean()
    assert len(front) == pytest.approx(len(back), rel=0.1)  # The meshes are nearly symmetric in front and at the back.


def test_the_instep_of_a_sock_is_its_front():
    """The foot points forward, and its upper side continues the front of the leg."""
    fabric = garment("sock")
    position = fabric.corner_position[fabric.face_start[:-1]]
    foot = np.flatnonzero(position[:, 2] > 8.0)
    front = np.isin(foot, select(fabric, "front"))
    assert position[foot[front], 1].mean() > position[foot[~front], 1].mean() + 2.0


def test_the_sleeves_of_a_sweater_are_its_tubes_up_to_the_body():
    fabric = garment("sweater")
    left, right = select(fabric, "left sleeve"), select(fabric, "right sleeve")
    assert len(left) == len(right) and not np.intersect1d(left, right).size
    np.testing.assert_array_equal(np.union1d(left, right), select(fabric, "sleeves"))
    x = fabric.corner_position[fabric.face_start[:-1], 0]
    assert x[left].min() > 0.0 > x[right].max()
    assert np.isin(select(fabric, "cuffs 5"), select(fabric, "sleeves")).all()
    assert not np.isin(select(fabric, "hem 5 or neck 5"), select(fabric, "sleeves")).any()
    for row in np.unique(fabric.row[left]):
        assert np.isin(np.flatnonzero(fabric.row == row), left).all()  # Whole rows.


def test_the_sleeve_of_a_glove_ends_at_the_thumb():
    fabric = garment("glove")
    y = fabric.corner_position[fabric.face_start[:-1], 1]
    assert y[select(fabric, "sleeves")].max() < y[select(fabric, "tips")].min()


@pytest.mark.parametrize("name", ["dress", "sock", "swatch"])
def test_a_garment_without_sleeves_says_so(name):
    with pytest.raises(ParameterError, match="sleeves: the fabric has none; a sleeve is a tube of rows"):
        select(garment(name), "sleeves")


def test_a_spiral_has_the_parts_of_its_rings():
    """A turn of a spiral is a row; a band along its first turn has a step at the seam, one stitch for each row."""
    rings = garment("hat")
    turns = make_spiral(rings)
    assert [border.name for border in borders(turns)] == BORDERS["hat"]
    assert len(np.setxor1d(select(turns, "front"), select(rings, "front"))) < 0.1 * rings.face_count
    band = select(turns, "hem 4")
    assert set(turns.row[band]) <= {0, 1, 2, 3, 4} and np.isin(select(turns, "rows 0-3"), band).all()


def test_the_panel_of_a_sweater_lies_in_the_middle_of_its_front():
    fabric = garment("sweater", 1.2)
    panel = select(fabric, "front panel 10 and rows 0-20")
    position = fabric.corner_position
    middle = np.add.reduceat(position[:, 0], fabric.face_start[:-1])[panel] / 4
    assert abs(middle.mean()) < 1.2 and np.isin(panel, select(fabric, "front")).all()
    assert np.bincount(fabric.row[panel]).tolist() == [10] * 21
