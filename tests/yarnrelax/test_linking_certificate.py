# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Linking numbers of known links, and a pull-through that is caught."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from stockinette import flat_patch, tube

from stitchmesh.errors import ParameterError
from stitchmesh.lattice import Lattice
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import linking_certificate
from stitchmesh.yarnrelax.linking import changed_pairs


def ring(centre: tuple[float, float, float], axis: int, points: int = 24) -> np.ndarray:
    angle = np.arange(points) / points * 2 * np.pi
    circle = np.roll(np.stack([0 * angle, np.cos(angle), np.sin(angle)], axis=1), axis, axis=1)
    return circle + np.asarray(centre)


def closed(*curves: np.ndarray) -> YarnSet:
    return YarnSet.from_curves(curves, closed=[True] * len(curves), radius=0.05)


def torus_link(turns: int) -> YarnSet:
    """Two strands that wind around each other ``turns`` times along a circle."""
    angle = np.arange(80) / 80 * 2 * np.pi
    strands = []
    for phase in (0.0, np.pi):
        out, up = 3 + np.cos(turns * angle + phase), np.sin(turns * angle + phase)
        strands.append(np.stack([out * np.cos(angle), out * np.sin(angle), up], axis=1))
    return closed(*strands)


def test_hopf_link_has_linking_number_one() -> None:
    certificate = linking_certificate(closed(ring((0, 0, 0), 0), ring((0, 0, 1), 1)))
    assert abs(certificate[0, 1]) == 1
    assert np.issubdtype(certificate.dtype, np.integer)


@pytest.mark.parametrize("turns", [1, 2, 5, -3])
def test_torus_links_wind_as_often_as_they_were_made_to(turns: int) -> None:
    yarns = torus_link(turns)
    certificate = linking_certificate(yarns)
    # strands that run the same way and wind right-handed are linked by +turns; up grows with the outward phase
    assert abs(certificate[0, 1]) == abs(turns)
    mirrored = replace(yarns, points=yarns.points * [1.0, 1.0, -1.0])
    assert linking_certificate(mirrored)[0, 1] == -certificate[0, 1]
    assert np.sign(certificate[0, 1]) == np.sign(turns) * np.sign(linking_certificate(torus_link(1))[0, 1])


def test_unlinked_rings_have_none() -> None:
    certificate = linking_certificate(closed(ring((0, 0, 0), 0), ring((0, 0, 5), 1), ring((0.2, 0.1, 0.5), 0)))
    assert certificate.nnz == 0


def gauss_integral(first: np.ndarray, second: np.ndarray) -> float:
    """The linking number of two closed polylines as a sum of solid angles (Arai 2013), for comparison."""
    total = 0.0
    for a, b in zip(first, np.roll(first, -1, axis=0), strict=True):
        for c, d in zip(second, np.roll(second, -1, axis=0), strict=True):
            sides = np.array([c - a, d - a, d - b, c - b])
            sides = sides / np.linalg.norm(sides, axis=1, keepdims=True)
            p, q, r, s = sides
            for x, y, z in ((p, q, r), (r, s, p)):
                volume = np.dot(x, np.cross(y, z))
                total += 2 * np.arctan2(volume, 1 + np.dot(x, y) + np.dot(y, z) + np.dot(z, x))
    return total / (4 * np.pi)


def test_agrees_with_the_gauss_integral_on_random_loops() -> None:
    random = np.random.default_rng(11)
    yarns = closed(*(random.normal(size=(7, 3)) for _ in range(4)))
    certificate = linking_certificate(yarns).toarray()
    loops = yarns.sampled(4)
    for i in range(4):
        for j in range(i):
            assert certificate[i, j] == certificate[j, i]
            assert abs(certificate[i, j]) == round(abs(gauss_integral(loops[i], loops[j])))


def test_every_row_of_a_tube_is_unlinked_and_a_pulled_yarn_is_caught() -> None:
    yarns = tube(5, 6)
    before = linking_certificate(yarns)
    assert before.nnz == 0  # knitting unravels: no two rows are linked
    points = yarns.points.copy()
    row = slice(yarns.start[2], yarns.start[3])
    head = np.argmax(points[row, 1])  # the top of one loop, pushed through the loop around it
    outwards = points[row][head] * [1.0, 0.0, 1.0] / np.linalg.norm(points[row][head][[0, 2]])
    points[row.start + head + np.arange(-2, 3)] += 0.5 * outwards
    after = linking_certificate(replace(yarns, points=points))
    assert 2 in changed_pairs(before, after)


def test_open_yarns_are_closed_far_away() -> None:
    certificate = linking_certificate(flat_patch(6, 5))
    assert abs(certificate - certificate.T).nnz == 0


def test_two_crossed_open_yarns_tell_which_lies_above() -> None:
    place = np.linspace(-2.0, 2.0, 9)
    lower = np.stack([place, 0 * place, 0 * place], axis=1)
    crossing = [
        YarnSet.from_curves(
            [lower, np.stack([0 * place, place, 0 * place + height], axis=1)], closed=[False] * 2, radius=0.05
        )
        for height in (0.5, -0.5)
    ]
    above, below = (linking_certificate(yarns)[0, 1] for yarns in crossing)
    assert abs(above - below) == 1


def test_a_lattice_is_refused() -> None:
    yarns = replace(tube(2, 3), lattice=Lattice(np.eye(3)[:2]), lattice_step=np.zeros((2, 2)))
    with pytest.raises(ParameterError, match="lattice"):
        linking_certificate(yarns)
