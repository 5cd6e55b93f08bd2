# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Comparisons with published measurements: deviations, errors, what is kept, and the quantities that are computed."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from benchmarks.published.comparison import (
    TITLES,
    Claim,
    Curve,
    Figure,
    Title,
    cells_of,
    error_of,
    item_of,
    kept,
    passed,
)
from benchmarks.published.drape_meter import SPECIMEN, folds, shadow
from benchmarks.published.industrial_patterns import Solid, fitted
from benchmarks.published.loose_monofilament import law
from benchmarks.published.validation_page import table_of


def figure(ours: float, low: float = 2.0, high: float = 4.0, **more) -> Figure:
    return Figure(quantity="q", published=(low, high), ours=ours, sure="2nd", **more)


def test_a_deviation_is_relative_to_the_nearest_end_of_the_range():
    assert [figure(ours).deviation for ours in (1.0, 2.0, 3.0, 5.0)] == [-0.5, 0.0, 0.0, 0.25]
    assert figure(5.0, within=0.25).passes and not figure(5.0, within=0.2).passes


def test_the_error_is_the_root_mean_square_of_the_figures_that_count():
    items = [figure(1.0), figure(3.0), figure(100.0, counts=False), "text", ["cell"]]
    assert error_of(items) == pytest.approx(math.sqrt(0.125))
    assert error_of(["text"]) is None
    assert passed([*items, Claim(quantity="c", published="a", ours="a", passes=True, sure="page")]) == (2, 4)


def test_what_is_kept_comes_back():
    items = [
        figure(1.0), Claim(quantity="c", published="a", ours="b", passes=False, sure="page"), Title("t"), "text",
        ["a", "1"], Curve(panel="p", label="l", x=(0.0, 1.0), y=(0.0, 2.0)),
    ]  # fmt: skip
    assert [item_of(json.loads(json.dumps(kept(item)))) for item in items] == items


def test_figures_that_follow_one_another_are_one_table_and_titles_part_tables():
    items = [figure(1.0), Curve(panel="p", label="l", x=(), y=()), figure(3.0), Title("t"), ["a", "b"], ["1", "2"]]
    assert cells_of(items).count(TITLES) == 1
    assert table_of(items).count("\n") == 3  # titles, line and two figures
    assert table_of(items, "t") == "| a | b |\n|---|---|\n| 1 | 2 |"


def test_the_law_of_the_monofilament_has_the_published_shape():
    shape = [law(strain) / law(0.1) for strain in (0.05, 0.15, 0.2, 0.3, 0.4)]
    assert shape == pytest.approx([0.52, 1.46, 1.90, 2.77, 3.63], abs=0.01)  # tensions with two decimals


def test_a_solid_is_found_from_its_own_tensions():
    one = np.linspace(1.0, 1.3, 7)
    stretches = np.concatenate([np.stack([one, np.ones(7)], axis=1), np.stack([np.ones(7), one], axis=1)])
    solid = Solid(120.0, 2.5, np.radians(41.0), 0.0)
    found = fitted(stretches, solid.tensions(stretches))
    # The last grid has steps of 0.0007 in b and 0.004 degrees.
    assert (found.b, np.degrees(found.angle)) == pytest.approx((2.5, 41.0), abs=0.01)
    assert found.a == pytest.approx(120.0, rel=1e-3)


def test_the_shadow_of_a_flat_specimen_is_its_area_and_its_hem_has_the_folds_that_it_is_given():
    around = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    rest = np.concatenate([[[0.0, 0.0]], SPECIMEN * np.stack([np.cos(around), np.sin(around)], axis=1)])
    triangles = np.array([[0, 1 + k, 1 + (k + 1) % 60] for k in range(60)])
    flat = np.stack([rest[:, 0], np.zeros(61), rest[:, 1]], axis=1)
    polygon = 30.0 * SPECIMEN**2 * np.sin(2.0 * np.pi / 60.0)
    assert shadow(flat, triangles) == pytest.approx(polygon, rel=0.005)  # a pixel at the border
    waved = flat * (1.0 - 0.1 * np.concatenate([[0.0], 1.0 + np.cos(5.0 * around)]))[:, None]
    assert folds(waved, rest) == 5
