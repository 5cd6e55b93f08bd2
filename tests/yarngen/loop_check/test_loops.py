# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Linking numbers of test curves: what a loop passes through, and that yarn with a wrong course is found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import YarnError
from stitchmesh.labeling import label
from stitchmesh.linking.polygon_linking import Polygons, linking_numbers
from stitchmesh.linking.yarn_polylines import SAMPLES_PER_POINT
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.mesh.stitch import CODES, Stitch
from stitchmesh.tessellate import tessellate
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen import embedding, generate_yarns
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarngen.loop_check.loop_linking import LoopLinking, check_loops, expected_linking, loop_linking
from stitchmesh.yarngen.loop_check.loops import Arc, Arcs, find_arcs
from stitchmesh.yarngen.loop_check.threadings import slipped_legs
from stitchmesh.yarngen.templates.template import Template, TemplatePart
from stitchmesh.yarnrelax import relax_yarns
from tests.gallery import FLAT_AND_ROUND
from tests.meshrelax.fabrics import rotation
from tests.nightly import at_night
from tests.shaking import SHAKES, shaken_many
from tests.yarngen.samplers import bottoms, sampler, tops

pytestmark = pytest.mark.decides

KNIT = Stitch.KNIT


def fabric_of(name: str) -> StitchMesh:
    return tessellate(label(FLAT_AND_ROUND[name]()), stitch_width=0.5)


def swatch(*codes: str) -> StitchMesh:
    """One row of stitches between plain rows, with knit stitches at its ends."""
    row = [KNIT, KNIT, *(CODES[code] for code in codes), KNIT, KNIT]
    return sampler([[KNIT] * bottoms(row), row, [KNIT] * tops(row)])


def polygons(curves: list[FloatArray]) -> Polygons:
    points = np.concatenate(curves)
    return Polygons(points, np.cumsum([0, *map(len, curves)]), np.arange(len(points)))


def linking(first: FloatArray, second: FloatArray) -> float:
    return float(linking_numbers(polygons([first]), polygons([second]), np.array([[0, 0]]))[0])


def gauss_integral(first: FloatArray, second: FloatArray) -> float:
    """Linking number as the solid angles of pairs of edges over 4 pi (Banchoff 1976)."""
    total = 0.0
    for a, b in zip(first, np.roll(first, -1, axis=0), strict=True):
        for c, d in zip(second, np.roll(second, -1, axis=0), strict=True):
            sides = np.cross([c - a, d - a, d - b, c - b], [d - a, d - b, c - b, c - a])
            unit = sides / np.linalg.norm(sides, axis=1, keepdims=True)
            angles = np.arcsin(np.clip((unit * np.roll(unit, -1, axis=0)).sum(axis=1), -1.0, 1.0))
            total += float(angles.sum() * np.sign(np.cross(b - a, d - c) @ (a - c)))
    return total / (4.0 * np.pi)


SQUARE = np.array([[1.0, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]])
"""A square, counter-clockwise seen from above."""
UPRIGHT = np.array([[0.0, 0, -1], [0.1, 0, 1], [5, 0, 1], [5, 0, -1]])
"""A curve that passes up through the square and down outside it."""


def test_a_curve_up_through_a_loop_counts_one() -> None:
    assert linking(SQUARE, UPRIGHT) == 1.0
    assert linking(UPRIGHT, SQUARE) == 1.0
    assert linking(SQUARE[::-1], UPRIGHT) == linking(SQUARE, UPRIGHT[::-1]) == -1.0
    assert linking(SQUARE, UPRIGHT + np.array([3.0, 0, 0])) == 0.0


def test_linking_numbers_equal_the_gauss_integral() -> None:
    noise = np.random.default_rng(4)
    curves = [noise.normal(size=(size, 3)) for size in (5, 9, 7, 12, 10, 11)]
    pairs = np.array([(i, j) for i in range(6) for j in range(6) if i < j])
    found = linking_numbers(polygons(curves), polygons(curves), pairs)
    # sums of some tens of angles, each exact to 1e-16, or to the square root of 1e-16 for nearly flat solid angles
    np.testing.assert_allclose(found, [gauss_integral(curves[i], curves[j]) for i, j in pairs], atol=1e-6)
    assert np.abs(found).max() >= 1


def test_polygons_with_edges_on_one_line_do_not_cross() -> None:
    """Loops and links of a flat piece have edges on one line, the line of the needle that closes them."""
    random = np.random.default_rng(5)
    arch = np.array([[0.0, 0, 0], [0.3, 0.9, 0.1], [0.7, 0.9, -0.1], [1.0, 0, 0]])
    for seed in range(100):
        turn, shift = rotation(seed), random.normal(size=3)
        beyond = arch * [1, -1, 1] + [random.uniform(1.1, 3.0), 0.0, 0.0]
        assert linking(arch @ turn.T + shift, beyond @ turn.T + shift) == 0.0


RING = np.array([[-1, 0, 0], [0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0], [-1, 2, 0.0]])
"""A flat polygon with a corner in the middle of a side and a repeated corner."""
STANDING = np.array([[0, 1, 0], [0, 1, 1], [0, -1, 1], [0, -1, 0], [0, -1, -1], [0, 1, -1.0]])
"""A polygon perpendicular to it, whose corners lie in one plane."""
DEGENERATE = {
    "linked, corners in one plane": (STANDING, 1),
    "corners above corners": (RING + np.array([0, 0, 1]), 0),
    "sides on the lines of others": (RING + np.array([4, 0, 0]), 0),
    "all in one plane, one within the other": (0.5 * RING + [0, 0.5, 0], 0),
    "one point": (RING[[0, 0, 0]] + [0.5, 1, 1], 0),
    "touching": (RING + np.array([2, 0, 0]), None),
    "a polygon and itself": (RING, None),
}


@pytest.mark.parametrize("name", DEGENERATE)
def test_shaken_degenerate_polygons_have_the_same_linking(name: str) -> None:
    """The linking is the same in all shaken copies. For polygons that touch, it is at least a whole number."""
    other, expected = DEGENERATE[name]
    rings, others = shaken_many(RING), shaken_many(other)[::-1]
    one, two = (Polygons(points.reshape(-1, 3), np.arange(SHAKES + 1) * points.shape[1], np.arange(points[..., 0].size))
                for points in (rings, others))  # fmt: skip
    found = linking_numbers(one, two, np.stack([np.arange(SHAKES)] * 2, axis=1))
    assert (found == np.round(found)).all()
    assert expected is None or (np.abs(found) == expected).all()


def test_linking_does_not_depend_on_where_polygons_lie() -> None:
    noise = np.random.default_rng(8)
    first, second = ([noise.normal(size=(size, 3)) for _ in range(40)] for size in (8, 11))
    pairs = np.stack([np.arange(40)] * 2, axis=1)
    before = linking_numbers(polygons(first), polygons(second), pairs)
    turn = rotation(3)
    moved = [[curve @ turn * np.linalg.det(turn) + 2.0 for curve in curves] for curves in (first, second)]
    np.testing.assert_array_equal(linking_numbers(polygons(moved[0]), polygons(moved[1]), pairs), before)
    assert len(np.unique(before)) > 2


@pytest.mark.parametrize("name", FLAT_AND_ROUND)
def test_every_top_side_has_its_loop_as_defined_and_yarn_is_cut_without_a_gap(name: str) -> None:
    fabric = fabric_of(name)
    yarns = generate_yarns(fabric, quality="draft")
    check_loops(fabric, yarns)
    arcs = find_arcs(fabric, yarns)
    made = fabric.side_role == 2
    joined = (made & fabric.mismatched).sum()  # where rows meet top to top, two loops join into one
    rings = sum(not any(loop.on_needle) for loop in arcs.loops)
    assert len(arcs.loops) == made.sum() - joined + rings
    assert sum(sum(link.on_needle) for link in arcs.links) == 2 * made.sum()
    points = sum(arc.count - 1 for arc in (*arcs.loops, *arcs.links))
    bridged = len(yarns.points) - np.diff(arcs.pieces.points, axis=1).sum()
    assert points >= SAMPLES_PER_POINT * (len(yarns.points) - bridged) - len(arcs.links)


def test_a_knit_loop_is_threaded_once_up_and_once_down_and_a_purl_loop_reversed() -> None:
    fabric = swatch("p", "k", "p")
    arcs = find_arcs(fabric, generate_yarns(fabric))
    threadings = expected_linking(arcs).threadings.toarray()
    worked = np.flatnonzero(np.abs(threadings).sum(axis=0))
    assert len(worked) == len(arcs.loops), "every loop is held"
    np.testing.assert_array_equal(threadings.sum(axis=0)[worked][: -tops([KNIT] * 7)], 0)
    assert set(np.unique(threadings)) == {-1, 0, 1}


@pytest.mark.parametrize(
    ("code", "threadings"),
    [("kp", {1, -2}), ("ky", {1, -1}), ("kyk", {1, -1}), ("yky", {1, -1}), ("sk", {1, -1}), ("sy", set())],
)
def test_yarn_between_loops_of_one_stitch_threads_as_the_stitch_defines(code: str, threadings: set[int]) -> None:
    """From knit to purl the yarn passes through the loop below twice; a yarn-over does not pass through it."""
    fabric = swatch(code)
    arcs = find_arcs(fabric, generate_yarns(fabric))
    face = int(np.flatnonzero(fabric.stitch == CODES[code])[0])
    held = arcs.loop_of_side[int(fabric.face_start[face])]
    through = loop_linking(arcs, generate_yarns(fabric)).threadings[:, [held]].toarray()[:, 0]
    by_face = [
        round(through[number])
        for number, link in enumerate(arcs.links)
        if any(arcs.pieces.face[piece] == face for piece in link.pieces)
    ]
    assert {value for value in by_face if value} == threadings


def measured(arcs: Arcs, yarns: YarnSet) -> LoopLinking:
    found = loop_linking(arcs, yarns)
    assert np.abs(found.threadings.data - np.round(found.threadings.data)).max() < 1e-6
    return found


def assert_same(found: LoopLinking, expected: LoopLinking) -> None:
    assert (found.threadings - expected.threadings).count_nonzero() == 0
    np.testing.assert_array_equal(found.turns, expected.turns)


EVERYTHING = ("p", "y", "d12k", "k", "b", "f", "kp", "d21p", "sk", "d213k", "x", "ky", "sy")


def test_a_leg_has_no_turns_where_the_link_beside_it_threads_no_loop() -> None:
    fabric = swatch("b", "k", "b")
    yarns = generate_yarns(fabric)
    arcs = find_arcs(fabric, yarns)
    legs = slipped_legs(arcs).link
    off_needle = replace(arcs.links[legs[0]], on_needle=(False,) * len(arcs.links[legs[0]].on_needle))
    links = [off_needle if number == legs[0] else link for number, link in enumerate(arcs.links)]
    found = loop_linking(replace(arcs, links=links), yarns).turns
    expected = np.where(legs == legs[0], np.nan, measured(arcs, yarns).turns)
    assert 0 < np.isnan(expected).sum() < len(legs)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("quality", ["draft", *at_night("standard", "reference")])
def test_linking_is_whole_and_as_defined_at_every_quality(quality: str) -> None:
    fabric = swatch(*EVERYTHING)
    yarns = generate_yarns(fabric, quality=quality)
    arcs = find_arcs(fabric, yarns)
    assert len(measured(arcs, yarns).turns) == 8, "the legs of b, f, x and sy"
    assert_same(measured(arcs, yarns), expected_linking(arcs))


def test_linking_does_not_depend_on_where_yarn_is_cut() -> None:
    """All cuts are moved along the yarn by half a control point, about a twenty-fifth of a plain loop."""
    fabric = swatch(*EVERYTHING)
    yarns = generate_yarns(fabric, quality="draft")
    arcs = find_arcs(fabric, yarns)

    def moved(arc: Arc) -> Arc:
        return replace(arc, first=arc.first + 1, last=arc.last + 1)

    elsewhere = Arcs(arcs.pieces, [moved(loop) for loop in arcs.loops], [moved(link) for link in arcs.links])
    assert_same(measured(elsewhere, yarns), expected_linking(arcs))


@pytest.mark.nightly
def test_flat_fabric_may_lie_anywhere_in_its_plane() -> None:
    """All yarns are equal, so on the deformation path they lie on each other's edges and in one plane at all times."""
    fabric = sampler([[KNIT] * 20] * 20)
    yarns = generate_yarns(fabric, quality="draft")
    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    check_loops(fabric, replace(yarns, points=yarns.points @ quarter + 5.0))


@pytest.mark.nightly
def test_a_mirror_image_is_linked_the_other_way() -> None:
    """A mirror parallel to the fabric turns knit into purl, which no motion without pull-throughs can do."""
    fabric = swatch("k")
    yarns = generate_yarns(fabric, quality="draft")
    mirrored = replace(yarns, points=yarns.points * [1.0, 1.0, -1.0])
    arcs = find_arcs(fabric, mirrored)
    assert (measured(arcs, mirrored).threadings + expected_linking(arcs).threadings).count_nonzero() == 0
    with pytest.raises(YarnError, match=r"face \d+: its yarn passed through that of face \d+ since it was generated"):
        check_loops(fabric, mirrored)


def replace_template(monkeypatch: pytest.MonkeyPatch, stitch: Stitch, change: Callable[[Template], Template]) -> None:
    right = embedding.template

    def wrong(kind: Stitch, n_bottom: int, n_top: int, twists: tuple[int, ...] = ()) -> Template:
        shape = right(kind, n_bottom, n_top, twists)
        return change(shape) if kind == stitch else shape

    monkeypatch.setattr(embedding, "template", wrong)


IN_FRONT = np.array([0.0, 0.0, 6.0])


def head_in_front(shape: Template) -> Template:
    """The head completely in front of the yarn that should hold it."""
    parts = [replace(part, curve=part.curve + IN_FRONT) if part.is_head else part for part in shape.parts]
    return Template(shape.n_bottom, shape.n_top, tuple(parts))


def hook_beside_the_head(shape: Template) -> Template:
    """The yarn between two loops of one stitch is straight and does not turn through the head."""
    parts = []
    for part in shape.parts:
        straight = np.linspace(part.curve[0], part.curve[-1], len(part.curve))
        on_top = [shape.n_bottom < end.place <= shape.n_bottom + shape.n_top for end in (part.start, part.end)]
        parts.append(TemplatePart(part.start, part.end, straight, part.is_head) if all(on_top) else part)
    return Template(shape.n_bottom, shape.n_top, tuple(parts))


@pytest.mark.parametrize("code", ["k", "kp", "d312p", "sk"])
def test_a_loop_that_is_not_held_is_caught(code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    fabric = swatch("b", code, "b") if code != "k" else swatch()
    replace_template(monkeypatch, CODES[code], head_in_front)
    message = r"passes 0 times through loop \d of face \d+, expected -?\d .*the template of a stitch is wrong"
    with pytest.raises(YarnError, match=message):
        check_loops(fabric, generate_yarns(fabric, quality="draft"))


@pytest.mark.parametrize("code", ["kp", "ky"])
def test_yarn_that_does_not_turn_through_the_head_is_caught(code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    fabric = swatch(code)
    replace_template(monkeypatch, CODES[code], hook_beside_the_head)
    with pytest.raises(YarnError, match=r"passes 0 times through loop \d of face \d+, expected -?\d"):
        check_loops(fabric, generate_yarns(fabric, quality="draft"))


@pytest.mark.parametrize(("code", "template_code"), [("kp", "pk"), ("k", "p"), ("d12k", "d21p")])
def test_a_stitch_with_the_template_of_another_is_caught(
    code: str, template_code: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    fabric = swatch("d21k", code, "d21k")
    other = embedding.template
    replace_template(monkeypatch, CODES[code], lambda shape: other(CODES[template_code], shape.n_bottom, shape.n_top))
    with pytest.raises(YarnError, match="times through"):
        check_loops(fabric, generate_yarns(fabric, quality="draft"))


@pytest.mark.parametrize(
    ("code", "template_code", "turns"), [("b", "f", 0), ("f", "b", -1), ("x", "b", -1), ("b", "x", -2)]
)
def test_yarn_on_the_wrong_side_of_a_slipped_loop_is_caught(
    code: str, template_code: str, turns: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The linking number of the whole loop is zero in all these cases, but those of its legs differ.

    The second row runs from right to left or from left to right.
    """
    fabric = swatch(code)
    other = embedding.template
    replace_template(monkeypatch, CODES[code], lambda shape: other(CODES[template_code], shape.n_bottom, shape.n_top))
    with pytest.raises(YarnError, match=rf"yarn winds -?{abs(turns)} times around a leg of its slipped loop"):
        check_loops(fabric, generate_yarns(fabric, quality="draft"))


@pytest.mark.nightly
def test_a_pull_through_by_hand_is_caught() -> None:
    """One loop of a relaxed tube is lifted out of the loop that passes through it."""
    fabric = fabric_of("tube")
    yarns = relax_yarns(generate_yarns(fabric, quality="draft"), quality="draft", device="cpu", keep_shape=fabric).yarns
    check_loops(fabric, yarns)
    face = int(np.flatnonzero(fabric.row == 4)[3])
    head = (yarns.face == face) & (yarns.part == 0)
    outwards = yarns.points[head].mean(axis=0) * [1.0, 0.0, 1.0]
    points = yarns.points.copy()
    points[head] += 8.0 * yarns.radius[0] * outwards / np.linalg.norm(outwards)
    with pytest.raises(YarnError, match=r"face \d+: its yarn passed through that of face \d+ since it was generated"):
        check_loops(fabric, replace(yarns, points=points))


def test_yarns_of_another_fabric_are_refused() -> None:
    with pytest.raises(YarnError, match="their routes differ from those of this stitch mesh"):
        check_loops(swatch("k"), generate_yarns(swatch("p", "k")))


def test_yarns_are_checked_with_the_finish_that_they_have() -> None:
    fabric = swatch("k", "p")
    yarns = generate_yarns(fabric, quality="draft", bind_off="chain", cast_on="open")
    check_loops(fabric, yarns, finish=YarnFinish(bind_off="chain", cast_on="open"))
    with pytest.raises(YarnError, match="and the finish with which"):
        check_loops(fabric, yarns, finish=YarnFinish(bind_off="drawn"))


@pytest.mark.parametrize("courses", [4, 5])  # the chain is worked to the right, and to the left
def test_the_yarn_of_a_chain_leads_up_and_down_through_each_loop_of_the_last_row(courses: int) -> None:
    fabric = swatch(*["k"] * courses)
    arcs = find_arcs(fabric, generate_yarns(fabric))
    threadings = expected_linking(arcs).threadings.toarray()
    held = threadings[:, [arcs.loop_of_side[side] for side in np.flatnonzero(arcs.whole.side_role == 0).tolist()
                          if arcs.whole.stitch[arcs.whole.side_face[side]] == Stitch.BIND_OFF]]  # fmt: skip
    # through the last loop the yarn is drawn once, to the end of the row
    assert sorted(np.abs(held).sum(axis=0).tolist()) == [1, *[2] * (held.shape[1] - 1)]
    assert sorted(held.sum(axis=0).tolist())[1:-1] == [0] * (held.shape[1] - 2)
