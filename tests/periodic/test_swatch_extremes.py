# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Swatches with extreme options: they converge or raise an error of one line; the effects of take-up and gamma."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError, PatternError, SolverError
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import parse_pattern
from stitchmesh.periodic.fabric_shape import FlatFabric
from stitchmesh.periodic.relaxation.continuation import change_radius, size_of
from stitchmesh.periodic.relaxation.prepared_swatch import smallest_cell
from stitchmesh.periodic.relaxation.support import planes
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.sampling.even_sampling import sample_evenly
from stitchmesh.periodic.sampling.sampling import GENERATED, refined, with_contacts
from stitchmesh.periodic.swatch import Swatch, scale_yarns, swatch
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.periodic.weave.weave import Thread, Weave
from stitchmesh.quality import quality_named
from stitchmesh.yarn.rest_length import RestLengths, apply_rest_lengths, parse_rest_lengths, segment_faces
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial, relax_yarns, yarn_energies
from tests.nightly import at_night
from tests.periodic.free_cells import FREE, free_swatch, yarn_lengths

pytestmark = pytest.mark.usefixtures("first_state")
RADIUS = 0.125
DRAFT = {"quality": "draft", "device": "cpu"}
SLIPS = "slip-stitch-honeycomb"


def lengths_of(name: str, words: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Return the factor of each rest length, and the kind of each segment: 1 float, 2 held loop, 0 other."""
    fabric, yarns = draw_swatch(resolve_pattern(name), SwatchOptions(), quality_named("draft"))
    changed = apply_rest_lengths(yarns, parse_rest_lengths(words), fabric=fabric)
    face = segment_faces(yarns)
    slips = np.isin(fabric.stitch[face], [Stitch.SLIP_BACK, Stitch.SLIP_FRONT])
    tucks = np.isin(fabric.stitch[face], [Stitch.SY, Stitch.YS])
    own = yarns.row[yarns.segment_points[:, 1]] == fabric.row[face]
    return changed.rest_length / yarns.rest_length, np.where(slips & own, 1, np.where((slips | tucks) & ~own, 2, 0))


def check_valid(made: Swatch) -> None:
    """Check that a swatch is finite; ``swatch`` itself raises an error if a yarn has passed through another."""
    report = made.report
    assert np.isfinite(made.yarns.points).all()
    assert np.isfinite([report["energy"], report["max_strain"], report["width"], report["height"]]).all()
    assert report["min_distance_over_radius"] > 0.0 and report["pull_throughs"] == 0


@pytest.mark.parametrize("name", [SLIPS, "jacquard1"])
def test_only_floats_and_held_loops_take_their_factors(name):
    factor, kind = lengths_of(name, ["floats=0.5", "held=1.5"])
    assert set(kind.tolist()) == {0, 1, 2}
    np.testing.assert_allclose(factor, np.array([1.0, 0.5, 1.5])[kind], rtol=1e-15)  # one product, one quotient


def test_a_tuck_holds_a_loop_and_has_no_float():
    factor, kind = lengths_of("half-cardigan", ["held=0.5"])
    np.testing.assert_array_equal(factor, np.where(kind == 2, 0.5, 1.0))
    with pytest.raises(ParameterError, match="rest length floats: the fabric has no slip stitch and no stitches"):
        lengths_of("half-cardigan", ["floats=0.5"])
    with pytest.raises(ParameterError, match="rest length held: the fabric has no slip or tuck that holds a loop"):
        lengths_of("stockinette", ["held=0.5"])


def test_shorter_held_loops_contract_the_fabric():
    """Shorter held loops cause the cavities of the honeycomb (Leaf et al. 2018, figure 14)."""
    plain = free_swatch(SLIPS)
    tight = swatch(SLIPS, **FREE, rest_lengths=RestLengths(held=0.6), **DRAFT)
    # between planes the cells become narrower and hardly shorter
    assert tight.report["width"] < 0.95 * plain.report["width"]
    assert tight.report["width"] * tight.report["height"] < 0.98 * plain.report["width"] * plain.report["height"]
    # the yarn slides, so that each yarn is shorter by what its held loops lose, everywhere alike
    fabric, drawn = draw_swatch(resolve_pattern(SLIPS), SwatchOptions(), GENERATED)
    shorter = apply_rest_lengths(drawn, RestLengths(held=0.6), fabric=fabric)
    expected = yarn_lengths(shorter) / yarn_lengths(drawn)
    np.testing.assert_allclose(yarn_lengths(tight.yarns) / yarn_lengths(plain.yarns), expected, rtol=1e-12)  # sums


def test_warp_and_weft_take_their_factors():
    made = swatch("plain", rest_lengths=RestLengths(warp=0.9, weft=1.2), **DRAFT).yarns
    base = swatch("plain", **DRAFT).yarns
    weft = base.lattice_step[base.segment_yarn, 0] != 0
    np.testing.assert_allclose(made.rest_length / base.rest_length, np.where(weft, 1.2, 0.9), rtol=1e-12)  # rounding


@pytest.mark.parametrize(
    ("name", "words", "message"),
    [
        ("stockinette", ["k=2.5"], r"rest lengths of yarn \d: got a factor of 2.5; expected 0.1 to 2"),
        ("stockinette", ["k=2", "row:0=2"], "got a factor of 4; expected 0.1 to 2"),
        ("stockinette", ["warp=0.9"], "rest length warp: the yarns are not woven"),
        ("plain", ["k=0.9"], "got factors of stitches for a weave; use warp=F, weft=F or yarn:N=F"),
        ("plain", ["yarn:9=0.9"], "rest length yarn:9: there is no such yarn; expected 0 to 3"),
        ("plain", ["row:0=0.9"], "the yarns do not store which stitch made them"),
    ],
)  # fmt: skip
def test_impossible_take_up_is_refused(name, words, message):
    with pytest.raises(ParameterError, match=message):
        swatch(name, rest_lengths=parse_rest_lengths(words), **DRAFT)


def test_a_pattern_without_a_plain_stitch_keeps_its_generated_length():
    _fabric, yarns = draw_swatch(parse_pattern("round 1: yo k2tog\n"), SwatchOptions(), quality_named("draft"))
    assert yarns.rest_length.sum() == pytest.approx(yarns.lengths.sum(), rel=1e-9)  # rounding of sums


def test_a_loop_length_among_the_rest_lengths_is_refused():
    with pytest.raises(ParameterError, match="got a loop length among them; give the loop length to the swatch"):
        swatch("stockinette", rest_lengths=RestLengths(loop_length=3.0), **DRAFT)


@pytest.mark.parametrize(
    ("name", "asked"),
    [
        ("stockinette", {"factor": 2.0}), (SLIPS, {"floats": 0.1}), ("plain", {"warp": 0.1}),
        *at_night(
            ("rib1x1", {"factor": 0.5}), (SLIPS, {"floats": 2.0}), (SLIPS, {"held": 0.1}), ("plain", {"weft": 2.0}),
        ),
    ],
)  # fmt: skip
def test_the_largest_changes_of_rest_lengths_converge(name, asked):
    made = swatch(name, **FREE, rest_lengths=RestLengths(**asked), **DRAFT)
    check_valid(made)
    assert made.report["converged"]


def test_a_tenth_of_all_yarn_length_in_a_fixed_repeat_is_refused():
    with pytest.raises(SolverError, match="rest lengths cannot be separated; change them less, or let the cell relax"):
        swatch("stockinette", rest_lengths=RestLengths(factor=0.1), **DRAFT)


def test_length_factors_of_a_weave_are_applied_in_steps():
    weave = Weave(((0, 1), (1, 0)), warps=(Thread(length=0.1), Thread(length=2.0)))
    made = swatch(weave, **DRAFT)
    check_valid(made)
    length = yarn_lengths(made.yarns)
    np.testing.assert_allclose(length[2:] / length[:2], [0.1, 2.0], rtol=1e-12)  # rounding of sums


@pytest.mark.parametrize(
    ("name", "gamma", "tolerance"),
    [("stockinette", 1.3, 1e-2), ("plain", 2.0, 1e-12), *at_night(("seed", 2.0, 1e-12))],
)  # fmt: skip
def test_gamma_is_an_exact_similarity(name, gamma, tolerance):
    """A fabric that is simulated gamma times as large and scaled back has the same energies as one of its final size
    (Leaf et al. 2018, equation 4), so the same iterations give the same state except for rounding. Factors of two are
    exact. Other factors are rounded, and iterations amplify the error along soft directions, up to what the residual
    of 1e-4 allows."""
    quality = replace(quality_named("draft"), precision="float64", tolerance=1e-4)
    material = YarnMaterial.named("stitchmesh").of_radius(RADIUS)
    made = swatch(name, gamma=gamma, material=material, quality=quality, device="cpu", **FREE)
    source, cell = resolve_pattern(name), RelaxCell(shear=False)
    fabric, generated = draw_swatch(source, SwatchOptions(), GENERATED)
    first = sample_evenly(generated, draw_swatch(source, SwatchOptions(), refined(quality))[1])
    own = smallest_cell(generated, first, first.rest_length, SwatchOptions(), lies_alike=fabric is not None)
    quality = with_contacts(refined(quality), SwatchOptions(gamma=gamma), fabric, own, cell)
    small = change_radius(own.part_of(scale_yarns(first, 1.0 / gamma)), gamma, material, quality, "cpu")
    np.testing.assert_allclose(small.radius, RADIUS, rtol=1e-12)  # three roundings
    flat = FlatFabric.of(scale_yarns(generated, 1.0 / gamma), fabric, source)
    terms = planes(SwatchOptions(relax_cell=True), flat, small.radius)
    direct = relax_yarns(small, material=material, quality=quality, device="cpu", cell=cell, terms=terms)
    repeat = own.repeated(direct.yarns, first)
    apart = made.yarns.points - repeat.points
    # no force holds a repeat in its plane, so that it may lie anywhere there
    np.testing.assert_allclose(apart - apart.mean(axis=0), 0.0, atol=tolerance * RADIUS)
    # the error is of second order in the positions
    assert made.report["energy"] == pytest.approx(own.copies * direct.report["energy"], rel=1e-6)
    np.testing.assert_allclose(made.yarns.rest_length, repeat.rest_length, rtol=1e-12)  # three roundings


def test_a_scaled_cell_of_curved_yarn_has_the_same_bending_energy():
    made = swatch("plain", **DRAFT).yarns
    made = replace(made, natural_curvature=np.linspace(-2.0, 2.0, len(made.points)))
    material = YarnMaterial.named("stitchmesh")
    one, three = yarn_energies(made, material), yarn_energies(scale_yarns(made, 3.0), material.scaled(3.0))
    straight = replace(made, natural_curvature=0.0 * made.natural_curvature)
    assert one["bend"] != pytest.approx(yarn_energies(straight, material)["bend"], rel=0.01)
    assert three["bend"] == pytest.approx(one["bend"], rel=1e-9)  # only rounding, because the similarity is exact


@pytest.mark.parametrize(("name", "gamma"), [("stockinette", 0.2), ("plain", 5.0)])
def test_a_fifth_and_five_times_gamma_are_valid(name, gamma):
    made = swatch(name, gamma=gamma, **DRAFT)
    check_valid(made)
    assert made.report["converged"] and made.yarns.radius == pytest.approx(RADIUS, rel=1e-12)  # scaled up and back


def test_gamma_that_is_too_large_for_the_loops_is_refused():
    with pytest.raises(SolverError, match=r"yarn 0 .*: yarn of this radius does not fit; take thinner"):
        swatch("garter", gamma=10.0, **DRAFT)


@pytest.mark.parametrize("gamma", [0.01, np.nan, np.inf])
def test_gamma_out_of_bounds_is_refused(gamma):
    with pytest.raises(ParameterError, match=r"gamma: got .*; expected 0.1 to 10"):
        swatch("stockinette", gamma=gamma, **DRAFT)


@pytest.mark.parametrize(
    ("name", "share"),
    [("stockinette", (0.5, 0.5)), *at_night(("stockinette", (2.0, 1.0)), ("twill-2x1", (0.5, 0.5)))],
)
def test_a_repeat_of_half_or_twice_its_free_size_is_valid(name, share):
    own = size_of(free_swatch(name).lattice)
    made = swatch(name, period=(share[0] * own[0], share[1] * own[1]), **DRAFT)
    check_valid(made)
    # the sizes are stored as float32
    np.testing.assert_allclose(size_of(made.lattice), np.multiply(share, own), rtol=1e-5)


def test_a_repeat_that_its_yarn_cannot_span_is_refused():
    width, height = size_of(free_swatch("stockinette").lattice)
    with pytest.raises(SolverError, match="cannot be separated in a repeat of this size; give a size closer to"):
        swatch("stockinette", period=(2.0 * width, 2.0 * height), **DRAFT)


@pytest.mark.parametrize(
    ("period", "message"),
    [
        ((0.0, 1.0), "period width: got 0.0 cm; expected a positive number"),
        ((1.0, -2.0), "period height: got -2.0 cm; expected a positive number"),
        ((np.nan, None), "period width: got nan cm; expected a positive number"),
        ((1e6, None), r"period width: got 1e\+06 cm; expected 0.102 to 10.2 for this repeat"),
        ((None, 1e-5), "period height: got 1e-05 cm; expected 0.158 to 15.8 for this repeat"),
    ],
)
def test_a_size_far_from_the_generated_size_is_refused(period, message):
    with pytest.raises(ParameterError, match=message):
        swatch("stockinette", period=period, **DRAFT)


def test_loops_too_short_for_their_yarn_are_refused():
    with pytest.raises(SolverError, match="yarn of this radius does not fit; take thinner or longer yarn"):
        swatch("stockinette", loop_length=0.05, **DRAFT)


def test_the_fabric_scales_with_the_yarn_radius():
    """All lengths are proportional to the yarn radius, and the material is scaled with it."""
    made = swatch("stockinette", yarn_radius=1e3, **FREE, **DRAFT)
    # the tolerance of the quality draft
    expected = free_swatch("stockinette").report["width"] / RADIUS
    assert made.report["width"] / 1e3 == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize(
    ("chart", "where"), [("B", "row 1, stitch 1"), ("KKF\nKPB", "row 1, stitch 3")]
)
def test_a_loop_that_every_row_slips_is_refused(chart, where):
    with pytest.raises(PatternError, match=f"{where} from the left: slips a loop that every row slips; knit or purl"):
        swatch(parse_pattern(f"chart leaf:\n{chart}\n"), **DRAFT)
