# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Each stitch template alone: where it crosses the sides of its face, and what its yarn passes through."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import YarnError
from stitchmesh.mesh.stitch import CODES, SIDE_COUNTS, VOCABULARY, Stitch
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.clearance import smallest_distance
from stitchmesh.yarngen.embedding import place_parts
from stitchmesh.yarngen.templates.own_checks import PIERCING as MADE_PIERCING
from stitchmesh.yarngen.templates.own_checks import crossings_between, handedness, piercings, surround_stitch
from stitchmesh.yarngen.templates.plain import HEIGHT_IN_RADII, LOOP_WIDTH, knit
from stitchmesh.yarngen.templates.table import drawings, template, template_from_drawing
from stitchmesh.yarngen.templates.template import (
    RADIUS_OVER_WIDTH,
    Crossing,
    Template,
    TemplatePart,
    crossing_point,
    mirrored,
    top,
    trapezoid,
    turned_over,
    twisted,
)
from tests.gallery import ROOT

pytestmark = pytest.mark.decides

EDGES = [(Stitch.CAST_ON, 1, 1), (Stitch.CAST_ON, 0, 1), (Stitch.CAST_ON, 0, 2), (Stitch.CAST_ON, 2, 3),
         (Stitch.BIND_OFF, 1, 1), (Stitch.DRAW_THROUGH, 1, 0), (Stitch.DRAW_THROUGH, 3, 0)]  # fmt: skip
EMPTY_BOTTOM, EMPTY_TOP = {Stitch.CAST_ON}, {Stitch.BIND_OFF, Stitch.DRAW_THROUGH}
each_edge = pytest.mark.parametrize(("stitch", "n_bottom", "n_top"), EDGES)
each_stitch = pytest.mark.parametrize("stitch", VOCABULARY, ids=lambda stitch: VOCABULARY[stitch].code)
each_drawn = pytest.mark.parametrize("stitch", [CODES[code] for code in ("k", *drawings())],
                                     ids=lambda stitch: VOCABULARY[stitch].code)  # fmt: skip
PIERCING = {**MADE_PIERCING, "s": 0}
"""How often the left leg of a loop passes through a head from behind to the front. The right leg passes back."""


def twistings(stitch: Stitch) -> list[tuple[int, ...]]:
    """All combinations of twists of the loops on top."""
    return list(itertools.product((0, 1, -1), repeat=VOCABULARY[stitch].n_top))


def template_of(stitch: Stitch, twists: tuple[int, ...] = ()) -> Template:
    return template(stitch, *SIDE_COUNTS[stitch], twists)


def heads_of(shape: Template) -> dict[int, list[tuple[TemplatePart, int]]]:
    """Parts of the loop below on each bottom side, with 1 if they run clockwise and -1 if they do not."""
    heads: dict[int, list[tuple[TemplatePart, int]]] = {}
    for part in shape.parts:
        if part.is_head:
            heads.setdefault(part.start.place, []).append((part, 1 if part.start.slot == 0 else -1))
    return heads


def own_parts(shape: Template) -> list[TemplatePart]:
    return [part for part in shape.parts if not part.is_head]


def loop_at(stitch: Stitch, crossing: Crossing) -> int | None:
    """Number of the loop on top to which a crossing belongs."""
    n_bottom, n_top = SIDE_COUNTS[stitch]
    return n_bottom + n_top - crossing.place if n_bottom < crossing.place <= n_bottom + n_top else None


def expected_crossings(stitch: Stitch, n_bottom: int, n_top: int) -> set[tuple[int, int]]:
    """Two crossings on every course side that has yarn, and one on each wale side."""
    sides = {(n_bottom, 0), (n_bottom + n_top + 1, 0)}
    if stitch not in EMPTY_BOTTOM:
        sides |= {(place, slot) for place in range(n_bottom) for slot in (0, 1)}
    if stitch not in EMPTY_TOP:
        sides |= {(n_bottom + 1 + place, slot) for place in range(n_top) for slot in (0, 1)}
    return sides


def check_ends_and_sides(shape: Template, expected: set[tuple[int, int]]) -> None:
    n_bottom, n_top = shape.n_bottom, shape.n_top
    ends = [(c.place, c.slot) for part in shape.parts for c in (part.start, part.end)]
    assert len(ends) == len(set(ends)) and set(ends) == expected
    corners = trapezoid(n_bottom, n_top)
    inward = np.roll(corners, -1, axis=0) - corners
    inward = np.stack([-inward[:, 1], inward[:, 0]], axis=1) / np.linalg.norm(inward, axis=1)[:, None]
    for part in shape.parts:
        for crossing, point in ((part.start, part.curve[0]), (part.end, part.curve[-1])):
            # the formula of the plain loop is exact to 1e-12; splines pass through their waypoints exactly
            np.testing.assert_allclose(point, crossing_point(n_bottom, n_top, crossing), atol=1e-9)
        depth = np.einsum("kd,pkd->pk", inward, part.curve[:, None, :2] - corners[None])
        assert depth.min() > -0.02  # splines overshoot a side by up to a sixth of a radius where they cross it steeply


@each_edge
def test_edges_are_crossed_where_stitches_meet_and_yarn_stays_within(stitch, n_bottom, n_top):
    check_ends_and_sides(template(stitch, n_bottom, n_top), expected_crossings(stitch, n_bottom, n_top))


@each_stitch
def test_stitches_are_crossed_where_stitches_meet_and_yarn_stays_within_however_twisted(stitch):
    for twists in twistings(stitch):
        check_ends_and_sides(template_of(stitch, twists), expected_crossings(stitch, *SIDE_COUNTS[stitch]))


def test_the_plain_loop_is_the_closed_form():
    """A face holds t in (-pi/2, pi/2) of the lower row and the rest of its own row, which is 4.5 higher."""
    head, left, right = knit().parts
    for part, first, last, lift in ((head, -0.5, 0.5, 0.0), (left, -1.0, -0.5, 4.5), (right, 0.5, 1.0, 4.5)):
        t = np.linspace(first, last, len(part.curve)) * np.pi
        x, y = (t + 1.5 * np.sin(2 * t)) / LOOP_WIDTH + 0.5, (4 * np.cos(t) + lift) / LOOP_WIDTH
        np.testing.assert_allclose(part.curve[:, :2], np.stack([x, y], axis=1), atol=1e-14)
        middle = len(t) // 2
        assert part.curve[middle, 2] == pytest.approx(-np.cos(2 * t[middle]) * HEIGHT_IN_RADII, rel=1e-12)


def assert_same(one: Template, other: Template) -> None:
    """Compare the parts in any order, up to rounding of a few coordinates of order one."""
    for first, second in zip(*(sorted(each.parts, key=_by_start) for each in (one, other)), strict=True):
        assert (first.start, first.end, first.is_head) == (second.start, second.end, second.is_head)
        np.testing.assert_allclose(first.curve, second.curve, atol=1e-12)


def _by_start(part: TemplatePart) -> tuple[int, int]:
    return part.start.place, part.start.slot


@each_stitch
def test_in_a_mirror_and_turned_over_loops_are_twisted_the_other_way(stitch):
    shape, twists = template_of(stitch), (1, -1, -1)[: VOCABULARY[stitch].n_top]
    against = tuple(-turn for turn in twists)
    assert_same(mirrored(twisted(shape, twists)), twisted(mirrored(shape), against[::-1]))
    assert_same(turned_over(twisted(shape, twists)), twisted(turned_over(shape), against))


@each_stitch
def test_loops_pass_through_all_loops_below_as_their_letters_define_however_twisted(stitch):
    """The left leg of a knit loop counts 1 and its right leg -1; a purl loop has the opposite signs.

    Yarn between two loops of one stitch has both legs: from knit to purl it passes to the back twice, once around the
    top of the head.
    """
    signs = [PIERCING[letter] for letter in VOCABULARY[stitch].made]
    for twists in twistings(stitch):
        shape = template_of(stitch, twists)
        for head in heads_of(shape).values():
            for part in own_parts(shape):
                came, goes = loop_at(stitch, part.start), loop_at(stitch, part.end)
                expected = (0 if goes is None else signs[goes]) - (0 if came is None else signs[came])
                assert sum(piercings(part, leg) * sense for leg, sense in head) == expected, (twists, part.start)


@each_stitch
def test_loops_worked_together_lie_in_layers_and_are_not_linked(stitch):
    shape, order = template_of(stitch), VOCABULARY[stitch].order
    heads = {place + 1: parts[0][0] for place, parts in heads_of(shape).items()}
    for front, behind in itertools.combinations(order, 2):
        found, _ = crossings_between(heads[front], heads[behind])
        assert set(found) == {1} and handedness(heads[front], heads[behind]) == 0


@each_stitch
def test_yarn_of_the_row_is_not_linked_with_itself(stitch):
    for first, second in itertools.combinations(own_parts(template_of(stitch)), 2):
        assert handedness(first, second) == 0


@each_stitch
def test_a_twisted_loop_has_the_leg_from_the_left_in_front_at_one(stitch):
    """Its two upward legs cross once more than without twist; a crossing with the left leg in front is right-handed."""
    n_bottom, n_top = SIDE_COUNTS[stitch]
    for loop, turn in itertools.product(range(n_top), (1, -1)):
        slots = [top(n_bottom, n_top, loop, slot) for slot in (0, 1)]
        shape = template_of(stitch, tuple(turn if k == loop else 0 for k in range(n_top)))
        (left, up), (right, also_up) = (
            next((p, 1 if p.end == slot else -1) for p in shape.parts if slot in (p.start, p.end)) for slot in slots
        )
        before = [next(p for p in template_of(stitch).parts if slot in (p.start, p.end)) for slot in slots]
        assert up * also_up * (handedness(left, right) - handedness(*before)) == turn, (loop, turn)


@pytest.mark.parametrize("stitch", [Stitch.SLIP_BACK, Stitch.SLIP_FRONT, Stitch.WRAP])
def test_the_row_passes_a_slipped_loop_behind_in_front_or_once_around(stitch):
    shape = template_of(stitch)
    passes = {Stitch.SLIP_BACK: [-1], Stitch.SLIP_FRONT: [1], Stitch.WRAP: [-1, 1, -1]}[stitch]
    (thread,) = own_parts(shape)
    for ((leg, _),) in [[pair] for pair in heads_of(shape)[0]]:
        assert crossings_between(thread, leg)[0] == passes


def test_cast_on_loops_have_the_leg_from_the_left_in_front_unless_marked():
    for twists, sign in (((), 1), ((0,), 1), ((1,), 1), ((-1,), -1)):
        rising, falling = template(Stitch.CAST_ON, 1, 1, twists).parts
        assert (rising.end, falling.start) == (top(1, 1, 0, 1), top(1, 1, 0, 0))
        assert -handedness(rising, falling) == sign  # one runs upwards, the other downwards


def test_the_drawn_yarn_passes_behind_one_leg_and_in_front_of_the_other():
    for stitch, n_bottom, n_top in [(Stitch.BIND_OFF, 1, 1), (Stitch.DRAW_THROUGH, 3, 0)]:
        shape = template(stitch, n_bottom, n_top)
        (thread,) = own_parts(shape)
        for ((head, _),) in heads_of(shape).values():
            assert crossings_between(thread, head)[0] == [-1, 1]


def test_drawings_of_the_package_have_the_topology_of_the_rough_ones():
    rough = json.loads((ROOT / "assets" / "stitches" / "rough.json").read_text())
    assert list(rough) == list(drawings())
    for code, parts in rough.items():
        shipped, rough_shape = template_from_drawing(code, drawings()[code]), template_from_drawing(code, parts)
        for pair in itertools.combinations(range(len(parts)), 2):
            one, other = (handedness(*(shape.parts[k] for k in pair)) for shape in (shipped, rough_shape))
            assert one == other, (code, pair)


def smallest_in(stitch: Stitch, twists: tuple[int, ...]) -> float:
    """Smallest distance of yarns among knit and among purl stitches [radii]; touching yarns are 2 apart."""
    found = []
    for plain in (Stitch.KNIT, Stitch.PURL):
        yarns = generate_yarns(surround_stitch(stitch, twists, plain)[0], yarn_radius=RADIUS_OVER_WIDTH)
        found.append(smallest_distance(yarns, 2 * RADIUS_OVER_WIDTH)[0])
    return min(found) / RADIUS_OVER_WIDTH


@each_drawn
def test_stitches_start_at_least_a_radius_from_their_neighbours_and_twisted_ones_three_quarters_of_it(stitch):
    """The other stitches are mirror images of these, or these turned over."""
    assert smallest_in(stitch, ()) > 1.0
    for turn in (1, -1):
        assert smallest_in(stitch, (turn,) * VOCABULARY[stitch].n_top) > 0.75, turn


def test_marks_on_top_sides_twist_the_loops_of_these_sides():
    """Top sides run from right to left, but twists are listed from left to right."""
    fabric, centre = surround_stitch(Stitch.KY, (1, 0))
    parts = place_parts(fabric, RADIUS_OVER_WIDTH, 20)
    shape, first = template_of(Stitch.KY, (1, 0)), fabric.face_start[centre]
    for number in np.flatnonzero(parts.face == centre):
        part = shape.parts[parts.index[number]]
        points = parts.points[parts.start[number] : parts.start[number + 1]]
        # the face has the proportions of its template, so the map is the identity up to rounding
        expected = part.resampled(len(points)) * [1.0, 1.0, RADIUS_OVER_WIDTH]
        np.testing.assert_allclose(points, expected, atol=1e-9)
        assert parts.end_side[number].tolist() == [first + part.start.place, first + part.end.place]


def test_a_slipped_loop_is_yarn_of_the_row_that_made_it():
    fabric, centre = surround_stitch(Stitch.SLIP_BACK)
    stitch = fabric.stitch.copy()
    above = fabric.side_face[fabric.twin[fabric.face_start[centre] + 2]]
    stitch[above] = Stitch.SLIP_BACK
    parts = place_parts(replace(fabric, stitch=stitch), RADIUS_OVER_WIDTH, 20)
    row_of = {int(face): parts.row[(parts.face == face) & (parts.index < 2)].tolist() for face in (centre, above)}
    assert fabric.row[centre] == 1 and row_of == {centre: [0, 0], above: [0, 0]}


def test_a_panel_and_a_stitch_that_does_not_fit_its_face_are_refused():
    with pytest.raises(YarnError, match="tessellate the mesh first"):
        template(Stitch.PANEL, 1, 1)
    with pytest.raises(YarnError, match="KPK on 1 bottom and 2 top sides"):
        template(Stitch.KPK, 1, 2)
