# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tessellation makes exactly the stitches of the given counts, joined without gaps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError, TessellationError
from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.mesh import BORDER, BOTTOM, StitchMesh
from stitchmesh.mesh.mean_value import mean_value_weights
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.tessellate import tessellate
from stitchmesh.tessellate.counts import reached_sizes
from stitchmesh.tessellate.courses import stitch_widths
from tests.gallery import FLAT_AND_ROUND, GARMENTS, ROOT, closed_cone, grid, pentagon_row, shared, tube
from tests.meshrelax.fabrics import rotation
from tests.nightly import mostly_at_night
from tests.shaking import shaken

pytestmark = pytest.mark.decides


def euler(mesh: StitchMesh) -> int:
    return len(mesh.vertices) - len(mesh.edge_side) + mesh.face_count


def assert_legal(fabric: StitchMesh) -> None:
    """Check that each face has one to three loops on its wide side and at most one on its narrow side."""
    wide = np.maximum(fabric.n_bottom, fabric.n_top)
    narrow = np.minimum(fabric.n_bottom, fabric.n_top)
    assert wide.min() >= 1 and wide.max() <= 3 and narrow.max() <= 1
    assert (fabric.stitch != Stitch.PANEL).all()


@pytest.mark.parametrize("name", FLAT_AND_ROUND)
def test_tessellation_preserves_the_topology_without_t_junctions(name):
    """A T-junction would be a gap with its own border; the borders must have the same lengths as those of the input."""
    labeled = label(FLAT_AND_ROUND[name]())
    fabric = tessellate(labeled, stitch_width=0.3)
    assert euler(fabric) == euler(labeled)
    assert_legal(fabric)
    before = sorted(labeled.side_length[loop].sum() for loop in labeled.boundary_loops)
    after = sorted(fabric.side_length[loop].sum() for loop in fabric.boundary_loops)
    np.testing.assert_allclose(after, before, rtol=1e-12)  # Sums of parts of the same straight sides.


def test_given_counts_determine_the_number_of_faces():
    fabric = tessellate(label(grid(1, 1)), stitch_width=0.5, counts={(0, 1): 7, (2, 3): 7, (0, 2): 5})
    assert (fabric.n_bottom == 1).all() and (fabric.n_top == 1).all()
    assert np.bincount(fabric.row).tolist() == [7] * 5


def test_stitches_have_the_requested_size():
    fabric = tessellate(label(grid(5, 4, width=4.0, height=3.85)), stitch_width=0.8)
    np.testing.assert_allclose(fabric.side_length[~fabric.is_wale], 0.8, rtol=1e-12)
    # There are 3.85 / (0.77 * 0.8) = 6.25 courses, rounded to 6.
    np.testing.assert_allclose(fabric.side_length[fabric.is_wale], 3.85 / 6, rtol=1e-12)


def test_the_two_wale_edges_of_a_face_have_one_count():
    """If the wale edges of a panel differ in length, both are divided into the same number, as in the whole row."""
    labeled = label(tube(8, 3, radius=5.0, top_radius=2.0))
    fabric = tessellate(labeled, stitch_width=0.37)
    assert len(fabric.boundary_loops) == 2
    counts = np.bincount(fabric.row[fabric.side_face[fabric.right_wale]])
    assert len(counts) == fabric.row.max() + 1 and counts.min() >= 8


@pytest.mark.parametrize(("bottom", "top", "courses"), [(6, 9, 4), (9, 6, 4), (3, 1, 1), (2, 40, 5)])
def test_increases_and_decreases_add_up(bottom, top, courses):
    labeled = label(grid(1, 1))
    fabric = tessellate(labeled, stitch_width=1.0, counts={(0, 1): bottom, (2, 3): top, (0, 2): courses})
    below = [int(fabric.n_bottom[fabric.row == row].sum()) for row in range(courses)]
    above = [int(fabric.n_top[fabric.row == row].sum()) for row in range(courses)]
    assert below[0] == bottom and above[-1] == top and below[1:] == above[:-1]


def test_increases_are_placed_at_both_wale_edges_or_at_the_marked_one():
    labeled = label(grid(1, 1))
    counts = {(0, 1): 8, (2, 3): 12, (0, 2): 4}
    for marked, expected in [((), {0, 1}), (((0, 2),), {0}), (((1, 3),), {1})]:
        fabric = tessellate(labeled, stitch_width=1.0, counts=counts, marked=marked)
        centre = np.add.reduceat(fabric.corner_position[:, 0], fabric.face_start[:-1]) / np.diff(fabric.face_start)
        ends = {int(centre[face] > 0.5) for face in np.flatnonzero(fabric.n_top > 1)}
        assert ends == expected


def test_a_course_edge_cannot_be_marked():
    with pytest.raises(ParameterError, match="is a course edge"):
        tessellate(label(grid(1, 1)), stitch_width=0.5, marked=[(0, 1)])


def test_a_pole_ends_in_stitches_without_a_top():
    fabric = tessellate(label(closed_cone(6)), stitch_width=0.5)
    assert (fabric.stitch == Stitch.DRAW_THROUGH).sum() == (fabric.n_top == 0).sum() > 0
    assert euler(fabric) == 1


def test_the_first_row_is_cast_on():
    fabric = tessellate(label(tube(8, 2)), stitch_width=0.5)
    on_border = (fabric.twin == BORDER) & (fabric.side_role == 0)
    assert set(fabric.side_face[on_border]) == set(np.flatnonzero(fabric.stitch == Stitch.CAST_ON))


@pytest.mark.parametrize("name", mostly_at_night([path.stem for path in GARMENTS], by_day=("glove",)))
def test_every_garment_tessellates(name):
    labeled = label(read_mesh(ROOT / "assets" / "meshes" / f"{name}.obj"))
    fabric = tessellate(labeled, stitch_width=1.0)
    assert_legal(fabric)
    assert euler(fabric) == euler(labeled)


def test_the_real_skirt_tessellates():
    labeled = label(read_mesh(shared("meshes/makehuman-helper-skirt.obj"), unit="dm"))
    fabric = tessellate(labeled, stitch_width=2.0)
    assert_legal(fabric)
    assert euler(fabric) == 0


def test_inner_points_of_a_flat_panel_stay_inside_it():
    fabric = tessellate(label(pentagon_row(), seeds=[(0, 1)]), stitch_width=0.2)
    assert (fabric.face_vector_area[:, 2] > 0).all()


def test_mean_value_weights_reproduce_linear_functions():
    polygon = np.array([[0.0, 0], [1, 0], [2, 0], [1.5, 1], [0.5, 1]])
    rng = np.random.default_rng(3)
    points = rng.uniform([0.6, 0.05], [1.4, 0.95], (50, 2))
    on_sides = np.array([[0.25, 0.0], [1.75, 0.0], [1.75, 0.5], [1.0, 1.0], [0.0, 0.0]])
    for at in (points, on_sides):
        weights = mean_value_weights(polygon, at)
        np.testing.assert_allclose(weights @ polygon, at, atol=1e-12)  # Rounding of a few dozen operations.
        np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-14)
        assert weights.min() > -1e-12


def test_stitch_widths_sum_to_the_wide_side():
    for narrow in range(1, 6):
        for wide in range(narrow, 3 * narrow + 1):
            for marked in ("", "left", "right"):
                widths = stitch_widths(narrow, wide, course=1, marked=marked)
                assert widths.sum() == wide and widths.min() >= 1 and widths.max() <= 3


def test_the_message_for_too_large_a_change_of_width_names_the_face():
    with pytest.raises(TessellationError, match="face 0: 1 stitches at the bottom and 20 at the top within 2"):
        tessellate(label(grid(1, 1)), stitch_width=0.5, counts={(0, 1): 1, (2, 3): 20, (0, 2): 2})


def test_two_counts_for_one_row_are_refused():
    with pytest.raises(TessellationError, match="all wale edges of a row take one count"):
        tessellate(label(grid(2, 1)), stitch_width=0.5, counts={(0, 3): 3, (2, 5): 4})


@pytest.mark.parametrize(
    ("width", "error", "message"),
    [
        (0.0, ParameterError, "expected a positive number"),
        (np.inf, ParameterError, "expected a positive number"),
        (1e3, ParameterError, "the widest row is 4 cm around"),
        (1e-4, TessellationError, r"needs about .* stitches and .* GB of memory"),
    ],
)
def test_a_stitch_width_out_of_range_is_refused(width, error, message):
    with pytest.raises(error, match=message):
        tessellate(label(grid(4, 4)), stitch_width=width)


def test_stitches_are_not_divided_again():
    fabric = tessellate(label(grid(2, 2)), stitch_width=0.5)
    with pytest.raises(TessellationError, match="face 0: is a stitch already"):
        tessellate(fabric, stitch_width=0.1)


@pytest.mark.parametrize("name", FLAT_AND_ROUND)
def test_shaken_meshes_have_the_same_stitches(name: str) -> None:
    """Wherever they lie in space; the edges are two stitches and a half long, where rounding could decide."""
    labeled = label(FLAT_AND_ROUND[name]())
    width = float(np.median(labeled.side_length)) / 2.5
    expected = tessellate(labeled, stitch_width=width)
    for seed in range(4):
        turned = labeled.vertices @ rotation(seed) + 1.0 if seed > 1 else labeled.vertices
        found = tessellate(replace(labeled, vertices=shaken(turned, seed)), stitch_width=width)
        for field in ("face_vertex", "n_bottom", "n_top", "stitch", "row"):
            np.testing.assert_array_equal(getattr(found, field), getattr(expected, field))


def test_a_stitch_as_wide_as_the_whole_row_is_accepted_however_shaken() -> None:
    labeled = label(grid(3, 3))
    around = max(np.bincount(labeled.row[labeled.side_face], labeled.side_length * (labeled.side_role == BOTTOM)))
    for seed in range(4):
        shake = replace(labeled, vertices=shaken(labeled.vertices @ rotation(3), seed))
        assert tessellate(shake, stitch_width=around).face_count > 0


def test_the_reached_size_is_the_median_with_percentiles():
    """4 x 3 unit faces at a width of 0.24: rint(1 / 0.24) = 4 stitches along a side, rint(1 / 0.1848) = 5 courses."""
    sizes = reached_sizes(tessellate(label(grid(4, 3)), stitch_width=0.24))
    assert sizes["width_cm"] == {"median": 0.25, "p5": 0.25, "p95": 0.25}
    assert sizes["height_cm"] == {"median": 0.2, "p5": 0.2, "p95": 0.2}


def test_a_size_that_is_not_met_is_said(caplog):
    tessellate(label(grid(30, 30)), stitch_width=0.5)
    assert not caplog.records
    tessellate(label(grid(30, 30)), stitch_width=2.0)
    (line,) = [record.message for record in caplog.records]
    assert "stitch width: asked for 2 cm, reached 1 cm (median)" in line and "faces have a width of 1 cm" in line


def test_a_size_that_the_faces_are_far_too_small_for_is_refused():
    """A stitch 5 cm wide would be five faces wide; 1 / (1 - 0.2) = 1.25 cm is 20 % more than a face."""
    message = "got 5 cm, but each face holds at least one stitch, .* at most 1.2 cm is possible"
    with pytest.raises(TessellationError, match=message):
        tessellate(label(grid(30, 30)), stitch_width=5.0)
    message = "stitch height: got 4.5 cm, but .* have a height of 1 cm"
    with pytest.raises(TessellationError, match=message):
        tessellate(label(grid(30, 30)), stitch_width=1.0, stitch_height=4.5)
