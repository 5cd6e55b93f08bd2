# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The drawing of a periodic fabric: copies at the lattice points, parts by colour, and frames that only move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError, YarnError
from stitchmesh.mesh.palette import colours_of
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import PRESETS
from stitchmesh.render.tile_drawing import MOST_PARTS, MOST_TRIANGLES, TileDrawing, draw_tiles
from stitchmesh.yarn import YarnSet


def repeat(name: str) -> YarnSet:
    return draw_swatch(sm.resolve_pattern(name), SwatchOptions(), PRESETS["draft"])[1]


def triangle_count(drawing: TileDrawing) -> int:
    """Number of triangles of one repeat."""
    return sum(len(part.triangles) for part in drawing.parts)


def triangle_points(drawing: TileDrawing) -> np.ndarray:
    """Corners of all triangles of one repeat, in an order that does not depend on the parts, shape (T, 9)."""
    corners = np.concatenate([part.vertices[part.triangles].reshape(-1, 9) for part in drawing.parts])
    return corners[np.lexsort(corners.T)]


@pytest.mark.parametrize("name", ["peerie", "double-plain-stitched"])
def test_copies_lie_at_the_points_of_the_lattice_around_the_origin(name):
    yarns = repeat(name)
    drawing = draw_tiles(yarns, (3, 2))
    assert yarns.lattice is not None
    expected = yarns.lattice.shift([(column, row) for row in range(2) for column in range(3)])
    # float32 positions of some centimetres
    np.testing.assert_allclose(drawing.offsets - drawing.offsets[0], expected - expected[0], atol=1e-5)
    np.testing.assert_allclose(drawing.low, -drawing.high, atol=1e-9)
    placed = triangle_points(drawing).reshape(-1, 3)[:, None] + drawing.offsets
    np.testing.assert_allclose(placed.min(axis=(0, 1)), drawing.low, atol=1e-5)
    np.testing.assert_allclose(placed.max(axis=(0, 1)), drawing.high, atol=1e-5)


def test_parts_divide_the_triangles_of_the_tubes():
    yarns = repeat("honeycomb")
    one = draw_tiles(yarns, (1, 1))
    striped = colours_of(np.arange(len(yarns.points)) // 7 % 5, yarns.palette)
    many = draw_tiles(yarns, (1, 1), colours=striped)
    assert (len(one.parts), len(many.parts)) == (1, 5)
    np.testing.assert_array_equal(triangle_points(one), triangle_points(many))
    two = repeat("peerie")
    colours = set(map(tuple, colours_of(two.colour, two.palette).tolist()))
    assert {part.colour for part in draw_tiles(two, (1, 1)).parts} == colours and len(colours) == 2


def test_many_copies_have_less_detail():
    yarns = repeat("stockinette")
    finest, fewest = (triangle_count(draw_tiles(yarns, (tiles, tiles))) for tiles in (1, 20))
    assert 400 * fewest <= MOST_TRIANGLES < 400 * finest


def test_many_colours_become_few_that_are_near():
    yarns = repeat("honeycomb")
    shades = np.linspace(0, 255, len(yarns.points)).astype(np.uint8)
    drawing = draw_tiles(yarns, (1, 1), colours=np.stack([shades, shades, 255 - shades], axis=1))
    assert len(drawing.parts) <= MOST_PARTS
    shown = np.array([part.colour for part in drawing.parts])
    # A scale of at most 24 steps over 256 shades has steps of 16.
    assert np.abs(shown[:, 0] + shown[:, 2] - 255).max() <= 16
    assert np.abs(np.diff(np.sort(shown[:, 0]))).max() <= 16


def test_yarns_that_have_only_moved_keep_the_arrays_of_their_triangles():
    yarns = repeat("peerie")
    before = draw_tiles(yarns, (2, 2))
    moved = replace(yarns, points=yarns.points + np.array([0.0, 0.0, 0.1]))
    after = draw_tiles(moved, (2, 2), before=before)
    assert all(part.triangles is old.triangles for part, old in zip(after.parts, before.parts, strict=True))
    np.testing.assert_array_equal(triangle_points(after), triangle_points(draw_tiles(moved, (2, 2))))


def test_other_colours_of_whole_parts_keep_the_triangles_and_other_divisions_do_not():
    yarns = repeat("peerie")
    before = draw_tiles(yarns, (2, 2))
    dyed = replace(yarns, palette=np.array([[9, 8, 7], [1, 2, 3]], dtype=np.uint8))
    after = draw_tiles(dyed, (2, 2), before=before)
    assert {part.colour for part in after.parts} == {(9, 8, 7), (1, 2, 3)}
    assert after.parts[0].triangles is before.parts[0].triangles
    striped = colours_of(np.arange(len(yarns.points)) // 7 % 3, yarns.palette)
    three = draw_tiles(yarns, (2, 2), colours=striped, before=before)
    assert len(three.parts) == 3
    one = draw_tiles(yarns, (2, 2), colours=np.zeros_like(striped), before=three)
    assert len(one.parts) == 1 and triangle_count(one) == triangle_count(three)
    another = draw_tiles(repeat("stockinette"), (2, 2), before=before)
    assert triangle_count(another) < triangle_count(before)


def test_what_cannot_be_tiled_is_refused():
    yarns = repeat("stockinette")
    with pytest.raises(ParameterError, match="tiles: got 0 x 3"):
        draw_tiles(yarns, (0, 3))
    with pytest.raises(ParameterError, match="tiles: got 200 x 200"):
        draw_tiles(yarns, (200, 200))
    with pytest.raises(YarnError, match="have no lattice"):
        draw_tiles(sm.tile_yarns(yarns, 2, 2), (1, 1))
