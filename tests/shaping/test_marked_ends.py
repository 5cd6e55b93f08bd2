# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The ends of a surface with marks: what marks name, and what the other borders are then."""

from __future__ import annotations

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.shaping.marks import marked_ends
from stitchmesh.shaping.triangle_surface import TriangleSurface, triangle_surface
from tests.gallery import ROOT
from tests.shaping.surfaces import closed_ball, in_triangles

UP = np.array([0.0, 1.0, 0.0])
PLACES = {"hem": [0.0, 0.0, 13.0], "neck": [0.0, 60.0, 5.0], "left": [56.0, 10.0, 7.0], "right": [-56.0, 10.0, 7.0]}
"""A point near each border of the sweater [cm]."""


@pytest.fixture(scope="module")
def sweater() -> TriangleSurface:
    return triangle_surface(in_triangles(sm.read_mesh(ROOT / "assets" / "meshes" / "sweater.obj")), 5.0)


def roles(surface: TriangleSurface, *marks: sm.TimeMark) -> tuple[set[str], set[str]]:
    """Names of the borders of the sweater at which knitting begins, and of those at which it ends."""
    ends = marked_ends(surface, marks, UP)
    return tuple({named(surface, end.vertices) for end in some} for some in (ends.begin_ends, ends.finish_ends))


def named(surface: TriangleSurface, vertices: np.ndarray) -> str:
    """Name of a border; ``tip`` for a single vertex."""
    away = {name: np.linalg.norm(surface.vertices[vertices] - place, axis=1).min() for name, place in PLACES.items()}
    return "tip" if len(vertices) == 1 else min(away, key=away.get)


def border(name: str, role: str) -> sm.TimeMark:
    return sm.TimeMark("border", [PLACES[name]], role)


UPWARDS = ({"hem", "left", "right"}, {"neck"})
DOWNWARDS = ({"neck"}, {"hem", "left", "right"})


@pytest.mark.parametrize(
    ("marks", "expected"),
    [
        ([], UPWARDS),
        ([("hem", "begin")], UPWARDS),
        ([("neck", "end")], UPWARDS),
        ([("neck", "begin")], DOWNWARDS),
        ([("hem", "end")], DOWNWARDS),
        ([("neck", "begin"), ("hem", "end")], DOWNWARDS),
        ([("hem", "begin"), ("left", "end")], ({"hem", "right"}, {"left", "neck"})),
        ([("left", "side")], ({"hem", "right"}, {"neck"})),
    ],
)
def test_borders_without_a_mark_keep_their_roles_or_turn_with_the_garment(sweater, marks, expected):
    assert roles(sweater, *(border(*mark) for mark in marks)) == expected


@pytest.mark.parametrize("role", ["begin", "end"])
def test_a_marked_tip_changes_no_border(sweater, role):
    begins, finishes = roles(sweater, sm.TimeMark("point", [[0.0, 30.0, 13.0]], role))
    assert (begins - {"tip"}, finishes - {"tip"}) == UPWARDS and "tip" in (begins if role == "begin" else finishes)


def test_a_plain_mark_changes_no_end(sweater):
    assert roles(sweater, sm.TimeMark("stroke", [[0.0, 10.0, 13.0], [0.0, 40.0, 13.0]], "plain")) == UPWARDS


def test_knitting_ends_at_the_only_border_if_a_tip_begins_and_the_other_way_round():
    sock = triangle_surface(in_triangles(sm.read_mesh(ROOT / "assets" / "meshes" / "sock.obj")), 2.0)
    toe = sock.vertices[sock.vertices[:, 2].argmax()].tolist()
    for role, begins in (("begin", "tip"), ("end", "border")):
        ends = marked_ends(sock, [sm.TimeMark("point", [toe], role)], UP)
        first, last = ("tip" if len(some) == 1 and len(some[0].vertices) == 1 else "border"
                       for some in (ends.begin_ends, ends.finish_ends))  # fmt: skip
        assert first == begins and last != begins


def test_a_closed_surface_with_one_marked_tip_has_no_other_given_end():
    top = sm.TimeMark("point", [[0.0, 6.0, 0.0]], "begin")
    ends = marked_ends(triangle_surface(closed_ball(12, 8), 2.0), [top], UP)
    assert ends.begins and len(ends.all) == 1


def test_a_glove_begins_at_its_cuff_and_ends_at_all_fingertips():
    """Its fingertips have holes of 2 cm, one of which is the highest border."""
    glove = triangle_surface(in_triangles(sm.read_mesh(ROOT / "assets" / "meshes" / "glove.obj")), 1.0)
    ends = marked_ends(glove, [], UP)
    assert len(ends.begin_ends) == 1 and len(ends.finish_ends) == 5
    assert glove.vertices[ends.begin_ends[0].vertices, 1].max() < 1.0
