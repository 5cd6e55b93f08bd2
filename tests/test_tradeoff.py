# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The measures of the trade-off benchmark tell known differences."""

from __future__ import annotations

import sys
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from stitchmesh.errors import YarnError
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from tests.gallery import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))
tradeoff_measures = import_module("tradeoff_measures")
tradeoff_scenes = import_module("tradeoff_scenes")
tradeoff_plot = import_module("tradeoff_plot")


def scenes() -> list[Any]:
    """A small scene of each kind that is made from a formula."""
    plain, rib = tradeoff_scenes.PLAIN, tradeoff_scenes.RIB
    return [
        tradeoff_scenes.tube("stockinette", plain, 2, 8),
        tradeoff_scenes.tube("rib", rib, 1, 8),
        tradeoff_scenes.cell("stockinette-cell", plain, 1, 1),
        tradeoff_scenes.cell("rib-cell", rib, 2, 4),
    ]


def compared(scene: Any, yarns: YarnSet, reference: YarnSet) -> Any:
    """The difference of two states of a scene."""
    places, others = (tradeoff_measures.places_of(state, scene.per_run) for state in (yarns, reference))
    return tradeoff_measures.difference(places, others, scene.gauge(others), scene.freedom, tradeoff_scenes.RADIUS)


def turned(points: np.ndarray) -> np.ndarray:
    """Points turned by a third about the diagonal, and moved."""
    return points[:, [1, 2, 0]] + np.array([3.0, -7.0, 2.0])


@pytest.mark.parametrize("scene", scenes()[:1], ids=lambda scene: scene.name)
def test_a_tube_moved_as_a_whole_has_no_distance(scene: Any) -> None:
    # the lattice stays where it was, so places are compared rather than spacings
    places = tradeoff_measures.places_of(scene.make(12), scene.per_run)
    moved = tradeoff_measures.aligned(turned(places.points), places.points, scene.freedom)
    # rounding of a singular value decomposition of coordinates of a few centimetres
    np.testing.assert_allclose(moved, places.points, atol=1e-12)


def test_a_mirror_image_is_not_a_rigid_motion() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], dtype=float)
    moved = tradeoff_measures.aligned(corners * [1.0, 1.0, -1.0], corners, "rigid")
    # four corners of a box of sides 1, 2, 3 and their mirror image: no turn brings them together
    assert np.abs(moved - corners).max() > 0.1


@pytest.mark.parametrize("scene", scenes(), ids=lambda scene: scene.name)
def test_a_shifted_copy_has_no_distance(scene: Any) -> None:
    yarns = scene.make(12)
    found = compared(scene, replace(yarns, points=yarns.points + np.array([1.0, -2.0, 0.5])), yarns)
    # rounding of coordinates of a few centimetres, in radii
    assert max(found.rms, found.largest, found.wale_error, found.course_error) < 1e-11


@pytest.mark.parametrize("scene", scenes(), ids=lambda scene: scene.name)
def test_places_are_the_same_in_all_discretisations(scene: Any) -> None:
    found = [compared(scene, scene.make(count), scene.make(48)).rms for count in (12, 24)]
    # a spline through points of a smooth curve nears it with the fourth power of their spacing, the rib's kinks where
    # feet pass through the fabric with the second; a place that moved with the control points would miss by a step
    assert found[0] < 0.1
    assert found[1] < found[0] / 3


@pytest.mark.parametrize("name", ["wale", "course"])
def test_stretching_gives_the_error_of_a_spacing(name: str) -> None:
    scene = tradeoff_scenes.cell("stockinette-cell", tradeoff_scenes.PLAIN, 3, 4)
    yarns = scene.make(12)
    stretch = np.array([1.07, 1.0, 1.0] if name == "wale" else [1.0, 1.07, 1.0])
    lattice = replace(yarns.lattice, periods=yarns.lattice.periods * stretch)
    stretched = replace(yarns, points=yarns.points * stretch, lattice=lattice)
    places = tradeoff_measures.places_of(yarns, scene.per_run)
    gauge = scene.gauge(places)
    moved = replace(
        gauge, wale_shift=gauge.wale_shift * stretch, course_shift=gauge.course_shift * stretch
    )
    before = tradeoff_measures.spacings(gauge, places.points)
    after = tradeoff_measures.spacings(moved, tradeoff_measures.places_of(stretched, scene.per_run).points)
    ratio = dict(zip(["wale", "course"], np.divide(after, before), strict=True))
    # an affine map of a lattice stretches one spacing by its factor and leaves the other; rounding only
    assert ratio.pop(name) == pytest.approx(1.07, rel=1e-12)
    assert ratio.popitem()[1] == pytest.approx(1.0, rel=1e-12)


def test_a_wider_tube_has_the_known_wale_error() -> None:
    scene = tradeoff_scenes.tube("stockinette", tradeoff_scenes.PLAIN, 2, 8)
    yarns = scene.make(12)
    found = compared(scene, replace(yarns, points=yarns.points * [1.05, 1.0, 1.05]), yarns)
    # loops' centres lie on a circle around the axis, which grows by a twentieth; rounding only
    assert found.wale_error == pytest.approx(0.05, rel=1e-9)
    assert found.course_error < 1e-12


def test_distance_is_in_radii() -> None:
    scene = tradeoff_scenes.cell("stockinette-cell", tradeoff_scenes.PLAIN, 2, 2)
    yarns = scene.make(12)
    lifted = yarns.points + np.where(yarns.row == 1, 1.0, -1.0)[:, None] * [0.0, 0.0, 0.3 * tradeoff_scenes.RADIUS]
    found = compared(scene, replace(yarns, points=lifted), yarns)
    # one row 0.3 radii up, as long a one down: the mean stays, every place moved by 0.3 radii
    assert found.rms == pytest.approx(0.3, rel=1e-9)
    assert found.largest == pytest.approx(0.3, rel=1e-9)


def test_scenes_of_other_stitches_are_refused() -> None:
    small, large = (tradeoff_scenes.cell("cell", tradeoff_scenes.PLAIN, 1, count) for count in (1, 2))
    with pytest.raises(YarnError, match="two discretisations of one scene"):
        compared(small, small.make(12), large.make(12))


def test_energy_does_not_depend_on_how_finely_a_curve_is_drawn() -> None:
    scene = tradeoff_scenes.cell("stockinette-cell", tradeoff_scenes.PLAIN, 1, 1)
    material = YarnMaterial.named("stitchmesh")
    coarse, fine = (tradeoff_measures.energy_of(scene.make(count), material, "cpu") for count in (24, 48))
    # the curve itself converges with the fourth power of spacing, its curvature with the second: (1/24)^2 of a loop
    # that turns four times; a sum that went with the number of segments would double
    assert coarse == pytest.approx(fine, rel=0.02)


def test_loops_of_a_yarn_file_are_found_by_their_repeat() -> None:
    scene = tradeoff_scenes.tube("stockinette", tradeoff_scenes.PLAIN, 3, 24)
    made = scene.make(16)
    yarns = replace(made, face=np.arange(len(made.points)), lattice=None, lattice_step=None)
    places = tradeoff_measures.places_of(yarns, 1)
    gauge = tradeoff_scenes._gauge_of_loops(places)
    # every centre is the mean of the 16 control points of a loop, whichever it starts with
    assert set(np.diff(gauge.centre.indptr)) == {16}
    wale, course = tradeoff_measures.spacings(gauge, places.points)
    scale = tradeoff_scenes.RADIUS / tradeoff_scenes.FORMULA_RADIUS
    # rows lie exactly one row height apart; loops on a circle of 24: the chord is 0.3 % shorter than the arc, and
    # the feet, which hold more than half of the yarn, make centres lie off the axis's circle by up to 1 of 24 units
    assert course == pytest.approx(scale * tradeoff_scenes.ROW_HEIGHT, rel=1e-9)
    assert wale == pytest.approx(scale * tradeoff_scenes.STITCH_WIDTH, rel=0.05)


def test_the_front_holds_the_runs_that_none_beats() -> None:
    pairs = [(1.0, 0.5), (2.0, 0.6), (2.0, 0.4), (3.0, 0.1), (4.0, 0.1)]
    rows = [{"seconds": str(seconds), "rms": str(rms)} for seconds, rms in pairs]
    assert tradeoff_plot.pareto(rows) == [(1.0, 0.5), (2.0, 0.4), (3.0, 0.1)]
