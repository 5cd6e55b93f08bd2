# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The radius of yarns is recovered from their curves alone."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.radius_estimate import estimate_radius
from tests.gallery import shared
from tests.io.yarn_sets import ring


def coil(points: int, pitch: float = 0.2) -> YarnSet:
    """A helix of ten turns with radius 1 cm; the pitch is in cm."""
    turn = np.linspace(0, 20 * np.pi, points)
    curve = np.stack([np.cos(turn), np.sin(turn), pitch * turn / (2 * np.pi)], axis=1)
    return YarnSet.from_curves([curve], closed=[False], radius=1.0)


def plain_weave(spacing: float, radius: float, count: int = 12) -> YarnSet:
    """Sinusoidal yarns over and under each other, which touch only where they cross."""
    along = np.arange(0.5, count, 0.25)
    waves = [radius * np.cos(np.pi * (along + number)) for number in range(count)]
    warp = [np.stack([spacing * along, 0 * along + spacing * n, w], axis=1) for n, w in enumerate(waves)]
    weft = [np.stack([0 * along + spacing * n, spacing * along, -w], axis=1) for n, w in enumerate(waves)]
    return YarnSet.from_curves(warp + weft, closed=[False] * (2 * count), radius=1.0)


def test_stacked_rings_touch_at_their_distance():
    yarns = YarnSet.from_curves([ring([0, 0, 0.3 * k]) for k in range(4)], closed=[True] * 4, radius=1.0)
    # Samples of neighbouring rings lie exactly above one another, up to rounding.
    assert estimate_radius(yarns) == pytest.approx(0.15, rel=1e-9)


@pytest.mark.parametrize("points", [400, 2000])
def test_a_coil_touches_at_its_pitch_for_any_number_of_control_points(points):
    slope = np.arctan(0.2 / (2 * np.pi))
    # The nearest point of the next turn lies perpendicular to the strand, at pitch * cos(slope). The chords of 160
    # samples per turn add an error of about 1e-6.
    assert estimate_radius(coil(points)) == pytest.approx(0.1 * np.cos(slope), rel=1e-4)


def test_a_loose_weave_touches_at_its_crossings():
    # The control points lie on a cosine, h = 45 degrees apart; the B-spline reaches (2 + cos h) / 3 of its amplitude.
    # Beside the crossing the curves are closer by about 0.2 %.
    assert estimate_radius(plain_weave(2.0, 0.1)) == pytest.approx(0.1 * (2 + np.sqrt(0.5)) / 3, rel=5e-3)


def test_the_estimate_scales_with_the_yarns_and_does_not_change_when_they_move():
    yarns = coil(400)
    moved = replace(yarns, points=7.0 * yarns.points[:, [1, 2, 0]] + 30.0)
    assert estimate_radius(moved) == pytest.approx(7.0 * estimate_radius(yarns), rel=1e-9)  # Rounding at 30 cm.


def test_thick_and_thin_yarn_on_the_same_stitches_are_distinguished():
    fabric = sm.tessellate(sm.label(sm.read_mesh("hat")), stitch_width=2.0)
    for radius in (0.08, 0.16):
        yarns = sm.generate_yarns(fabric, yarn_radius=radius)
        # The strands of a crossing in a stitch template are 0.82 diameters apart, before contact forces separate them.
        assert 0.8 * radius < estimate_radius(yarns) < 0.9 * radius


@pytest.mark.parametrize(("name", "loop_length"), [("glove.bcc", 2.63), ("knittube.bcc", 2.76)])
def test_real_plain_knits_have_the_tightness_of_plain_knits(name, loop_length):
    # The files store no radius. Their loop length [cm] is the length of a yarn divided by its number of loops (median
    # of all yarns). A loop of plain knit is 16.7 diameters long where loops just touch, and shorter in a tight fabric.
    radius = estimate_radius(sm.read_yarns(shared("yarns") / name, radius=1.0))
    assert 13.0 < loop_length / (2 * radius) < 17.0


def test_the_radius_of_a_single_ring_and_of_rings_in_one_place_cannot_be_estimated():
    alone = YarnSet.from_curves([ring([0, 0, 0])], closed=[True], radius=1.0)
    with pytest.raises(ParameterError, match=r"never come close to each other.*give it \(--yarn-radius\)"):
        estimate_radius(alone)
    with pytest.raises(ParameterError, match="never come close"):
        estimate_radius(YarnSet.from_curves([ring([0, 0, 0])] * 2, closed=[True] * 2, radius=1.0))


def test_the_memory_of_the_estimate_has_a_bound():
    rings = [ring([3.0 * column, 0, 0.3 * k]) for column in range(60) for k in range(12)]
    yarns = YarnSet.from_curves(rings, closed=[True] * len(rings), radius=1.0)
    tracemalloc.start()
    estimate_radius(yarns)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # 4,096 samples with 64 neighbours each take about 15 MB at once, the samples themselves a few; all samples of all
    # windows at once took 150 MB.
    assert most < 40e6
