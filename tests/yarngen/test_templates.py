# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Each stitch template alone: crossings, and what its yarn passes through."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from stitchmesh.errors import YarnError
from stitchmesh.stitch import SIDE_COUNTS, Stitch
from stitchmesh.yarngen.plain import HEIGHT_IN_RADII, LOOP_WIDTH, knit, purl
from stitchmesh.yarngen.table import ANY_SIDES, FIXED, template
from stitchmesh.yarngen.template import (
    STITCH_HEIGHT,
    Crossing,
    Part,
    Template,
    crossing_point,
    mirrored,
    trapezoid,
    turned_over,
)

KINDS = [(stitch, *SIDE_COUNTS[stitch]) for stitch in FIXED] + [
    (Stitch.CAST_ON, 1, 1), (Stitch.CAST_ON, 0, 1), (Stitch.CAST_ON, 0, 2), (Stitch.CAST_ON, 2, 3),
    (Stitch.BIND_OFF, 1, 1), (Stitch.DRAW_THROUGH, 1, 0), (Stitch.DRAW_THROUGH, 3, 0),
]  # fmt: skip
EMPTY_BOTTOM, EMPTY_TOP = {Stitch.CAST_ON}, {Stitch.BIND_OFF, Stitch.DRAW_THROUGH}
each_kind = pytest.mark.parametrize(("stitch", "n_bottom", "n_top"), KINDS)


def expected_crossings(stitch: Stitch, n_bottom: int, n_top: int) -> set[tuple[int, int]]:
    """Two on every course side that yarn crosses, one on each wale side."""
    sides = {(n_bottom, 0), (n_bottom + n_top + 1, 0)}
    if stitch not in EMPTY_BOTTOM:
        sides |= {(place, slot) for place in range(n_bottom) for slot in (0, 1)}
    if stitch not in EMPTY_TOP:
        sides |= {(n_bottom + 1 + place, slot) for place in range(n_top) for slot in (0, 1)}
    return sides


@each_kind
def test_yarn_crosses_each_course_side_twice_and_each_wale_side_once(stitch, n_bottom, n_top):
    ends = [(c.place, c.slot) for part in template(stitch, n_bottom, n_top).parts for c in (part.start, part.end)]
    assert len(ends) == len(set(ends))
    assert set(ends) == expected_crossings(stitch, n_bottom, n_top)


@each_kind
def test_parts_start_and_end_at_common_places_at_height_zero(stitch, n_bottom, n_top):
    for part in template(stitch, n_bottom, n_top).parts:
        for crossing, point in ((part.start, part.curve[0]), (part.end, part.curve[-1])):
            # the plain loop is closed to 1e-12 by its formula; splines hit their waypoints exactly
            np.testing.assert_allclose(point, crossing_point(n_bottom, n_top, crossing), atol=1e-9)


@each_kind
def test_yarn_stays_within_its_face(stitch, n_bottom, n_top):
    corners = trapezoid(n_bottom, n_top)
    inward = np.roll(corners, -1, axis=0) - corners
    inward = np.stack([-inward[:, 1], inward[:, 0]], axis=1) / np.linalg.norm(inward, axis=1)[:, None]
    for part in template(stitch, n_bottom, n_top).parts:
        depth = np.einsum("kd,pkd->pk", inward, part.curve[:, None, :2] - corners[None])
        assert depth.min() > -0.02  # splines swing a sixth of a radius over a side where they meet it steeply


def test_the_plain_loop_is_the_closed_form():
    """A face holds t in (-pi/2, pi/2) of the lower row and the rest of its own row, 4.5 higher."""
    head, left, right = knit().parts
    for part, first, last, lift in ((head, -0.5, 0.5, 0.0), (left, -1.0, -0.5, 4.5), (right, 0.5, 1.0, 4.5)):
        t = np.linspace(first, last, len(part.curve)) * np.pi
        x, y = (t + 1.5 * np.sin(2 * t)) / LOOP_WIDTH + 0.5, (4 * np.cos(t) + lift) / LOOP_WIDTH
        np.testing.assert_allclose(part.curve[:, :2], np.stack([x, y], axis=1), atol=1e-14)
        middle = len(t) // 2
        assert part.curve[middle, 2] == pytest.approx(-np.cos(2 * t[middle]) * HEIGHT_IN_RADII, rel=1e-12)


def test_purl_is_knit_turned_over():
    for front, back in zip(knit().parts, purl().parts, strict=True):
        np.testing.assert_array_equal(front.curve * [1, 1, -1], back.curve)


@each_kind
def test_a_mirror_image_of_a_mirror_image_is_the_original(stitch, n_bottom, n_top):
    original = template(stitch, n_bottom, n_top)
    for part, twice in zip(original.parts, mirrored(mirrored(original)).parts, strict=True):
        np.testing.assert_allclose(part.curve, twice.curve, atol=1e-14)
        assert (part.start, part.end) == (twice.start, twice.end)


def crossings_between(first: Part, second: Part) -> list[int]:
    """For each crossing of two parts seen from the right side: 1 where ``first`` lies in front, -1 behind."""
    result = []
    a, b = first.curve, second.curve
    u, v = np.diff(a[:, :2], axis=0), np.diff(b[:, :2], axis=0)
    for i, j in itertools.product(range(len(u)), range(len(v))):
        det = u[i, 0] * v[j, 1] - u[i, 1] * v[j, 0]
        if abs(det) < 1e-15:
            continue
        gap = b[j, :2] - a[i, :2]
        s, t = (gap[0] * v[j, 1] - gap[1] * v[j, 0]) / det, (gap[0] * u[i, 1] - gap[1] * u[i, 0]) / det
        if 0 <= s < 1 and 0 <= t < 1:
            ahead = a[i, 2] + s * (a[i + 1, 2] - a[i, 2]) - b[j, 2] - t * (b[j + 1, 2] - b[j, 2])
            result.append(int(np.sign(ahead)))
    return result


def loops(shape: Template) -> tuple[list[Part], list[Part]]:
    return [p for p in shape.parts if p.is_head], [p for p in shape.parts if not p.is_head]


@pytest.mark.parametrize("stitch", [Stitch.KNIT, Stitch.D12K, Stitch.D21K, Stitch.D213K])
def test_a_knitted_loop_comes_through_every_loop_from_behind(stitch):
    """Each foot passes behind a head's leg, then its leg passes in front of the head's top: through it once."""
    heads, feet = loops(template(stitch, *SIDE_COUNTS[stitch]))
    for head in heads:
        for foot in feet:
            signs = crossings_between(foot, head)
            assert sum(signs) == 0 and signs.count(-1) >= 1


def test_a_purled_loop_comes_through_from_the_front():
    heads, feet = loops(purl())
    for foot in feet:
        assert sorted(crossings_between(foot, heads[0])) == [-1, 1]
    left_signs = crossings_between(feet[0], heads[0])
    assert left_signs[0] == 1, "the foot, which comes first along the part, lies in front"


@pytest.mark.parametrize("stitch", [Stitch.D12K, Stitch.D21K, Stitch.D213K])
def test_loops_knitted_together_lie_in_layers_and_are_not_linked(stitch):
    heads, _ = loops(template(stitch, *SIDE_COUNTS[stitch]))
    for first, second in itertools.combinations(heads, 2):
        signs = crossings_between(first, second)
        assert len(set(signs)) == 1 and len(signs) % 2 == 0


def test_the_left_loop_is_in_front_in_d12_and_behind_in_d21():
    for stitch, sign in ((Stitch.D12K, 1), (Stitch.D21K, -1)):
        heads, _ = loops(template(stitch, 2, 1))
        left, right = sorted(heads, key=lambda part: part.start.place)
        assert set(crossings_between(left, right)) == {sign}


@pytest.mark.parametrize("stitch", [Stitch.KY, Stitch.YK, Stitch.KYK])
def test_the_yarn_of_an_increase_hooks_around_the_head(stitch):
    """Between a knitted loop and a yarn-over the yarn goes down in front of the head and up behind it."""
    heads, own = loops(template(stitch, *SIDE_COUNTS[stitch]))
    tops = range(2, 2 + SIDE_COUNTS[stitch][1])  # places of the top sides, after one bottom and the right wale side
    hooks = [part for part in own if part.start.place in tops and part.end.place in tops]
    assert len(hooks) == SIDE_COUNTS[stitch][1] - 1
    for hook in hooks:
        assert sorted(crossings_between(hook, heads[0])) == [-1, 1]


def test_cast_on_loops_are_crossed():
    first, second = template(Stitch.CAST_ON, 1, 1).parts
    assert len(crossings_between(first, second)) % 2 == 1


def test_the_drawn_yarn_passes_behind_one_leg_and_in_front_of_the_other():
    for stitch, n_bottom, n_top in [(Stitch.BIND_OFF, 1, 1), (Stitch.DRAW_THROUGH, 3, 0)]:
        heads, (thread,) = loops(template(stitch, n_bottom, n_top))
        for head in heads:
            assert crossings_between(thread, head) == [-1, 1]


def test_even_points_are_even():
    for part in knit().parts:
        points = part.evenly(12)
        steps = np.linalg.norm(np.diff(points * [1, 1, 1 / 8], axis=0), axis=1)
        # chords of equal arcs differ where the yarn bends: by at most (arc * curvature)^2 / 24, 8% here
        assert steps.max() / steps.min() < 1.15


def test_turning_over_twice_changes_nothing():
    for part, twice in zip(knit().parts, turned_over(turned_over(knit())).parts, strict=True):
        np.testing.assert_array_equal(part.curve, twice.curve)


def test_a_panel_has_no_yarn():
    with pytest.raises(YarnError, match="tessellate the mesh first"):
        template(Stitch.PANEL, 1, 1)


def test_every_stitch_has_a_template_but_the_panel():
    assert set(FIXED) | set(ANY_SIDES) | {Stitch.PANEL} == set(Stitch)


def test_crossings_lie_at_quarters_and_a_ninth():
    assert crossing_point(1, 1, Crossing(0, 0)) == (0.25, 0.0, 0.0)
    assert crossing_point(1, 1, Crossing(2, 0)) == (0.75, STITCH_HEIGHT, 0.0)
    assert crossing_point(1, 1, Crossing(3))[1] == pytest.approx(STITCH_HEIGHT / 9)
