# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flat, folded and crumpled fabrics, from generated yarns that are folded along known curves."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.lattice import Lattice
from stitchmesh.periodic.fabric_shape import LAYER, FabricShape, FlatFabric, thickness_of
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch import scale_yarns, swatch
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import quality_named
from stitchmesh.yarn import YarnSet
from tests.periodic.free_cells import FREE, free_swatch

pytestmark = pytest.mark.usefixtures("first_state")
DRAFT = quality_named("draft")
Fold = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Maps a coordinate to its place along the same axis and its height."""


def flat_piece(pattern: str = "stockinette", **options: Any) -> tuple[YarnSet, FlatFabric]:
    """A generated repeat, of 16 by 16 stitches by default, and its flat fabric."""
    source = resolve_pattern(pattern)
    fabric, yarns = draw_swatch(source, SwatchOptions(**({"columns": 16, "rows": 16} | options)), DRAFT)
    return yarns, FlatFabric.of(yarns, fabric, source)


def folded(yarns: YarnSet, axis: int, fold: Fold) -> YarnSet:
    """The yarns after (x, z) -> (X(x), z + Z(x)) along an axis; the fold takes one period to one period."""
    assert yarns.lattice is not None
    points, periods = yarns.points.copy(), yarns.lattice.periods.copy()
    points[:, axis], height = fold(yarns.points[:, axis])
    points[:, 2] += height
    periods[axis, axis] = float(fold(np.array([periods[axis, axis]]))[0][0])
    return replace(yarns, points=points, lattice=Lattice(periods))


def zigzag(period: float, slope: float) -> Fold:
    """Two straight parts of equal length, at an angle of +-slope to the plane."""

    def fold(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        along = np.mod(x, period)
        return x * np.cos(slope), np.sin(slope) * np.minimum(along, period - along)

    return fold


def pleat(period: float, height: float) -> Fold:
    """Thirds that run forwards, backwards and forwards, at rising heights that fall again in the last third."""

    def fold(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        whole, along = np.floor(x / period), np.mod(x, period) / period
        back = np.interp(along, [0.0, 1 / 3, 2 / 3, 1.0], [0.0, 1 / 3, 0.0, 1 / 3])
        return (whole / 3 + back) * period, height * np.interp(along, [0.0, 0.5, 1.0], [0.0, 1.0, 0.0])

    return fold


def size(yarns: YarnSet, axis: int) -> float:
    assert yarns.lattice is not None
    return float(yarns.lattice.periods[axis, axis])


@pytest.mark.parametrize("pattern", ["rib2x2", "rope-cable", "checks", "twill-3x2"])
def test_generated_yarns_are_flat(pattern: str) -> None:
    one = {"columns": 1, "rows": 1}
    yarns, flat = flat_piece(pattern, **one)
    shape = flat.shape_of(yarns)
    assert shape.name == "flat"
    assert shape.thickness_ratio <= 1.0 + 1e-12  # rounding; less where the flat fabric has a second layer
    # equal by construction, up to rounding
    assert (shape.course_fold, shape.wale_fold, shape.layers) == pytest.approx((1.0, 1.0, 1.0), rel=1e-12)


def test_fabrics_with_both_faces_are_one_layer_thicker() -> None:
    plain, rib = (flat_piece(name, columns=1, rows=1) for name in ("stockinette", "rib1x1"))
    for (yarns, flat), layers in ((plain, 0), (rib, 1)):
        assert flat.diameters == pytest.approx(thickness_of(yarns) / (2 * yarns.radius[0]) + layers * LAYER, rel=1e-12)


@pytest.mark.parametrize(("axis", "degrees"), [(0, 20.0), (1, 50.0)])
def test_a_zigzag_is_as_much_longer_as_its_slope_says(axis: int, degrees: float) -> None:
    slope = np.radians(degrees)
    yarns, flat = flat_piece()
    shape = flat.shape_of(folded(yarns, axis, zigzag(size(yarns, axis), slope)))
    found = (shape.course_fold, shape.wale_fold)
    # two of sixteen steps pass over a bend; there they are shorter, at most by the whole difference
    assert found[axis] == pytest.approx(1.0 / np.cos(slope), rel=2 / 16)
    assert found[1 - axis] == pytest.approx(1.0, abs=1e-9)  # heights along the other axis are equal
    assert shape.layers == pytest.approx(1.0, abs=1e-9)
    assert shape.name == "folded"  # a sixteen stitches wide zigzag is higher than any yarn is thick


def test_a_pleat_has_three_layers() -> None:
    yarns, flat = flat_piece()
    high = flat.thickness(yarns)
    shape = flat.shape_of(folded(yarns, 0, pleat(size(yarns, 0), high)))
    # a third as wide; two of sixteen steps pass over a fold and lose at most their length
    assert shape.layers == pytest.approx(3.0, rel=2 / 16)
    assert shape.name == "folded"


def test_folds_in_both_directions_are_crumpled() -> None:
    yarns, flat = flat_piece()
    once = folded(yarns, 0, zigzag(size(yarns, 0) / 2, np.radians(50.0)))
    assert flat.shape_of(folded(once, 1, zigzag(size(once, 1) / 2, np.radians(50.0)))).name == "crumpled"


def test_shape_does_not_depend_on_size_place_or_turn() -> None:
    yarns, flat = flat_piece()
    bent = folded(yarns, 0, zigzag(size(yarns, 0), np.radians(30.0)))
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    assert bent.lattice is not None
    moved = replace(bent, points=bent.points @ turn.T + 3.0, lattice=Lattice(bent.lattice.periods @ turn.T))
    for other in (moved, scale_yarns(bent, 2.5)):
        found, expected = flat.shape_of(other).report(), flat.shape_of(bent).report()
        assert found.pop("shape") == expected.pop("shape")
        assert found == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("shape", "name"),
    [
        (FabricShape(1.5, 1.0, 1.0, 1.0), "flat"), (FabricShape(1.51, 1.0, 1.0, 1.0), "folded"),
        (FabricShape(1.5, 2.0, 2.0, 1.4), "flat"), (FabricShape(2.0, 1.3, 1.2, 1.0), "folded"),
        (FabricShape(2.0, 1.3, 1.3, 1.0), "crumpled"), (FabricShape(9.0, 1.3, 1.0, 1.0), "folded"),
    ],
)  # fmt: skip
def test_names_of_shapes(shape: FabricShape, name: str) -> None:
    assert shape.name == name


def test_a_swatch_that_lies_on_nothing_folds_and_says_so(caplog: pytest.LogCaptureFixture) -> None:
    soon = replace(DRAFT, max_iterations=800)
    with caplog.at_level(logging.WARNING, "stitchmesh"):
        loose = swatch("checks", **FREE, unsupported=True, quality=soon, device="cpu", progress=False)
        assert free_swatch("stockinette").report["shape"] == "flat"
    assert loose.report["shape"] == "folded" and loose.report["thickness_ratio"] > 1.5
    said = [record.getMessage() for record in caplog.records if record.getMessage().startswith("the fabric is folded")]
    assert len(said) == 1 and "\n" not in said[0] and "let it lie on a table" in said[0]
