# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns by name, gauges as text, and the sizes that follow from them."""

from __future__ import annotations

import math

import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError
from stitchmesh.yarn.stitch_size import StitchMeasures, stitch_size
from stitchmesh.yarn.yarn_presets import parse_gauge, yarn_for_gauge, yarn_names

PUBLISHED = {
    "lace": (33, 40, 0.141, 0.278, 3.9),
    "fingering": (27, 32, 0.149, 0.344, 4.6),
    "sport": (23, 26, 0.175, 0.415, 4.7),
    "dk": (21, 24, 0.203, 0.452, 4.4),
    "worsted": (16, 20, 0.242, 0.564, 4.7),
    "bulky": (12, 15, 0.299, 0.753, 5.0),
    "super-bulky": (6, 11, 0.363, 1.195, 6.6),
}
"""Stitches in 4 inches (Craft Yarn Council); apparent diameter [cm], stitch width [cm], and width over apparent radius,
computed by hand from the middles of the published ranges."""


def yarns():
    return [sm.Yarn.named(name) for name in yarn_names()]


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_yarn_has_the_published_sizes(name):
    low, high, diameter, width, ratio = PUBLISHED[name]
    yarn = sm.Yarn.named(name)
    half = 0.5e-3  # the table above is rounded to three decimals, its last column to one
    assert 2 * yarn.apparent_radius == pytest.approx(diameter, abs=half)
    assert yarn.stitch_width == pytest.approx(width, abs=half)
    assert yarn.stitch_width / yarn.apparent_radius == pytest.approx(ratio, abs=0.05)
    assert low <= yarn.gauge.stitches * 1.016 <= high  # 4 inches are 10.16 cm


def test_the_core_of_a_yarn_suits_its_stitches():
    for yarn in yarns():
        assert yarn.core_radius < yarn.apparent_radius
        assert yarn.stitch_width == pytest.approx(8 * yarn.core_radius)  # the default of a garment, an eighth
        # Peirce's compact loop has 16.67 diameters, and Munden's constant 4.06 gives it a width of 8.2 radii
        assert yarn.loop_length / (2 * yarn.core_radius) == pytest.approx(16.67 * 8 / 8.2, rel=2e-3)


def test_yarns_of_the_table_have_nearly_one_density():
    """Weight and wraps come from different sources; spun wool of any thickness fills its cross-section alike."""
    density = [yarn.grams_per_metre / 100 / (math.pi * yarn.apparent_radius**2) for yarn in yarns()]
    assert all(0.09 < found < 0.15 for found in density)  # [g/cm3]; lace, whose wraps are only bounded, is lightest


@pytest.mark.parametrize(
    ("other", "name"),
    [("sock", "fingering"), ("DK", "dk"), ("super_chunky", "super-bulky"), ("light worsted", "dk")],
)
def test_yarns_have_other_names(other, name):
    assert sm.Yarn.named(other) == sm.Yarn.named(name)


def test_an_unknown_yarn_is_refused_with_the_nearest_name():
    with pytest.raises(ParameterError, match=r"^yarn: got 'worstad'; expected worsted$"):
        sm.Yarn.named("worstad")
    with pytest.raises(ParameterError, match=r"^yarn: got 'xyz'; expected lace, fingering, .*cotton-elastane$"):
        sm.Yarn.named("xyz")


def test_a_yarn_of_ones_own_is_checked():
    with pytest.raises(ParameterError, match=r"^yarn 'mine': core_radius: got 0.0; expected a positive number$"):
        sm.Yarn("mine", 0.0, 0.1, 0.5, sm.Gauge(20))
    with pytest.raises(ParameterError, match=r"core_radius 0.2 cm and apparent_radius 0.1 cm; expected a core inside"):
        sm.Yarn("mine", 0.2, 0.1, 0.5, sm.Gauge(20))


@pytest.mark.parametrize(("text", "counts"), [("22", (22, 28.6)), ("22x30", (22, 30)), ("17.5X23", (17.5, 23))])
def test_a_gauge_is_read_from_text(text, counts):
    found = parse_gauge(text)
    assert (found.stitches, found.rows) == pytest.approx(counts)


@pytest.mark.parametrize("text", ["wide", "22x30x4", "22xinf"])
def test_a_malformed_gauge_is_refused(text):
    with pytest.raises(ParameterError, match=rf"^gauge: got '{text}'; expected stitches in 10 cm such as 22, or"):
        parse_gauge(text)


@pytest.mark.parametrize("text", ["-3", "22x0"])
def test_a_gauge_of_no_stitches_is_refused(text):
    with pytest.raises(ParameterError, match=r"^gauge: got (0.0|-3.0) (stitches|rows) in 10 cm; expected a positive"):
        parse_gauge(text)


def test_the_yarn_of_a_gauge_is_the_one_that_is_knitted_at_it():
    for yarn in yarns():
        assert yarn_for_gauge(yarn.gauge) == yarn
    assert yarn_for_gauge(sm.Gauge(22)).name == "dk"


def test_sizes_follow_from_the_yarn_unless_they_are_given():
    dk = sm.Yarn.named("dk")
    assert stitch_size() == StitchMeasures()
    assert stitch_size("dk") == StitchMeasures(
        stitch_width=dk.stitch_width, stitch_height=dk.stitch_height, yarn_radius=dk.core_radius,
        drawn_radius=dk.apparent_radius, loop_length=dk.loop_length, mass_per_length=dk.grams_per_metre / 100,
    )  # fmt: skip
    given = {"stitch_width": 0.6, "stitch_height": 0.5, "yarn_radius": 0.07, "loop_length": 2.0}
    given |= {"mass_per_length": 0.001}
    assert stitch_size(**given) == StitchMeasures(**given)
    assert stitch_size(dk, **given) == StitchMeasures(**given, drawn_radius=dk.apparent_radius)


def test_a_stitch_width_is_a_gauge_of_the_yarn():
    wide = stitch_size("dk", stitch_width=0.6)
    assert wide == stitch_size("dk", sm.Gauge(10 / 0.6))
    assert wide.loop_length == pytest.approx(4.06 * 0.6)
    assert wide.yarn_radius == sm.Yarn.named("dk").core_radius


def test_a_gauge_alone_sets_the_yarn_that_suits_it():
    size = stitch_size(None, "20x28")
    assert (size.stitch_width, size.stitch_height, size.drawn_radius) == (0.5, pytest.approx(10 / 28), None)
    assert size.yarn_radius == pytest.approx(0.5 / 8)


def test_sizes_that_contradict_each_other_are_refused():
    with pytest.raises(ParameterError, match=r"^stitch width: got 0.5 cm and a gauge of 22 stitches and 28.6 rows in"):
        stitch_size(None, "22", stitch_width=0.5)
    with pytest.raises(ParameterError, match=r"^stitch height: got 0.5 cm and a gauge of 22 stitches"):
        stitch_size("dk", "22x30", stitch_height=0.5)
    with pytest.raises(ParameterError, match=r"^stitch width: got -1 cm; expected a positive number$"):
        stitch_size("dk", stitch_width=-1)


def test_pictures_draw_no_yarn_thinner_than_its_core():
    assert stitch_size("dk", yarn_radius=0.2).drawn_radius == 0.2
