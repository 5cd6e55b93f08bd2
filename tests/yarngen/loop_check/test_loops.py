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
from stitchmesh.linking.yarn_polylines import SAMPLES_PER_POINT
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import CODES, Stitch
from stitchmesh.tessellate import tessellate
from stitchmesh.yarngen import embedding, generate_yarns
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarngen.loop_check.loop_linking import LoopLinking, check_loops, expected_linking, loop_linking
from stitchmesh.yarngen.loop_check.loops import Arc, Arcs, find_arcs
from stitchmesh.yarngen.loop_check.threadings import slipped_legs
from stitchmesh.yarngen.templates.template import Template, TemplatePart
from stitchmesh.yarnrelax import relax_yarns
from tests.gallery import FLAT_AND_ROUND
from tests.nightly import at_night
from tests.yarngen.samplers import bottoms, sampler, tops

pytestmark = pytest.mark.decides

KNIT = Stitch.KNIT


def fabric_of(name: str) -> StitchMesh:
    return tessellate(label(FLAT_AND_ROUND[name]()), stitch_width=0.5)


def swatch(*codes: str) -> StitchMesh:
    """One row of stitches between plain rows, with knit stitches at its ends."""
    row = [KNIT, KNIT, *(CODES[code] for code in codes), KNIT, KNIT]
    return sampler([[KNIT] * bottoms(row), row, [KNIT] * tops(row)])


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
        int(through[number])
        for number, link in enumerate(arcs.links)
        if any(arcs.pieces.face[piece] == face for piece in link.pieces)
    ]
    assert {value for value in by_face if value} == threadings


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
    expected = np.where(legs == legs[0], np.nan, loop_linking(arcs, yarns).turns)
    assert 0 < np.isnan(expected).sum() < len(legs)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("quality", ["draft", *at_night("standard", "reference")])
def test_linking_is_as_defined_at_every_quality(quality: str) -> None:
    fabric = swatch(*EVERYTHING)
    yarns = generate_yarns(fabric, quality=quality)
    arcs = find_arcs(fabric, yarns)
    assert len(loop_linking(arcs, yarns).turns) == 8, "the legs of b, f, x and sy"
    assert_same(loop_linking(arcs, yarns), expected_linking(arcs))


def test_linking_does_not_depend_on_where_yarn_is_cut() -> None:
    """All cuts are moved along the yarn by half a control point, about a twenty-fifth of a plain loop."""
    fabric = swatch(*EVERYTHING)
    yarns = generate_yarns(fabric, quality="draft")
    arcs = find_arcs(fabric, yarns)

    def moved(arc: Arc) -> Arc:
        return replace(arc, first=arc.first + 1, last=arc.last + 1)

    elsewhere = Arcs(arcs.pieces, [moved(loop) for loop in arcs.loops], [moved(link) for link in arcs.links])
    assert_same(loop_linking(elsewhere, yarns), expected_linking(arcs))


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
    assert (loop_linking(arcs, mirrored).threadings + expected_linking(arcs).threadings).count_nonzero() == 0
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
    yarns = generate_yarns(fabric, quality="draft", finish=YarnFinish(bind_off="chain", cast_on="open"))
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
