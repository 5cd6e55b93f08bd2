# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Swatches against known properties of fabrics (gauge, widths, curl, crimp), and against their tilings and images."""

from __future__ import annotations

from dataclasses import astuple, replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from benchmarks.published import cells, weaves
from benchmarks.published import rod_model as rods
from stitchmesh.patterns import parse_pattern, read_pattern
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.sampling.sampling import close_contacts
from stitchmesh.periodic.swatch import Swatch, swatch
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.periodic.weave.jamming import jam_report
from stitchmesh.periodic.weave.library import read_weave
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns, yarn_energies, yarn_forces
from stitchmesh.yarnrelax.cell_stress import cell_stress
from tests.gallery import ROOT
from tests.nightly import at_night
from tests.periodic.free_cells import FREE

KALDOR = YarnMaterial.named("kaldor-simulation")
AT_REST = replace(PRESETS["standard"], tolerance=3e-4)
CELLS = ROOT.parent / "shared" / "data" / "periodic"


@cache
def relaxed(pattern: str, quality: str | Quality = AT_REST) -> Swatch:
    """Relax a swatch of the published simulation material in a free cell with right angles."""
    return swatch(pattern, material=KALDOR, quality=quality, device="cpu", **FREE)


def moments(pattern: str) -> np.ndarray:
    """Return the bending moments along the courses and along the wales [dyn]."""
    report = relaxed(pattern).report
    return np.array([report["course_moment"], report["wale_moment"]])


def test_stockinette_has_the_gauge_of_relaxed_plain_knit() -> None:
    """Munden's constants for dry and full relaxation, and the gauge of hand knitters."""
    report = relaxed("stockinette").report
    assert report["converged"]
    assert 5.0 <= report["loop_length"] / report["course_spacing"] <= 5.5
    assert 3.8 <= report["loop_length"] / report["wale_spacing"] <= 4.2
    assert 1.25 <= report["wale_spacing"] / report["course_spacing"] <= 1.40
    # the yarn has the given length, except for the strain caused by the bending of loops
    assert report["loop_length"] == pytest.approx(16.67 * 0.25, rel=0.01)


@pytest.mark.nightly
def test_loose_loops_have_the_same_size_in_the_qualities_standard_and_reference() -> None:
    """In loops of 24 yarn diameters, contact samples would be further apart than in a compact loop."""
    sizes = []
    for quality in ("standard", "reference"):
        report = swatch(
            "stockinette", material=KALDOR, quality=quality, device="cpu", **FREE, loop_length=24 * 0.25
        ).report
        sizes.append([report["wale_spacing"], report["course_spacing"]])
    # errors of control points and residual; 17 % without more contact samples
    np.testing.assert_allclose(*sizes, rtol=0.01)


def test_compact_loops_have_the_contact_samples_of_the_quality() -> None:
    standard = PRESETS["standard"]
    assert close_contacts(standard, SwatchOptions()) == standard
    assert close_contacts(standard, SwatchOptions(loop_length=12 * 0.25)) == standard
    twice = close_contacts(standard, SwatchOptions(loop_length=2 * 16.67 * 0.25))
    assert twice == close_contacts(standard, SwatchOptions(gamma=0.5)) == replace(standard, contact_samples=9)


def test_stockinette_curls_towards_the_right_side_along_the_wales_and_to_the_wrong_side_along_the_courses() -> None:
    course, wale = moments("stockinette")
    assert wale > 10.0 and course < -10.0  # dyn; the noise is below 0.1
    # the wrong side of the same fabric
    np.testing.assert_allclose(moments("reverse-stockinette"), [-course, -wale], rtol=0.02)


@pytest.mark.parametrize(
    ("pattern", "largest"), [("garter", 0.01), *at_night(("seed", 0.01), ("rib1x1", 0.01), ("rib2x2", 0.1))]
)
def test_fabrics_with_equal_sides_lie_flat(pattern: str, largest: float) -> None:
    # moments of stockinette are bending forces times the thickness; a residual of 0.0003 leaves a tenth of these; the
    # ridges of a rib of two stitches lean a little to one side, which lowers the energy
    assert np.abs(moments(pattern)).max() < largest * np.abs(moments("stockinette")).min()


@pytest.mark.nightly
def test_ribs_are_narrower_than_stockinette_and_garter_is_shorter() -> None:
    plain, garter = relaxed("stockinette").report, relaxed("garter").report
    # knitted ribs are about 30 % narrower; this rib of one stitch leaves the balance in which its columns stand
    for pattern, width in (("rib1x1", 0.8), ("rib2x2", 0.7)):
        assert relaxed(pattern).report["wale_spacing"] < width * plain["wale_spacing"]
    assert garter["course_spacing"] < 0.8 * plain["course_spacing"]
    assert relaxed("seed").report["course_spacing"] < 0.9 * plain["course_spacing"]


@pytest.mark.parametrize("name", ["k1 p1", "half-cardigan", "linen-stitch"])
def test_yarn_that_is_worked_into_its_own_row_has_the_same_length_in_a_taller_cell(name: str) -> None:
    """A loop that is held over all rows of a repeat is worked by its own yarn, one period above."""
    pattern = parse_pattern(f"round 1: {name}") if name == "k1 p1" else read_pattern(name)
    one, tall = (draw_swatch(pattern, SwatchOptions(rows=rows), PRESETS["draft"])[1].rest_length for rows in (1, 2))
    np.testing.assert_allclose(np.sort(tall), np.sort(np.repeat(one, 2)), rtol=1e-12)  # rounding


def test_the_image_in_which_a_yarn_is_stored_does_not_matter() -> None:
    yarns = relaxed("garter").yarns
    moved = yarns.points.copy()
    last = slice(yarns.start[-2], yarns.start[-1])
    moved[last] += yarns.lattice.shift(np.array([(-2, 3)]))[0]  # type: ignore[union-attr]
    other = replace(yarns, points=moved)
    assert yarns.yarn_count > 1
    assert yarn_energies(other, KALDOR) == pytest.approx(yarn_energies(yarns, KALDOR), rel=1e-9)  # rounding
    before, after = yarn_forces(yarns, KALDOR), yarn_forces(other, KALDOR)
    np.testing.assert_allclose(after, before, atol=1e-8 * np.abs(before).max() + 1e-6)
    assert astuple(cell_stress(other, KALDOR)) == pytest.approx(astuple(cell_stress(yarns, KALDOR)), rel=1e-6, abs=1e-6)


@pytest.mark.parametrize(("spacing", "published"), [(1.732, 0.2092), (3.0, 0.0585)])
def test_peirces_geometry_has_the_published_crimps(spacing: float, published: float) -> None:
    assert weaves.Peirce.spaced(spacing).crimp == pytest.approx(published, abs=5e-5)  # four digits


@pytest.mark.parametrize("spacing", [2.4, *at_night(2.0)])
def test_a_plain_weave_of_taut_flexible_yarns_has_the_crimp_of_peirces_geometry(spacing: float) -> None:
    found = weaves.taut_weave(spacing)
    assert found.nearest == pytest.approx(1.0, abs=0.005)  # contacts are compressed by less than half a percent
    # crimp is proportional to the square of the diameter: 1 % error for 0.5 %; bending contributes one part in 1000
    assert found.crimp == pytest.approx(weaves.Peirce.spaced(spacing).crimp, rel=0.02)
    assert found.crown == pytest.approx(1.0, abs=0.01)
    assert found.tension > 100.0  # dyn/cm; the yarns are taut


def test_taut_yarns_of_a_jammed_weave_push_on_their_periods() -> None:
    """Below a spacing of sqrt(3) diameters taut yarns have no equilibrium: they push on the cell; above, they pull.

    The symmetric weave is a saddle there: its yarns turn aside, which leaves little of the push.
    """
    stiff = 10 * weaves.CONTACT
    above, below = weaves.taut_weave(1.8, contact=stiff), weaves.taut_weave(1.6, contact=stiff)
    assert above.tension > 100.0 and below.tension < 0.0
    assert above.crown < 1.03 < below.crown
    assert not jam_report(read_weave("plain"), above.yarns)["jammed"]
    assert jam_report(read_weave("plain"), below.yarns)["jammed"]


@cache
def cell_of_rods(name: str) -> Any:
    """Return a relaxed cell that another group published (Sperl et al. 2021)."""
    if not CELLS.is_dir():
        pytest.skip("the relaxed cells of another group are not beside the project")
    return cells.read_cell(CELLS / f"{name}.pyp")


@pytest.mark.parametrize("name", ["stockinette", *at_night("basket")])
def test_the_rods_of_published_cells_are_in_equilibrium(name: str) -> None:
    """Torques about the yarn axes cancel for one ratio of moduli, a round number; after a reading error for none."""
    found = rods.constants_of(cell_of_rods(name).rods)
    # the files hold six digits of positions and angles, and their relaxation was not complete
    assert found.turning_left < 0.01
    assert found.shear == pytest.approx(0.4, abs=0.001)
    assert found.force_left < 0.1


@pytest.mark.parametrize("name", ["stockinette", *at_night("basket")])
def test_forces_of_rods_are_the_derivatives_of_their_energy(name: str) -> None:
    of = cell_of_rods(name).rods
    stiff, pairs, step = cell_of_rods(name).stiffness, rods.pairs_of(of), 1e-9
    rng = np.random.default_rng(0)
    move, turn, grow = rng.normal(size=of.places.shape), 1e3 * rng.normal(size=len(of.places)), rng.normal(size=2)
    ends = [
        rods.slopes(
            replace(of, places=of.places + side * move, turns=of.turns + side * turn, periods=of.periods + side * grow),
            pairs, stiff,
        ).energy
        for side in (step, -step)
    ]  # fmt: skip
    slope = rods.slopes(of, pairs, stiff)
    expected = (slope.places * move).sum() + slope.turns @ turn + slope.periods @ grow
    # with steps of 1e-6 radii the truncation error is 1e-8; energies round to 1e-16, and a step changes them by 1e-5
    assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(expected, rel=1e-5)


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["stockinette", "basket"])
def test_published_cells_of_rods_have_the_same_spacings_in_this_simulation(name: str) -> None:
    """Radius, rest lengths and natural curvature are as published, with our material and with their stiffnesses."""
    cell = cell_of_rods(name)
    yarns = 100 * cell.rods.periods
    for material in (cells.held(cell), cells.theirs(cell)):
        found = np.array(cells.at_rest(cell.yarns, material, cells.FREE)[1])
        assert np.abs(found / yarns - 1.0).max() < 0.05
    straight = np.array(cells.at_rest(cell.straight, cells.held(cell), cells.FREE)[1])
    assert np.abs(straight / yarns - 1.0).max() > 0.08


def test_a_published_weave_of_rods_keeps_its_positions() -> None:
    """With fixed periods, an equilibrium of yarns with natural curvature is near, and its stresses agree.

    Without friction that equilibrium is a saddle: relaxed further, neighbouring yarns slide together in pairs.
    """
    cell = cell_of_rods("basket")
    material = cells.theirs(cell)
    near = replace(cells.QUALITY, max_iterations=60)
    moved = [cells.moved_by(yarns, material, near) for yarns in (cell.yarns, cell.straight)]
    assert moved[0] < 0.05 < 0.1 < moved[1]
    assert relax_yarns(cell.yarns, material=material, quality=near, device="cpu").report["residual"] < 1e-3
    # splines are smoother than polylines with 2.5 edges for each crossing; straight yarns push nine times as strongly
    assert cells.tension(cell.yarns, material, near) == pytest.approx(rods.tension(cell.rods, cell.stiffness), rel=0.35)
