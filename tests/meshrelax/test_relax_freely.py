# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mesh relaxation without a surface: sizes in closed form, invariances, periods, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import MeshError, ParameterError, PatternError, StitchMeshError
from stitchmesh.mesh import BOTTOM, StitchMesh
from stitchmesh.meshrelax.bobbles import NO_BOBBLES
from stitchmesh.meshrelax.forces import force_groups
from stitchmesh.meshrelax.free.free_springs import free_springs
from stitchmesh.meshrelax.free.relax_freely import relax_mesh_freely
from stitchmesh.meshrelax.free.stitch_sizes import HEIGHT, WIDTH, stitch_sizes
from stitchmesh.patterns import parse_pattern, pattern_mesh, pattern_tube, read_pattern
from stitchmesh.periodic.natural_outline import natural_outline
from stitchmesh.periodic.repeat.torus import torus_mesh
from stitchmesh.run import Run
from stitchmesh.run_control import RunControl, Snapshot
from tests.meshrelax.fabrics import grid_fabric, tube_points

PLAIN = {"stitch_width": 0.8, "stitch_height": 0.616}
"""The rest size of plain knit by default [cm]."""
LEANING = 'pattern "lace"\nsource "test"\nrow 1 RS: yo k6 {}\nrow 2 WS: p8\n'


def lace(name: str = "feather-and-fan") -> StitchMesh:
    return pattern_mesh(read_pattern(name), 1, 2, **PLAIN)


def test_plain_knit_at_its_rest_size_stays_where_it_is() -> None:
    drawn = pattern_mesh(read_pattern("stockinette"), 5, 4, **PLAIN)
    shape = relax_mesh_freely(drawn)
    assert shape.report.iterations == 0
    np.testing.assert_array_equal(shape.fabric.vertices, drawn.vertices)
    # Lengths of 1 cm have rounding errors of 1e-16.
    np.testing.assert_allclose(shape.fabric.stretch, 1.0, atol=1e-12)


@pytest.mark.parametrize(
    ("form", "name", "share"), [("flat", "garter", 1), ("tube", "rib2x2", 0), ("lattice", "garter", 1)]
)
def test_rib_and_garter_stitch_take_their_rest_sizes_in_every_form(form: str, name: str, share: int) -> None:
    """Four of five stitches are balanced by an unequal neighbour, and the mean of five is 1 / 5."""
    measures = natural_outline(name, form, columns=8, rows=6).measures()
    part = 1.0 - 0.2**2
    # The residual of 1e-4 is about the strain that remains; borders have fewer neighbours.
    close = 1e-3 if form == "lattice" else 0.05
    assert measures["width_over_plain"] == pytest.approx(np.exp(part * WIDTH[share]), rel=close)
    assert measures["height_over_plain"] == pytest.approx(np.exp(part * HEIGHT[share]), rel=close)


def test_feather_and_fan_scallops_and_stockinette_does_not() -> None:
    assert natural_outline("feather-and-fan", columns=2, rows=4).wave(BOTTOM) > 2.0
    assert natural_outline("stockinette", columns=20, rows=10).wave(BOTTOM) < 1e-3


def test_mirrored_lace_slants_to_the_other_side() -> None:
    right, left = (
        natural_outline(parse_pattern(text), "lattice").slant
        for text in (LEANING.format("ssk"), LEANING.format("k2tog").replace("yo k6 k2tog", "k2tog k6 yo"))
    )
    assert right > 20.0
    assert left == pytest.approx(-right, abs=0.1)  # Both stop at a residual of 1e-4, at different places.


def test_a_turned_and_shifted_piece_takes_the_same_shape() -> None:
    drawn = lace()
    axes = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    axes *= np.sign(np.linalg.det(axes))
    turned = replace(drawn, vertices=drawn.vertices @ axes.T + [3.0, -2.0, 5.0])
    one, other = (relax_mesh_freely(fabric, tolerance=1e-6) for fabric in (drawn, turned))
    # The tolerance of 1e-6 leaves strains of this order, which add up over 20 stitches.
    np.testing.assert_allclose(one.fabric.stretch, other.fabric.stretch, atol=1e-4)
    assert one.width == pytest.approx(other.width, rel=1e-4)


def test_a_repeat_is_the_same_in_a_cell_of_two_repeats() -> None:
    pattern = read_pattern("openwork-trellis")
    one, two = (
        relax_mesh_freely(torus_mesh(pattern, columns, 1, **PLAIN), tolerance=1e-6)
        for columns in (1, 2)
    )
    assert one.fabric.lattice is not None and two.fabric.lattice is not None
    expected = one.fabric.lattice.periods * [[2.0], [1.0]]
    np.testing.assert_allclose(two.fabric.lattice.periods, expected, atol=1e-4)  # The tolerance leaves 1e-6 a stitch.


def test_forces_on_the_unknowns_do_the_work_of_the_forces_on_the_points() -> None:
    fabric = torus_mesh(read_pattern("eyelet-lace"), **PLAIN)
    forces = free_springs(fabric, stitch_sizes(fabric, width=0.8, height=0.6), NO_BOBBLES)
    random, points = np.random.default_rng(5), forces.corners.points
    step = random.normal(size=(points.unknown_count, 3))
    moved = points.moved(np.zeros((len(points.vertex), 3)), step)
    for ends, weights in force_groups(forces.springs):
        unknowns, shares = points.on_unknowns(ends, weights)
        span = np.einsum("nmi,m->ni", moved[ends], np.array(weights))
        # Sums of ten numbers of order 1 have rounding errors of 1e-15.
        np.testing.assert_allclose(np.einsum("nmi,nm->ni", step[unknowns], shares), span, atol=1e-12)


def test_results_are_repeatable_and_a_pause_changes_nothing() -> None:
    seen: list[Snapshot[StitchMesh]] = []
    control = RunControl(seen.append, seconds=0.0)
    one, other = relax_mesh_freely(lace()), relax_mesh_freely(lace(), run=Run(False, control=control))
    np.testing.assert_array_equal(one.fabric.vertices, other.fabric.vertices)
    assert len(seen) > 1 and seen[0].state.stretch is not None
    assert not np.array_equal(seen[0].state.vertices, seen[-1].state.vertices)


def test_what_has_no_natural_outline_is_refused_in_one_line() -> None:
    plain, round_tube = lace("stockinette"), grid_fabric(tube_points(8, 3, 2.0, 3.0), wrap=True)
    refused: list[tuple[type[StitchMeshError], str, object]] = [
        (ParameterError, "form: got", lambda: natural_outline("garter", "round")),  # type: ignore[arg-type]
        (ParameterError, "columns: got 0", lambda: natural_outline("garter", columns=0)),
        (ParameterError, "2,000,000 stitches", lambda: natural_outline("garter", columns=1000, rows=1000)),
        (ParameterError, "stitch_width: got nan", lambda: natural_outline("garter", stitch_width=float("nan"))),
        (ParameterError, "aspect: got -1", lambda: relax_mesh_freely(plain, aspect=-1.0)),
        (ParameterError, "a round of 2", lambda: pattern_tube(read_pattern("garter"), 2, **PLAIN)),
        (MeshError, "expected a flat piece", lambda: relax_mesh_freely(round_tube)),
        (PatternError, "row 1", lambda: natural_outline(parse_pattern('pattern "a"\nsource "b"\nrow 1 RS: k kfb'))),
    ]
    for kind, text, call in refused:
        with pytest.raises(kind, match=text) as error:
            call()  # type: ignore[operator]
        assert "\n" not in str(error.value)
