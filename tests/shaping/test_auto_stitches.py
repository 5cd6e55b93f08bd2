# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches on any surface: legal, of the right size and number, and the same whatever the rounding."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import MeshError, ParameterError, TessellationError
from stitchmesh.mesh import BORDER, Mesh, StitchMesh
from stitchmesh.mesh.courses import find_courses
from stitchmesh.mesh.shaping_stitches import stitch_counts
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.mesh.turns import turn_slits
from stitchmesh.selection.parts import face_centres
from stitchmesh.shaping.report import distance_to_surface
from tests.gallery import ROOT, grid, shared, tube
from tests.nightly import at_night
from tests.shaking import shaken
from tests.shaping.surfaces import closed_ball, in_triangles, ring_torus

MESHES = ROOT / "assets" / "meshes"


def euler(mesh: Mesh) -> int:
    """Euler characteristic; the slits of turns, which are no holes of the garment, do not count."""
    return len(mesh.vertices) - len(mesh.edge_side) + mesh.face_count + turns(mesh)


def turns(mesh: Mesh) -> int:
    return len(turn_slits(mesh)) if isinstance(mesh, StitchMesh) else 0


def garment(name: str) -> Mesh:
    return in_triangles(sm.read_mesh(MESHES / f"{name}.obj"))


@cache
def stitches_of(name: str, width: float) -> StitchMesh:
    return sm.auto_stitches(garment(name), stitch_width=width)


@pytest.mark.decides
def test_polygons_with_straight_corners_give_the_same_stitches_for_every_first_corner():
    case = "cases/field/02-square-tube-straight-corners"
    found = [sm.auto_stitches(sm.read_mesh(shared(f"{case}{end}.obj")), stitch_width=1.6) for end in ("", "-turned")]
    assert [len(fabric.face_start) for fabric in found] == 2 * [len(found[0].face_start)]
    assert found[0].face_count == pytest.approx(380, rel=0.02)  # 48 cm around over 1.6 cm, times 16 cm of rows.


def sizes_of_rounds(fabric: StitchMesh) -> list[int]:
    return sorted(len(course.faces) for course in find_courses(fabric) if course.closed)


def test_a_tube_has_the_rows_and_stitches_of_its_size():
    mesh = in_triangles(tube(40, 10, radius=4.0))
    fabric = sm.auto_stitches(mesh, stitch_width=0.8, stitch_height=0.5)
    around = 40 * 2 * 4.0 * np.sin(np.pi / 40)  # Perimeter of the polygon with 40 corners.
    assert sizes_of_rounds(fabric) == [round(around / 0.8)] * 20
    assert stitch_counts(fabric) == {"faces": fabric.face_count, "increases": 0, "decreases": 0}
    heights = sorted(fabric.vertices[fabric.face_vertex[loop], 1].mean() for loop in fabric.boundary_loops)
    np.testing.assert_allclose(heights, [0.0, 10.0], atol=1e-9)  # The two ends of the tube are level lines themselves.
    assert (fabric.twin == BORDER).sum() == sum(len(loop) for loop in fabric.boundary_loops)


def test_a_flat_piece_is_knitted_to_and_fro_from_its_lower_side():
    fabric = sm.auto_stitches(in_triangles(grid(6, 8)), stitch_width=0.5, stitch_height=0.4)
    courses = find_courses(fabric)
    assert [len(course.faces) for course in courses] == [12] * 20 and not any(course.closed for course in courses)
    first = fabric.stitch == Stitch.CAST_ON
    # A cast-on stitch stands on the lower side y = 0.
    assert np.allclose(fabric.vertices[fabric.face_vertex[fabric.face_start[:-1][first]], 1], 0.0, atol=1e-9)


@pytest.mark.decides
@pytest.mark.parametrize("corners", [[0, 1, 2], [2, 1, 0]], ids=["front", "back"])
def test_a_shawl_with_a_right_angle_narrows_from_its_lower_side(corners):
    # Its slanting side faces upwards by 45 degrees and shares a corner with the first row.
    triangle = Mesh.from_polygons(np.array([[0.0, 0.0, 0.0], [20.0, 0.0, 0.0], [0.0, 20.0, 0.0]]), [corners])
    shaped = sm.shape_fabric(triangle, stitch_width=0.8, progress=False)
    assert shaped.fabric.n_bottom[shaped.fabric.row == 0].sum() == 25  # 20 cm in stitches of 0.8 cm
    assert not any(course.closed for course in find_courses(shaped.fabric))


@pytest.mark.decides
@pytest.mark.parametrize(
    ("name", "width"),
    [("sweater", 3.0), *at_night(("sock", 1.4), ("tea_cozy", 1.4), ("sheep", 3.0), ("dress", 1.6))],
)
def test_triangulated_garments_keep_their_topology(name, width):
    mesh = garment(name)
    fabric = stitches_of(name, width)
    assert euler(fabric) == euler(mesh)
    assert len(fabric.boundary_loops) - turns(fabric) == len(mesh.boundary_loops)
    assert max(fabric.n_bottom.max(), fabric.n_top.max()) <= 3 and fabric.n_bottom.min() >= 1


@pytest.mark.decides
@pytest.mark.parametrize("mesh", [ring_torus(16, 48), closed_ball(24, 20)], ids=["torus", "ball"])
def test_closed_surfaces_are_open_at_two_tips_only(mesh):
    shaped = sm.shape_fabric(mesh, stitch_width=0.9)
    fabric = shaped.fabric
    assert shaped.report.lost is None
    assert euler(fabric) == euler(mesh) - 2  # Each tip is a hole through whose few loops a yarn is drawn.
    assert len(fabric.boundary_loops) == 2 and max(len(loop) for loop in fabric.boundary_loops) <= 20


def test_the_border_of_a_fabric_on_a_closed_surface_is_free_on_it():
    shaped = sm.shape_fabric(closed_ball(24, 20), stitch_width=0.9)
    relaxed = sm.relax_mesh(shaped.fabric, surface=shaped.surface.mesh).fabric
    border = relaxed.face_vertex[relaxed.twin == BORDER]
    # The surface for relaxation lies off the given faces by a small part of a stitch.
    assert distance_to_surface(relaxed.vertices[border], shaped.given).max() < 0.3 * 0.9
    assert 0.5 < relaxed.stretch.min() and relaxed.stretch.max() < 1.6


@pytest.mark.decides
def test_rounding_changes_no_stitch():
    mesh = garment("sweater")
    fabric = stitches_of("sweater", 3.0)
    other = sm.auto_stitches(Mesh.from_polygons(shaken(mesh.vertices, 0), mesh.face_vertex.reshape(-1, 3).tolist()),
                             stitch_width=3.0)  # fmt: skip
    for name in ("face_vertex", "twin", "n_bottom", "n_top", "stitch", "row"):
        np.testing.assert_array_equal(getattr(other, name), getattr(fabric, name))


def test_decreases_are_spread_around_a_tube():
    mesh = in_triangles(tube(32, 10, radius=5.0, height=3.0, top_radius=3.0))
    fabric = sm.auto_stitches(mesh, stitch_width=0.6)
    counts = stitch_counts(fabric)
    shaped = np.flatnonzero((fabric.n_bottom != 1) | (fabric.n_top != 1))
    assert len(shaped) == counts["increases"] + counts["decreases"] > 15
    middle = face_centres(fabric, shaped)
    turn = np.exp(1j * np.arctan2(middle[:, 2], middle[:, 0]))
    # The mean of n unit vectors that turn by the golden ratio is at most 1 / (n sin(pi 0.618)) = 0.07 long; the rest is
    # for the whole stitches between which a place is chosen. All in one line, the mean is 1 long.
    assert abs(turn.mean()) < 0.15
    assert abs((turn**2).mean()) < 0.15  # nor are they in two lines at opposite sides


@pytest.mark.decides
def test_both_sleeves_of_a_symmetric_sweater_have_the_same_rounds():
    fabric = stitches_of("sweater", 3.0)
    sides: dict[bool, list[int]] = {False: [], True: []}
    for course in find_courses(fabric):
        middle = fabric.vertices[fabric.face_vertex[fabric.sides_of(np.array(course.faces))]].mean(axis=0)
        if abs(middle[0]) > 10.0:  # Beyond the body, whose courses are centred.
            sides[bool(middle[0] > 0.0)].append(len(course.faces))
    assert len(sides[True]) > 10 and sorted(sides[True]) == sorted(sides[False])


def test_rounds_are_multiples_of_what_a_pattern_repeats():
    fabric = sm.auto_stitches(garment("hat"), stitch_width=1.6, options=sm.ShapingOptions(multiple=4))
    counts = [int(fabric.n_top[list(course.faces)].sum()) for course in find_courses(fabric) if course.closed]
    assert counts and not any(count % 4 for count in counts)


@pytest.mark.parametrize(("name", "width"), [("hat", 1.6), *at_night(("glove", 0.5), ("tea_cozy", 1.6))])
def test_stitches_relax_on_the_surface_and_their_loops_hold_one_another(name, width):
    shaped = sm.shape_fabric(garment(name), stitch_width=width)
    relaxed = sm.relax_mesh(shaped.fabric, surface=shaped.surface.mesh).fabric
    # A vertex leaves the given faces by what the smoothing takes off, a small part of a stitch.
    assert distance_to_surface(relaxed.vertices, shaped.given).max() < 0.5 * width
    yarns = sm.generate_yarns(relaxed)
    sm.check_loops(relaxed, yarns)
    assert yarns.yarn_count > 1


def test_parts_are_knitted_one_after_another():
    near, far = (in_triangles(tube(16, 4, radius=2.0)) for _ in range(2))
    vertices = np.concatenate([near.vertices, far.vertices + np.array([10.0, 0.0, 0.0])])
    faces = np.concatenate([near.face_vertex, far.face_vertex + len(near.vertices)]).reshape(-1, 3)
    both = sm.auto_stitches(Mesh.from_polygons(vertices, faces.tolist()), stitch_width=0.6)
    alone = sm.auto_stitches(near, stitch_width=0.6)
    assert both.face_count == 2 * alone.face_count and euler(both) == 2 * euler(alone)
    assert len(np.unique(both.row)) == 2 * len(np.unique(alone.row))


def test_short_rows_add_rows_at_a_heel_unless_they_are_not_wanted():
    plain = sm.auto_stitches(garment("sock"), stitch_width=1.2, options=sm.ShapingOptions(short_rows=False))
    turned = stitches_of("sock", 1.2)
    slits = [loop for loop in turned.boundary_loops if len(loop) == 2]
    assert len(slits) > 0 and not any(len(loop) == 2 for loop in plain.boundary_loops)
    assert turned.face_count > plain.face_count


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"stitch_width": 0.0}, ParameterError, "stitch width"),
        ({"stitch_width": 1.0, "stitch_height": -1.0}, ParameterError, "stitch height"),
        ({"stitch_width": 1.0, "options": "seams"}, ParameterError, "auto_stitches, options: got the text 'seams'"),
        ({"stitch_width": 50.0}, MeshError, "room for"),
        ({"stitch_width": 1e-4}, TessellationError, "larger stitch"),
    ],
)
def test_what_cannot_be_knitted_is_refused_in_one_line(arguments, error, words):
    with pytest.raises(error, match=words) as caught:
        sm.auto_stitches(in_triangles(tube(16, 4)), **arguments)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [({"up": (0.0, 0.0, 0.0)}, "up"), ({"most_shaping": 0.0}, "most shaping: got 0.0; expected a part")],
)
def test_wrong_options_are_refused_in_one_line(arguments, words):
    with pytest.raises(ParameterError, match=words) as caught:
        sm.ShapingOptions(**arguments)
    assert "\n" not in str(caught.value)


def test_progress_is_reported_within_a_part_and_can_stop_the_search():
    calls: list[tuple[float, str]] = []
    sm.shape_fabric(garment("hat"), stitch_width=2.0, progress=lambda _, done, note: calls.append((done, note)))
    done = [part for part, _ in calls]
    assert done == sorted(done) and len(done) > 6 and 0.0 <= done[0] and done[-1] < 1.0
    assert {"time", "lines", "rows"} < {note for _, note in calls}

    def stop(_: str, part: float, note: str) -> None:
        calls.append((part, note))
        if note == "rows":
            raise KeyboardInterrupt

    calls.clear()
    with pytest.raises(KeyboardInterrupt):
        sm.shape_fabric(garment("hat"), stitch_width=2.0, progress=stop)
    assert [note for _, note in calls].count("rows") == 1
