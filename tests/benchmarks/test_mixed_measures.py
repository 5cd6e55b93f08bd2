# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The measures by which mixed runs are compared with runs with yarns everywhere."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.measures.mixed.node_errors import all_nodes, position_error, spectrum_error, wrinkle_spectrum
from stitchmesh.mixed.layout.weave import lay_weave
from tests.mixed.placement.sheets import sheet

SHEET = sheet(4, 1, side=4.0)
YARNS = lay_weave(SHEET.cloth, [[1, 0], [0, 1]], ends=4.0, picks=4.0)
FLAT = np.column_stack([YARNS.position, np.zeros(YARNS.node_count)])
ALL = np.ones(YARNS.node_count, dtype=bool)
UP = (0.0, 0.0, 1.0)


def test_a_shift_of_one_spacing_is_an_error_of_one() -> None:
    assert position_error(FLAT + np.array([0.15, 0.0, -0.2]), FLAT, 0.25) == pytest.approx(1.0, rel=1e-12)  # rounding


def test_a_wave_is_one_line_of_the_spectrum_whatever_the_slope() -> None:
    along = FLAT[:, 0]
    wave = FLAT.copy()
    wave[:, 2] = 0.1 * np.cos(2.0 * np.pi * 3.0 * along / 4.0)
    spectrum = wrinkle_spectrum(YARNS, ALL, wave, UP)
    assert spectrum.argmax() == 2
    # the nearest line of three cosine waves over 16 nodes has a slope of its own
    assert spectrum[2] == pytest.approx(0.1, rel=1e-2)
    tilted = wave + np.outer(along, [0.0, 0.0, 0.5])
    assert np.abs(wrinkle_spectrum(YARNS, ALL, tilted, UP) - spectrum).max() < 1e-13  # rounding of the fitted line
    assert np.abs(wrinkle_spectrum(YARNS, ALL, FLAT, UP)).max() < 1e-15
    assert spectrum_error(spectrum, spectrum) == 0.0 and spectrum_error(2.0 * spectrum, spectrum) == 1.0


def test_nodes_outside_the_region_lie_on_the_triangles() -> None:
    own = sheet(6, 2)
    region = own.region(own.patch.near((0.5, 0.5), 0.2))
    vertices = own.patch.vertices * [1.1, 0.9, 1.0]
    moved = own.patch.nodes[region.nodes] + [0.0, 0.0, 0.3]
    found = all_nodes(region, vertices, moved)
    assert np.array_equal(found[region.nodes], moved)
    outside = np.setdiff1d(np.arange(len(own.patch.nodes)), region.nodes)
    assert np.abs(found[outside] - (own.patch.nodes * [1.1, 0.9, 1.0])[outside]).max() < 1e-14  # rounding
