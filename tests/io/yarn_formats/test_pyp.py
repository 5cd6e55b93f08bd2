# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Periodic yarn patterns: published files are read, cells are written and read, and errors name the line."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io import read_yarns, write_yarns
from stitchmesh.io.yarns import check_writable
from stitchmesh.lattice import Lattice
from stitchmesh.yarn import YarnSet
from tests.gallery import shared
from tests.io.refusals import refused
from tests.io.yarn_sets import awkward_yarns
from tests.yarnrelax.stockinette import periodic_patch, woven_cell

CELL = """*pattern # px py r n
0.02 0.01 0.001 3

*Q
0.001 0.002 0 0.5
0.008 0.002 0.001 0
-0.006 0.012 0 0

*E # sorted by where they go to
2 0 0 -1
0 1 0 0
1 2 1 -1

*RL # of the edges that leave vertices 0, 1, 2
0.007
0.006
0.008

*RK
0 0
0 0
0 0

*Other
anything at all
"""
"""One yarn of three vertices; the third vertex is in another image of the cell."""


def written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def knots(yarns: YarnSet) -> NDArray[np.float64]:
    """Return the starts of all segments [cm], shape (S, 3)."""
    return np.concatenate(yarns.sampled(1))


def in_the_cell(points: NDArray[np.float64], lattice: Lattice) -> NDArray[np.float64]:
    """Return points as fractions of the periods and heights, moved into the cell, sorted by their first nine digits."""
    share = points[:, :2] @ np.linalg.inv(lattice.periods[:, :2])
    places = np.column_stack([(share + 0.2503) % 1.0, points[:, 2]])  # No vertex is at the border.
    return places[np.lexsort(np.round(places, 9).T)]


def numbers_of(path: Path, block: str) -> NDArray[np.float64]:
    lines = path.read_text().split(f"*{block}")[1].split("\n\n")[0].splitlines()[1:]
    return np.array([[float(word) for word in line.split()] for line in lines])


def test_a_yarn_passes_through_its_vertices_in_continuous_coordinates(tmp_path):
    yarns = read_yarns(written(tmp_path / "y.pyp", CELL))
    np.testing.assert_allclose(yarns.lattice.periods, [[2, 0, 0], [0, 1, 0]])
    np.testing.assert_array_equal(yarns.lattice_step, [[1, -2]])
    # The third vertex is moved by one period along x and by minus one along y.
    np.testing.assert_allclose(knots(yarns), [[0.1, 0.2, 0], [0.8, 0.2, 0.1], [1.4, 0.2, 0]], atol=1e-15)
    np.testing.assert_allclose(yarns.rest_length, [0.7, 0.6, 0.8])
    np.testing.assert_allclose(yarns.radius, [0.1])


def test_ignored_twists_are_logged(tmp_path, caplog):
    with caplog.at_level(logging.WARNING, "stitchmesh"):
        read_yarns(written(tmp_path / "y.pyp", CELL.replace(" 0.5\n", " 0\n")))
        assert not caplog.text
        read_yarns(written(tmp_path / "y.pyp", CELL))
    assert "twists are ignored" in caplog.text


def zigzag(curvatures: NDArray[np.float64]) -> str:
    """Return a file of one yarn along x with edges of 1 cm at rest and the given numbers for RK."""
    count = len(curvatures)
    vertices = "\n".join(f"{0.01 * i} 0.002 {0.002 * (-1) ** i} 0" for i in range(count))
    edges = "\n".join(f"{i} {(i + 1) % count} {int(i + 1 == count)} 0" for i in range(count))
    lengths = "\n".join(["0.01"] * count)
    bends = "\n".join(f"{a!r} {b!r}" for a, b in curvatures.tolist())
    blocks = {"pattern": f"{0.01 * count} 0.01 0.001 {count}", "Q": vertices, "E": edges, "RL": lengths, "RK": bends}
    return "\n".join(f"*{name}\n{lines}\n" for name, lines in blocks.items())


@pytest.mark.parametrize("direction", [0.0, 1.0, 4.0])
def test_equal_rest_angles_give_a_circle(tmp_path, direction):
    """2 tan(phi / 2) at every vertex and edges of 1 cm give a circle of curvature phi, in every direction."""
    angle = 0.7
    size = 2 * np.tan(angle / 2)
    bends = np.tile([size * np.cos(direction), size * np.sin(direction)], (6, 1))
    yarns = read_yarns(written(tmp_path / "y.pyp", zigzag(bends)))
    np.testing.assert_allclose(np.abs(yarns.natural_curvature), angle, rtol=1e-12)  # Rounding of a linear system.
    assert len(set(np.sign(yarns.natural_curvature))) == 1


def test_rest_angles_are_means_of_the_natural_curvature_about_vertices(tmp_path):
    angles = np.random.default_rng(4).normal(scale=0.8, size=9)
    bends = np.stack([2 * np.tan(angles / 2), np.zeros(9)], axis=1)
    yarns = read_yarns(written(tmp_path / "y.pyp", zigzag(bends)))
    knots = yarns.natural_ends[:, 0]
    # The signs are compared too: they are kept if k2 is zero.
    np.testing.assert_allclose((np.roll(knots, 1) + 4 * knots + np.roll(knots, -1)) / 6, angles, rtol=1e-12)
    write_yarns(tmp_path / "again.pyp", yarns)
    np.testing.assert_allclose(numbers_of(tmp_path / "again.pyp", "RK"), bends, atol=1e-14)
    again = read_yarns(tmp_path / "again.pyp")
    np.testing.assert_allclose(again.natural_curvature, yarns.natural_curvature, rtol=1e-12)


def test_periods_that_are_not_those_of_the_yarns_give_a_warning(caplog):
    with caplog.at_level(logging.WARNING, "stitchmesh"):
        read_yarns(shared("periodic/stockinette.pyp"))
        assert "director" not in caplog.text
        read_yarns(shared("periodic/basket.pyp"))
    assert "the periods may not be those of the yarns" in caplog.text


@pytest.mark.parametrize(
    ("name", "steps", "periods"),
    [
        ("stockinette.pyp", [[1, 0]] * 2, (1.50513, 0.793099)),
        ("basket.pyp", [[1, 0]] * 4 + [[0, 1]] * 4, (1.07037, 1.03)),
    ],
)
def test_published_patterns_are_relaxed_cells(tmp_path, name, steps, periods):
    source = shared(f"periodic/{name}")
    yarns = read_yarns(source)
    np.testing.assert_array_equal(yarns.lattice_step, steps)
    np.testing.assert_allclose(yarns.lattice.periods, np.diag([*periods, 0])[:2], rtol=1e-12)
    file = numbers_of(source, "Q")[:, :3] * 100
    # Vertices are knots: the solution for the spline and its evaluation leave rounding errors.
    np.testing.assert_allclose(
        in_the_cell(knots(yarns), yarns.lattice), in_the_cell(file, yarns.lattice), atol=1e-12
    )
    # The lengths of relaxed stiff yarns differ from the rest lengths by at most a tenth. If the rest lengths were
    # shifted by one segment, the difference would be a third.
    assert np.abs(yarns.strain).max() < 0.1
    write_yarns(tmp_path / name, yarns)
    again = read_yarns(tmp_path / name)
    for field in ("lattice_step", "start", "row"):
        np.testing.assert_array_equal(getattr(again, field), getattr(yarns, field))
    np.testing.assert_allclose(again.rest_length, yarns.rest_length, rtol=1e-15)
    assert np.abs(yarns.natural_curvature).min() > 0.0
    np.testing.assert_allclose(again.natural_curvature, yarns.natural_curvature, rtol=1e-10)  # A linear system.


@pytest.mark.parametrize("cell", [periodic_patch(1, 1), periodic_patch(2, 3), woven_cell()])
def test_cells_are_written_and_read_up_to_whole_periods(tmp_path, cell):
    write_yarns(tmp_path / "y.pyp", cell)
    again = read_yarns(tmp_path / "y.pyp")
    np.testing.assert_array_equal(again.lattice_step, cell.lattice_step)
    np.testing.assert_allclose(again.lattice.periods, cell.lattice.periods, rtol=1e-15)
    np.testing.assert_allclose(again.radius, cell.radius, rtol=1e-15)
    np.testing.assert_allclose(again.rest_length, cell.rest_length, rtol=1e-15)
    moved = (again.points - cell.points)[cell.start[:-1]]
    share = moved[:, :2] / np.diag(cell.lattice.periods[:, :2])
    np.testing.assert_allclose(share, np.round(share), atol=1e-12)  # Rounding of a linear system.
    expected = cell.points + cell.lattice.shift(np.round(share))[cell.point_yarn]
    np.testing.assert_allclose(again.points, expected, atol=1e-12)


def test_vertices_are_written_in_the_cell_and_edges_in_their_order(tmp_path):
    cell = periodic_patch(2, 1)
    write_yarns(tmp_path / "y.pyp", cell)
    vertices, edges = numbers_of(tmp_path / "y.pyp", "Q"), numbers_of(tmp_path / "y.pyp", "E")
    sides = np.diag(cell.lattice.periods[:, :2]) / 100
    assert (vertices[:, :2] >= 0).all()
    assert (vertices[:, :2] <= sides).all()
    np.testing.assert_array_equal(edges[:, 0], np.arange(24))
    assert np.abs(edges[:, 2:]).max() == 1
    assert (np.linalg.norm(np.diff(vertices[:, :3], axis=0), axis=1) > sides.min() / 2).any()  # Edges cross the border.


def test_a_rotated_cell_is_along_the_axes_of_the_file(tmp_path):
    cell = periodic_patch(1, 1)
    turn = np.array([[0.0, 1.0, 0.0], [-0.6, 0.0, 0.8], [0.8, 0.0, 0.6]])
    turned = replace(cell, points=cell.points @ turn, lattice=Lattice(cell.lattice.periods @ turn))
    write_yarns(tmp_path / "a.pyp", cell)
    write_yarns(tmp_path / "b.pyp", turned)
    first, second = read_yarns(tmp_path / "a.pyp"), read_yarns(tmp_path / "b.pyp")
    np.testing.assert_allclose(
        in_the_cell(knots(second), first.lattice), in_the_cell(knots(first), first.lattice), atol=1e-12
    )


def test_yarns_that_the_format_cannot_hold_are_errors(tmp_path):
    cell = woven_cell()
    sheared = replace(cell, lattice=Lattice([[0.75, 0, 0], [0.1, 0.75, 0]]))
    mixed = replace(cell, radius=[0.1, 0.1, 0.1, 0.2])
    ending = replace(cell, closed=[True, True, True, False], rest_length=cell.rest_length[:-3])
    bad = [
        (awkward_yarns(), "the yarns are not periodic; the format holds only periodic yarns"),
        (sheared, "the periods are 82.41 degrees apart; the format holds right angles"),
        (mixed, "yarns of radius 0.1 to 0.2 cm; the format holds one radius"),
        (ending, "yarn 3 has ends; the format holds only yarns without ends"),
        (replace(cell, natural_curvature=np.full(len(cell.points), 90.0)), "turns the yarn by half a turn or more"),
    ]
    for yarns, message in bad:
        for refuse in (check_writable, write_yarns):
            with pytest.raises(FileError, match=message):
                refuse(tmp_path / "y.pyp", yarns)
    with pytest.raises(ParameterError, match="holds one period; leave the tiles out"):
        write_yarns(tmp_path / "y.pyp", cell, tiles=(2, 2))
    with pytest.raises(ParameterError, match="leave the unit out"):
        write_yarns(tmp_path / "y.pyp", cell, unit="mm")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0.02 0.01 0.001 3", "0.02 0.01 0.001 4", "line 4: block *Q has 3 lines and line 2 says 4; it was cut short"),
        ("0.008\n\n*RK", "\n*RK", "line 14: block *RL has 2 lines and line 2 says 3"),
        ("1 2 1 -1\n", "", "line 9: block *E has 2 lines and line 2 says 3"),
        ("0 1 0 0", "0 3 0 0", "line 11: got edge 0 3 0 0; expected vertices 0 to 2 and a whole shift"),
        ("0 1 0 0", "0 1 0.5 0", "line 11: got edge 0 1 0.5 0; expected"),
        ("0 1 0 0", "2 1 0 0", "line 11: 2 edges start at vertex 2; expected one, so that chains are closed"),
        ("0 1 0 0\n1 2", "0 0 0 0\n1 2", "2 edges end at vertex 0; expected one"),
        ("2 0 0 -1\n0 1 0 0\n1 2 1", "2 1 0 -1\n0 0 0 0\n1 2 1", "line 5: the yarn of this vertex has 1 vertices"),
        ("0.008 0.002 0.001 0", "0.008 nan 0.001 0", "line 6: got '0.008 nan 0.001 0'; expected 4 finite numbers"),
        ("0.02 0.01", "0.02 0", "line 2: got 0; expected positive lengths in metres"),
        ("0.02 0.01", "1e-320 0.01", "y.pyp: periods of 1e-320 and 0.01: lattice: the periods"),
        ("0.006\n", "-0.006\n", "line 16: got -0.006; expected positive lengths in metres"),
        ("0.001 3\n", "0.001 3\n1 1 1 3\n", "line 3: a second line of *pattern"),
        ("*RK", "*RL", "line 19: a second block *RL; expected one"),
        ("*RK\n0 0\n", "*RK\n", "line 19: block *RK has 2 lines and line 2 says 3"),
        ("*pattern", "pattern", "line 1: got 'pattern' outside of any block; expected '*pattern'"),
        ("*RL", "*LR", "block *RL is missing or empty"),
    ],
)
def test_each_bad_file_gets_its_message(tmp_path, old, new, message):
    assert CELL.count(old) == 1
    path = written(tmp_path / "y.pyp", CELL.replace(old, new))
    with refused(path, message):
        read_yarns(path)
