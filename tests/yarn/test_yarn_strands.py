# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Strands of yarns: plies fill the body, turn once in a lay, and continue over joints."""

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.lattice import Lattice
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.yarn_look import YarnLook
from stitchmesh.yarn.yarn_strands import FIBRE, HAIR, PLY, YarnStrands, yarn_strands

RADIUS = 0.05
EVEN = {"unevenness": 0.0, "neps": 0.0}


def straight(length: float = 20.0) -> YarnSet:
    line = np.stack([np.linspace(0.0, length, 120), np.zeros(120), np.zeros(120)], axis=1)
    return YarnSet.from_curves([line], closed=[False], radius=RADIUS)


def ring() -> YarnSet:
    turn = 2.0 * np.pi * np.arange(40) / 40
    loop = np.stack([np.cos(turn), np.sin(turn), 0.2 * np.sin(2.0 * turn)], axis=1)
    return YarnSet.from_curves([loop], closed=[True], radius=RADIUS)


def repeating() -> YarnSet:
    """Return a wave that continues in the next period, which is 2 cm away along x."""
    place = np.arange(30) / 30
    wave = np.stack([2.0 * place, 0.4 * np.sin(2.0 * np.pi * place), 0.3 * np.cos(2.0 * np.pi * place)], axis=1)
    yarns = YarnSet.from_curves([wave], closed=[True], radius=RADIUS)
    lattice = Lattice(np.array([[2.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
    return replace(yarns, lattice=lattice, lattice_step=np.array([[1, 0]]))


def curves(strands: YarnStrands, kind: int) -> list[np.ndarray]:
    pieces = np.split(strands.points, strands.start[1:-1])
    return [piece for piece, own in zip(pieces, strands.kind, strict=True) if own == kind]


@pytest.mark.parametrize("plies", [1, 2, 6])
def test_plies_reach_to_the_body_and_touch_where_they_are_not_pressed(plies: int) -> None:
    """On a straight yarn, the distance of a ply from the axis plus its radius is the radius of the body."""
    strands = yarn_strands(straight(), YarnLook("wool", plies=plies, fullness=1.0, body=0.8, heather=0.0, **EVEN))
    plied = curves(strands, PLY)
    assert len(plied) == plies
    for ply in plied:
        # the sums are of a few terms of the size of the radius
        np.testing.assert_allclose(np.hypot(ply[:, 1], ply[:, 2]) + strands.radius[0], 0.8 * RADIUS, atol=1e-12)
    if plies > 1:
        np.testing.assert_allclose(np.linalg.norm(plied[0] - plied[1], axis=1), 2.0 * strands.radius[0], atol=1e-12)


@pytest.mark.parametrize(("twist", "sign"), [("Z", 1.0), ("S", -1.0)])
def test_plies_turn_once_in_a_lay_in_the_direction_of_the_twist(twist: str, sign: float) -> None:
    yarns = straight()
    strands = yarn_strands(yarns, YarnLook("wool", plies=2, lay=6.0, twist=twist, **EVEN))
    ply = curves(strands, PLY)[0]
    angle = np.unwrap(np.arctan2(ply[:, 2], ply[:, 1]))
    turns = float(yarns.lengths.sum()) / (6.0 * 2.0 * RADIUS)
    # a right-handed helix around x turns from y to z
    assert angle[-1] - angle[0] == pytest.approx(sign * 2.0 * np.pi * turns, rel=1e-9)


@pytest.mark.parametrize("yarns", [ring(), repeating()], ids=["ring", "lattice"])
def test_plies_and_fibres_continue_over_the_joint(yarns: YarnSet) -> None:
    """The step over the joint turns no more than the others: a strand is smooth there too."""
    strands = yarn_strands(yarns, YarnLook("tweed"), fibres=3, samples=8)
    for number in np.flatnonzero(strands.kind != HAIR):
        own = slice(strands.start[number], strands.start[number + 1])
        assert strands.closed[number]
        points, radius = strands.points[own], strands.radius[own]
        around = np.concatenate([points, points[:2] + strands.shift[number]])
        steps = np.diff(around, axis=0)
        bends = np.linalg.norm(np.diff(steps, axis=0), axis=1)
        # the joint is one place of many alike; the noise of flecks varies by less than half between neighbours
        assert bends[-2:].max() <= 1.5 * bends[:-2].max()
        jumps = np.abs(np.diff(np.append(radius, radius[0])))
        assert jumps[-1] <= 1.5 * jumps[:-1].max()


def test_the_same_yarn_has_the_same_strands_and_another_yarn_others() -> None:
    line = straight().points
    both = YarnSet.from_curves([line, line], closed=[False, False], radius=RADIUS)
    first, second = (yarn_strands(both, YarnLook("tweed"), fibres=2, hair=1.0) for _ in range(2))
    np.testing.assert_array_equal(first.points, second.points)
    np.testing.assert_array_equal(first.colour, second.colour)
    one, other = (first.points[np.repeat(first.yarn, np.diff(first.start)) == yarn] for yarn in (0, 1))
    assert one.shape != other.shape or np.abs(one - other).max() > 0.1 * RADIUS


def test_a_part_of_a_yarn_has_the_thickness_and_colours_of_the_whole() -> None:
    yarns, look = straight(), YarnLook("tweed", plies=1)
    whole = yarn_strands(yarns, look)
    part = yarn_strands(yarns, look, segments=np.arange(40, 60))
    own = slice(3 * 40, 3 * 60)
    # places are sums of lengths in another order
    np.testing.assert_allclose(part.radius[:-1], whole.radius[own], rtol=1e-9)
    assert np.abs(part.colour[:-1].astype(int) - whole.colour[own]).max() <= 1


def test_thickness_varies_as_much_as_the_look_says() -> None:
    strands = yarn_strands(straight(300.0), YarnLook("monofilament", unevenness=0.1))
    found = strands.radius / RADIUS
    # 375 cells of the longest noise: their standard deviation is known to 4 %, the mean to 0.5 % of the thickness
    assert found.mean() == pytest.approx(1.0, abs=0.02) and found.std() == pytest.approx(0.1, rel=0.15)


def test_fibres_fill_the_ply_and_stay_in_it() -> None:
    look = YarnLook("wool", plies=1, **EVEN)
    strands = yarn_strands(straight(), look, fibres=60)
    reach = np.concatenate([np.hypot(fibre[:, 1], fibre[:, 2]) for fibre in curves(strands, FIBRE)]) / RADIUS
    assert reach.max() <= 1.05 and reach.max() > 0.95 and reach.min() > 0.4


def test_hair_has_its_density_and_mean_length() -> None:
    yarns, look = straight(60.0), YarnLook("mohair")
    hair = curves(yarn_strands(yarns, look, hair=1.0), HAIR)
    diameters = float(yarns.lengths.sum()) / (2.0 * RADIUS)
    assert len(hair) == pytest.approx(look.hair_density * diameters, abs=2)
    lengths = [np.linalg.norm(np.diff(one, axis=0), axis=1).sum() for one in hair]
    # 8,400 lengths with a deviation of 0.66 of their mean; the cut at three means shortens them by 1.5 %
    assert np.mean(lengths) == pytest.approx(look.hair_length * 2.0 * RADIUS, rel=0.04)


def test_marl_and_colours_along_the_yarn() -> None:
    marl = yarn_strands(straight(), YarnLook("monofilament", plies=2, marl=("#ff0000", "#0000ff")))
    half = len(marl.points) // 2
    assert (marl.colour[:half] == [255, 0, 0]).all() and (marl.colour[half:] == [0, 0, 255]).all()
    along = yarn_strands(straight(), YarnLook("monofilament", variegation=("#000000", "#ffffff"), colour_length=20.0))
    light = along.colour[:, 0].astype(int)
    # 20 cm are 200 diameters: ten times dark, light and dark again
    assert np.sum((light[:-1] < 128) & (light[1:] >= 128)) == 10
