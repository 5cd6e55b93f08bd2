# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rest lengths change where the user requests it and by the requested factor, and stay the same elsewhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import Cell, Pattern, Row
from stitchmesh.periodic.repeat.torus import torus_mesh
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import (
    RestLengths,
    apply_rest_lengths,
    carried_segments,
    parse_rest_lengths,
    segment_faces,
    stitch_lengths,
)
from tests.gallery import grid, tube
from tests.io.yarn_sets import ring


@pytest.fixture(scope="module")
def banded() -> tuple[YarnSet, StitchMesh]:
    """A narrowing tube of alternating knit and purl rows, with decreases, cast-on and bind-off."""
    mesh = tube(8, 4, radius=4.0, top_radius=2.0)
    fabric = sm.tessellate(sm.label(mesh), stitch_width=0.8)
    purl = (fabric.stitch == Stitch.KNIT) & (fabric.row % 4 < 2)
    fabric = replace(fabric, stitch=np.where(purl, Stitch.PURL, fabric.stitch))
    return sm.generate_yarns(fabric), fabric


@pytest.fixture(scope="module")
def flat() -> tuple[YarnSet, StitchMesh]:
    """A flat piece: one yarn, knitted back and forth, with turns at the row ends."""
    fabric = sm.tessellate(sm.label(grid(6, 6)), stitch_width=0.8)
    return sm.generate_yarns(fabric), fabric


def loose_rings(count: int = 3) -> YarnSet:
    """Yarns that do not store which stitches made them, as in files of curves."""
    return YarnSet.from_curves([ring([0, 0, 0.3 * k]) for k in range(count)], closed=[True] * count, radius=0.1)


def inside(fabric: StitchMesh) -> np.ndarray:
    """Whether each face is a knit or purl stitch that is not on the border."""
    at_border = np.bincount(fabric.side_face[fabric.twin < 0], minlength=fabric.face_count) > 0
    return np.isin(fabric.stitch, [Stitch.KNIT, Stitch.PURL]) & ~at_border


def test_the_lengths_of_all_stitches_add_up_to_the_length_of_all_yarn(banded):
    yarns, fabric = banded
    # There is one rounding error for each of about 1e4 terms.
    assert stitch_lengths(yarns, fabric).sum() == pytest.approx(yarns.rest_length.sum(), rel=1e-12)


def test_every_plain_stitch_inside_has_the_loop_length(banded):
    yarns, fabric = banded
    plain = inside(fabric)
    assert np.ptp(stitch_lengths(yarns, fabric)[plain]) > 0.01  # The generated lengths differ.
    changed = apply_rest_lengths(yarns, RestLengths(loop_length=2.5), fabric=fabric)
    np.testing.assert_allclose(stitch_lengths(changed, fabric)[plain], 2.5, rtol=1e-12)  # Rounding of a sum.


def test_shaping_and_edges_take_the_median_scale_of_a_loop_length(flat, banded):
    for yarns, fabric in (flat, banded):
        plain, before = inside(fabric), stitch_lengths(yarns, fabric)
        changed = apply_rest_lengths(yarns, RestLengths(loop_length=2.5), fabric=fabric)
        share = (stitch_lengths(changed, fabric) / before)[~plain]
        np.testing.assert_allclose(share, np.median(2.5 / before[plain]), rtol=1e-12)  # Rounding of a sum.


def test_a_float_is_no_part_of_the_loop_that_it_starts_from():
    rows = tuple(Row(tuple(Cell(Stitch.KNIT, yarn=int(yarn)) for yarn in row)) for row in ("00011", "02211"))
    fabric = torus_mesh(Pattern("Colours", "", rows), stitch_width=0.8, stitch_height=0.6)
    yarns = sm.generate_yarns(fabric, yarn_radius=0.1)
    carried = carried_segments(yarns)
    changed = apply_rest_lengths(yarns, RestLengths(loop_length=3.2), fabric=fabric)
    loops = np.bincount(segment_faces(changed)[~carried], changed.rest_length[~carried])
    np.testing.assert_allclose(loops, 3.2, rtol=1e-12)  # Rounding of a sum.
    given = np.bincount(segment_faces(yarns)[~carried], yarns.rest_length[~carried])
    share = changed.rest_length[carried] / yarns.rest_length[carried]
    np.testing.assert_allclose(share, np.median(3.2 / given), rtol=1e-12)  # Rounding of a sum.


@pytest.mark.parametrize(("code", "stitch"), [("k", Stitch.KNIT), ("d12k", Stitch.D12K)])
def test_the_factor_of_a_stitch_type_applies_to_this_type_only(banded, code, stitch):
    yarns, fabric = banded
    scale = apply_rest_lengths(yarns, RestLengths(stitches={code: 1.5}), fabric=fabric).rest_length / yarns.rest_length
    expected = np.where(fabric.stitch[segment_faces(yarns)] == stitch, 1.5, 1.0)
    assert 1.0 < expected.mean() < 1.5
    np.testing.assert_allclose(scale, expected, rtol=1e-15)  # One product and one division.


def test_factors_of_a_row_and_of_a_yarn_apply_to_these_only(banded):
    yarns, _ = banded
    scale = apply_rest_lengths(yarns, RestLengths(rows={3: 0.5}, yarns={5: 2.0})).rest_length / yarns.rest_length
    row = yarns.row[yarns.segment_points[:, 1]]
    expected = np.where(row == 3, 0.5, 1.0) * np.where(yarns.segment_yarn == 5, 2.0, 1.0)
    assert (row == 3).any()
    np.testing.assert_allclose(scale, expected, rtol=1e-15)  # Products by powers of two are exact; one division.


def test_factors_multiply_the_loop_length_and_each_other(banded):
    yarns, fabric = banded
    change = RestLengths(factor=1.1, loop_length=2.5, stitches={"p": 0.8})
    length = stitch_lengths(apply_rest_lengths(yarns, change, fabric=fabric), fabric)
    plain = inside(fabric)
    # The tolerance is for the rounding of sums.
    np.testing.assert_allclose(length[plain & (fabric.stitch == Stitch.KNIT)], 2.5 * 1.1, rtol=1e-12)
    np.testing.assert_allclose(length[plain & (fabric.stitch == Stitch.PURL)], 2.5 * 1.1 * 0.8, rtol=1e-12)


@pytest.mark.parametrize("yarns_of_row", ["0001", "01001"])
def test_the_factor_of_floats_applies_to_floats_behind_stitches_of_other_yarns(yarns_of_row):
    """The other yarn floats behind each stitch; a float of n stitches is about n stitch widths long."""
    width = 0.5
    row = Row(tuple(Cell(Stitch.KNIT, yarn=int(yarn)) for yarn in yarns_of_row))
    fabric = torus_mesh(Pattern("made", "test", (row,)), stitch_width=width, stitch_height=0.4)
    yarns = sm.generate_yarns(fabric)
    changed = apply_rest_lengths(yarns, RestLengths(floats=0.8), fabric=fabric).rest_length
    factor = changed / yarns.rest_length
    floats = factor < 0.9
    np.testing.assert_allclose(factor, np.where(floats, 0.8, 1.0), rtol=1e-12)
    changes = sum(a != b for a, b in zip(yarns_of_row, yarns_of_row[1:] + yarns_of_row[0], strict=True))
    # At both ends a float extends obliquely over a part of a stitch, to the beginning of the next stitch.
    assert yarns.rest_length[floats].sum() == pytest.approx(len(yarns_of_row) * width, abs=0.6 * changes * width)
    behind = yarns.points[yarns.segment_points[floats, 1], 2]
    assert behind.mean() < yarns.points[:, 2].mean() - yarns.radius[0]


def test_yarn_that_no_stitch_made_keeps_its_rest_length(banded):
    yarns, fabric = banded
    face = yarns.face.copy()
    face[:100] = -1
    partly = replace(yarns, face=face)
    change = RestLengths(loop_length=1.0, stitches={"k": 2.0, "p": 2.0})
    scale = apply_rest_lengths(partly, change, fabric=fabric).rest_length / yarns.rest_length
    unknown = segment_faces(partly) == -1
    assert unknown.sum() >= 97  # A hundred consecutive control points of an open yarn have 97 segments.
    np.testing.assert_array_equal(scale[unknown], 1.0)
    assert (scale[~unknown] != 1.0).all()


def test_words_of_all_kinds_are_parsed():
    words = ["k=1.1", "d12k=0.75", "row:3=0.9", "yarn:12=1.2", "yarn:0=2"]
    words += ["floats=0.8", "held=0.6", "warp=0.9", "weft=3"]
    assert parse_rest_lengths(words, factor=1.05, loop_length=3.2) == RestLengths(
        factor=1.05, loop_length=3.2, stitches={"k": 1.1, "d12k": 0.75}, rows={3: 0.9}, yarns={12: 1.2, 0: 2.0},
        floats=0.8, held=0.6, warp=0.9, weft=3.0,
    )  # fmt: skip


@pytest.mark.parametrize("word", ["k", "k=long", "row:x=1", "course:3=1", ""])
def test_a_word_of_the_wrong_form_is_refused(word):
    with pytest.raises(ParameterError, match=r"got '.*'; expected CODE=FACTOR, row:N=FACTOR, yarn:N=FACTOR, or floats"):
        parse_rest_lengths([word])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["q=1.1"], r"rest length q: unknown stitch; expected one of k, p, y, b"),
        (["float=1.1"], r"rest length float: unknown stitch; expected one of k, .*, floats, held, warp, weft$"),
        (["weft=1.1", "weft=1.2"], r"got 'weft=1.2' after another factor for the same"),
        (["row:3=-1"], r"rest length row:3: got -1.0; expected a positive number"),
        (["yarn:3=inf"], r"rest length yarn:3: got inf; expected a positive number"),
        (["row:03=1", "row:3=2"], r"got 'row:3=2' after another factor for the same"),
    ],
)
def test_a_word_with_an_invalid_name_or_factor_is_refused(words, message):
    with pytest.raises(ParameterError, match=message):
        parse_rest_lengths(words)


@pytest.mark.parametrize(("change", "name"), [({"factor": 0.0}, "rest length factor"), ({"loop_length": -2.0}, "loop")])
def test_a_length_that_is_not_positive_is_refused(change, name):
    with pytest.raises(ParameterError, match=f"{name}.*: got .*; expected a positive number"):
        RestLengths(**change)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["ky=1.1"], "rest length ky: the fabric has no such stitch; it has k, p, d12k"),
        (["row:77=1.1"], "rest length row:77: no yarn is in that row; expected 0 to"),
        (["yarn:99=1.1"], "rest length yarn:99: there is no such yarn; expected 0 to"),
        (["floats=1.1"], "rest length floats: the fabric has no slip stitch and no stitches"),
        (["held=1.1"], "rest length held: the fabric has no slip or tuck that holds a loop"),
        (["warp=1.1"], "rest length warp: the yarns are not woven"),
    ],
)
def test_the_message_names_what_does_not_exist(banded, words, message):
    yarns, fabric = banded
    with pytest.raises(ParameterError, match=message):
        apply_rest_lengths(yarns, parse_rest_lengths(words), fabric=fabric)


@pytest.mark.parametrize(
    "change", [RestLengths(loop_length=3.0), RestLengths(stitches={"k": 1.1}), RestLengths(held=1.1)]
)
def test_factors_of_stitches_need_the_fabric_of_the_yarns(banded, flat, change):
    assert change.need_fabric
    yarns, fabric = banded
    with pytest.raises(ParameterError, match="got no fabric; give the stitch mesh that the yarns were made from"):
        apply_rest_lengths(yarns, change)
    with pytest.raises(ParameterError, match=r"yarns refer to stitch face \d+ and the fabric has"):
        apply_rest_lengths(yarns, change, fabric=flat[1])
    with pytest.raises(ParameterError, match="the yarns do not store which stitch made them"):
        apply_rest_lengths(loose_rings(), change, fabric=fabric)


def test_factors_of_rows_and_yarns_need_no_fabric_but_rows_need_stitches(banded):
    change = RestLengths(rows={0: 1.1}, yarns={0: 1.1})
    assert not change.need_fabric
    assert apply_rest_lengths(banded[0], change).yarn_count == banded[0].yarn_count
    with pytest.raises(ParameterError, match="rest length row:0: the yarns do not store which stitch made them"):
        apply_rest_lengths(loose_rings(), change)


def test_a_loop_length_needs_a_plain_stitch():
    fabric = sm.tessellate(sm.label(grid(2, 2)), stitch_width=1.0, stitch_height=1.0)
    with pytest.raises(ParameterError, match="loop length: the fabric has no plain stitch away from its borders"):
        apply_rest_lengths(sm.generate_yarns(fabric), RestLengths(loop_length=3.0), fabric=fabric)
