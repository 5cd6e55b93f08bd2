# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patterns that are moved or mirrored are the same fabrics, turned around a tube or seen in a mirror."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import apply_pattern, parse_pattern, pattern_names, read_pattern
from stitchmesh.patterns.charts.knit_chart import knit_chart
from stitchmesh.patterns.library import FAMILIES, family_of
from stitchmesh.patterns.moved import mirrored_pattern, possible_shifts, shifted_pattern
from stitchmesh.selection.parts import face_centres
from tests.editing.fabrics import around, flat


@pytest.mark.parametrize("name", ["rope-cable", "eyelet-lace", "twisted-rib", "half-cardigan"])
def test_a_mirrored_pattern_is_its_chart_in_a_mirror(name):
    pattern = read_pattern(name)
    mirrored = mirrored_pattern(pattern)
    assert mirrored_pattern(mirrored) == pattern
    assert mirrored.rows == knit_chart(pattern).mirrored(upwards=False).pattern().rows


def test_a_shifted_pattern_is_turned_around_a_tube_and_moved_upwards():
    """The tube has 12 wales and 8 rows above its cast-on, whole repeats of the pattern."""
    pattern = parse_pattern("chart colours:\n0011\n0122\n")
    tube = around(12, 9)
    laid = apply_pattern(tube, pattern).yarn[12:].reshape(8, 12)
    moved = apply_pattern(tube, shifted_pattern(pattern, 3, 1)).yarn[12:].reshape(8, 12)
    assert np.array_equal(moved, np.roll(laid, (1, 3), axis=(0, 1)))


@pytest.mark.parametrize(
    ("wales", "remainder", "turn"), [(10, "centre", 0.0), (13, "centre", 2.5), (16, "stretch", 1.0)]
)
def test_a_centred_pattern_has_the_middle_of_a_repeat_in_the_middle_of_the_front(wales, remainder, turn):
    """The pattern has a purl wale in the middle of five; the tube is turned by an angle about its axis."""
    fabric = around(wales, 5)
    turned = fabric.vertices @ np.array([[np.cos(turn), 0, -np.sin(turn)], [0, 1, 0], [np.sin(turn), 0, np.cos(turn)]])
    laid = apply_pattern(replace(fabric, vertices=turned), parse_pattern("round 1: k2 p k2"), remainder=remainder,
                         centre=True)  # fmt: skip
    purled = face_centres(laid, np.flatnonzero((laid.stitch == Stitch.PURL) & (laid.row == 1)))
    aside = np.abs(np.arctan2(purled[:, 0], purled[:, 2])).min()
    # Half a wale, and half of it again because places are whole halves of a wale.
    assert aside <= 0.75 * 2 * np.pi / wales


@pytest.mark.parametrize(("columns", "purled"), [(10, [4]), (21, [5, 10, 15])])
def test_a_centred_pattern_has_the_middle_of_a_repeat_in_the_middle_of_flat_rows(columns, purled):
    laid = apply_pattern(flat(columns, 3), parse_pattern("round 1: k2 p k2"), centre=True)
    assert np.flatnonzero(laid.stitch[columns : 2 * columns] == Stitch.PURL).tolist() == purled


@pytest.mark.parametrize("name", ["twisted-rib", "checks"])
def test_shifts_add_up_and_whole_repeats_change_nothing(name):
    pattern = read_pattern(name)
    assert shifted_pattern(pattern, pattern.width, -pattern.height) == pattern
    assert shifted_pattern(shifted_pattern(pattern, -1, 1), 1, -1) == pattern


def test_a_shift_that_would_cut_a_cable_is_refused():
    with pytest.raises(ParameterError, match=r"row 1: cannot be shifted by 3 columns, because .* a cable"):
        shifted_pattern(read_pattern("rope-cable"), 3)
    assert possible_shifts(read_pattern("rope-cable")) == (1, 5)  # it has a purl stitch on each side
    assert possible_shifts(read_pattern("rib2x2")) == (1, 2, 3)
    with pytest.raises(ParameterError, match="does not repeat upwards; shift it by columns only"):
        shifted_pattern(parse_pattern("row 1 RS: ky\nrow 2 WS: p2"), 0, 1)


def test_every_pattern_of_the_library_has_its_family():
    names = {name: family_of(read_pattern(name)) for name in pattern_names()}
    assert set(names.values()) == set(FAMILIES)
    known = {
        "rib2x2": "Knit and purl", "rope-cable": "Cables", "eyelet-lace": "Lace", "linen-stitch": "Slipped and tucked",
        "peerie": "Colours",
    }  # fmt: skip
    assert names | known == names
